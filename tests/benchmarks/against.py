"""What got slower since a release? Calls, builds, commands and libraries of two revisions, in turn.

``python -m tests.benchmarks.against`` takes the package of the last release out of git, or of
``--against REVISION``, starts one process with it and one with this checkout, and lets them do the
same work in turn. It compares the least processor times of both, and ends with 1 where one is more
than 10 % above the other revision's. No limit is in seconds: what the machine does besides slows
both. Times of processes (cold builds, warm commands) include their compilers.

The worker of a revision is this file as a script, which imports only public names.
"""

from __future__ import annotations

import argparse
import fnmatch
import io
import json
import math
import os
import resource
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

MAX_RATIO = 1.10
"""Most that a cost may be, in parts of the other revision's."""
RESULT_TOLERANCE = 1e-6
"""Part of its largest number within which a result is that of the other revision."""
ROOT = Path(__file__).parents[2]

Call = Callable[[], object]

TABLE_3 = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
ARM = {"theta_1": -1.3, "theta_2": -1.8}
ARM_HEIGHT = -0.5 * (math.sin(-1.3) + math.sin(-1.8))
"""At which the end of the arm touches the ground."""
HERTZ = {"E": 20.9e14, "n": 1.764, "e_energetic": 0.75}
"""All that matters of the law: defaults differ between releases."""


def _engine(record: str, mechanism: str, state: dict[str, float], **parameters: float) -> Call:
    """Return an impact of a mechanism at rtol 1e-9 until it separates."""
    import painleve_sym as ps

    simulator = ps.Simulator(ps.model(mechanism), ps.law("bilinear-hertz", reload="virgin"))
    given = {"parameters": HERTZ | parameters, "t_end": 0.01, "until": "separation"}
    return lambda: simulator.run(state, record=record, rtol=1e-9, **given)


def _bounce(record: str) -> Call:
    """Return a long run of compliant bounces, in which the engine is nearly all."""
    import painleve_sym as ps

    simulator = ps.Simulator(ps.model("rod"), ps.law("bilinear-hertz", reload="elastic"))
    state, parameters = TABLE_3 | {"y_A": 0.001}, {"mu": 0.8, "E": 209e9, "n": 1.764}
    return lambda: simulator.run(state, record=record, t_end=0.3, parameters=parameters)


def _batch(mechanism: str, rows: int) -> Call:
    import numpy as np

    import painleve_sym as ps

    law = ps.law("bilinear-hertz", reload="virgin")
    options: dict[str, Any] = {"t_end": 0.01, "until": "separation", "rtol": 1e-9}
    if mechanism == "rod":
        states: dict[str, Any] = TABLE_3 | {"theta": np.linspace(1.0, 1.1, rows)}
        parameters: dict[str, Any] = HERTZ | {"mu": 1.5}
    else:
        one, two = np.linspace(-1.35, -1.25, rows), np.linspace(-1.8, -1.75, rows)
        states = {"theta_1": one, "theta_2": two}
        parameters = HERTZ | {"mu": 1.0, "h": -0.5 * (np.sin(one) + np.sin(two))}
    options |= {"parameters": parameters, "threads": 1}
    return lambda: ps.simulate_batch(mechanism, law, states, **options)


def _classify(mechanism: str, state: dict[str, float]) -> Call:
    import painleve_sym as ps

    return lambda: ps.classify(mechanism, state)


def _jump() -> Call:
    import painleve_sym as ps

    return lambda: ps.evaluate_jump("rod", "energetic", TABLE_3)


def _corrected() -> Call:
    import painleve_sym as ps

    given = {"parameters": {"n": 1.764}}
    return lambda: ps.evaluate_corrected_jump("rod", "bilinear-hertz", TABLE_3, **given)


def _simulate(**parameters: float) -> Call:
    import painleve_sym as ps

    law = ps.law("bilinear-hertz", reload="elastic")
    given = {"n": 1.764, **parameters}
    return lambda: ps.simulate("rod", law, TABLE_3, parameters=given, t_end=0.01)


def _impact() -> Call:
    import painleve_sym as ps

    W = [[4.0, 1.2], [1.2, 2.0]]
    return lambda: ps.solve_impact(W, 0.5, (-1.0, 0.7), "energetic", 0.6)


def _impact_in_space() -> Call:
    import painleve_sym as ps

    W = [[2.0, 0.3, -0.4], [0.3, 1.5, 0.2], [-0.4, 0.2, 1.8]]
    return lambda: ps.solve_impact(W, 0.5, (-1.0, 0.7, 0.4), "energetic", 0.6)


