"""A mode's field and guards as a tape of operations that have a Taylor recurrence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import casadi as ca

from painleve_sym.engines.taylor.scalars import ONE, ZERO, Scalar, Scalars, common_factor
from painleve_sym.errors import NoRecurrence

MOST_FACTORS = 16
"""A whole power up to this one is made of products."""
LARGEST_FLOOR = 1e-30
"""max(a, floor) with a floor up to this one is a ramp: the base of a real power."""


class Combination(NamedTuple):
    """constant + Σ coefficient · node: nodes in ascending order, no coefficient 0."""

    constant: Scalar = ZERO
    terms: tuple[tuple[int, Scalar], ...] = ()

    @property
    def is_scalar(self) -> bool:
        """Whether it has no series in it."""
        return not self.terms

    def scaled(self, by: Scalar) -> Combination:
        """Return it times a scalar."""
        if by.is_zero:
            return Combination()
        if by == ONE:
            return self
        return Combination(self.constant * by, tuple((n, c * by) for n, c in self.terms))


class Node(NamedTuple):
    """One row of Taylor coefficients.

    Attributes
    ----------
    op : str
        ``state``, ``linear``, ``ramp``, ``above`` (whether a ramp is above its floor; has no
        series), ``mul``, ``sq``, ``div``, ``inv``, ``sqrt``, ``pow``, ``exp``, ``log``, ``sin``,
        ``cos``, ``sinh``, ``cosh``, ``tanh``, ``sech2`` (1/cosh²), ``atan2``.
    args : tuple of int
        Nodes, all of them earlier; of ``atan2`` y, x and x² + y².
    inner : Combination or None
        Of ``linear``, ``ramp`` and ``above``.
    scalar : Scalar or None
        Exponent of ``pow``, floor of ``ramp`` and ``above``.
    state_index : int
        Of ``state``.
    """

    op: str
    args: tuple[int, ...] = ()
    inner: Combination | None = None
    scalar: Scalar | None = None
    state_index: int = -1

    @property
    def operands(self) -> tuple[int, ...]:
        """Every node it is computed from."""
        return (*self.args, *(n for n, _ in self.inner.terms)) if self.inner else self.args


PAIRS = {"sin": "cos", "cos": "sin", "sinh": "cosh", "cosh": "sinh"}
PAIRS |= {"tanh": "sech2", "sech2": "tanh"}
"""Functions whose recurrences need each other."""

FLAT = ("exp", "sinh", "tanh")
"""Functions whose series may have vanishing terms far from where they change."""

PRODUCTS = dict.fromkeys(("mul", "sq", "div", "inv", "sqrt", "exp", "log", *PAIRS), 1)
PRODUCTS |= {"pow": 2, "atan2": 3}
"""Cauchy products that an operation takes at each order."""


@dataclass
class SeriesTape:
    """Expression graph whose nodes are rows of Taylor coefficients.

    The rates are ẋ, one per state; `others` are nodes that are needed besides.
    """

    nodes: list[Node] = field(default_factory=list)
    rates: list[Combination] = field(default_factory=list)
    guards: list[Combination] = field(default_factory=list)
    scalars: Scalars = field(default_factory=Scalars)
    others: list[int] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._known = {node: i for i, node in enumerate(self.nodes)}

    def reachable(self) -> list[int]:
        """Return the states and every node that rates and guards need, in order."""
        reached = set(range(len(self.rates)))
        front = [*self.others, *(n for c in (*self.rates, *self.guards) for n, _ in c.terms)]
        while front:
            n = front.pop()
            if n not in reached:
                reached.add(n)
                front += [*self.nodes[n].operands, self.pair(n)]
        return sorted(reached)

    def pair(self, i: int) -> int:
        """Return the partner of a node, itself where it has none."""
        node = self.nodes[i]
        return self.node(Node(PAIRS[node.op], node.args)) if node.op in PAIRS else i

    def monomials(self) -> set[Scalar]:
        """Return the scalars of rates, guards and the nodes that they need but numbers."""
        nodes = [self.nodes[i] for i in self.reachable()]
        sums = [
            *self.rates,
            *self.guards,
            *(node.inner for node in nodes if node.inner is not None),
        ]
        scalars = {c for a in sums for c in (a.constant, *(c for _, c in a.terms))}
        scalars |= {node.scalar for node in nodes if node.scalar is not None}
        return {s for s in scalars if s.factors}

    @property
    def products(self) -> int:
        """Number of Cauchy products in one order."""
        return sum(PRODUCTS.get(self.nodes[i].op, 0) for i in self.reachable())

    @property
    def cost(self) -> tuple[int, int]:
        """Numbers of Cauchy products and of terms of sums in one order."""
        sums = [*self.rates, *(self.nodes[i].inner for i in self.reachable())]
        return self.products, sum(len(c.terms) for c in sums if c is not None)

    # ---- building ----

    def node(self, node: Node) -> int:
        """Return the index of a node, the same for equal ones."""
        if node not in self._known:
            self._known[node] = len(self.nodes)
            self.nodes.append(node)
            if node.op in PAIRS:
                self.node(Node(PAIRS[node.op], node.args))
        return self._known[node]

    def has(self, node: Node) -> bool:
        """Whether the tape holds an equal node."""
        return node in self._known

    def single(self, node: Node) -> Combination:
        """Return a node as a combination."""
        return Combination(ZERO, ((self.node(node), ONE),))

    def plus(self, a: Combination, b: Combination) -> Combination:
        """Return a + b."""
        terms = dict(a.terms)
        for n, c in b.terms:
            terms[n] = self.scalars.add(terms.get(n, ZERO), c)
        kept = tuple(sorted((n, c) for n, c in terms.items() if not c.is_zero))
        return Combination(self.scalars.add(a.constant, b.constant), kept)

    def row(self, a: Combination) -> int:
        """Return a node that holds `a` itself."""
        if a.constant.is_zero and len(a.terms) == 1 and a.terms[0][1] == ONE:
            return a.terms[0][0]
        return self.node(Node("linear", inner=a))

    def scaled_row(self, a: Combination) -> tuple[Scalar, int]:
        """Return a scalar and a node whose product is `a`; equal nodes for proportional sums."""
        if a.constant.is_zero and len(a.terms) == 1:
            return a.terms[0][1], a.terms[0][0]
        factor, inner = self.unscaled(a)
        return factor, self.row(inner)

    def unscaled(self, a: Combination) -> tuple[Scalar, Combination]:
        """Return a scalar and a sum whose product is `a`; equal sums for proportional ones."""
        coefficients = [c for _, c in a.terms]
        if not a.constant.is_zero:
            coefficients.append(a.constant)
        factor = common_factor(coefficients)
        terms = tuple((n, c / factor) for n, c in a.terms)
        return factor, Combination(a.constant / factor, terms)

    def times(self, a: Combination, b: Combination) -> Combination:
        """Return a · b."""
        if a.is_scalar or b.is_scalar:
            a, b = (b, a) if a.is_scalar else (a, b)
            return a.scaled(b.constant)
        (c, m), (d, n) = self.scaled_row(a), self.scaled_row(b)
        product = Node("sq", (m,)) if m == n else Node("mul", (min(m, n), max(m, n)))
        return self.single(product).scaled(c * d)

    def over(self, a: Combination, b: Combination) -> Combination:
        """Return a / b."""
        if b.is_scalar:
            return a.scaled(b.constant.inverse())
        d, n = self.scaled_row(b)
        if a.is_scalar:
            return self.single(Node("inv", (n,))).scaled(a.constant * d.inverse())
        c, m = self.scaled_row(a)
        return self.single(Node("div", (m, n))).scaled(c * d.inverse())

    def power(self, a: Combination, exponent: Combination) -> Combination:
        """Return a to a power."""
        if not exponent.is_scalar:
            return self.function("exp", self.times(exponent, self.function("log", a)))
        e = exponent.constant
        if e.factors or abs(e.number) > MOST_FACTORS or 2 * e.number % 1:
            return self.single(Node("pow", (self.row(a),), scalar=e))
        whole = Combination(ONE)
        for _ in range(int(abs(e.number))):
            whole = self.times(a, whole) if whole.is_scalar else self.times(whole, a)
        if e.number % 1:
            whole = self.times(self.function("sqrt", a), whole)
        return whole if e.number > 0 else self.over(Combination(ONE), whole)

    def function(self, name: str, a: Combination) -> Combination:
        """Return a function of one argument."""
        return self.single(Node(name, (self.row(a),)))

    def angle(self, y: Combination, x: Combination) -> Combination:
        """Return atan2(y, x)."""
        square = self.plus(self.times(x, x), self.times(y, y))
        return self.single(Node("atan2", (self.row(y), self.row(x), self.row(square))))

    def ramp(self, a: Combination, b: Combination) -> Combination:
        """Return max(a, b) where one of them is a floor next to zero."""
        a, b = (b, a) if a.is_scalar else (a, b)
        floor = b.constant
        if not b.is_scalar or floor.factors or not 0 < floor.number <= LARGEST_FLOOR:
            raise NoRecurrence("max")
        return self.single(Node("ramp", inner=a, scalar=floor))

    def above(self, floor: Combination, a: Combination) -> Combination:
        """Return whether a ramp, max(a, floor), is above its floor."""
        if not floor.is_scalar:
            raise NoRecurrence("lt")
        return self.single(Node("above", inner=a, scalar=floor.constant))

    def where(self, condition: Combination, a: Combination) -> Combination:
        """Return a, made of powers of a ramp, whose series is 0 where that is at its floor.

        Where the ramp is as good as a parameter the condition is a number, 1 or 0.
        """
        if condition.is_scalar:
            return a.scaled(condition.constant)
        for n, _ in condition.terms:
            above = self.nodes[n]
            if above.op == "above" and self._vanishes(a, above._replace(op="ramp")):
                return a
        raise NoRecurrence("if_else_zero")

    def _vanishes(self, a: Combination, ramp: Node) -> bool:
        """Whether each term has a real power of the ramp as a factor."""

        def has_factor(i: int) -> bool:
            node = self.nodes[i]
            if node.op in ("mul", "sq", "div"):
                return any(map(has_factor, node.args[:1] if node.op == "div" else node.args))
            if node.op == "linear" and node.inner is not None:
                return self._vanishes(node.inner, ramp)
            return self.base_ramp(i) == ramp

        return a.constant.is_zero and all(has_factor(n) for n, _ in a.terms)

    def base_ramp(self, i: int) -> Node | None:
        """Return the ramp of which a node is a real power, so 0 where that is at its floor."""
        node = self.nodes[i]
        base = self.nodes[node.args[0]] if node.op in ("pow", "sqrt") else node
        return base if base is not node and base.op == "ramp" else None


def build(expressions: ca.SX, x: ca.SX, z: ca.SX, c: ca.SX, rates: int) -> SeriesTape:
    """Return the tape of expressions: the rates of the states, this many, then the guards.

    NoRecurrence names the operation that has none; x, z and c are states, memory and constants.
    """
    function = ca.Function("f", [x, z, c], [ca.cse(ca.densify(expressions))])
    tape = SeriesTape()
    states = [tape.single(Node("state", state_index=i)) for i in range(x.numel())]
    # A state that rests in this mode is as good as a parameter.
    resting = [i for i in range(rates) if expressions[i].is_zero()]
    for i in resting:
        states[i] = Combination(tape.scalars.of(x[i]))
    inputs = [
        states,
        [Combination(tape.scalars.of(z[i])) for i in range(z.numel())],
        [Combination(tape.scalars.of(c[i])) for i in range(c.numel())],
    ]
    work: dict[int, Combination] = {}
    results = [Combination()] * function.nnz_out(0)
    for k in range(function.n_instructions()):
        op = function.instruction_id(k)
        source, target = function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            work[target[0]] = inputs[source[0]][source[1]]
        elif op == ca.OP_CONST:
            work[target[0]] = Combination(Scalar(float(function.instruction_constant(k))))
        elif op == ca.OP_OUTPUT:
            results[target[1]] = work[source[0]]
        else:
            work[target[0]] = _operate(tape, op, [work[i] for i in source])
    tape.rates, tape.guards = results[:rates], results[rates:]
    return tape


_Rule = Callable[..., Combination]
_MINUS, _TWO = Scalar(-1.0), Scalar(2.0)


def _beside(t: SeriesTape, a: Combination) -> Combination:
    square = t.times(a, a).scaled(_MINUS)
    return t.function("sqrt", t.plus(Combination(ONE), square))


_RULES: dict[int, _Rule] = {
    ca.OP_ASSIGN: lambda t, a: a,
    ca.OP_ADD: lambda t, a, b: t.plus(a, b),
    ca.OP_SUB: lambda t, a, b: t.plus(a, b.scaled(_MINUS)),
    ca.OP_NEG: lambda t, a: a.scaled(_MINUS),
    ca.OP_TWICE: lambda t, a: a.scaled(_TWO),
    ca.OP_MUL: lambda t, a, b: t.times(a, b),
    ca.OP_SQ: lambda t, a: t.times(a, a),
    ca.OP_DIV: lambda t, a, b: t.over(a, b),
    ca.OP_INV: lambda t, a: t.over(Combination(ONE), a),
    ca.OP_SQRT: lambda t, a: t.function("sqrt", a),
    ca.OP_POW: lambda t, a, b: t.power(a, b),
    ca.OP_CONSTPOW: lambda t, a, b: t.power(a, b),
    ca.OP_EXP: lambda t, a: t.function("exp", a),
    ca.OP_LOG: lambda t, a: t.function("log", a),
    ca.OP_SIN: lambda t, a: t.function("sin", a),
    ca.OP_COS: lambda t, a: t.function("cos", a),
    ca.OP_TAN: lambda t, a: t.over(t.function("sin", a), t.function("cos", a)),
    ca.OP_SINH: lambda t, a: t.function("sinh", a),
    ca.OP_COSH: lambda t, a: t.function("cosh", a),
    ca.OP_TANH: lambda t, a: t.function("tanh", a),
    ca.OP_ATAN: lambda t, a: t.angle(a, Combination(ONE)),
    ca.OP_ASIN: lambda t, a: t.angle(a, _beside(t, a)),
    ca.OP_ACOS: lambda t, a: t.angle(_beside(t, a), a),
    ca.OP_ATAN2: lambda t, a, b: t.angle(a, b),
    ca.OP_FMAX: lambda t, a, b: t.ramp(a, b),
    ca.OP_LT: lambda t, a, b: t.above(a, b),
    ca.OP_IF_ELSE_ZERO: lambda t, a, b: t.where(a, b),
}
_NAMES: dict[int, str] = {
    getattr(ca, name): name[3:].lower() for name in dir(ca) if name.startswith("OP_")
}


def _operate(tape: SeriesTape, op: int, args: list[Combination]) -> Combination:
    rule = _RULES.get(op)
    if all(a.is_scalar for a in args):
        infinite = op in (ca.OP_DIV, ca.OP_INV) and args[-1].constant.is_zero
        if op in _MONOMIAL and rule is not None and not infinite:
            return rule(tape, *args)
        values: list[Any] = [tape.scalars.expression(a.constant) for a in args]
        kind: Any = ca.SX.unary if len(values) == 1 else ca.SX.binary
        return Combination(tape.scalars.of(kind(op, *values)))
    if rule is None:
        raise NoRecurrence(_NAMES.get(op, str(op)))
    return rule(tape, *args)


_MONOMIAL = {
    ca.OP_ASSIGN, ca.OP_ADD, ca.OP_SUB, ca.OP_NEG, ca.OP_TWICE, ca.OP_MUL, ca.OP_SQ, ca.OP_DIV,
    ca.OP_INV,
}  # fmt: skip
