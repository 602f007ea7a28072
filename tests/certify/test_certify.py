"""Proofs on boxes: against closed forms, the checker against forged certificates, the command."""

from __future__ import annotations

import copy
import json
import math

import casadi as ca
import pytest
from hypothesis import given
from hypothesis import strategies as st

from painleve_sym.certify.checker import Interval, Rejected, check, digest, evaluated, halves
from painleve_sym.certify.program import program_of
from painleve_sym.errors import InputError
from tests.cli.cli_helpers import run, run_json

ENDS = st.tuples(st.floats(-9, 9), st.floats(0, 4)).map(lambda p: Interval(p[0], p[0] + p[1]))
ROD = ("certify", "rod", "--over", "theta=0.2:1.4")


def function(make, n=2):
    x = ca.SX.sym("x", n)
    return ca.Function("f", [x], [make(x)])


SMOOTH = (
    lambda x: ca.sin(x[0]) * ca.cos(x[1]) - x[0] ** 2 / (2 + x[1] ** 2),
    lambda x: ca.sqrt(1 + x[0] ** 2) + x[1] ** 3 - 2 * x[0],
    lambda x: 1 / (3 + ca.cos(x[0])) - x[1] * x[0] + ca.sin(-x[1]),
)


@given(ENDS, ENDS, st.floats(0, 1), st.floats(0, 1), st.sampled_from(SMOOTH))
def test_intervals_hold_every_value_and_derivative(a, b, s, t, make):
    f = function(make)
    whole = evaluated(program_of(f), (a, b))
    point = [min(side.high, side.low + u * (side.high - side.low)) for side, u in ((a, s), (b, t))]
    x = ca.SX.sym("x", 2)
    slopes = ca.Function("g", [x], [ca.gradient(f(x), x)])(point)
    for value, range_ in zip(
        (f(point), slopes[0], slopes[1]), (whole.value, *whole.slopes), strict=True
    ):
        slack = 1e-12 * (1 + abs(float(value)))
        assert range_.low - slack <= float(value) <= range_.high + slack


@given(ENDS)
def test_waves_are_within_their_ranges_and_reach_them(side):
    for wave, range_ in ((math.sin, side.sine()), (math.cos, side.cosine())):
        values = [wave(side.low + k / 200 * (side.high - side.low)) for k in range(201)]
        assert range_.low <= min(values) and max(values) <= range_.high
        assert range_.high - max(values) < 3e-4 and min(values) - range_.low < 3e-4


def test_division_by_an_interval_with_zero_is_rejected():
    with pytest.raises(Rejected, match="divide by 0"):
        evaluated(program_of(function(lambda x: x[0] / x[1])), (Interval(1, 2), Interval(-1, 1)))
    with pytest.raises(Rejected, match="negative number"):
        evaluated(program_of(function(lambda x: ca.sqrt(x[0]))), (Interval(-1, 1), Interval(0, 1)))


def test_operation_without_bounds_is_an_error():
    with pytest.raises(InputError, match="an operation other than sums"):
        program_of(function(lambda x: ca.atan2(x[0], x[1])))


def proved(make, over, **options):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    from painleve_sym.certify.proof import prove_positive

    return prove_positive(function(make, len(over)), over, "test", **options)


def test_verdicts_are_those_of_closed_forms():
    # 2 - sin x cos y has the least value 1; x² + y² - 1 is negative in the disc.
    box = {"x": (-5.0, 5.0), "y": (-5.0, 5.0)}
    assert proved(lambda x: 2 - ca.sin(x[0]) * ca.cos(x[1]), box).verdict == "proved"
    inside = proved(lambda x: x[0] ** 2 + x[1] ** 2 - 1, {"x": (-2.0, 2.1), "y": (-2.0, 2.2)})
    assert inside.verdict == "refuted"
    middles = [(a + b) / 2 for a, b in inside.piece.values()]
    assert sum(m**2 for m in middles) < 1
    # It touches 0, which no bound decides.
    touching = proved(lambda x: (x[0] - x[1]) ** 2, box, max_pieces=50)
    assert touching.verdict == "undecided" and touching.certificate is None


@pytest.fixture(scope="module")
def certificate():
    return proved(
        lambda x: 0.6 - ca.sin(x[0]) * ca.cos(x[0]) * x[1], {"x": (0.0, 3.0), "y": (0.2, 1.0)}
    ).certificate


def test_certificate_is_verified(certificate):
    assert check(json.loads(json.dumps(certificate))) > 1


def forged(certificate, change):
    copied = copy.deepcopy(certificate)
    change(copied)
    return copied | {"sha256": digest(copied)}


