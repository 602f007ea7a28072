"""Scales of the states of one contact: formulas of what its energy and its forces can do."""

from __future__ import annotations

from collections.abc import Mapping

import sympy as sp
from sympy.logic.boolalg import Boolean

from painleve_sym.automata.automaton import Definition
from painleve_sym.mechanics.closed_within import closed_within

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


def driving_energy(numbers: Numbers, length: sp.Expr, terms: Terms) -> sp.Symbol:
    """Return the energy that the free contact forces |b|/W give to a motion over the length; J."""
    gains = []
    for row in ("n", "t"):
        mobility = numbers[f"W_{row}{row}"]
        force = terms("force", sp.Abs(numbers[f"b_{row}"]) / mobility)
        gains.append(where(sp.Gt(mobility, 0), force * length, 0))
    return terms("gained", sp.Max(*(terms("gain", gain) for gain in gains)))


def gained_energy(numbers: Numbers, length: sp.Expr, terms: Terms) -> sp.Symbol:
    """Return `driving_energy`, 1 where it is 0: what nothing drives needs no scale; J."""
    largest = driving_energy(numbers, length, terms)
    return terms("gained", where(sp.Gt(largest, 0), largest, 1))


def rigid_scales(numbers: Numbers, terms: Terms) -> tuple[sp.Expr, sp.Expr, sp.Expr]:
    """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a rigid contact."""
    kinetic, length = numbers["kinetic_energy"], characteristic_length(numbers, terms)
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
    still, length = sp.Eq(energy, 0), characteristic_length(numbers, terms)
    delta = terms("compression", where(still, length, delta))
    energy = terms("energy", where(still, gained_energy(numbers, length, terms), energy))
    free = IDLE * terms.root(2 * energy * W_nn)
    return delta, where(pressed, terms.root(delta * b_n), free), energy


def characteristic_length(numbers: Numbers, terms: Terms) -> sp.Symbol:
    """Return the length over which the motion is resolved; m (see `closed_within`)."""
    names = ("length", "kinetic_energy", "W_nn", "b_n")
    return terms("length", closed_within(*(numbers[name] for name in names))[0])
