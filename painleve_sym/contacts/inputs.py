"""From what a user gives (names and numbers) to checked parameters and states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from painleve_sym.checks import checked_number
from painleve_sym.contacts.contact_numbers import domain_margins
from painleve_sym.errors import InputError, unknown_name
from painleve_sym.mechanics.declarations import Parameter
from painleve_sym.mechanics.mechanism import Mechanism


def _raise(where: str, faults: Sequence[str]) -> None:
    if faults:
        raise InputError(f"{where}: " + " ".join(faults))


def resolve_parameters(
    where: str, declared: Sequence[Parameter], given: Mapping[str, float]
) -> dict[str, float]:
    """Return every declared parameter's value: the given one, else its default.

    Raises
    ------
    InputError
        Unknown names, values that are not finite or out of range; all faults at once.
    """
    known, faults = {p.name: p for p in declared}, []
    values = {p.name: p.default for p in declared}
    for name, value in given.items():
        if name not in known:
            faults.append(unknown_name("parameter", name, known))
            continue
        values[name], fault = checked_number(value, f"parameter {name}")
        fault = fault or known[name].fault(values[name]) or ""
        if fault:
            faults.append(fault)
    _raise(where, faults)
    return values


def resolve_state(
    mechanism: Mechanism, given: Mapping[str, float], parameters: Mapping[str, float]
) -> dict[str, float]:
    """Return coordinates, velocities, and ``t`` where it occurs; what is not given is 0.

    Raises
    ------
    InputError
        Unknown names, values that are not finite, a state outside the mechanism's domain.
    """
    where, faults = f"state of {mechanism.name!r}", []
    values = dict.fromkeys(mechanism.state_names, 0.0)
    for name, value in given.items():
        if name not in values:
            faults.append(unknown_name("state", name, values))
            continue
        values[name], fault = checked_number(value, f"state {name}")
        if fault:
            faults.append(fault)
    _raise(where, faults)
    domain = mechanism.outline.domain
    margins = domain_margins(mechanism)({**values, **parameters}).values() if domain else ()
    for bound, margin in zip(domain, margins, strict=True):
        if not margin > 0:
            got = ", ".join(f"{n} = {values.get(n, parameters.get(n))!r}" for n in bound.names)
            faults.append(f"got {got}, need {bound.margin} > 0 ({bound.meaning}).")
    _raise(where, faults)
    return values


def symbol_values(
    mechanism: Mechanism, state: Mapping[str, float], parameters: Mapping[str, float]
) -> dict[object, float]:
    """Return the values keyed by the mechanism's symbols."""
    system = mechanism.system
    values: dict[object, float] = {s: state[s.name] for s in mechanism.motion if s.name in state}
    values |= {p.symbol: parameters[p.name] for p in system.parameters if p.name in parameters}
    return values