def _map(per_axis: int) -> Call:
    import painleve_sym as ps

    return lambda: ps.region_map("rod", ("theta", "theta_dot"), points=per_axis)


def _contact_problem(n: int) -> Call:
    """Return a problem of n contacts with one regular solution or several."""
    import numpy as np

    import painleve_sym as ps

    draw = np.random.default_rng(n)
    G = draw.normal(size=(2 * n, 2 * n))
    W, b = G @ G.T + np.eye(2 * n), draw.normal(size=2 * n)
    return lambda: ps.ContactProblem(W, b, np.full(n, 0.5), np.zeros(n)).solutions()


def _robot_contact() -> Any:
    import painleve_sym as ps

    return ps.robot(ROOT / "examples" / "robots" / "quadruped.urdf").contact(
        "LF_foot", pose="standing"
    )


CALLS: dict[str, Callable[[], Call]] = {
    "simulate by name, dense": _simulate,
    "simulate by name, with parameters": lambda: _simulate(mu=1.5, m=2.0),
    "impact of the rod, end": lambda: _engine("end", "rod", TABLE_3),
    "impact of the rod, dense": lambda: _engine("dense", "rod", TABLE_3),
    "impact of the arm, end": lambda: _engine("end", "two-link-arm", ARM, h=ARM_HEIGHT),
    "impact of the arm, dense": lambda: _engine("dense", "two-link-arm", ARM, h=ARM_HEIGHT),
    "bounces of the rod, end": lambda: _bounce("end"),
    "bounces of the rod, dense": lambda: _bounce("dense"),
    "batch of one row": lambda: _batch("rod", 1),
    "batch of 400 rows, rod": lambda: _batch("rod", 400),
    "batch of 400 rows, arm": lambda: _batch("two-link-arm", 400),
    "classify, slip": lambda: _classify("rod", TABLE_3),
    "classify, at rest": lambda: _classify("rod", {"theta": 1.0}),
    "classify, two feet": lambda: _classify("block-two-feet", {"x_A_dot": -1.0}),
    "classify, two feet at rest": lambda: _classify("block-two-feet", {}),
    "evaluate_jump": _jump,
    "evaluate_corrected_jump": _corrected,
    "solve_impact": _impact,
    "solve_impact in space": _impact_in_space,
    "map of 300 x 300": lambda: _map(300),
    "three contacts at rest": lambda: _contact_problem(3),
    "risk of a robot": lambda: _robot_contact().risk,
}
"""Work inside one process, by title: each makes the call that is timed."""

BUILDS = {
    "build of rod, compliant": ("rod", "bilinear-hertz"),
    "build of rod, rigid": ("rod", "rigid"),
    "build of arm, compliant": ("two-link-arm", "bilinear-hertz"),
    "build of two feet, rigid": ("block-two-feet", "rigid"),
    "build of two feet, compliant": ("block-two-feet", "hertz"),
}
"""Mechanism and law of a first run in an empty cache, by title."""

_BUILD = """
import sys, painleve_sym as ps
mechanism = ps.model(sys.argv[1])
ps.Simulator(mechanism, ps.law(sys.argv[2])).run(mechanism.start, t_end=1e-3)
"""

_AT = ("--state", "theta=1,theta_dot=1,x_A_dot=-1")
COMMANDS = {
    "command models": ("models",),
    "command laws": ("laws",),
    "command classify": ("classify", "rod", *_AT),
    "command jump": ("jump", "rod", *_AT),
    "command simulate": ("simulate", "rod", *_AT, "--law", "bilinear-hertz", "--t-end", "0.01"),
    "command derive": ("derive", "rod"),
    "command map": ("map", "rod", "--over", "theta,theta_dot", "--points", "50"),
    "command contrast": ("contrast", "rod"),
}
"""Commands with a full cache, by title."""


def serve() -> None:
    """Answer each line ``[title, seconds]`` of the standard input with the least time of a call.

    And with numbers of its result, by which another revision's is the same.
    """
    calls: dict[str, Call] = {}
    results: dict[str, list[float]] = {}
    for line in sys.stdin:
        title, seconds = json.loads(line)
        try:
            if title not in calls:
                calls[title] = CALLS[title]()
                results[title] = numbers_of(calls[title]())
            answer: Any = {"took": least_of(calls[title], seconds), "result": results[title]}
        except Exception as error:  # a revision may lack a call
            answer = f"{type(error).__name__}: {error}"
        print(json.dumps(answer), flush=True)


