"""Formulas of the start of a run: the whole start state, and the scale of every state."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import sympy as sp
from sympy.logic.boolalg import Boolean

from painleve_sym.contacts.closed_within import closed_within, length_formula
from painleve_sym.hybrid.automaton import Definition, Preparation
from painleve_sym.laws.catalogue import Law
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.system import TIME

if TYPE_CHECKING:
    from painleve_sym.contacts.contact_states import ContactRow, ContactStates

AT_REST = sp.Float(1e-20)
"""Part of the energy to be gained below which a motion starts from rest."""
IDLE = sp.Float(0.01)
"""Of a contact that nothing presses: the part that counts of what its energy can compress, and of
the free accelerations of the contacts beside it."""

Numbers = Mapping[str, sp.Expr]
"""Of one contact: ``kinetic_energy``, ``W_nn``, ``W_tt``, ``b_n``, ``b_t`` and ``length``."""


class Terms:
    """Abbreviations, each of which may use those before it.

    Short formulas keep SymPy from rearranging long ones.
    """

    def __init__(self) -> None:
        self.all: list[Definition] = []

    def __call__(self, name: str, expression: sp.Expr | int) -> sp.Symbol:
        """Return a symbol that stands for the expression."""
        symbol = sp.Dummy(f"{name}_{len(self.all)}", real=True)
        self.all.append(Definition(symbol, sp.sympify(expression)))
        return symbol

    def root(self, expression: sp.Expr) -> sp.Expr:
        """Return √expression."""
        return sp.sqrt(self("square", expression))


def where(condition: Boolean, value: sp.Expr | int, otherwise: sp.Expr | int) -> sp.Piecewise:
    """Return the first value where the condition holds, else the second; unevaluated."""
    return sp.Piecewise((value, condition), (otherwise, True), evaluate=False)


# ---- scales of one contact ----


def gained_energy(numbers: Numbers, length: sp.Expr, terms: Terms) -> sp.Symbol:
    """Return what the free contact forces |b|/W would give to a motion over the length; J.

    1 where there are none: what nothing drives needs no scale.
    """
    gains = []
    for row in ("n", "t"):
        mobility = numbers[f"W_{row}{row}"]
        force = terms("force", sp.Abs(numbers[f"b_{row}"]) / mobility)
        gains.append(where(sp.Gt(mobility, 0), force * length, 0))
    largest = terms("gained", sp.Max(*(terms("gain", gain) for gain in gains)))
    return terms("gained", where(sp.Gt(largest, 0), largest, 1))


def rigid_scales(numbers: Numbers, terms: Terms) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a rigid contact."""
    kinetic, length = numbers["kinetic_energy"], _length(numbers, terms)
    gained = gained_energy(numbers, length, terms)
    energy = terms("energy", where(sp.Gt(kinetic, AT_REST * gained), kinetic, gained))
    return length, terms.root(2 * energy * numbers["W_nn"]), energy


