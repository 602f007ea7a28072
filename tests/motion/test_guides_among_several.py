"""Guides beside contacts that open, through impacts of both."""

from dataclasses import replace

import pytest

from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, StopReason
from painleve_sym.laws.catalogue import one_law
from painleve_sym.laws.contact_kind import ContactKind
from painleve_sym.mechanics.toml.mechanism_file import mechanism_from_text
from painleve_sym.motion.simulator import Simulator
from tests.scenes import parameter

START = {"theta": 0.01, "x_A_dot": -0.5}
SOFT = {"k_B": 1e5, "c_B": 10.0, "beta": 0.0}


def _guided_block():
    block = model("block-two-feet")
    held, free = block.contacts
    return replace(block, contacts=(replace(held, bilateral=True), free))


@pytest.mark.slow
def test_guide_beside_a_compliant_foot_keeps_its_gap_and_the_energy():
    laws = {"A": one_law("rigid"), "B": one_law("linear")}
    run = Simulator(_guided_block(), laws).run(START, parameters=SOFT, t_end=0.3)
    assert run.stop_reason is StopReason.T_END
    assert run.final["y_A"] == 0 and run.final["y_A_dot"] == 0
    assert run.energy_residual < 1e-9


def test_a_guide_follows_its_own_law_whatever_its_neighbour_follows():
    block = _guided_block()
    for laws in ({"A": one_law("rigid"), "B": one_law("linear")}, one_law("linear")):
        simulator = Simulator(block, laws)
        assert simulator.contact.kinds == (ContactKind.GUIDE, ContactKind.COMPLIANT)
        assert simulator.choices["policy"] == "liftoff"
        assert "restitution" not in simulator.choices
        assert not [p.name for p in simulator.own_parameters if p.name.startswith("e")]
    with pytest.raises(InputError, match="holds from both sides, and a law only pushes"):
        Simulator(block, {"A": one_law("linear"), "B": one_law("rigid")})


DIMENSIONS = {
    "m": (1, 0, 0),
    "J": (1, 2, 0),
    "a": (0, 1, 0),
    "h": (0, 1, 0),
    "g": (0, 1, -2),
    "k_B": (1, 0, -2),
    "c_B": (1, 0, -1),
    "x_A_dot": (0, 1, -1),
    "theta_dot": (0, 0, -1),
}
HEAVILY_DAMPED = [
    (
        {"theta": 0.030491063730913315, "x_A_dot": -0.48323996, "theta_dot": -1.3544613111550587},
        {"mu_A": 1.522637455024931, "mu_B": 0.6749914199622027, "h": 0.563445546035138}
        | {"a": 0.4125920009638035, "J": 0.001050956057727339, "k_B": 21409.675, "c_B": 157.07},
    ),
    (
        {"theta": 0.023724757100169247, "x_A_dot": -0.64992350, "theta_dot": -1.352044293027924},
        {"mu_A": 6.178362000350421, "mu_B": 0.019637754471713897, "h": 0.12376245160744667}
        | {"a": 0.21809708806257855, "J": 0.0016347397494088176, "k_B": 118173.692, "c_B": 162.64},
    ),
    (
        {"theta": 0.10587245947506951, "x_A_dot": 0.02357528, "theta_dot": 0.7100280152283491},
        {"mu_A": 0.38477754788955554, "mu_B": 0.28295947261745447, "h": 0.24772299457242547}
        | {"a": 0.15070524618445194, "J": 0.002867839912356494, "k_B": 77504.733, "c_B": 484.94},
    ),
]


@pytest.mark.slow
@pytest.mark.parametrize(("state", "own"), HEAVILY_DAMPED)
def test_guide_beside_a_damped_foot_keeps_the_energy_in_all_units(state, own):
    """Guide and foot stick in a line: their friction against each other is hardly determined."""
    simulator = Simulator(_guided_block(), {"A": one_law("rigid"), "B": one_law("linear")})
    own = own | {"beta": 0.2, "m": 1.0, "g": 9.8}
    run = simulator.run(state, parameters=own, t_end=0.2)
    assert run.stop_reason is StopReason.T_END
    assert run.energy_residual < 1e-9
    mass, length, time = 1e3, 1e-3, 10.0

    def other(values):
        powers = {k: DIMENSIONS.get(k, (0, 0, 0)) for k in values}
        return {
            k: v * mass ** powers[k][0] * length ** powers[k][1] * time ** powers[k][2]
            for k, v in values.items()
        }

    same = simulator.run(other(state), parameters=other(own), t_end=0.2 * time)
    assert same.energy_residual < 1e-9
    # Slips slower than the tolerance are divided otherwise; landings and impacts are the same.
    for kind in ("touchdown", "impact"):
        times = [e.time / time for e in same.events_of(kind)]
        assert times == pytest.approx([e.time for e in run.events_of(kind)], rel=1e-9)
    assert same.final["x_A"] == pytest.approx(run.final["x_A"] * length, rel=1e-7)
    assert same.final["theta"] == pytest.approx(run.final["theta"], rel=1e-7, abs=1e-9)


@pytest.mark.slow
def test_impacts_beside_a_guide_without_friction_are_those_of_a_pendulum():
    """The foot on a pivot-like guide without friction: the motion keeps y_A = 0 and the energy."""
    for e in (0.0, 0.6, 1.0):
        run = Simulator(_guided_block(), one_law("rigid")).run(
            {"theta": 0.2},
            parameters={"beta": 0.0, "mu_A": 0.0, "mu_B": 0.0, "e_energetic": e},
            t_end=1.0,
        )
        assert run.stop_reason is StopReason.T_END
        assert run.final["y_A"] == 0 and run.final["y_A_dot"] == 0
        assert run.energy_residual < 1e-9
        hits = run.events_of("impact")
        assert len(hits) >= 1 and all(h.impulses[2] > 0 for h in hits if h.impulses)
        # Without friction a guide with a foot is one degree of freedom: each bounce keeps e.
        for hit, start in zip(hits, run.events_of("touchdown"), strict=False):
            assert hit.state["theta_dot"] == pytest.approx(
                -e * start.state["theta_dot"], rel=1e-9, abs=1e-12
            )


