"""The command map: which case of the rigid contact holds, over two quantities."""

from __future__ import annotations

import argparse
import math
from fractions import Fraction
from functools import partial
from typing import Any

from painleve_sym.cli.case import chosen_mechanism
from painleve_sym.cli.options import (
    MAPS,
    figure_file,
    read_look,
    read_names,
    read_quantities,
    read_ranges,
)
from painleve_sym.cli.output import assignments, deliver_map, number, quantity, show, show_table
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.problem.solution import ContactCase
from painleve_sym.study.maps.axes import SLIP_DIRECTION, axis_units
from painleve_sym.study.maps.region_map import RegionMap, region_map
from painleve_sym.study.scenario import Scenario

SHOWN_CROSSINGS = 20
_OUTSIDE = "beyond the mechanism's domain"


def map(arguments: argparse.Namespace) -> int:
    """Compute the map, write the files asked for and print what it holds."""
    look = read_look(arguments)
    files = [figure_file("--out", text, look, MAPS) for text in arguments.out or ()]
    over = read_names("--over", arguments.over)
    mechanism = chosen_mechanism(arguments.model, arguments.contact)

    units = partial(axis_units, mechanism)
    options: dict[str, Any] = {
        "ranges": read_ranges("--range", arguments.range, units, "0.1:1.5"),
        "state": read_quantities("--state", arguments.state, units) or None,
        "parameters": read_quantities("--set", arguments.set, units),
        "points": arguments.points,
        "slip": arguments.slip,
        "close": arguments.close,
    }
    if arguments.material is not None:
        given = {"parameters": options["parameters"], "material": arguments.material}
        case = Scenario(arguments.model, contact=arguments.contact, where="map", **given)
        options["parameters"] = case.from_material(over).parameters
    regions = region_map(mechanism, over, **options)
    show_text = None if arguments.json else lambda: _show(regions, mechanism)
    notices = mechanism.outline.truncation_notices
    deliver_map(regions, files, "map_figure", look, show_text, notices)
    return 0


def _show(regions: RegionMap, mechanism: Mechanism) -> None:
    show(f"{mechanism.name} with {assignments(regions.parameters, mechanism.units)}")
    held = {name: value for name, value in regions.state.items() if value != 0}
    if held:
        show(f"at {assignments(held, mechanism.state_units)} (others 0)")
    if regions.close:
        show(f"with the contact closed at every point by {regions.close}")
    data: dict[str, Any] = regions.summary()
    for axis in data["axes"]:
        ends = f"{number(axis['from'])} to {quantity(axis['to'], axis['unit'])}"
        show(f"over {axis['name']} from {ends}, {axis['points']} points")
    show()
    sign = "<" if regions.slip < 0 else ">"
    way = f"with v_t {sign} 0"
    if regions.in_space:
        ways = f"along {number(regions.slip)} rad from t1 towards t2"
        way = "in every direction" if SLIP_DIRECTION in regions.over else ways
    show(f"cases of the rigid contact, slip {way}")
    total = regions.case.size
    meanings = {case.value: case.sentence for case in ContactCase} | {"outside": _OUTSIDE}
    rows = [
        (name, f"{100 * regions.counts[name] / total:.2f} %", meaning)
        for name, meaning in meanings.items()
        if regions.counts.get(name)
    ]
    show_table(("case", "points", "meaning"), rows, left=(0, 2))
    share = 100 * data["stick_feasible_count"] / total
    show(f"a contact without slip velocity could stick at {share:.2f} % of the points")
    show()
    _show_zeros(regions)
    if "mu_P" in regions.thresholds:
        show(f"A < 0 is possible for mu > mu_P = {number(regions.thresholds['mu_P'], 9)}")
    if "least_over_normals" in regions.thresholds:
        least = number(regions.thresholds["least_over_normals"], 9)
        show(f"least mu_P of all normals of the surface: {least}")
    if "mu_C" in regions.thresholds:
        show(f"second threshold mu_C = 2/sqrt(3) mu_P = {number(regions.thresholds['mu_C'], 9)}")


def _show_zeros(regions: RegionMap) -> None:
    """Print where A and B vanish together along curves, and where A = 0 and B = 0 cross."""
    units = dict(zip(regions.over, regions.units, strict=True))
    for curve in regions.shared_zeros:
        at = ", ".join(f"{name} = {_angle(value, units[name])}" for name, value in curve.items())
        along = "along" if len(curve) == 1 else "along a curve through"
        show(f"A and B vanish together {along} {at}")
    if not len(regions.crossings):
        cross = "cross nowhere else" if regions.shared_zeros else "do not cross here"
        show(f"A = 0 and B = 0 {cross}")
        return
    show("A = 0 and B = 0 cross at")
    head = [f"{n} [{u}]" for n, u in units.items()]
    rows = [[number(v, 15) for v in row] for row in regions.crossings[:SHOWN_CROSSINGS].tolist()]
    show_table(head, rows, left=())
    if (hidden := len(regions.crossings) - SHOWN_CROSSINGS) > 0:
        show(f"  and at {hidden} more, which --json lists")


def _angle(value: float, unit: str) -> str:
    """Return a number with its unit; an angle that is a part of a turn as such, like pi/2."""
    twelfths = 12 * value / math.pi
    if unit != "rad" or not round(twelfths) or abs(twelfths - round(twelfths)) > 1e-9:
        return quantity(value, unit, 9)
    part = Fraction(round(twelfths), 12)
    above = {1: "pi", -1: "-pi"}.get(part.numerator, f"{part.numerator} pi")
    return above if part.denominator == 1 else f"{above}/{part.denominator}"
