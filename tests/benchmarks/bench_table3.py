"""What does one tangential impact cost, at equal end-state error, in each integrator?

``python -m tests.benchmarks.bench_table3`` finds the loosest tolerance with which each peer
reaches the target error, and prints one table per target. ``make bench`` runs the same as a test.
Times depend on the machine; ratios are what to read.

The rule is the same for every peer. Tolerances are tried eight to a decade; a peer's own is the
first from which on half a decade stays at or below the target. The peer is timed there and at the
one before, whose error is above the target, and its time is interpolated between the two, at the
target, in logarithms of error and time. Times at one tolerance each would compare unequal errors:
heyoka's depends on its order alone, a whole number, and falls from 2.1e-9 to 1.7e-10 at one
tolerance, to stay there for a decade; ours is as uneven.
"""

from __future__ import annotations

import argparse
import importlib
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.benchmarks.cases import CASES, MOTIONS, ROD, Case
from tests.benchmarks.peers import HeyokaPeer, at_error, peers, time_all, tune
from tests.oracles.rod_scipy import simulate

TARGETS = (1e-9, 1e-11)


# ==============================================================================================
# The package's own engines, in the one module here that imports the package. Taylor comes first in
# the table, so ratios are relative to it. They resolve the reverse slip, and so does every peer.
PACKAGE_PEER = "tests.benchmarks.package_peer"
# ==============================================================================================


@dataclass(frozen=True)
class Line:
    """Hold one line of the table.

    Attributes
    ----------
    case, peer : str
    target : float
        Error to reach.
    tolerance : float or None
        Loosest tolerance that reaches it; None if none does, and then the rest is None too.
    error : float or None
        `Case.end_error` at that tolerance.
    looser, looser_error : float or None
        The tolerance before, and its error, above the target; None where the peer has none.
    seconds : float or None
        Least processor time of one run, interpolated at the target.
    prepare_seconds : float or None
        Time of `prepare` and of what the first run took longer than that.
    ratio : float or None
        Time relative to the first peer of the table.
    """

    case: str
    peer: str
    target: float
    tolerance: float | None = None
    error: float | None = None
    looser: float | None = None
    looser_error: float | None = None
    seconds: float | None = None
    prepare_seconds: float | None = None
    ratio: float | None = None


def package_peers(case: Case) -> tuple[list[Any], list[str]]:
    """Return the package's own peers, or a line that says why there are none."""
    try:
        module = importlib.import_module(PACKAGE_PEER)
    except ModuleNotFoundError as missing:
        return [], [f"skipped: the package's engines ({missing})"]
    return [module.PackagePeer(case, engine) for engine in ("taylor", "compiled")], []


def contestants(case: Case = ROD) -> tuple[list[Any], list[str]]:
    """Return all peers that can run, the package's first, and why others cannot."""
    own, unregistered = package_peers(case)
    others, skipped = peers(case, reverse_slip=True)
    return [*own, *others], [*unregistered, *skipped]