def compliant_scales(
    numbers: Numbers, gap: sp.Expr, stiffness: sp.Expr, exponent: sp.Expr, terms: Terms
) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a compliant contact.

    The gap's is the compression δ_c under the free normal force |b_n|/W_nn, its rate's δ_c/T
    with T the time of a contact under that force. Where nothing presses, the compression is a
    hundredth of what the available energy can cause. Stiffness and exponent are K and n of the
    loading curve K δⁿ.
    """
    k, n = terms("stiffness", stiffness), terms("exponent", exponent)
    W_nn, b_n, kinetic = numbers["W_nn"], sp.Abs(numbers["b_n"]), numbers["kinetic_energy"]
    force, depth = terms("force", b_n / W_nn), terms("depth", sp.Max(0, -gap))
    stored = k * depth ** (n + 1) / (n + 1)
    available, pressed = terms("available", kinetic + stored), sp.Gt(force, 0)
    static = terms("static", force / k) ** (1 / n)
    impact = terms("impact", (n + 1) * available / k) ** (1 / (n + 1))
    delta = terms("compression", where(pressed, static, IDLE * impact))
    energy = terms("energy", available + force * delta)
    still, length = sp.Eq(energy, 0), _length(numbers, terms)
    delta = terms("compression", where(still, length, delta))
    energy = terms("energy", where(still, gained_energy(numbers, length, terms), energy))
    free = IDLE * terms.root(2 * energy * W_nn)
    return delta, where(pressed, terms.root(delta * b_n), free), energy


def _length(numbers: Numbers, terms: Terms) -> sp.Symbol:
    names = ("length", "kinetic_energy", "W_nn", "b_n")
    return terms("length", closed_within(*(numbers[name] for name in names))[0])


# ---- all contacts ----


def preparation(contacts: ContactStates) -> Preparation:
    """Return the formulas of the start of a run with these contacts.

    A start state has gap, gap rate and slip velocity of every contact, those of a closed one
    exactly 0: computed from coordinates they cancel, and a touching start must not become a tiny
    fall. An only, compliant contact with gap 0 is compressed so that it carries the initial force.
    """
    terms, mechanism = Terms(), contacts.mechanism
    force = sp.Dummy("initial_force", real=True)
    kinetic = terms("kinetic_energy", mechanism.system.kinetic_energy)
    numbers = []
    for i, c in enumerate(mechanism.all_coefficients):
        own = {name: terms(name, getattr(c, name)) for name in ("W_nn", "W_tt", "b_n", "b_t")}
        own["length"] = terms("length", length_formula(mechanism, i))
        numbers.append({**own, "kinetic_energy": kinetic})
    states: dict[sp.Symbol, sp.Expr] = {}
    refused: list[Boolean] = []
    for row, law, own in zip(contacts.rows, contacts.model.own_laws, numbers, strict=True):
        values, faults = _contact_start(row, law, own, mechanism, terms)
        states |= values
        refused += faults
    first, law = contacts.rows[0], contacts.model.own_laws[0]
    pressable = len(contacts.rows) == 1 and law.is_compliant
    if pressable:
        refused.append(sp.And(sp.Ge(force, 0), sp.Ne(states[first.gap], 0)))
    definitions = [s for own_law in contacts.model.own_laws for s in own_law.definitions]
    finite = [sp.Le(sp.Abs(s), sp.Float(sys.float_info.max)) for s in definitions]
    inside = [sp.Gt(bound.margin, 0, evaluate=False) for bound in mechanism.domain]
    admits = (
        terms("law", where(sp.Or(*refused), 0, 1)),
        terms("finite", where(sp.And(*finite), 1, 0)),
        terms("domain", where(sp.And(*inside, evaluate=False), 1, 0) if inside else 1),
    )
    if pressable and law.is_compliant:
        ready = sp.And(sp.Ge(force, 0), *(sp.Gt(value, 0) for value in admits))
        load = terms("load", force / terms("stiffness", law.stiffness))
        states[first.gap] = where(ready, -(load ** (1 / law.exponent)), states[first.gap])
    scales = _scales(contacts, numbers, terms)
    return Preparation(
        given=mechanism.motion,
        force=force,
        states=states,
        admits=admits,
        scales=scales,
        terms=tuple(terms.all),
    )


def _contact_start(
    row: ContactRow, law: Law, numbers: Numbers, mechanism: Mechanism, terms: Terms
) -> tuple[dict[sp.Symbol, sp.Expr], list[Boolean]]:
    """Return the start values of a contact's states, and where its law does not admit them."""
    given = (numbers[name] for name in ("length", "kinetic_energy", "W_nn", "b_n"))
    near, slow = (terms("closed", tolerance) for tolerance in closed_within(*given)[1:])
    values = dict(zip(row.symbols, row.expressions, strict=True))
    for symbol, tolerance in ((row.gap, near), (row.gap_rate, slow)):
        value = terms(symbol.name, values[symbol])
        if symbol not in mechanism.motion:
            value = terms(symbol.name, where(sp.Le(sp.Abs(value), tolerance), 0, value))
        values[symbol] = value
    gap, rate = values[row.gap], values[row.gap_rate]
    if row.contact.bilateral:
        return values, [sp.Gt(sp.Abs(gap), near), sp.Gt(sp.Abs(rate), slow)]
    return values, [] if law.is_compliant else [sp.Lt(gap, 0)]


