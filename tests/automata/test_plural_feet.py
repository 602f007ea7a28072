"""A block on two compliant feet against an independent integration with SciPy."""

import numpy as np
import pytest

from painleve_sym.errors import StopReason
from tests.oracles.feet_scipy import Block, Law
from tests.scenes import FEET, simulator

# K_e of the laws' formula, both bodies of one material: (4/3) E/(2 (1 - nu^2)) sqrt(R).
_PER_MODULUS = 4 / 3 / (2 * (1 - 0.3**2)) * np.sqrt(0.00645)
LAWS = {
    "hertz": ("hertz", {"E": 2e7}, Law(2e7 * _PER_MODULUS, 1.5)),
    "linear": ("linear", {"k": 1e5, "c": 40.0}, Law(1e5, 1.0, 40.0)),
    "bilinear": ("bilinear-hertz", {"E": 3e7}, Law(3e7 * _PER_MODULUS, 1.5, 0.0, 0.75)),
}
STARTS = {
    "level drop on the slope": ({"y_A": 1e-3, "x_A_dot": -0.05}, 0.1, {}),
    "tilted drop": ({"y_A": 1e-3, "theta": 0.02, "x_A_dot": -0.3}, 0.1, {}),
    "drop on B": ({"y_A": 5e-3, "theta": -0.02, "x_A_dot": 0.3, "theta_dot": 0.3}, 0.1, {}),
    "slide": ({"y_A": -1e-4, "x_A_dot": -1.0}, 0.1, {}),
    "rocking": ({"y_A": 1e-4, "theta": 0.05}, 0.15, {"mu_A": 0.9, "mu_B": 0.9}),
}


