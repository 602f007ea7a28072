"""Proofs on boxes: against closed forms, the checker against forged certificates, the command."""

from __future__ import annotations

import copy
import json
import math
from fractions import Fraction

import casadi as ca
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.certify.checker import Polynomials, Rejected, check, digest, halves
from painleve_sym.certify.program import program_of
from painleve_sym.errors import InputError
from tests.cli.cli_helpers import run, run_json

SIDES = st.tuples(st.floats(-3, 3), st.floats(0, 1.5)).map(lambda p: (p[0], p[0] + p[1]))
SHARES = st.floats(0, 1)
ROD = ("certify", "rod", "--over", "theta=0.2:1.4")


def function(make, n=2):
    x = ca.SX.sym("x", n)
    return ca.Function("f", [x], [make(x)])


RATIONAL = (
    lambda x: x[0] / (7 + x[1] ** 2) - 2 * x[1] + 1 / (12 - x[0]),
    lambda x: (x[0] - x[1]) ** 3 * (x[0] + 0.1) ** 2 - x[1] * x[0],
)
SMOOTH = (
    lambda x: ca.sin(x[0]) * ca.cos(x[1]) - x[0] ** 2 / (2 + x[1] ** 2 / 9),
    lambda x: ca.sqrt(12 + x[0] * x[1]) + x[1] ** 3 - 2 * x[0],
    lambda x: 1 / (3 + ca.cos(x[0])) - x[1] * x[0] + ca.sin(-x[1]),
)


def inside(side, share):
    return min(side[1], side[0] + share * (side[1] - side[0]))


def distances(box, point):
    """Return exactly where a point is between the middle of a box and its ends, from -1 to 1."""
    away = []
    for p, (low, high) in zip(point, box, strict=True):
        middle = low + (high - low) / 2
        radius = math.nextafter(max(high - middle, middle - low), math.inf)
        away.append((Fraction(p) - Fraction(middle)) / Fraction(radius))
    return away


def exactly(program, point):
    """Follow a program of sums, products and quotients in rational numbers."""
    operations = {
        "add": lambda x, y: x + y,
        "sub": lambda x, y: x - y,
        "mul": lambda x, y: x * y,
        "div": lambda x, y: x / y,
        "neg": lambda x: -x,
        "sq": lambda x: x * x,
        "twice": lambda x: 2 * x,
        "inv": lambda x: 1 / x,
    }
    places = {}
    for name, place, taken in program:
        if name == "const":
            places[place] = Fraction(float.fromhex(taken[0]))
        elif name == "input":
            places[place] = Fraction(point[taken[0]])
        elif name == "output":
            return places[taken[0]]
        else:
            places[place] = operations[name](*(places[k] for k in taken))
    raise AssertionError


def polynomial_at(polynomials, model, at):
    """Return the polynomial of a model exactly."""
    total = Fraction(0)
    for k, c in model.terms.items():
        term = Fraction(c)
        for i, d in enumerate(at):
            term *= d ** (k // polynomials.base**i % polynomials.base)
        total += term
    return total


@given(SIDES, SIDES, SHARES, SHARES, st.sampled_from(RATIONAL), st.integers(1, 5))
def test_taylor_model_is_within_its_error_of_exact_values(a, b, s, t, make, degree):
    program, box = program_of(function(make)), (a, b)
    point = [inside(side, u) for side, u in zip(box, (s, t), strict=True)]
    polynomials = Polynomials(2, degree)
    model = polynomials.evaluated(program, box)
    value = exactly(program, point)
    away = abs(value - polynomial_at(polynomials, model, distances(box, point)))
    assert away <= Fraction(model.error)
    assert Fraction(polynomials.lowest(model)) <= value


@settings(deadline=None)  # The first call imports flint.
@given(SIDES, SIDES, SHARES, SHARES, st.sampled_from(SMOOTH), st.integers(1, 6))
def test_bounds_of_both_arithmetics_are_below_every_value(a, b, s, t, make, degree):
    f, box = function(make), (a, b)
    value = float(f([inside(side, u) for side, u in zip(box, (s, t), strict=True)]))
    polynomials = Polynomials(2, degree)
    try:
        lowest = polynomials.lowest(polynomials.evaluated(program_of(f), box))
    except Rejected:
        lowest = -math.inf
    assert lowest <= value + 1e-12 * (1 + abs(value))
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    from painleve_sym.certify.ball_polynomials import BallPolynomials

    balls = BallPolynomials(2, degree)
    bound = balls.lower_bound(balls.results(program_of(f), box))
    assert bound <= value + 1e-12 * (1 + abs(value))
    # What balls prove, the checker confirms.
    assert bound < 1e-9 or lowest >= bound / 2


def test_bounds_come_near_the_least_value_with_the_power_of_the_degree():
    f, errors = function(lambda x: ca.sin(x[0]) / (2 + x[0]), 1), []
    for half in (0.2, 0.1):
        box = [(0.7 - half, 0.7 + half)]
        errors.append(Polynomials(1, 4).evaluated(program_of(f), box).error)
    assert errors[0] / errors[1] == pytest.approx(2**5, rel=0.2)


def test_division_by_what_may_be_zero_is_rejected():
    box = ((1.0, 2.0), (-1.0, 1.0))
    with pytest.raises(Rejected, match="divide by 0"):
        Polynomials(2, 3).evaluated(program_of(function(lambda x: x[0] / x[1])), box)
    with pytest.raises(Rejected, match="negative number"):
        Polynomials(2, 3).evaluated(program_of(function(lambda x: ca.sqrt(x[1]))), box)


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
    assert touching.piece is not None
    late = proved(lambda x: (x[0] - x[1]) ** 2, box, max_seconds=0.0)
    assert late.verdict == "undecided" and late.piece == box


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
    "degree": (lambda c: c.__setitem__("degree", 17), "the degree 17"),
    "lower degree": (lambda c: c.__setitem__("degree", 1), "not confirmed"),
    "ends": (lambda c: c["over"].__setitem__("y", [1.0, 0.2]), "wrong order"),
    "infinite": (lambda c: c["over"].__setitem__("y", [0.2, math.inf]), "no finite value"),
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
    left, right = halves([(0.0, 1.0), (2.0, 4.0)], 1)
    assert left[1][1] == right[1][0] == 3.0 and left[0] == right[0] == (0.0, 1.0)


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
