"""A tape as C: one function per mode that fills the rows of Taylor coefficients."""

from __future__ import annotations

from painleve_sym.codegen.taylor.scalars import ZERO, Scalar
from painleve_sym.codegen.taylor.tape import PAIRS, Combination, Node, Tape

_START = {
    "mul": "{0} * {1}",
    "sq": "{0} * {0}",
    "div": "{0} / {1}",
    "inv": "1 / {0}",
    "atan2": "atan2({0}, {1})",
}
"""Order 0 of a node; other operations are functions of C."""

_FACTOR = {
    "div": "1 / {1}",
    "inv": "1 / {0}",
    "sqrt": "0.5 / {c}",
    "pow": "1 / {0}",
    "log": "1 / {0}",
    "atan2": "1 / {2}",
}
"""What a recurrence divides by, inverted once."""

_EACH = {
    "mul": "ps_mul({0}, {1}, k)",
    "sq": "ps_square({0}, k)",
    "div": "r{i} * ({0}[k] - ps_rest({1}, {c}, k))",
    "inv": "-r{i} * ps_rest({0}, {c}, k)",
    "sqrt": "r{i} * ({0}[k] - ps_square_inner({c}, k))",
    "pow": "r{i} * (e{i} * r * ps_rest({d0}, {c}, k) - ps_rest({0}, {c}, k))",
    "exp": "r * ps_rest({d0}, {c}, k)",
    "log": "r{i} * ({0}[k] - r * ps_inner({d}, {0}, k))",
    "sin": "r * ps_rest({d0}, {pair}, k)",
    "cos": "-r * ps_rest({d0}, {pair}, k)",
    "sinh": "r * ps_rest({d0}, {pair}, k)",
    "cosh": "r * ps_rest({d0}, {pair}, k)",
    "atan2": "r{i} * r * (ps_rest({d0}, {1}, k) - ps_rest({d1}, {0}, k) - ps_inner({d}, {2}, k))",
}
"""Order k of a node; {0}, {1}, {2} are its arguments, {d0}, {d1}, {d} slopes, {c} itself."""

COST = {
    "mul": lambda k: 2 * k + 1,
    "sq": lambda k: k + 3,
    "div": lambda k: 2 * k + 2,
    "inv": lambda k: 2 * k + 1,
    "sqrt": lambda k: k + 3,
    "pow": lambda k: 4 * k + 4,
    "exp": lambda k: 2 * k + 1,
    "log": lambda k: 2 * k + 2,
    "atan2": lambda k: 6 * k + 4,
}
"""Additions and multiplications at order k; the pairs cost what ``exp`` does."""


