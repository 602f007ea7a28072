"""A mode whose local modes are data, with constants in place of the memory that holds them.

Such a mode has forces and guards for whatever each part does, switched by flags. While the flags
have certain values most of that is nothing: the rest is shorter, and equal but for rounding.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from painleve_sym.automata.automaton import Definition, HybridAutomaton, LinearSystem, Mode, Part

Term = Definition | LinearSystem
Terms = tuple[Term, ...]
Memory = Mapping[sp.Symbol, sp.Expr]


@dataclass(frozen=True)
class Variant:
    """The modes of an automaton with constants in place of some of its memory.

    `terms` take the place of those of the automaton that define the same symbols; those that are
    numbers are `constants`, too.
    """

    constants: Memory
    terms: Terms

    def field(self, mode: Mode) -> dict[sp.Symbol, sp.Expr]:
        """Return the field of a mode."""
        return {s: sp.sympify(rate).xreplace(self.constants) for s, rate in mode.field.items()}

    def guards(self, mode: Mode) -> dict[int, sp.Expr]:
        """Return the guards of a mode that may fire, by the index of their transition."""
        guards = {
            j: t.guard.xreplace(self.constants)
            for j, t in enumerate(mode.transitions)
            if t.guard is not None
        }
        return {j: g for j, g in guards.items() if not (g.is_number and g >= 0)}


def known_memory(automaton: HybridAutomaton, values: Sequence[float]) -> Memory:
    """Return the memory that the variant for these values takes as constants.

    Of each part that of the first of its `Part.variants` that agrees with the values, else all of
    it that are whole numbers: flags, signs and indices. Infinity stands for any value.
    """
    given = dict(zip(automaton.memory, values, strict=True))
    known: dict[sp.Symbol, sp.Expr] = {}
    for part in automaton.parts:
        known |= next((v for v in part.variants if _agrees(v, given)), _whole(part, given))
    return known


def known_values(automaton: HybridAutomaton, values: Sequence[float]) -> tuple[float, ...]:
    """Return what the variant for these values knows of each entry, infinity for any value."""
    known = known_memory(automaton, values)
    constants = (known.get(s, s) for s in automaton.memory)
    return tuple(float(v) if v.is_number else math.inf for v in constants)


def _agrees(variant: Memory, given: Mapping[sp.Symbol, float]) -> bool:
    return all(not value.is_number or float(value) == given[s] for s, value in variant.items())


def _whole(part: Part, given: Mapping[sp.Symbol, float]) -> Memory:
    return {s: sp.Integer(int(given[s])) for s in part.memory if float(given[s]).is_integer()}


def variant(automaton: HybridAutomaton, known: Memory) -> Variant:
    """Return the variant of an automaton with these constants in place of memory."""
    reached, terms = set(known), list[Term]()
    for term in automaton.terms:
        if reached & term.needs:
            reached |= set(term.symbols)
            terms.append(term)
    constants = dict(known)
    return Variant(constants, tuple(_specialised(tuple(terms), constants)))


def _specialised(terms: Terms, constants: dict[sp.Symbol, sp.Expr]) -> Iterator[Term]:
    """Yield the terms with constants substituted; terms that become numbers join the constants."""
    for term in terms:
        whole = _with_constants(term, constants)
        for part in [whole] if isinstance(whole, Definition) else _blocks(whole):
            own = _with_constants(part, constants)
            if isinstance(own, Definition) and own.expression.is_number:
                constants[own.symbol] = own.expression
            yield own


def _with_constants(term: Term, constants: Mapping[sp.Symbol, sp.Expr]) -> Term:
    if isinstance(term, Definition):
        return Definition(term.symbol, term.expression.xreplace(constants))
    return LinearSystem(
        term.unknowns,
        term.matrix.xreplace(constants),
        term.right.xreplace(constants),
        None if term.weights is None else tuple(e.xreplace(constants) for e in term.weights),
        tuple(s.xreplace(constants) for s in term.scales),
        term.determinant,
    )


def _blocks(term: LinearSystem) -> Iterator[Term]:
    """Yield the systems of the unknowns that depend on each other; a single one is a quotient."""
    determinant, every = sp.Integer(1), list(range(term.right.cols))
    for rows in _rows_of_blocks(term.matrix):
        if len(rows) == 1:
            (i,) = rows
            for k in every:
                yield Definition(term.unknowns[i, k], term.right[i, k] / term.matrix[i, i])
            if term.scales:
                determinant *= term.matrix[i, i] / term.scales[i]
            continue
        own = sp.Symbol(f"{term.determinant}_{rows[0]}", real=True) if term.determinant else None
        yield LinearSystem(
            term.unknowns.extract(rows, every),
            term.matrix.extract(rows, rows),
            term.right.extract(rows, every),
            term.weights and tuple(term.weights[i] for i in rows),
            term.scales and tuple(term.scales[i] for i in rows),
            own,
        )
        determinant *= own or 1
    if term.determinant is not None:
        # More than two unknowns may be undetermined, and then no determinant is asked for.
        yield Definition(term.determinant, determinant if term.matrix.rows <= 2 else sp.Integer(1))


def _rows_of_blocks(matrix: sp.Matrix) -> list[list[int]]:
    blocks: list[list[int]] = []
    for i in range(matrix.rows):
        joined = [b for b in blocks if any(matrix[i, j] != 0 or matrix[j, i] != 0 for j in b)]
        blocks = [b for b in blocks if b not in joined]
        blocks.append(sorted([i, *(j for b in joined for j in b)]))
    return sorted(blocks)
