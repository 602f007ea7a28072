"""What does each integrator's accuracy cost, from loose to tight tolerances, on three motions?

``python -m tests.benchmarks.bench_numerics`` measures error and processor time of the package's
engines and of the peers at eight tolerances. The motions are those of `cases`: two impacts, and a
block with 21 changes between sticking and slip. All are called once per motion from Python;
what a call runs is compiled but for the callbacks of SciPy and scikit-sundae and the package's
``erk``.

Processor time, in turns and its minimum (`time_all`); ratios in one run are what to read.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.benchmarks.cases import MOTIONS, Case
from tests.benchmarks.package_peer import BatchPeer, PackagePeer
from tests.benchmarks.peers import HeyokaGlue, HeyokaPeer, Peer, peers, time_all

TOLERANCES = tuple(10.0**-k for k in (3, 4.5, 6, 7.5, 9, 10.5, 12, 13.5))
ALONE = "heyoka Taylor, its calls alone"
"""heyoka's time without what Python does between the phases: a bound of a caller in C++."""
FAILED = 1e-1
"""An error beyond it is a motion with other events: not part of a curve."""


def contestants(case: Case) -> tuple[list[Peer], list[str]]:
    """Return the package's engines, then the peers that are installed, and why others are not."""
    own: list[Any] = [PackagePeer(case, engine) for engine in ("taylor", "compiled")]
    own += [BatchPeer(case), PackagePeer(case, "erk")]
    others, skipped = peers(case, reverse_slip=True)
    return [*own, *others], skipped


def _error(peer: Peer, tol: float) -> float | None:
    try:
        # CasADi says on stderr that events are experimental, and what failed.
        with contextlib.redirect_stderr(io.StringIO()):
            error = peer.case.end_error(peer.run(tol), peer.reverse_slip)
    except (RuntimeError, KeyError):
        return None
    return error if math.isfinite(error) and error < FAILED else None


def curves(case: Case, repeats: int, tolerances: Sequence[float] = TOLERANCES) -> dict[str, Any]:
    """Return error and least processor time of every contestant at every tolerance.

    Parameters
    ----------
    case : Case
    repeats : int
        Rounds of timed runs.
    tolerances : sequence of float

    Returns
    -------
    dict
        ``peers``: name → list of {``tolerance``, ``error``, ``seconds``}, by falling tolerance;
        ``failed``: name → tolerances at which the motion was not completed; ``skipped``: lines.
    """
    contenders, skipped = contestants(case)
    lines: dict[str, list[dict[str, float]]] = {}
    failed: dict[str, list[float]] = {}
    runs: list[tuple[Peer, float]] = []
    for peer in contenders:
        peer.prepare()
        lines[peer.name], failed[peer.name] = [], []
        for tol in tolerances:
            if not peer.tightest <= tol:
                continue
            error = _error(peer, tol)
            if error is None:
                failed[peer.name].append(tol)
                continue
            lines[peer.name].append({"tolerance": tol, "error": error})
            runs.append((peer, tol))
    idle = 0.0
    if any(isinstance(p, HeyokaPeer) for p in contenders):
        glue = HeyokaGlue(case, True)
        glue.prepare()
        idle = time_all([(glue, 1e-9)], 101)[0]
    with contextlib.redirect_stderr(io.StringIO()):
        seconds = iter(time_all(runs, repeats))
    for peer in contenders:
        for line in lines[peer.name]:
            line["seconds"] = next(seconds) / getattr(peer, "rows", 1)
            if isinstance(peer, HeyokaPeer):
                lines.setdefault(ALONE, []).append(line | {"seconds": line["seconds"] - idle})
    return {"peers": lines, "failed": {n: t for n, t in failed.items() if t}, "skipped": skipped}


def seconds_at(points: Sequence[dict[str, float]], error: float) -> float | None:
    """Return the least time at which a curve reaches an error; None where it does not.

    Along the curve time is interpolated in logarithms between neighbouring tolerances; points that
    cost more and are less exact than another do not count.
    """
    best = sorted(points, key=lambda p: p["seconds"])
    front: list[dict[str, float]] = []
    for point in best:
        if not front or point["error"] < front[-1]["error"]:
            front.append(point)
    for loose, tight in zip([None, *front], front, strict=False):
        if tight["error"] <= error:
            if loose is None:
                return tight["seconds"]
            part = math.log(loose["error"] / error) / math.log(
                loose["error"] / max(tight["error"], 1e-17)
            )
            return float(loose["seconds"] * (tight["seconds"] / loose["seconds"]) ** part)
    return None


def ratios(
    measured: dict[str, Any], errors: Sequence[float] = (1e-6, 1e-9, 1e-11)
) -> dict[str, Any]:
    """Return, for each peer, its time at some errors as a multiple of the Taylor engine's."""
    own = measured["peers"][PackagePeer().name]
    table: dict[str, Any] = {}
    for name, points in measured["peers"].items():
        table[name] = {}
        for error in errors:
            here, unit = seconds_at(points, error), seconds_at(own, error)
            table[name][f"{error:.0e}"] = None if here is None or unit is None else here / unit
    return table


def measure(repeats: int, cases: Sequence[Case] = MOTIONS) -> dict[str, Any]:
    """Return the curves of all motions, with ratios at equal error."""
    result: dict[str, Any] = {}
    for case in cases:
        measured = curves(case, repeats)
        result[case.name] = measured | {"ratios": ratios(measured)}
        print(text(case.name, result[case.name]), flush=True)
    return result


def text(case: str, measured: dict[str, Any]) -> str:
    """Return the curves of one motion as a table."""
    lines = [case, *measured["skipped"]]
    for name, points in measured["peers"].items():
        row = "  ".join(f"{p['error']:.0e} {1e6 * p['seconds']:.0f}us" for p in points)
        lines.append(f"{name:36s} {row}")
    return "\n".join([*lines, ""])


@pytest.mark.parametrize("case", MOTIONS, ids=lambda c: c.name)
def test_every_contestant_converges(case):
    measured = curves(case, 1, TOLERANCES[2:7:2])
    print("", text(case.name, measured), sep="\n")
    for name, points in measured["peers"].items():
        assert points, name
        assert min(p["error"] for p in points) < 1e-6, name


def test_time_at_an_error_follows_the_best_points():
    points = [
        {"error": 1e-4, "seconds": 1.0},
        {"error": 1e-3, "seconds": 1.5},
        {"error": 1e-8, "seconds": 4.0},
    ]
    assert seconds_at(points, 1e-2) == 1.0
    assert seconds_at(points, 1e-6) == pytest.approx(2.0)
    assert seconds_at(points, 1e-9) is None
    assert np.isclose(seconds_at(points, 1e-8), 4.0)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the curves; write them as JSON where asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path, metavar="FILE")
    parser.add_argument("--repeats", type=int, default=21, help="rounds of timed runs")
    o = parser.parse_args(arguments)
    measured = measure(o.repeats)
    if o.json is not None:
        o.json.write_text(json.dumps(measured, indent=2) + "\n", "utf-8")


if __name__ == "__main__":
    main()