def leaf(certificate):
    return next(k for k, node in enumerate(certificate["tree"]) if isinstance(node, str))


CHANGES = {
    "hash": (lambda c: None, "hash"),
    "bound too large": (lambda c: c["tree"].__setitem__(leaf(c), (5.0).hex()), "not confirmed"),
    "bound 0": (lambda c: c["tree"].__setitem__(leaf(c), (0.0).hex()), "not positive"),
    "bound nan": (lambda c: c["tree"].__setitem__(leaf(c), "nan"), "not positive"),
    "piece left out": (lambda c: c["tree"].pop(), "do not cover"),
    "piece too many": (lambda c: c["tree"].append((0.1).hex()), "more pieces"),
    "wider box": (lambda c: c["over"].__setitem__("y", [0.2, 1.3]), "not confirmed"),
    "other formula": (
        lambda c: c["program"].__setitem__(
            next(k for k, s in enumerate(c["program"]) if s[0] == "const"),
            ["const", next(s for s in c["program"] if s[0] == "const")[1], [(0.5).hex()]],
        ),
        "not confirmed",
    ),
    "no program": (lambda c: c.pop("program"), "damaged"),
    "no result": (lambda c: c["program"].pop(), "no result"),
    "words": (lambda c: c.__setitem__("over", "all"), "damaged"),
    "side": (lambda c: c["tree"].__setitem__(0, 7), "damaged"),
}


@pytest.mark.parametrize("name", CHANGES)
def test_forged_certificate_is_rejected(certificate, name):
    change, reason = CHANGES[name]
    changed = forged(certificate, change)
    if name == "hash":
        changed["claim"] = "everything"
    with pytest.raises(Rejected, match=reason):
        check(changed)


def test_halves_share_their_border():
    left, right = halves([Interval(0.0, 1.0), Interval(2.0, 4.0)], 1)
    assert left[1].high == right[1].low == 3.0 and left[0] == right[0] == (0.0, 1.0)


def test_rod_is_proved_below_its_threshold_and_refuted_above(capsys, tmp_path):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    file = f"{tmp_path}/rod.json"
    below = run_json(capsys, *ROD, "--set", "mu=1.333", "--out", file)
    assert below["verdict"] == "proved" and below["piece"] is None
    code, out, _ = run(capsys, *ROD, "--set", "mu=1.34", "--json")
    data = json.loads(out)
    low, high = data["piece"]["theta"]
    theta = (low + high) / 2
    assert (code, data["verdict"]) == (1, "refuted")
    # m A = 1 + 3 cos² θ - 3 μ sin θ cos θ of a uniform rod.
    assert 1 + 3 * math.cos(theta) ** 2 - 3 * 1.34 * math.sin(theta) * math.cos(theta) < 0
    checked = run_json(capsys, *ROD, "--set", "mu=1.333", "--check", file)
    assert checked["verdict"] == "verified" and checked["pieces"] == below["pieces"]
    code, out, _ = run(capsys, *ROD, "--set", "mu=1.3", "--check", file)
    assert code == 1 and "its claim is not that of this command" in out
    changed = json.loads((tmp_path / "rod.json").read_text())
    changed["over"]["theta"][1] = 1.5
    (tmp_path / "rod.json").write_text(json.dumps(changed))
    code, out, _ = run(capsys, *ROD, "--set", "mu=1.333", "--check", file)
    assert code == 1 and out.startswith("rejected")


def test_rod_in_space_is_certified_for_every_direction(capsys):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    space = ("certify", "rod-3d", "--over", "theta=0.2:1.4")
    assert run(capsys, *space, "--set", "mu=1.3")[0] == 0
    assert run(capsys, *space, "--set", "mu=1.4")[0] == 1


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("rod", "--over", "thet=0:1"), "unknown quantity 'thet'. Did you mean 'theta'?"),
        (("rod", "--over", "theta=1:0"), "theta from 1 to 0, need ends that grow"),
        (("rod", "--over", "theta=0.2"), "need FROM:TO"),
        (("rod", "--over", "mu=-1:1"), "parameter mu"),
        (("rod", "--over", "mu=1:2", "--set", "mu=1"), "got mu both varied and set"),
        (("block-two-feet", "--over", "mu=0.1:0.2"), "got 2 contacts, need one"),
        (("rod", "--over", "theta=0:1", "--check", "absent.json"), "No such file"),
    ],
)
def test_bad_input_is_one_sentence(capsys, arguments, expected):
    code, out, err = run(capsys, "certify", *arguments)
    assert code == 2 and out == "" and expected in err