class SeriesCode:
    """Writes the C of one tape.

    The generated function takes the state, the scalars of the mode, which ramps are alive, the
    order and the unit of time; row n of `v` receives the coefficients of node n. Rows after those
    of the nodes hold slopes, k·aₖ of a node.

    Parameters
    ----------
    tape : Tape
    name : str
        Of the C function.
    """

    def __init__(self, tape: Tape, name: str) -> None:
        self.tape, self.name = tape, name
        # A constant rate is a row of its own: then all orders of a state follow one rule.
        plain = [rate.constant.is_zero for rate in tape.rates]
        self._rates = [
            rate if ok else Combination(ZERO, ((tape.row(rate), Scalar(1.0)),))
            for rate, ok in zip(tape.rates, plain, strict=True)
        ]
        self._slots: dict[Scalar, int] = {}
        self._live = self._reachable()
        sloped = {n: None for i in self._live for n in self._sloped(tape.nodes[i], i)}
        self._slopes = {n: len(tape.nodes) + i for i, n in enumerate(sloped)}
        self.text, self.guards_text = self._function(), self._guards()

    @property
    def rows(self) -> int:
        """How many rows it fills."""
        return len(self.tape.nodes) + len(self._slopes)

    @property
    def scalars(self) -> list[Scalar]:
        """What has to be evaluated before, in the order of the argument `w`."""
        return list(self._slots)

    @property
    def ramps(self) -> list[int]:
        """Nodes that are ramps."""
        return [i for i in self._live if self.tape.nodes[i].op == "ramp"]

    def floor(self, ramp: int) -> float:
        """Return the least value of a ramp."""
        scalar = self.tape.nodes[ramp].scalar
        return scalar.number if scalar is not None else 0.0

    def operations(self, order: int) -> int:
        """Return how many additions and multiplications a series of that order takes."""
        total = 0
        for k in range(1, order):
            total += len(self._slopes) + sum(2 * len(r.terms) + 1 for r in self._rates)
            for i in self._live:
                node = self.tape.nodes[i]
                if node.inner is not None:
                    total += 2 * len(node.inner.terms)
                elif node.op != "state":
                    total += COST.get(node.op, COST["exp"])(k)
        return total

    def _reachable(self) -> list[int]:
        found = set(range(len(self._rates)))
        front = [n for c in (*self._rates, *self.tape.guards) for n, _ in c.terms]
        while front:
            n = front.pop()
            node = self.tape.nodes[n]
            if n not in found:
                found.add(n)
                front += node.operands
                if node.op in PAIRS:
                    front.append(self._pair(node))
        return sorted(found)

    def _pair(self, node: Node) -> int:
        return self.tape.node(Node(PAIRS[node.op], node.args))

    def _sloped(self, node: Node, i: int) -> tuple[int, ...]:
        """Nodes whose slopes a recurrence needs."""
        if node.op == "log":
            return (i,)
        if node.op == "atan2":
            return (*node.args[:2], i)
        return node.args if node.op in ("pow", "exp", *PAIRS) else ()

    # ---- pieces of C ----

    def scalar(self, s: Scalar) -> str:
        """Return a scalar in C: a number, or an entry of `w`."""
        if not s.factors:
            return repr(s.number)
        return f"w[{self._slots.setdefault(s, len(self._slots))}]"

    def sum(self, a: Combination, order: str, *, constant: bool = False) -> str:
        """Return one order of a combination in C, its constant included where asked."""
        text = f" + {self.scalar(a.constant)}" if constant and not a.constant.is_zero else ""
        for n, c in a.terms:
            value = f"v[{n}][{order}]"
            if c.factors or abs(c.number) != 1:
                text += f" + {self.scalar(c)} * {value}"
            else:
                text += f" {'+' if c.number > 0 else '-'} {value}"
        return text.removeprefix(" + ") or "0.0"

    def _function(self) -> str:
        start = [f"v[{i}][0] = x[{i}];" for i in range(len(self._rates))]
        states = [
            f"v[{i}][k] = dt * r * ({self.sum(rate, 'k - 1')});"
            for i, rate in enumerate(self._rates)
        ]
        each = [self._slope(i) for i in range(len(self._rates)) if i in self._slopes]
        for i in self._live[len(self._rates) :]:
            start += self._start(i, self.tape.nodes[i])
            each.append(f"v[{i}][k] = {self._order(i, self.tape.nodes[i])};")
            if i in self._slopes:
                each.append(self._slope(i))
        lines = [
            f"static void {self.name}(const double *x, const double *w, const double *live,",
            "                     int p, double dt, double (*restrict v)[PS_LENGTH]) {",
            *(f"  {line}" for line in start),
            "  for (int k = 1; k <= p; k++) {",
            "    const double r = PS_INVERSE[k];",
            *(f"    {line}" for line in states),
            "    if (k == p) break;",
            *(f"    {line}" for line in each),
            "  }",
            "}",
        ]
        return "\n".join(lines) + "\n"

    def _guards(self) -> str:
        """Rows of the guards; the last order is known of states only."""
        states = len(self._rates)
        lines = [
            f"static void {self.name}_guards(const double *w, int p,",
            "    const double (*v)[PS_LENGTH], double (*restrict g)[PS_LENGTH]) {",
        ]
        for j, guard in enumerate(self.tape.guards):
            last = Combination(ZERO, tuple((n, c) for n, c in guard.terms if n < states))
            lines += [
                f"  for (int k = 0; k < p; k++) g[{j}][k] = {self.sum(guard, 'k')};",
                f"  g[{j}][p] = {self.sum(last, 'p')};",
            ]
            if not guard.constant.is_zero:
                lines.append(f"  g[{j}][0] += {self.scalar(guard.constant)};")
        return "\n".join([*lines, "  (void)w; (void)v; (void)g; (void)p;", "}", ""])

    def _slope(self, i: int) -> str:
        return f"v[{self._slopes[i]}][k] = k * v[{i}][k];"

    def _start(self, i: int, node: Node) -> list[str]:
        args = [f"v[{n}][0]" for n in node.args]
        if node.inner is not None:
            value = self.sum(node.inner, "0", constant=True)
            if node.op == "ramp" and node.scalar is not None:
                floor = repr(node.scalar.number)
                value = f"live[{self.ramps.index(i)}] > 0 ? fmax({value}, {floor}) : {floor}"
        elif node.op == "pow" and node.scalar is not None:
            value = f"pow({args[0]}, {self.scalar(node.scalar)})"
        else:
            value = _START.get(node.op, f"{node.op}({{0}})").format(*args)
        lines = [f"v[{i}][0] = {value};"]
        if node.op in _FACTOR:
            factor = _FACTOR[node.op].format(*args, c=f"v[{i}][0]")
            lines.append(f"const double r{i} = {factor};")
        if node.op == "pow" and node.scalar is not None:
            lines.append(f"const double e{i} = {self.scalar(node.scalar)} + 1;")
        return lines

    def _order(self, i: int, node: Node) -> str:
        if node.inner is not None:
            text = self.sum(node.inner, "k")
            return f"live[{self.ramps.index(i)}] * ({text})" if node.op == "ramp" else text
        slopes = {f"d{j}": f"v[{self._slopes.get(n)}]" for j, n in enumerate(node.args)}
        pair = f"v[{self._pair(node)}]" if node.op in PAIRS else ""
        d = f"v[{self._slopes.get(i)}]"
        args = [f"v[{n}]" for n in node.args]
        return _EACH[node.op].format(*args, i=i, c=f"v[{i}]", d=d, pair=pair, **slopes)
