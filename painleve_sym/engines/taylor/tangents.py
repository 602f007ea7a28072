"""A tape's derivatives as C: a function per mode that fills their rows of Taylor coefficients.

With dc the derivatives of row c in all directions, every operation says D · dc = Σ P · da, with
rows D and P of the tape and the derivatives da of its arguments a. Order k of such a product is a
Cauchy product of numbers with vectors, which hold as many directions as a register of the
processor; an operation takes one or two of them. Scalars have derivatives that are constant within
a mode and take none.

References
----------
Jorba & Zou (2005)
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from painleve_sym.engines.taylor.emit import SeriesCode
from painleve_sym.engines.taylor.scalars import ONE, ZERO, Scalar
from painleve_sym.engines.taylor.tape import Combination, Node, SeriesTape

_LOADS = 14
"""Sums in one loop: more would not stay in registers."""

_OWN, _PAIR = -1, -2
_RULES: dict[str, tuple[tuple[float, int] | None, tuple[tuple[float, int | None, int], ...]]] = {
    "mul": (None, ((1.0, 1, 0), (1.0, 0, 1))),
    "sq": (None, ((2.0, 0, 0),)),
    "div": ((1.0, 1), ((1.0, None, 0), (-1.0, _OWN, 1))),
    "inv": ((1.0, 0), ((-1.0, _OWN, 0),)),
    "sqrt": ((2.0, _OWN), ((1.0, None, 0),)),
    "exp": (None, ((1.0, _OWN, 0),)),
    "log": ((1.0, 0), ((1.0, None, 0),)),
    "sin": (None, ((1.0, _PAIR, 0),)),
    "cos": (None, ((-1.0, _PAIR, 0),)),
    "sinh": (None, ((1.0, _PAIR, 0),)),
    "cosh": (None, ((1.0, _PAIR, 0),)),
    "tanh": (None, ((1.0, _PAIR, 0),)),
    "atan2": ((1.0, 2), ((1.0, 1, 0), (-1.0, 0, 1))),
}
"""D and the terms P · da of each operation: D and P as a number times a row, and the argument a. A
row is an argument, the node itself or its partner; None stands for 1. The partner of tanh has no
rule: rates do not contain it."""


@dataclass(frozen=True)
class TangentRule:
    """divisor · dc = Σ partial · d argument + Σ d scalar · row.

    Attributes
    ----------
    terms : tuple of (int or None, int)
        Partial and argument, both of them nodes; a partial None stands for 1.
    divisor : int or None
        A node; None stands for 1.
    minus : int or None
        The node −divisor.
    scalars : tuple of (Scalar, int)
        Scalars that have derivatives, with their rows.
    """

    terms: tuple[tuple[int | None, int], ...]
    divisor: int | None = None
    minus: int | None = None
    scalars: tuple[tuple[Scalar, int], ...] = ()

    def products(self, own: int) -> list[tuple[int, int]]:
        """Return rows and the nodes whose derivatives they multiply; `own` is the node c."""
        products = [(p, n) for p, n in self.terms if p is not None]
        return products if self.minus is None else [*products, (self.minus, own)]


class Tangents:
    """Rules and rows that the derivatives of a tape's states are made of.

    Parameters
    ----------
    tape : Tape
        Its `others` become the rows that are factors of derivatives.
    states : sequence of int
        The states that have derivatives, in their order.
    moves : callable
        Whether a scalar has derivatives.

    Attributes
    ----------
    nodes : list of int
        Those whose derivatives are needed, in order.
    rules : dict of int to Rule
        Of the nodes that are neither states nor sums.
    """

    def __init__(
        self, tape: SeriesTape, states: Sequence[int], moves: Callable[[Scalar], bool]
    ) -> None:
        self.tape, self.states, self._of_scalars = tape, list(states), moves
        self._moving = set(states)
        for i in tape.reachable():
            node = tape.nodes[i]
            scalars = [node.scalar] if node.op == "pow" and node.scalar else []
            if node.inner is not None:
                scalars += [node.inner.constant, *(c for _, c in node.inner.terms)]
            if any(map(self.moves, scalars)) or any(n in self._moving for n in node.operands):
                self._moving.add(i)
        self.nodes = self._needed()
        sums = (tape.nodes[i].inner for i in self.nodes)
        self.sums = [*(a for a in sums if a is not None), *(tape.rates[i] for i in self.states)]
        of_rules = (i for i in self.nodes if i >= len(tape.rates) and tape.nodes[i].inner is None)
        self.rules = {i: self._rule(i) for i in of_rules}
        tape.others = sorted(self._rows())

    def moves(self, scalar: Scalar) -> bool:
        """Whether a scalar has derivatives."""
        return bool(scalar.factors) and self._of_scalars(scalar)

    def moving_terms(self, a: Combination) -> list[tuple[int, Scalar]]:
        """Return the terms of a sum whose nodes have derivatives."""
        return [(n, c) for n, c in a.terms if n in self._moving]

    def moving_scalars(self, a: Combination) -> list[tuple[Scalar, int]]:
        """Return the coefficients of a sum that have derivatives, with their nodes."""
        return [(c, n) for n, c in a.terms if self.moves(c)]

    def _needed(self) -> list[int]:
        needed = set[int]()
        front = [n for i in self.states for n, _ in self.tape.rates[i].terms]
        while front:
            n = front.pop()
            if n in self._moving and n not in needed:
                needed.add(n)
                front += self.tape.nodes[n].operands
        return sorted(needed)

    def _rule(self, i: int) -> TangentRule:
        tape, node = self.tape, self.tape.nodes[i]

        def multiple(factor: Scalar, row: int) -> int:
            return tape.row(Combination(ZERO, ((row, factor),)))

        exponent = node.scalar if node.op == "pow" else None
        if node.op == "sqrt" and tape.base_ramp(i) is not None:
            exponent = Scalar(0.5)
        if exponent is not None:
            # d(aᵉ) = e · (aᵉ/a) · da + (aᵉ log a) · de
            (base,), scalars = node.args, tuple[tuple[Scalar, int], ...]()
            if self.moves(exponent):
                log = tape.node(Node("log", (base,)))
                scalars = ((exponent, tape.node(Node("mul", (i, log)))),)
            slope = multiple(exponent, tape.node(Node("div", (i, base))))
            return TangentRule(((slope, base),) if base in self._moving else (), scalars=scalars)
        rows = dict(enumerate(node.args)) | {_OWN: i, _PAIR: tape.pair(i)}
        divisor, terms = _RULES[node.op]
        moving = (t for t in terms if node.args[t[2]] in self._moving)
        rule = TangentRule(
            tuple(
                (None if p is None else multiple(Scalar(c), rows[p]), node.args[a])
                for c, p, a in moving
            )
        )
        if divisor is None:
            return rule
        number, place = divisor
        both = (multiple(Scalar(sign * number), rows[place]) for sign in (1, -1))
        return replace(rule, divisor=next(both), minus=next(both))

    def _rows(self) -> set[int]:
        rows = {n for a in self.sums for _, n in self.moving_scalars(a)}
        for rule in self.rules.values():
            rows |= {p for p in (rule.divisor, rule.minus) if p is not None}
            rows |= {p for p, _ in rule.terms if p is not None}
            rows |= {n for _, n in rule.scalars}
        return rows


class TangentCode:
    """Writes the C of the derivatives of one tape.

    The generated function takes the arguments of the function of the series, which has filled `v`,
    and the number g of a vector of directions. States and scalars are followed by their
    derivatives. It fills the columns of the derivatives of the states, order by order.

    Parameters
    ----------
    tangents : Tangents
    code : SeriesCode
        Of the same tape, with the rows that are factors of derivatives.
    directions : int
    """

    def __init__(self, tangents: Tangents, code: SeriesCode, directions: int) -> None:
        self._of, self._code, self.directions = tangents, code, directions
        self._slots: dict[Scalar, int] = {}
        self._products = {i: rule.products(i) for i, rule in tangents.rules.items()}
        factors = {n for products in self._products.values() for _, n in products}
        self._places = {n: place for place, n in enumerate(sorted(factors))}
        self.text = self._function()

    @property
    def scalars(self) -> list[Scalar]:
        """Scalars whose derivatives follow the values of all, in their order."""
        return list(self._slots)

    def _function(self) -> str:
        of, name = self._of, self._code.name
        start = [line for i in of.nodes for line in self._node(i, "0")]
        each = [line for i in of.nodes for line in self._node(i, "k")]
        rates = {i: of.tape.rates[i] for i in of.states}
        start += [f"ps_wide f{i} = {self._sum(r, '0')}, b{i} = {{0}};" for i, r in rates.items()]
        turn = [f"b{i} = f{i}; f{i} = {self._sum(r, 'k')};" for i, r in rates.items()]
        read, step = [], []
        for place, i in enumerate(of.states):
            column = f"{len(of.tape.rates)} + {place} * PS_DIRECTIONS"
            read.append(f"ps_wide t{i} = ps_wide_at(x + {column}, g);")
            read += [f"ps_wide_to(v[0] + {column}, t{i}, g);", *self._kept(i, "0")]
            step.append(f"t{i} = PS_WIDE_FMA(q, f{i}, qb * b{i});")
            step += [f"ps_wide_to(v[k] + {column}, t{i}, g);", *self._kept(i, "k")]
        divisors = {i: rule.divisor for i, rule in of.rules.items() if rule.divisor is not None}
        inverse = [f"const double r{i} = 1 / {self._row(d, '0')};" for i, d in divisors.items()]
        places, scalars = len(self._places) or 1, len(self._slots)
        lines = [
            f"static void {name}_tangents(const double *x, const double *w, const double *live,",
            "    int p, double dt, double bend, int g, double (*restrict v)[PS_COLUMNS]) {",
            f"  ps_wide V[PS_ORDER + 1][{places}], D[{scalars or 1}];",
            f"  for (int i = 0; i < {scalars}; i++)",
            f"    D[i] = ps_wide_at(w + {len(self._code.scalars)} + i * PS_DIRECTIONS, g);",
            *(f"  {line}" for line in (*read, *inverse, *start)),
            "  for (int k = 1;; k++) {",
            "    const double r = PS_INVERSE[k];",
            "    const ps_wide q = PS_WIDE_OF(dt * r), qb = PS_WIDE_OF(bend * r);",
            *(f"    {line}" for line in step),
            "    if (k == p) break;",
            *(f"    {line}" for line in (*self._lower_orders(), *each, *turn)),
            "  }",
            "  (void)x; (void)w; (void)live; (void)v; (void)D;",
            "}",
        ]
        return "\n".join(lines) + "\n"

    # ---- pieces of C ----

    def _row(self, node: int, order: str) -> str:
        return f"v[{order}][{self._code.row(node)}]"

    def _derivative(self, scalar: Scalar) -> str:
        return f"D[{self._slots.setdefault(scalar, len(self._slots))}]"

    def _lower_orders(self) -> list[str]:
        """Return the sums over lower orders, 0 < j < k."""
        used = [i for i, products in self._products.items() if products]
        lines = [f"ps_wide s{i} = {{0}};" for i in used]
        loops = -(-len(used) // _LOADS)
        for loop in range(loops):
            some = used[loop * len(used) // loops : (loop + 1) * len(used) // loops]
            products = sorted((n, p, i) for i in some for p, n in self._products[i])
            lines.append("for (int j = 1; j < k; j++) {")
            for n, group in itertools.groupby(products, lambda product: product[0]):
                lines.append(f"  ps_wide a{n} = V[j][{self._places[n]}];")
                lines.append(f"  PS_IN_REGISTER(a{n});")
                for _, p, i in group:
                    lines.append(f"  s{i} = {_added(self._row(p, 'k - j'), f'a{n}', f's{i}')};")
            lines.append("}")
        return lines

    def _node(self, i: int, order: str) -> list[str]:
        """Return the lines that make order 0 or k of a node's derivatives."""
        node = self._of.tape.nodes[i]
        if node.op == "state":
            return []
        if node.inner is None:
            value = self._operation(i, order)
        else:
            value = self._sum(node.inner, order)
        if node.op == "ramp":
            value = f"PS_WIDE_OF(live[{self._code.ramps.index(i)}]) * ({value})"
        return [f"const ps_wide t{i} = {value};", *self._kept(i, order)]

    def _kept(self, i: int, order: str) -> list[str]:
        """Return the line that keeps derivatives which sums of higher orders need."""
        return [f"V[{order}][{self._places[i]}] = t{i};"] if i in self._places else []

    def _operation(self, i: int, order: str) -> str:
        rule, text = self._of.rules[i], ""
        if order != "0" and self._products[i]:
            text = f"s{i}"
            for p, n in self._products[i]:
                text = _added(self._row(p, order), f"V[0][{self._places[n]}]", text)
        for partial, n in rule.terms:
            text = _added("" if partial is None else self._row(partial, "0"), f"t{n}", text)
        for c, n in rule.scalars:
            text = _added(self._row(n, order), self._derivative(c), text)
        return text if rule.divisor is None else f"PS_WIDE_OF(r{i}) * ({text})"

    def _sum(self, a: Combination, order: str) -> str:
        """Return the derivatives of a sum; its constant takes part in order 0."""
        text = self._derivative(a.constant) if order == "0" and self._of.moves(a.constant) else ""
        for n, c in self._of.moving_terms(a):
            text = _added("" if c == ONE else self._code.number(c), f"t{n}", text)
        for c, n in self._of.moving_scalars(a):
            text = _added(self._row(n, order), self._derivative(c), text)
        return text or "PS_WIDE_OF(0.0)"


def _added(factor: str, vector: str, text: str) -> str:
    """Return text + factor · vector in C; an empty factor is 1, an empty text 0."""
    if not factor:
        return f"({text} + {vector})" if text else vector
    if not text:
        return f"PS_WIDE_OF({factor}) * {vector}"
    return f"PS_WIDE_FMA(PS_WIDE_OF({factor}), {vector}, {text})"