def numbers_of(result: Any) -> list[float]:
    """Return numbers that a result has in any revision; those of a motion, a batch or a jump."""
    import numpy as np

    if hasattr(result, "final_state"):
        return [float(v) for v in result.final_state]
    if hasattr(result, "velocity"):
        velocity = result.velocity
        values = velocity.values() if isinstance(velocity, dict) else velocity
        return [float(v) for v in values]
    if hasattr(result, "names") and hasattr(result, "stop_reason"):
        return [float(np.sum(result["time"]))]
    return []


def same(one: Sequence[float], other: Sequence[float]) -> bool:
    """Return whether two results have the same numbers but for a change of method."""
    scale = max(map(abs, (*one, *other)), default=0.0)
    return len(one) == len(other) and all(
        abs(a - b) <= RESULT_TOLERANCE * scale for a, b in zip(one, other, strict=True)
    )


def least_of(call: Call, seconds: float) -> float:
    """Return the least processor time of a call in about that many seconds of work, s."""
    count, took, spent, best = 1, 0.0, 0.0, float("inf")
    while spent < seconds:
        start = time.process_time()
        for _ in range(count):
            call()
        took = time.process_time() - start
        spent += took
        best = min(best, took / count)
        if took < 2e-3:
            count *= 2
    return best


class Revision:
    """The package of one revision: where it is, its worker, its cache."""

    def __init__(self, name: str, tree: Path, folder: Path) -> None:
        self.name, self.tree, self.folder = name, tree, folder
        self.environment = {
            **os.environ,
            "PYTHONPATH": str(tree),
            "PYTHONPYCACHEPREFIX": str(folder / "modules"),
            "PYTHONDONTWRITEBYTECODE": "",
            "PAINLEVE_OPTIMIZE": "",
            "PAINLEVE_CACHE": str(folder / "cache"),
        }
        self.worker = subprocess.Popen(
            [sys.executable, "-P", __file__, "--serve"],
            env=self.environment,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )

    def call(self, title: str, seconds: float) -> float | str:
        """Return the least time of a call, or why there is none."""
        assert self.worker.stdin is not None
        assert self.worker.stdout is not None
        self.worker.stdin.write(json.dumps([title, seconds]) + "\n")
        self.worker.stdin.flush()
        answer: Any = json.loads(self.worker.stdout.readline())
        if isinstance(answer, str):
            return answer
        self.result = answer["result"]
        took: float = answer["took"]
        return took

    def process(self, *words: str, cache: str = "cache") -> float | str:
        """Return the processor time of a Python process and its compilers, s; or its error."""
        environment = self.environment | {"PAINLEVE_CACHE": str(self.folder / cache)}
        before = children()
        command = [sys.executable, "-P", *words]
        done = subprocess.run(command, env=environment, capture_output=True, text=True)
        took = children() - before
        if done.returncode:
            return done.stderr.strip().splitlines()[-1]
        return took

    def command(self, title: str) -> float | str:
        """Return the processor time of a command with a full cache, s."""
        return self.process("-m", "painleve_sym", *COMMANDS[title])

    def build(self, title: str) -> float | str:
        """Return the processor time of a first run with an empty cache, s."""
        with tempfile.TemporaryDirectory(dir=self.folder) as empty:
            took = self.process("-c", _BUILD, *BUILDS[title], cache=Path(empty).name)
            self.size = sum(f.stat().st_size for f in Path(empty).rglob("*.so"))
        return took

    def close(self) -> None:
        """End the worker."""
        assert self.worker.stdin is not None
        self.worker.stdin.close()
        self.worker.wait()


def children() -> float:
    """Return the processor time of all processes that ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


@contextmanager
def revisions(against: str) -> Iterator[tuple[Revision, Revision]]:
    """Make the packages of another revision and of this checkout ready, in this order."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for part in ("old", "new"):
            (folder / part).mkdir()
        unpack(against, folder / "old")
        old = Revision(against, folder / "old", folder / "old")
        new = Revision("this checkout", ROOT, folder / "new")
        try:
            yield old, new
        finally:
            old.close()
            new.close()


def unpack(revision: str, folder: Path) -> None:
    """Write the package of a revision into a folder."""
    packed = _git("archive", revision, "painleve_sym", "examples")
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        archive.extractall(folder, filter="data")


def last_release() -> str:
    """Return the commit that gave the topmost dated section of the changelog its date."""
    dated = next(
        line
        for line in (ROOT / "CHANGELOG.md").read_text("utf-8").splitlines()
        if line.startswith("## [") and line != "## [Unreleased]"
    )
    commits = _git("log", f"-S{dated}", "--format=%h", "--", "CHANGELOG.md").decode().split()
    return commits[-1]


