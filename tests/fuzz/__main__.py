"""Call the program with made-up inputs and report every fault: ``make fuzz``.

Each input is run in a worker process that answers one after the other. An input that takes more
processor time than `MOST_SECONDS` is a hang, and one that ends the worker is a crash; both are
faults, as is what `tests.fuzz.calls` lists. Inputs with faults are written to `--keep`; after the
fault is corrected they go to `tests/fuzz/corpus`, which the tests run.
"""

from __future__ import annotations

import argparse
import collections
import os
import pickle
import selectors
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from random import Random

from tests.fuzz.calls import Outcome, make_store
from tests.fuzz.inputs import ROOT, SHARES, FuzzInput, input_of

MOST_SECONDS = 60.0
"""Processor time of one input; deriving may take `DERIVE_SECONDS` of it."""
DERIVE_SECONDS = 20
MOST_WALL = 600.0
PER_WORKER = 400
"""Inputs after which a worker is replaced: SymPy's caches grow."""


class Worker:
    """A process that answers inputs, replaced when it hangs, ends or is used up."""

    def __init__(self, store: Path) -> None:
        self.store, self.process, self.left = store, None, 0

    def _start(self) -> subprocess.Popen[bytes]:
        if self.process is None or self.left == 0:
            self.end()
            self.left = PER_WORKER
            self.process = subprocess.Popen(
                [sys.executable, "-m", "tests.fuzz.calls", str(self.store)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                cwd=ROOT,
                env={**os.environ, "PAINLEVE_DERIVE_SECONDS": str(DERIVE_SECONDS)},
            )
        self.left -= 1
        return self.process

    def end(self) -> None:
        """End the process."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()
            for stream in (self.process.stdin, self.process.stdout):
                stream.close()
        self.process = None

    def answer(self, given: FuzzInput) -> Outcome:
        """Return the outcome of an input, also where it hangs or ends the process."""
        process = self._start()
        pickle.dump(given, process.stdin)
        process.stdin.flush()
        used, begun = _processor_seconds(process.pid), time.monotonic()
        with selectors.DefaultSelector() as selector:
            selector.register(process.stdout, selectors.EVENT_READ)
            while not selector.select(timeout=1.0):
                took, wall = _processor_seconds(process.pid) - used, time.monotonic() - begun
                if took > MOST_SECONDS or wall > MOST_WALL:
                    self.end()
                    return Outcome(None, (f"hang: {took:.0f} s of processor time",), "")
        try:
            return pickle.load(process.stdout)
        except EOFError:
            status = process.wait()
            self.end()
            return Outcome(None, (f"crash: the process ended with {status}",), "")


def _processor_seconds(pid: int) -> float:
    """Return the processor time of a process and of the children it waited for; s."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text("ascii", "replace").rpartition(")")[2].split()
    except OSError:  # no such system: the time on the wall decides
        return 0.0
    return sum(map(int, fields[11:15])) / os.sysconf("SC_CLK_TCK")


def drawn(seed: int, kinds: list[str]) -> Iterator[tuple[int, FuzzInput]]:
    """Yield inputs of all kinds by their shares, each with the number that makes it."""
    order = Random(seed)
    while True:
        kind = order.choices(kinds, [SHARES[k] for k in kinds])[0]
        number = order.randrange(10**9)
        yield number, input_of(kind, number)


def main() -> int:
    """Run a campaign; 1 where an input has a fault."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description=__doc__)
    parser.add_argument("--inputs", type=int, default=10_000, help="number of inputs")
    parser.add_argument("--seconds", type=float, default=3600, help="end after this time")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--kind", action="append", choices=list(SHARES))
    parser.add_argument("--keep", type=Path, default=ROOT / "out/fuzz", help="folder")
    options = parser.parse_args()
    # A cache of its own: mechanisms that are made up are used once.
    os.environ["PAINLEVE_CACHE"] = str(options.keep / "cache")
    (options.keep / "cache").mkdir(parents=True, exist_ok=True, mode=0o700)
    store = options.keep / "store"
    make_store(store)
    worker, begun = Worker(store), time.monotonic()
    counts: collections.Counter[tuple[str, str]] = collections.Counter()
    faults: collections.Counter[str] = collections.Counter()
    for i, (number, given) in enumerate(drawn(options.seed, options.kind or list(SHARES))):
        if i == options.inputs or time.monotonic() - begun > options.seconds:
            break
        start = time.monotonic()
        outcome = worker.answer(given)
        took = time.monotonic() - start
        counts[given.kind, f"exit code {outcome.code}"] += 1
        if (i + 1) % 500 == 0:
            print(f"{i + 1} inputs, {time.monotonic() - begun:.0f} s", flush=True)
        if outcome.faults:
            path = options.keep / f"{given.kind}-{number}.json"
            path.write_text(given.to_text(), "utf-8")
            for fault in outcome.faults:
                faults[fault.splitlines()[0][:150]] += 1
                print(f"{path.name}: {fault}", flush=True)
        elif took > 20:
            (options.keep / f"slow-{given.kind}-{number}.json").write_text(given.to_text(), "utf-8")
            print(f"{given.kind}-{number}: slow, {took:.0f} s: {outcome.error[:200]}", flush=True)
    worker.end()
    return _report(counts, faults, time.monotonic() - begun)


def _report(
    counts: collections.Counter[tuple[str, str]], faults: collections.Counter[str], seconds: float
) -> int:
    for (kind, answer), n in sorted(counts.items()):
        print(f"{kind:10s} {answer}: {n}")
    print(f"{counts.total()} inputs, {faults.total()} faults, {seconds:.0f} s")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
