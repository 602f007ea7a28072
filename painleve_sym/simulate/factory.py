"""The simulator of a mechanism with its contact laws."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from painleve_sym.errors import InputError, unknown_name
from painleve_sym.laws.catalogue import Law
from painleve_sym.laws.rigid import RigidLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.simulate.compliant import SoftenedSimulator
from painleve_sym.simulate.plural import PluralSimulator
from painleve_sym.simulate.rigid import RigidSimulator
from painleve_sym.simulate.simulator import ContactSimulator
from painleve_sym.simulate.trajectory import Trajectory


def make_simulator(
    mechanism: Mechanism, law: Law | Mapping[str, Law], engine: str = "auto"
) -> ContactSimulator:
    """Return the simulator of a mechanism with any number of contacts.

    Parameters
    ----------
    mechanism : Mechanism
    law : ContactLaw or RigidLaw, or mapping of str to these
        One law for all contacts, or the law of each by the contact's name. Parameters of laws that
        are given by contact have its name behind theirs: ``E_A``.
    engine : {"auto", "compiled", "taylor", "erk"}

    Raises
    ------
    InputError
        A contact without a law, or a law for a contact that there is not.

    Examples
    --------
    >>> from painleve_sym import law, model
    >>> block = model("block-two-feet")
    >>> simulator = make_simulator(block, {"A": law("rigid"), "B": law("hertz")})
    >>> [p.name for p in simulator.own_parameters]
    ['e_energetic', 'E_B', 'nu_B', 'R_B', 'n_B']
    """
    names = [c.name for c in mechanism.contacts]
    if isinstance(law, Mapping):
        for name in law:
            if name not in names:
                message = unknown_name("contact", name, names)
                raise InputError(f"mechanism {mechanism.name!r}: law: {message}")
        without = [name for name in names if name not in law]
        if without:
            raise InputError(
                f"mechanism {mechanism.name!r}: law: contact {without[0]!r} has none. "
                "Fix: give each contact its law."
            )
        laws = tuple(law[name] for name in names)
    else:
        laws = (law,)
    if len(names) > 1:
        return PluralSimulator(mechanism, laws, engine)
    (only,) = laws
    if isinstance(only, RigidLaw):
        return RigidSimulator(mechanism, only.restitution, only.policy, engine)
    return SoftenedSimulator(mechanism, only, engine)


def simulate_softened(
    mechanism: Mechanism,
    law: Law | Mapping[str, Law],
    state: Mapping[str, float],
    *,
    engine: str = "auto",
    **options: Any,
) -> Trajectory:
    """Integrate a motion; see `make_simulator` and `SoftenedSimulator.run` for the options."""
    return make_simulator(mechanism, law, engine).run(state, **options)


def simulate_rigid(
    mechanism: Mechanism,
    state: Mapping[str, float],
    *,
    restitution: str = "energetic",
    policy: str = "liftoff",
    engine: str = "auto",
    **options: Any,
) -> Trajectory:
    """Integrate a motion with rigid contacts; see `RigidSimulator.run` for the options."""
    return make_simulator(mechanism, RigidLaw(restitution, policy), engine).run(state, **options)
