"""Formulas of the start of a run: the whole start state, and the scale of every state."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence

import sympy as sp
from sympy.logic.boolalg import Boolean

from painleve_sym.automata.automaton import Definition, Preparation
from painleve_sym.automata.interfaces import Interface
from painleve_sym.automata.scales import (
    AT_REST,
    IDLE,
    Numbers,
    Terms,
    characteristic_length,
    driving_energy,
    where,
)
from painleve_sym.mechanics.closed_within import closed_within, length_formula
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.solved import solved_motion
from painleve_sym.mechanics.system import TIME


def preparation(
    mechanism: Mechanism,
    contacts: Sequence[Interface],
    works: Iterable[sp.Symbol],
    definitions: Iterable[sp.Symbol],
) -> Preparation:
    """Return the formulas of the start of a run with these contacts.

    A start state has gap, gap rate and slip velocity of every contact, those of a closed one
    exactly 0: computed from coordinates they cancel, and a touching start must not become a tiny
    fall. An only, compliant contact with gap 0 is compressed so that it carries the initial force.
    `works` are the states that account for energy, `definitions` those of the laws.
    """
    terms = Terms()
    force = sp.Dummy("initial_force", real=True)
    kinetic = terms("kinetic_energy", mechanism.system.kinetic_energy)
    numbers = []
    terms.all += motion_steps(mechanism)
    solved = solved_motion(mechanism)
    for i, c in enumerate(solved.coefficients if solved else mechanism.all_coefficients):
        own = {name: terms(name, getattr(c, name)) for name in ("W_nn", "W_tt", "b_n", "b_t")}
        own["length"] = terms("length", length_formula(mechanism, i, c.W_nn))
        numbers.append({**own, "kinetic_energy": kinetic})
    states: dict[sp.Symbol, sp.Expr] = {}
    refused: list[Boolean] = []
    for contact, own in zip(contacts, numbers, strict=True):
        values, faults = _contact_start(contact, own, mechanism, terms)
        states |= values
        refused += faults
    gap = contacts[0].row.gap
    pressed = contacts[0].start.loading_curve if len(contacts) == 1 else None
    if pressed:
        refused.append(sp.And(sp.Ge(force, 0), sp.Ne(states[gap], 0)))
    finite = [sp.Le(sp.Abs(s), sp.Float(sys.float_info.max)) for s in definitions]
    inside = [sp.Gt(bound.margin, 0, evaluate=False) for bound in mechanism.domain]
    admits = (
        terms("law", where(sp.Or(*refused), 0, 1)),
        terms("finite", where(sp.And(*finite), 1, 0)),
        terms("domain", where(sp.And(*inside, evaluate=False), 1, 0) if inside else 1),
    )
    if pressed:
        stiffness, exponent = pressed
        ready = sp.And(sp.Ge(force, 0), *(sp.Gt(value, 0) for value in admits))
        load = terms("load", force / terms("stiffness", stiffness))
        states[gap] = where(ready, -(load ** (1 / exponent)), states[gap])
    return Preparation(
        given=mechanism.motion,
        force=force,
        states=states,
        admits=admits,
        scales=_scales(mechanism, contacts, works, numbers, terms),
        terms=tuple(terms.all),
    )


def motion_steps(mechanism: Mechanism) -> tuple[Definition, ...]:
    """Return the steps that lead to accelerations, where these have no closed form."""
    solved = solved_motion(mechanism)
    return tuple(Definition(*step) for step in solved.steps.items()) if solved else ()


def _contact_start(
    contact: Interface, numbers: Numbers, mechanism: Mechanism, terms: Terms
) -> tuple[dict[sp.Symbol, sp.Expr], list[Boolean]]:
    """Return the start values of a contact's states, and where its law does not admit them."""
    given = (numbers[name] for name in ("length", "kinetic_energy", "W_nn", "b_n"))
    near, slow = (terms("closed", tolerance) for tolerance in closed_within(*given)[1:])
    row = contact.row
    values = dict(zip(row.symbols, row.expressions, strict=True))
    for symbol, tolerance in ((row.gap, near), (row.gap_rate, slow)):
        value = terms(symbol.name, values[symbol])
        if symbol not in mechanism.motion:
            value = terms(symbol.name, where(sp.Le(sp.Abs(value), tolerance), 0, value))
        values[symbol] = value
    return values, contact.start.faults(values[row.gap], values[row.gap_rate], near, slow)


