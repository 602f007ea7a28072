"""One contact by the automaton for several, against the automaton for one."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from painleve_sym.automata.plural_contacts import PluralContacts
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.engines.compiled import CompiledEngine
from painleve_sym.engines.protocol import RunSettings
from painleve_sym.errors import EventKind
from painleve_sym.laws.catalogue import law
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.motion.simulator import Simulator

LAWS = {
    "hertz": lambda: law("hertz"),
    "linear": lambda: law("linear"),
    "linear/static": lambda: law("linear", friction="static"),
    "linear/spring": lambda: law("linear", friction="spring"),
    "newton by the final slip": lambda: RigidLaw("newton", impact_friction="final_slip"),
    **{policy: lambda policy=policy: RigidLaw(policy=policy) for policy in ("liftoff", "slip")},
}


NAMES = {EventKind.TANGENTIAL_IMPACT: EventKind.IMPACT}


@cache
def engines(mechanism, name):
    """Return a simulator of one contact, and an engine with the automaton for several."""
    simulator = Simulator(model(mechanism), LAWS[name](), "compiled")
    return simulator, CompiledEngine(PluralContacts(simulator.contact).automaton)


def both(mechanism, name, state, parameters, t_end):
    """Return kinds and times of events, and the end state, by both automata."""
    simulator, several = engines(mechanism, name)
    start = simulator.start(simulator.at(state, parameters))
    options = simulator.options(start.scale, RunSettings(t_end=t_end, rtol=1e-11))
    for engine in (simulator.integrator, several):
        raw = engine.run(start.state, start.parameters, options)
        records, kinds = raw.event_records, engine.outline.kinds
        events = [(kinds[k], t) for k, t in zip(records.kind, records.time, strict=True)]
        if EventKind.IMPACT_END in kinds:
            # One contact has events where an impact ends and where it leaves after that, and none
            # where one begins at v_n = 0.
            ended = {EventKind.IMPACT_END: EventKind.IMPACT}
            hits = {t for k, t in events if k is EventKind.IMPACT_END}
            events = [
                (ended.get(k, k), t)
                for k, t in events
                if k is not EventKind.IMPACT and (k is not EventKind.LIFTOFF or t not in hits)
            ]
        # Several contacts have an event where they find what they do at the start, and one name for
        # impacts.
        own = [(NAMES.get(kind, kind), t) for kind, t in events if kind is not EventKind.CONTACT]
        yield own, raw.state, raw.stop_reason


def agree(mechanism, name, state, parameters, t_end):
    (events, end, stop), (others, same, reason) = both(mechanism, name, state, parameters, t_end)
    first = list(zip(events, others, strict=False))[:30]
    assert [a[0] for a, _ in first] == [b[0] for _, b in first]
    assert max((abs(a[1] - b[1]) for a, b in first), default=0) < 1e-9 * t_end
    if len(events) <= 30:
        assert (stop, len(events)) == (reason, len(others))
        assert np.abs(end - same).max() < 1e-7 * np.abs(end).max()


@pytest.mark.parametrize(
    "name",
    [
        *("linear", "linear/static"),
        *(pytest.param(n, marks=pytest.mark.slow) for n in ("hertz", "linear/spring")),
    ],
)
@settings(max_examples=15)
@given(
    theta=st.floats(0.6, 1.3),
    slip=st.floats(-1.0, -0.2) | st.floats(0.2, 1.0),
    depth=st.sampled_from([-1e-3, 0.0, 1e-6]),
    mu=st.floats(0.1, 1.5),
)
def test_compliant_contact_of_a_rod(name, theta, slip, depth, mu):
    state = {"theta": theta, "x_A_dot": slip, "y_A": -depth, "theta_dot": 0.3}
    agree("rod", name, state, {"mu": mu}, 2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("policy", ["liftoff", "slip"])
@settings(max_examples=25)
@given(
    phi=st.floats(1.1, 1.35),
    slip=st.floats(-2.0, -0.5) | st.floats(0.5, 2.0),
    mu=st.floats(0.1, 2.0),
    force=st.floats(-20.0, 40.0),
)
def test_guide_takes_the_slip_that_the_policy_names(policy, phi, slip, mu, force):
    state, own = {"phi": phi, "x_dot": slip}, {"mu": mu, "P_1": 0.0, "P_2": force}
    agree("painleve-klein", policy, state, own | {"phi_0": phi}, 1e-2)