@pytest.mark.slow
@pytest.mark.parametrize("engine", ["taylor", "compiled"])
def test_impacts_beside_a_guide_with_friction_close_the_energy(engine):
    options = {"parameters": {"beta": 0.0, "mu_A": 0.4, "mu_B": 0.6}, "t_end": 0.6}
    run = Simulator(_guided_block(), one_law("rigid"), engine).run(
        {"theta": 0.05, "theta_dot": 0.3}, **options
    )
    assert run.stop_reason is StopReason.T_END
    assert len(run.events_of("impact")) >= 2
    assert run.final["y_A"] == 0 and run.final["y_A_dot"] == 0
    assert run.energy_residual < 1e-9
    for hit in run.events_of("impact"):
        P_n, P_t = hit.impulses[:2]
        assert abs(P_t) <= 0.4 * abs(P_n) * (1 + 1e-9)
    kinds = [str(e.kind) for e in run.events]
    wanted = Simulator(_guided_block(), one_law("rigid")).run(
        {"theta": 0.05, "theta_dot": 0.3}, **options
    )
    assert kinds == [str(e.kind) for e in wanted.events]
    assert run.final["x_A"] == pytest.approx(wanted.final["x_A"], rel=1e-8)


GUIDED = f"""
gravity = "g"
[coordinates]
x = {{ unit = "m", meaning = "place" }}
y = {{ unit = "m", meaning = "height" }}
theta = {{ unit = "rad", meaning = "tilt" }}
[parameters]
{parameter("m", 2.6, "kg", "mass", "positive = true")}\
{parameter("J", 0.05, "kg m^2", "moment of inertia", "positive = true")}\
{parameter("a", 0.165, "m", "half distance of the feet", "positive = true")}\
{parameter("h", 0.395, "m", "height of the mass centre")}\
{parameter("b", 0.09, "m", "place of the pin above the mass centre")}\
{parameter("k_theta", 52.0, "N m", "stiffness", "lower = 0")}\
{parameter("g", 9.8, "m/s^2", "gravity", "lower = 0")}\
{parameter("mu_pin", 0.1, "1", "friction coefficient")}\
{parameter("mu_A", 0.4, "1", "friction coefficient")}\
{parameter("mu_B", 0.4, "1", "friction coefficient")}
[[bodies]]
mass = "m"
inertia = "J"
angle = "theta"
centre = ["x", "y + h"]
[[springs]]
extension = "theta"
stiffness = "k_theta"
[[contacts]]
name = "pin"
point = ["x - b*sin(theta)", "y + h + b*cos(theta)"]
slope = "pi/2"
bilateral = true
friction = "mu_pin"
[[contacts]]
name = "A"
point = ["x - a*cos(theta) + h*sin(theta)", "y + h - a*sin(theta) - h*cos(theta)"]
friction = "mu_A"
[[contacts]]
name = "B"
point = ["x + a*cos(theta) + h*sin(theta)", "y + h + a*sin(theta) - h*cos(theta)"]
friction = "mu_B"
"""


@pytest.mark.slow
def test_feet_that_stick_beside_a_guide_leave_its_force_open_and_one_rests_at_its_bound():
    """Three level forces, two coordinates: engines stopped, or lost their step, in such states."""
    body = mechanism_from_text(GUIDED, name="guided")
    laws = {"A": one_law("linear"), "B": one_law("linear"), "pin": one_law("rigid")}
    start = {
        "theta": 0.00690550641477141,
        "theta_dot": -0.3345359409683949,
        "x": 0.0006246132321481102,
        "x_dot": -0.03025878789723803,
        "y": 0.0025271078828106304,
        "y_dot": -0.09735781655036095,
    }
    given = {"m": 2.601209876959093, "J": 0.04895339086607297, "a": 0.165042047531776}
    given |= {"h": 0.39486955573897686, "b": 0.09045219262404103, "k_theta": 52.37364589924226}
    given |= {"mu_pin": 0.09873106474540883, "mu_A": 0.00838931304302648}
    given |= {"mu_B": 0.5623625408608989, "k_A": 625790.4210460407, "c_A": 0.0}
    given |= {"k_B": 11749.565516764216, "c_B": 18.7765641550044}
    ends = []
    for engine in ("taylor", "compiled"):
        run = Simulator(body, laws, engine).run(start, parameters=given, t_end=0.2229)
        assert run.stop_reason is StopReason.T_END
        assert run.energy_residual < 1e-11
        ends.append(run)
    one, two = ends
    assert [e.kind for e in one.events] == [e.kind for e in two.events]
    assert one.final_state == pytest.approx(two.final_state, rel=1e-7, abs=1e-9)
    sticking = [e.mode_after for e in one.events if e.mode_after.count("stick") == 2]
    assert sticking
    # A foot that rests at its bound is said to stick, and its friction is at the edge of its cone.
    at = next(e.time for e in one.events if e.mode_after.count("stick") == 2) + 1e-9
    forces = one.outputs([at])
    shares = [
        abs(forces[f"tangential_force_{c}"][0])
        / (given[f"mu_{c}"] * forces[f"normal_force_{c}"][0])
        for c in "AB"
    ]
    assert max(shares) == pytest.approx(1, abs=1e-9)