def _scales(
    mechanism: Mechanism,
    contacts: Sequence[Interface],
    works: Iterable[sp.Symbol],
    numbers: Sequence[Numbers],
    terms: Terms,
) -> dict[sp.Symbol, sp.Expr]:
    """Return the scale of each state below which only its absolute error counts.

    Gap and its rate have the scales of the contact; other velocities that of the kinetic energy
    plus the energy of the contact; coordinates in m the characteristic length, angles 1, and the
    time that length over the speed of the energy.
    """
    system = mechanism.system
    of_contacts, energy = _all_scales(contacts, numbers, terms)
    length, kinetic = characteristic_length(numbers[0], terms), numbers[0]["kinetic_energy"]
    scales: dict[sp.Symbol, sp.Expr] = {
        c.symbol: length if c.unit == "m" else sp.Integer(1) for c in system.coordinates
    }
    scales[TIME] = length / terms.root(2 * energy * numbers[0]["W_nn"])
    driven = [terms("driven", driving_energy(own, length, terms)) for own in numbers]
    scales |= dict.fromkeys(works, _energy_of_works(energy, kinetic, driven, terms))
    for k, speed in enumerate(system.q_dot):
        scales[speed] = terms.root(2 * energy / terms("mass", system.mass_matrix[k, k]))
    for contact, own, (gap, rate) in zip(contacts, numbers, of_contacts, strict=True):
        row = contact.row
        normal, slip = (terms("speed", terms.root(2 * energy * own[w])) for w in ("W_nn", "W_tt"))
        scales[row.slip] = where(sp.Eq(slip, 0), normal, slip)
        scales |= {row.gap: gap, row.gap_rate: rate, **contact.start.scales_of_states(gap, terms)}
    return scales


def _energy_of_works(
    energy: sp.Expr, kinetic: sp.Expr, driven: Sequence[sp.Expr], terms: Terms
) -> sp.Expr:
    """Return the scale of works: from rest, where no energy is there yet, part of what will come.

    `driven` is the energy that the free contact forces give over the characteristic length.
    """
    largest = terms("driven", sp.Max(*driven))
    rests = sp.Le(kinetic, AT_REST * largest)
    return where(rests, sp.Max(energy, IDLE**2 * largest), energy)


def _all_scales(
    contacts: Sequence[Interface], numbers: Sequence[Numbers], terms: Terms
) -> tuple[list[tuple[sp.Expr, sp.Expr]], sp.Expr]:
    """Return the scales of gap and gap rate of every contact, and the largest energy of any.

    A contact with hardly any load yet, such as a wall, has a hundredth of the largest free
    acceleration of the others at least: their motion or load will press it.
    """
    if len(numbers) == 1:
        gap, rate, energy = contacts[0].start.scales(numbers[0], terms)
        return [(gap, rate)], energy
    pulls = [terms("pull", sp.Abs(own["b_n"])) for own in numbers]
    least = terms("least", IDLE * terms("largest", sp.Max(*pulls)))
    pressed = [
        {**own, "b_n": terms("b_n", sp.Max(pull, least))}
        for own, pull in zip(numbers, pulls, strict=True)
    ]
    energies: list[sp.Expr] = [sp.Integer(0)]
    for contact, own in zip(contacts, pressed, strict=True):
        still = sp.And(sp.Le(own["kinetic_energy"], 0), sp.Eq(own["b_n"], 0))
        idle = sp.And(still, sp.Ge(contact.row.gap, 0))
        energies.append(terms("energy", where(idle, 0, contact.start.scales(own, terms)[2])))
    largest = terms("energy", sp.Max(*energies))
    energy = terms("energy", where(sp.Gt(largest, 0), largest, 1))
    shared = [{**own, "kinetic_energy": energy} for own in pressed]
    every = zip(contacts, shared, strict=True)
    return [contact.start.scales(own, terms)[:2] for contact, own in every], energy