def _scales(
    contacts: ContactStates, numbers: Sequence[Numbers], terms: Terms
) -> dict[sp.Symbol, sp.Expr]:
    """Return the scale of each state below which only its absolute error counts.

    Gap and its rate have the scales of the contact; other velocities that of the kinetic energy
    plus the energy of the contact; coordinates in m the characteristic length, angles 1, and the
    time that length over the speed of the energy.
    """
    system = contacts.mechanism.system
    of_contacts, energy = _all_scales(contacts, numbers, terms)
    length = _length(numbers[0], terms)
    scales: dict[sp.Symbol, sp.Expr] = {
        c.symbol: length if c.unit == "m" else sp.Integer(1) for c in system.coordinates
    }
    scales[TIME] = length / terms.root(2 * energy * numbers[0]["W_nn"])
    scales |= dict.fromkeys(contacts.dissipations, energy)
    for k, speed in enumerate(system.q_dot):
        scales[speed] = terms.root(2 * energy / terms("mass", system.mass_matrix[k, k]))
    given = zip(contacts.rows, contacts.model.own_laws, numbers, of_contacts, strict=True)
    for row, law, own, (gap, rate) in given:
        normal, slip = (terms("speed", terms.root(2 * energy * own[w])) for w in ("W_nn", "W_tt"))
        scales[row.slip] = where(sp.Eq(slip, 0), normal, slip)
        scales |= {row.gap: gap, row.gap_rate: rate}
        if law.is_compliant and law.friction.tangential_stiffness is not None:
            # What the force of the gap's scale deflects.
            load = terms("load", law.stiffness * gap**law.exponent)
            scales[row.deflection] = load / law.friction.tangential_stiffness
    return scales


def _all_scales(
    contacts: ContactStates, numbers: Sequence[Numbers], terms: Terms
) -> tuple[list[tuple[sp.Expr, sp.Expr]], sp.Expr]:
    """Return the scales of gap and gap rate of every contact, and the largest energy of any.

    One of several that hardly anything presses yet, such as a wall, is hit by what moves or
    presses the others: its free acceleration counts as a hundredth of theirs at least.
    """

    def own_scales(i: int, own: Numbers) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
        law = contacts.model.own_laws[i]
        if not law.is_compliant:
            return rigid_scales(own, terms)
        return compliant_scales(own, contacts.rows[i].gap, law.stiffness, law.exponent, terms)

    if len(numbers) == 1:
        gap, rate, energy = own_scales(0, numbers[0])
        return [(gap, rate)], energy
    pulls = [terms("pull", sp.Abs(own["b_n"])) for own in numbers]
    least = terms("least", IDLE * terms("largest", sp.Max(*pulls)))
    pressed = [
        {**own, "b_n": terms("b_n", sp.Max(pull, least))}
        for own, pull in zip(numbers, pulls, strict=True)
    ]
    energies: list[sp.Expr] = [sp.Integer(0)]
    for i, (row, own) in enumerate(zip(contacts.rows, pressed, strict=True)):
        idle = sp.And(sp.Le(own["kinetic_energy"], 0), sp.Eq(own["b_n"], 0), sp.Ge(row.gap, 0))
        energies.append(terms("energy", where(idle, 0, own_scales(i, own)[2])))
    largest = terms("energy", sp.Max(*energies))
    energy = terms("energy", where(sp.Gt(largest, 0), largest, 1))
    shared = [{**own, "kinetic_energy": energy} for own in pressed]
    return [own_scales(i, own)[:2] for i, own in enumerate(shared)], energy
