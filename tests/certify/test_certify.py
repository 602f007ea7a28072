"""Proofs on boxes: against closed forms, the checker against forged certificates, the command."""

from __future__ import annotations

import copy
import json
import math
from fractions import Fraction

import casadi as ca
import pytest
from hypothesis import given
from hypothesis import strategies as st

from painleve_sym.certify.checker import Polynomials, Rejected, check, digest, halves
from painleve_sym.certify.program import program_of
from painleve_sym.errors import InputError
from tests.cli.cli_helpers import rejected, run, run_json

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
    lambda x: (25 + x[0] * x[1]) ** 1.5 - (3 + x[1] ** 2) ** -0.5 + (6 + x[0]) ** -2,
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
    [model] = polynomials.evaluated(program, box)
    value = exactly(program, point)
    away = abs(value - polynomial_at(polynomials, model, distances(box, point)))
    assert away <= Fraction(model.error)
    assert Fraction(polynomials.lowest(model)) <= value


@given(SIDES, SIDES, SHARES, SHARES, st.sampled_from(SMOOTH), st.integers(1, 6))
def test_bounds_of_both_arithmetics_are_below_every_value(a, b, s, t, make, degree):
    f, box = function(make), (a, b)
    value = float(f([inside(side, u) for side, u in zip(box, (s, t), strict=True)]))
    polynomials = Polynomials(2, degree)
    try:
        lowest = polynomials.lowest(*polynomials.evaluated(program_of(f), box))
    except Rejected:
        lowest = -math.inf
    assert lowest <= value + 1e-12 * (1 + abs(value))
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    from painleve_sym.certify.ball_polynomials import BallPolynomials

    balls = BallPolynomials(2, degree)
    bound = balls.lower_bound(*balls.results(program_of(f), box))
    assert bound <= value + 1e-12 * (1 + abs(value))
    # What balls prove, the checker confirms.
    assert bound < 1e-9 or lowest >= bound / 2


def test_bounds_come_near_the_least_value_with_the_power_of_the_degree():
    f, errors = function(lambda x: ca.sin(x[0]) / (2 + x[0]), 1), []
    for half in (0.2, 0.1):
        box = [(0.7 - half, 0.7 + half)]
        errors.append(Polynomials(1, 4).evaluated(program_of(f), box)[0].error)
    assert errors[0] / errors[1] == pytest.approx(2**5, rel=0.2)


@pytest.mark.parametrize("half", [0.3, 0.75, 0.95])
@pytest.mark.parametrize("degree", [1, 2, 5])
@pytest.mark.parametrize("make", [lambda x: 1 / x[0], lambda x: ca.sqrt(x[0])], ids=["1/x", "root"])
def test_the_rest_of_a_series_holds_at_the_ends_of_a_wide_piece(make, half, degree):
    """The terms that a series leaves out have one sign at one end: all of them count."""
    f, box = function(make, 1), [(1 - half, 1 + half)]
    polynomials = Polynomials(1, degree)
    [model] = polynomials.evaluated(program_of(f), box)
    for end in box[0]:
        at = distances(box, [end])
        away = abs(float(f(end)) - float(polynomial_at(polynomials, model, at)))
        assert away <= model.error * (1 + 1e-9)
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    from painleve_sym.certify.ball_polynomials import BallPolynomials

    balls = BallPolynomials(1, degree)
    [result] = balls.results(program_of(f), box)
    for end, side in zip(box[0], (-1, 1), strict=True):
        value = sum(c * side**k for k, c in result.items())
        assert value.contains(float(f(end))) or abs(value - float(f(end))) < 1e-12


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

    f = function(make, len(over))
    conditions = [f"condition {k}" for k in range(f.numel_out(0))]
    return prove_positive(f, conditions, over, "test", **options)


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
    assert touching.piece is not None and touching.condition == "condition 0"
    late = proved(lambda x: (x[0] - x[1]) ** 2, box, max_seconds=0.0)
    assert late.verdict == "undecided" and late.piece == box


def test_condition_is_refuted_only_where_those_before_it_hold():
    # x > 0 in the unit interval, 1/x - 3 < 0 from x = 1/3 on, and nothing beyond its pole at 0.
    def make(x):
        return ca.vertcat(x[0], 1 / x[0] - 3)

    left = proved(make, {"x": (-1.0, 1.0)})
    assert (left.verdict, left.condition) == ("refuted", "condition 0")
    low, high = left.piece["x"]
    assert low + high < 0
    later = proved(make, {"x": (0.1, 1.0)})
    assert (later.verdict, later.condition) == ("refuted", "condition 1")
    assert sum(later.piece["x"]) / 2 > 1 / 3
    # The formula has no value at 0, where x + 0.1 is positive.
    pole = proved(lambda x: ca.vertcat(x[0] + 0.1, 1 / x[0] ** 2), {"x": (-0.05, 0.06)})
    assert (pole.verdict, pole.condition) == ("undecided", "condition 1")
    low, high = pole.piece["x"]
    assert -1e-9 < low < high < 1e-9
    # Where the first one is 0, and not known to fail, the second does not count.
    border = proved(lambda x: ca.vertcat(0, -1 - x[0] ** 2), {"x": (0.0, 1.0)}, max_pieces=20)
    assert (border.verdict, border.condition) == ("undecided", "condition 0")
    both = proved(make, {"x": (0.1, 0.33)})
    assert both.verdict == "proved" and check(both.certificate) == both.pieces