def _git(*words: str) -> bytes:
    return subprocess.run(("git", "-C", str(ROOT), *words), capture_output=True, check=True).stdout


def ratios(
    old: Revision, new: Revision, titles: Sequence[str], rounds: int
) -> dict[str, dict[str, Any]]:
    """Return the least cost of each title in both revisions, taken in turn, and their ratio."""
    lines = {}
    for title in titles:
        lines[title] = line = compared(old, new, title, rounds)
        again = 0
        while line.get("ratio", 0) > MAX_RATIO and again < 3:
            again += 1  # noise only adds: a cost above the limit is measured longer
            more = compared(old, new, title, rounds)
            line["old"], line["new"] = (min(line[k], more[k]) for k in ("old", "new"))
            line["ratio"] = line["new"] / line["old"]
        print(text_of(title, line), flush=True)
        if "bytes" in line:
            size = line.pop("bytes")
            lines[f"library, {title}"] = size
            print(text_of(f"library, {title}", size), flush=True)
    return lines


def compared(old: Revision, new: Revision, title: str, rounds: int) -> dict[str, Any]:
    """Return the least cost of one title in both revisions, and their ratio where both have it."""
    least: dict[str, Any] = {}
    for _ in range(rounds):
        for key, revision in (("old", old), ("new", new)):
            took = measured(revision, title)
            if isinstance(took, str):
                least[key] = took
            else:
                least[key] = min(least.get(key, float("inf")), took)
        if any(isinstance(v, str) for v in least.values()):
            return least
        if title in BUILDS and least["new"] < least["old"]:
            break
    if title in CALLS and not same(old.result, new.result):
        return {"old": f"another result, {old.result}", "new": f"{new.result}"}
    line = least | {"ratio": least["new"] / least["old"]}
    if title in BUILDS:
        sizes = {"old": old.size, "new": new.size}
        line["bytes"] = sizes | {"ratio": new.size / old.size}
    return line


def measured(revision: Revision, title: str) -> float | str:
    """Return the cost of one title in one revision, s; or why there is none."""
    if title in CALLS:
        return revision.call(title, 0.05)
    return revision.command(title) if title in COMMANDS else revision.build(title)


def text_of(title: str, line: dict[str, Any]) -> str:
    """Return one line of the table."""
    if "ratio" not in line:
        reasons = [f"{k}: {v}" for k, v in line.items() if isinstance(v, str)]
        return f"{title:36} not compared ({'; '.join(reasons)})"
    unit, factor = ("kB", 1e-3) if title.startswith("library") else ("ms", 1e3)
    old, new = (factor * line[k] for k in ("old", "new"))
    mark = "  slower" if line["ratio"] > MAX_RATIO else ""
    return f"{title:36} {old:12.4g} {new:12.4g} {unit}  {line['ratio']:6.3f}{mark}"


def failed(lines: dict[str, dict[str, Any]]) -> list[str]:
    """Return the titles that are too slow, and those which this checkout can not do."""
    slow = [t for t, line in lines.items() if line.get("ratio", 0) > MAX_RATIO]
    return slow + [t for t, line in lines.items() if isinstance(line.get("new"), str)]


def main(arguments: Sequence[str] | None = None) -> int:
    """Compare, print, and return 1 where this checkout is slower."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    parser.add_argument("--against", metavar="REVISION", help="instead of the last release")
    parser.add_argument("--only", metavar="PATTERN", default="*", help="of titles, as in a shell")
    parser.add_argument("--rounds", type=int, default=6, help="times that the revisions take turns")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write the numbers as JSON")
    o = parser.parse_args(arguments)
    if o.serve:
        serve()
        return 0
    titles = [t for t in (*CALLS, *COMMANDS, *BUILDS) if fnmatch.fnmatch(t, o.only)]
    against = o.against or last_release()
    print(f"{'':36} {against:>12} {'checkout':>12}      {'ratio':>6}")
    with revisions(against) as (old, new):
        lines = ratios(old, new, titles, o.rounds)
    if o.out is not None:
        o.out.parent.mkdir(parents=True, exist_ok=True)
        result = {"against": against, "max_ratio": MAX_RATIO, "costs": lines}
        o.out.write_text(json.dumps(result, indent=2) + "\n", "utf-8")
    slow = failed(lines)
    if slow:
        print(f"slower than {against} by more than {MAX_RATIO - 1:.0%}: {', '.join(slow)}")
    return 1 if slow else 0


if __name__ == "__main__":
    raise SystemExit(main())