def measure(
    contenders: Sequence[Any], targets: Sequence[float] = TARGETS, repeats: int = 101
) -> list[Line]:
    """Tune and time every peer at every target.

    Parameters
    ----------
    contenders : sequence of Peer
        The first is the unit of the ratios.
    targets : sequence of float
        End-state errors to reach.
    repeats : int
        Rounds of timed runs at each target.

    Returns
    -------
    list of Line
        By target, in the order of the peers.
    """
    lines: list[Line] = []
    errors: dict[str, dict[float, float]] = {}
    for target in targets:
        tuned: list[tuple[Any, float, float | None]] = []
        first: list[tuple[float, float]] = []
        for peer in contenders:
            peer.prepare()
            known = errors.setdefault(peer.name, {})
            choice = tune(peer, target, known)
            if choice is None:
                lines.append(Line(peer.case.name, peer.name, target))
                continue
            tol, looser = choice
            # Imports are done by now; what the chosen tolerance costs to compile is timed again.
            start = time.perf_counter()
            peer.prepare()
            error = peer.case.end_error(peer.run(tol), peer.reverse_slip)
            first.append((error, time.perf_counter() - start))
            tuned.append((peer, tol, looser))
        runs = [(p, t) for p, *tols in tuned for t in tols if t is not None]
        times = iter(time_all(runs, repeats))
        unit = 0.0
        for (peer, tol, looser), (error, took) in zip(tuned, first, strict=True):
            known, here = errors[peer.name], next(times)
            above = None if looser is None else (known[looser], next(times))
            seconds = at_error(target, above, (error, here))
            unit = unit or seconds
            lines.append(
                Line(
                    peer.case.name,
                    peer.name,
                    target,
                    tolerance=tol,
                    error=error,
                    looser=looser,
                    looser_error=None if above is None else above[0],
                    seconds=seconds,
                    prepare_seconds=max(took - here, 0.0),
                    ratio=seconds / unit,
                )
            )
    return lines


def table(lines: Sequence[Line]) -> str:
    """Return the table as text."""
    head = f"{'peer':30s} {'tolerance':>10s} {'error':>9s} {'time':>12s} {'compile':>10s}    ratio"
    text: list[str] = []
    for case, target in dict.fromkeys((line.case, line.target) for line in lines):
        text += [f"{case}: end-state error at most {target:g}", head]
        for line in (line for line in lines if (line.case, line.target) == (case, target)):
            if line.seconds is None:
                text.append(f"{line.peer:30s} does not reach it")
                continue
            text.append(
                f"{line.peer:30s} {line.tolerance:10.1e} {line.error:9.1e} "
                f"{1e6 * line.seconds:9.1f} us {line.prepare_seconds:8.3f} s {line.ratio:8.3g}"
            )
        text.append("")
    return "\n".join(text)


@pytest.mark.parametrize("case", MOTIONS, ids=lambda c: c.name)
def test_reference_is_what_80_bit_taylor_finds(case):
    pytest.importorskip("heyoka")
    for reverse_slip, reference in case.reference.items():
        peer = HeyokaPeer(case, reverse_slip, number=np.longdouble, begin=1e-9)
        peer.prepare()
        assert peer.run(1e-19) == pytest.approx(reference, rel=4e-16, abs=1e-24)


def test_table3_reference_is_what_the_oracle_finds():
    final = simulate(1.0, 1.0, -1.0, t_end=1.0, until="separation", rtol=1e-13).final
    assert ROD.end_error(final, reverse_slip=True) < 1e-12


def test_time_at_an_error_lies_between_its_neighbours():
    assert at_error(1e-9, None, (1e-10, 3.0)) == 3.0
    assert at_error(1e-10, (1e-8, 2.0), (1e-10, 8.0)) == pytest.approx(8.0)
    assert at_error(1e-9, (1e-8, 2.0), (1e-10, 8.0)) == pytest.approx(4.0)


@pytest.mark.parametrize("case", CASES, ids=lambda c: c.name)
def test_every_peer_reaches_the_first_target(case):
    contenders, skipped = contestants(case)
    lines = measure(contenders, targets=TARGETS[:1], repeats=21)
    print("", *skipped, table(lines), sep="\n")
    for line in lines:
        assert line.error is not None, line.peer
        assert line.error <= line.target


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table; write it as JSON where asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the lines there")
    parser.add_argument("--repeats", type=int, default=101, help="rounds of timed runs")
    options = parser.parse_args(arguments)
    lines = []
    for case in CASES:
        contenders, skipped = contestants(case)
        print(*skipped, sep="\n")
        measured = measure(contenders, repeats=options.repeats)
        print(table(measured), flush=True)
        lines += measured
    if options.json is not None:
        options.json.write_text(json.dumps([asdict(line) for line in lines], indent=2) + "\n")


if __name__ == "__main__":
    main()