@pytest.fixture(scope="module")
def certificate():
    return proved(
        lambda x: ca.vertcat(4 - x[0], 0.6 - ca.sin(x[0]) * ca.cos(x[0]) * x[1]),
        {"x": (0.0, 3.0), "y": (0.2, 1.0)},
    ).certificate


def test_certificate_is_verified(certificate):
    assert check(json.loads(json.dumps(certificate))) > 1


def forged(certificate, change):
    copied = copy.deepcopy(certificate)
    change(copied)
    return copied | {"sha256": digest(copied)}


def leaf(certificate):
    return next(node for node in certificate["tree"] if isinstance(node, list))


CHANGES = {
    "hash": (lambda c: None, "hash"),
    "bound too large": (lambda c: leaf(c).__setitem__(1, (5.0).hex()), "not confirmed"),
    "first bound": (lambda c: leaf(c).__setitem__(0, (5.0).hex()), "not confirmed.*condition 0"),
    "bound 0": (lambda c: leaf(c).__setitem__(1, (0.0).hex()), "not positive"),
    "bound nan": (lambda c: leaf(c).__setitem__(0, "nan"), "not positive"),
    "bound left out": (lambda c: leaf(c).pop(0), "damaged"),
    "condition left out": (lambda c: c["conditions"].pop(0), "one result for each condition"),
    "no condition": (lambda c: c.update(conditions=[], tree=[[]], program=[]), "one result"),
    "piece left out": (lambda c: c["tree"].pop(), "do not cover"),
    "piece too many": (lambda c: c["tree"].append([(0.1).hex()] * 2), "more pieces"),
    "wider box": (lambda c: c["over"].__setitem__(1, ["y", 0.2, 1.3]), "not confirmed"),
    "other formula": (
        lambda c: c["program"].__setitem__(
            next(k for k, s in enumerate(c["program"]) if s[0] == "const"),
            ["const", next(s for s in c["program"] if s[0] == "const")[1], [(0.5).hex()]],
        ),
        "not confirmed",
    ),
    "no program": (lambda c: c.pop("program"), "damaged"),
    "no result": (lambda c: c["program"].pop(), "one result for each condition"),
    "twice a result": (
        lambda c: next(s for s in c["program"] if s[0] == "output").__setitem__(1, 1),
        "damaged",
    ),
    "words": (lambda c: c.__setitem__("over", "all"), "damaged"),
    "side": (lambda c: c["tree"].__setitem__(0, 7), "halves side 7 of a box of 2"),
    "degree": (lambda c: c.__setitem__("degree", 17), "the degree 17"),
    "lower degree": (lambda c: c.__setitem__("degree", 1), "not confirmed"),
    "ends": (lambda c: c["over"].__setitem__(1, ["y", 1.0, 0.2]), "wrong order"),
    "infinite": (lambda c: c["over"].__setitem__(1, ["y", 0.2, math.inf]), "ends finite"),
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
    changed["over"][0][2] = 1.5
    (tmp_path / "rod.json").write_text(json.dumps(changed))
    code, out, _ = run(capsys, *ROD, "--set", "mu=1.333", "--check", file)
    assert code == 1 and out.startswith("rejected")


def test_rod_in_space_is_certified_for_every_direction(capsys):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    space = ("certify", "rod-3d", "--over", "theta=0.2:1.4")
    assert run(capsys, *space, "--set", "mu=1.3")[0] == 0
    assert run(capsys, *space, "--set", "mu=1.4")[0] == 1


LEFT = {
    "declared bound": (("rod-3d", "theta=-0.5:0.5", "mu=0.5"), "sin(theta) > 0", "theta", 0.0),
    "gimbal lock": (("rod-3d", "theta=1:2", "mu=0.1"), "gimbal lock", "theta", math.pi / 2),
    "gimbal lock beside a singular mass matrix": (
        ("brick", "theta=1.2:1.6", "mu=0.1"),
        "gimbal lock",
        "theta",
        math.pi / 2,
    ),
    "moment of inertia": (("top", "J_3=1e-5:9e-5", "mu=0.1"), "moment of inertia", "J_3", 6e-5),
}
"""Boxes that leave the domain, a part of the message, and the border of the domain within them."""


@pytest.mark.parametrize("name", LEFT)
def test_box_that_leaves_the_domain_is_refuted_there(capsys, name):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    (mechanism, over, held), said, quantity, border = LEFT[name]
    command = ("certify", mechanism, "--over", over, "--set", held)
    code, out, _ = run(capsys, *command, "--json")
    data = json.loads(out)
    assert (code, data["verdict"]) == (1, "refuted") and said in data["condition"]
    # classify rejects the middle of the piece for the same reason.
    at = {"theta": 0.5, quantity: sum(data["piece"][quantity]) / 2}
    option = "--set" if quantity == "J_3" else "--state"
    place = [
        word
        for n, v in at.items()
        for word in ("--state" if n == "theta" else option, f"{n}={v!r}")
    ]
    err = rejected(capsys, "classify", mechanism, "--set", held, *place)
    assert said in " ".join(err.split())
    shown = " ".join(run(capsys, *command)[1].split())
    assert f"refuted: need {data['condition']}, which fails in the middle" in shown
    low, high = (float(end) for end in over.partition("=")[2].split(":"))
    inside = (0.1, high) if border <= 0 else (low, 0.9 * border)
    kept = f"{quantity}={inside[0]}:{inside[1]}"
    assert run(capsys, *command[:3], kept, "--set", held)[0] == 0


def test_mass_matrix_that_is_singular_beside_the_lock_names_the_lock(capsys):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    # 2.3e-6 rad from the lock: within its border of 1e-6 rad there is no state of this box.
    box = ("--over", "theta=1.5:1.570794", "--set", "mu=0.1", "--json")
    data = json.loads(run(capsys, "certify", "brick", *box)[1])
    assert data["verdict"] == "refuted"
    assert data["condition"].startswith("a regular mass matrix")
    assert data["condition"].endswith("which it loses in gimbal lock")


SINGULAR = """
[coordinates]
x = { unit = "m", meaning = "place of a slider" }
y = { unit = "m", meaning = "its height" }
r = { unit = "m", meaning = "distance of a bead from the axis of its rod" }
s = { unit = "rad", meaning = "angle of the rod" }
[parameters]
mu = { default = 0.5, unit = "1", meaning = "friction coefficient" }
[[bodies]]
mass = 1
centre = ["x", "y"]
[[bodies]]
mass = 1
centre = ["r*cos(s)", "r*sin(s)"]
[[contacts]]
name = "slider"
point = ["x", "y"]
friction = "mu"
"""


def test_box_with_a_singular_mass_matrix_is_not_proved(capsys, tmp_path):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    # The rod has no inertia where the bead is in its axis, and W of the slider does not tell.
    file = tmp_path / "bead.toml"
    file.write_text(SINGULAR)
    code, out, _ = run(capsys, "certify", str(file), "--over", "r=-0.5:0.6", "--json")
    data = json.loads(out)
    # r² comes down to 0 and not below.
    assert (code, data["verdict"]) == (1, "undecided")
    assert "kinetic energy of s_dot alone" in data["condition"]
    low, high = data["piece"]["r"]
    assert -1e-9 < low < high < 1e-9
    assert run(capsys, "certify", str(file), "--over", "r=0.1:0.6")[0] == 0


BALL = """
[coordinates]
x = { unit = "m", meaning = "first place of a bead" }
y = { unit = "m", meaning = "second place" }
z = { unit = "m", meaning = "height" }
[parameters]
mu = { default = 0.5, unit = "1", meaning = "friction coefficient" }
[[bodies]]
name = "bead"
mass = 1
centre = ["x", "y", "z"]
[[contacts]]
name = "bead"
friction = "mu"
point = ["x", "y", "z"]
surface = "x**2 + y**2 + z**2 - 1"
"""


@pytest.mark.slow
def test_surface_whose_normal_vanishes_is_not_proved(capsys, tmp_path):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    file = tmp_path / "ball.toml"
    file.write_text(BALL)
    # Its formulas have |∇g|³ = (4 x² + 4 y² + 4 z²)^(3/2).
    assert run(capsys, "certify", str(file), "--over", "y=0.6:1")[0] == 0
    code, out, _ = run(capsys, "certify", str(file), "--over", "y=-0.3:1", "--json")
    data = json.loads(out)
    assert (code, data["verdict"]) == (1, "undecided")
    assert all(abs(end) < 1e-12 for end in data["piece"]["y"])
    shown = " ".join(run(capsys, "certify", str(file), "--over", "y=-0.3:1")[1].split())
    assert f"undecided: need {data['condition']}, whose bounds stay too wide on this" in shown


def test_certificate_without_its_bounds_is_rejected(capsys, tmp_path):
    pytest.importorskip("flint", reason="needs the extra certify (python-flint)")
    file, command = tmp_path / "rod.json", ("certify", "rod-3d", "--set", "mu=0.5", "--over")
    run_json(capsys, *command, "theta=0.2:0.9", "--out", str(file))
    content = json.loads(file.read_text())
    assert content["conditions"][0].startswith("sin(theta) > 0")
    content["conditions"].pop(0)
    for node in content["tree"]:
        if isinstance(node, list):
            node.pop(0)
    program = [s for s in content["program"] if s[0] != "output" or s[1] != 0]
    content["program"] = [[n, p - 1 if n == "output" else p, t] for n, p, t in program]
    forged = content | {"sha256": digest(content)}
    # It proves what it says, which is not enough.
    assert check(forged) >= 1
    file.write_text(json.dumps(forged))
    code, out, _ = run(capsys, *command, "theta=0.2:0.9", "--check", str(file))
    assert code == 1 and out.startswith("rejected: its conditions is not")


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
    assert expected in rejected(capsys, "certify", *arguments)