def _both(names, start, t_end, own):
    """Return the run, the oracle's events and its end state."""
    tags = ("",) if len(names) == 1 else ("_A", "_B")
    given = {f"{k}{t}": v for n, t in zip(names, tags, strict=True) for k, v in LAWS[n][1].items()}
    laws = tuple(LAWS[n][2] for n in names) * (2 // len(names))
    block = Block(laws, mu=(own.get("mu_A", 0.4), own.get("mu_B", 0.6)))
    events, end = block.run(block.start(**start), t_end)
    laws = [LAWS[n][0] for n in names]
    text = ",".join(map("=".join, zip("AB", laws, strict=True))) if len(laws) > 1 else laws[0]
    run = simulator(FEET, text).run(start, parameters=given | own, t_end=t_end)
    return run, events, block.foot_A(end)


@pytest.mark.parametrize(
    "names",
    [
        ("linear",),
        *(
            pytest.param(n, marks=pytest.mark.slow)
            for n in (("hertz",), ("bilinear",), ("linear", "bilinear"))
        ),
    ],
)
@pytest.mark.parametrize("start", STARTS)
def test_two_feet_follow_the_independent_integration(names, start):
    state, t_end, own = STARTS[start]
    run, events, end = _both(names, state, t_end, own)
    assert run.stop_reason is StopReason.T_END
    assert [(str(e.kind), e.contact) for e in run.events] == [(e.kind, e.foot) for e in events]
    assert len(events) >= 6
    times = np.array([[e.time, o.time] for e, o in zip(run.events, events, strict=True)])
    assert np.abs(times[:, 0] - times[:, 1]).max() < 2e-10 * t_end
    final = dict(zip(run.state_names, run.final_state, strict=True))
    for name, value in end.items():
        assert final[name] == pytest.approx(value, rel=1e-8, abs=2e-9), name


FRICTIONS = {
    "mixed": ("static", "stribeck"),
    "one foot": ("coulomb", "static"),
}
STICK_SLIP = {
    "level drop on the slope": ({"y_A": 1e-3, "x_A_dot": -0.05}, 0.1, {}),
    "tilted drop": ({"y_A": 1e-3, "theta": 0.02, "x_A_dot": -0.3}, 0.1, {}),
    "rocking": ({"y_A": 1e-4, "theta": 0.05}, 0.15, {"mu_A": 0.9, "mu_B": 0.9}),
}


@pytest.mark.slow
@pytest.mark.parametrize("start", STICK_SLIP)
@pytest.mark.parametrize("frictions", FRICTIONS)
def test_feet_with_static_friction_follow_the_independent_integration(frictions, start):
    ratio, width = 1.6, 0.02
    state, t_end, own = STICK_SLIP[start]
    kinds = dict(zip("AB", FRICTIONS[frictions], strict=True))
    laws = ",".join(f"{c}=linear/{kind}" for c, kind in kinds.items())
    given = {f"{n}_{c}": v for n, v in LAWS["linear"][1].items() for c in "AB"}
    given |= {f"static_ratio_{c}": ratio for c, k in kinds.items() if k != "coulomb"}
    given |= {f"stribeck_velocity_{c}": width for c, k in kinds.items() if k == "stribeck"}
    block = Block(
        (LAWS["linear"][2],) * 2,
        mu=(own.get("mu_A", 0.4), own.get("mu_B", 0.6)),
        h=own.get("h", 0.2),
        static=tuple(1.0 if k == "coulomb" else ratio for k in kinds.values()),
        stribeck=tuple(width if k == "stribeck" else 0.0 for k in kinds.values()),
    )
    events, end = block.run(block.start(**state), t_end)
    run = simulator(FEET, laws).run(state, parameters=given | own, t_end=t_end)
    assert run.stop_reason is StopReason.T_END
    assert [(str(e.kind), e.contact) for e in run.events] == [(e.kind, e.foot) for e in events]
    times = np.array([[e.time, o.time] for e, o in zip(run.events, events, strict=True)])
    assert np.abs(times[:, 0] - times[:, 1]).max() < 2e-9 * t_end
    final = dict(zip(run.state_names, run.final_state, strict=True))
    for name, value in block.foot_A(end).items():
        assert final[name] == pytest.approx(value, rel=1e-8, abs=2e-9), name
    assert run.energy_residual < 1e-9


@pytest.mark.parametrize("name", ["hertz", "linear", "bilinear"])
def test_feet_that_come_to_rest_together_share_their_friction(name):
    # No height and equal friction: theta stays 0, the mobility of both sticking feet is singular.
    state, own = {"y_A": 1e-3, "x_A_dot": -0.05}, {"h": 0.0, "mu_A": 0.4, "mu_B": 0.4}
    given = LAWS[name][1] | own
    run = simulator(FEET, LAWS[name][0]).run(state, parameters=given, t_end=0.1)
    assert run.stop_reason is StopReason.T_END
    block = Block((LAWS[name][2],) * 2, h=0.0, mu=(0.4, 0.4))
    _, end = block.run(block.start(**state), 0.1)
    final = dict(zip(run.state_names, run.final_state, strict=True))
    for key, value in block.foot_A(end).items():
        assert final[key] == pytest.approx(value, rel=1e-8, abs=2e-9), key


@pytest.mark.parametrize("name", ["hertz", pytest.param("bilinear", marks=pytest.mark.slow)])
def test_a_level_drop_at_rest_bounces_like_one_mass_on_two_springs(name):
    # Nothing pushes along the ground; forces die out together with what friction can bear.
    given = LAWS[name][1] | {"beta": 0.0}
    run = simulator(FEET, LAWS[name][0]).run({"y_A": 1e-3}, parameters=given, t_end=0.05)
    assert run.stop_reason is StopReason.T_END
    final = dict(zip(run.state_names, run.final_state, strict=True))
    assert abs(final["theta"]) < 1e-12
    assert abs(final["x_A"]) < 1e-12
    fall = np.sqrt(2 * 1e-3 / 9.8)
    landings = [e.time for e in run.events if str(e.kind) == "touchdown"]
    assert landings[:2] == pytest.approx([fall, fall], rel=1e-12)
    leave = [e for e in run.events if str(e.kind) == "separation"][:2]
    speeds = [e.state["y_A_dot"] for e in leave]
    if name == "hertz":
        assert speeds == pytest.approx([np.sqrt(2 * 9.8 * 1e-3)] * 2, rel=1e-9)
    else:
        assert 0.74 < min(speeds) / np.sqrt(2 * 9.8 * 1e-3) < 0.76
