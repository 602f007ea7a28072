"""A tape as C: one function per mode that fills the rows of Taylor coefficients.

Order k of a product is Σ aⱼ b₍ₖ₋ⱼ₎. Of all products of a tape, the part 0 < j < k needs lower
orders only: it is summed first, four products side by side in one vector. The terms with the
coefficients of order k follow in scalars, operation by operation.
"""

from __future__ import annotations

from painleve_sym.codegen.taylor.scalars import ONE, ZERO, Scalar
from painleve_sym.codegen.taylor.tape import PAIRS, Combination, Node, Tape

WIDTH = 4
"""Products side by side: doubles in a vector."""
_CHUNK = 6
"""Vectors summed in one loop: more would not stay in registers."""

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
    "sqrt": "0.5 / {o}",
    "pow": "1 / {0}",
    "log": "1 / {0}",
    "atan2": "1 / {2}",
}
"""What a recurrence divides by, inverted once."""

_EACH = {
    "mul": "PS_FMA({o0}, {c1}, PS_FMA({c0}, {o1}, {s0}))",
    "sq": "PS_FMA(2 * {o0}, {c0}, {s0})",
    "div": "r{i} * ({c0} - PS_FMA({c1}, {o}, {s0}))",
    "inv": "-r{i} * PS_FMA({c0}, {o}, {s0})",
    "sqrt": "r{i} * ({c0} - {s0})",
    "pow": "r{i} * (e{i} * r * PS_FMA({d0}, {o}, {s0}) - PS_FMA({c0}, {o}, {s1}))",
    "exp": "r * PS_FMA({d0}, {o}, {s0})",
    "log": "r{i} * ({c0} - r * {s0})",
    "sin": "r * PS_FMA({d0}, {pair}, {s0})",
    "cos": "-r * PS_FMA({d0}, {pair}, {s0})",
    "sinh": "r * PS_FMA({d0}, {pair}, {s0})",
    "cosh": "r * PS_FMA({d0}, {pair}, {s0})",
    "atan2": "r{i} * r * (PS_FMA({d0}, {o1}, {s0}) - PS_FMA({d1}, {o0}, {s1}) - {s2})",
}
"""Order k of node i: {c0} … of its arguments, {d0} … their slopes k·cₖ, {o0} … their order 0, {o}
its own, {pair} that of its partner, {s0} … its sums over lower orders."""


def _products(i: int, node: Node, pair: int) -> tuple[tuple[str, str], ...]:
    """Left and right factors of the sums over lower orders of node i; d marks a slope."""
    a = [f"c{n}" for n in node.args]
    d = [f"d{n}" for n in node.args]
    own = f"c{i}"
    table: dict[str, tuple[tuple[str, str], ...]] = {
        "mul": ((a[0], a[-1]),) if a else (),
        "sq": ((a[0], a[0]),) if a else (),
        "div": ((a[-1], own),) if a else (),
        "inv": ((a[0], own),) if a else (),
        "sqrt": ((own, own),),
        "pow": ((d[0], own), (a[0], own)) if a else (),
        "exp": ((d[0], own),) if a else (),
        "log": ((f"d{i}", a[0]),) if a else (),
    }
    if node.op in PAIRS:
        return ((d[0], f"c{pair}"),)
    if node.op == "atan2":
        return ((d[0], a[1]), (d[1], a[0]), (f"d{i}", a[2]))
    return table.get(node.op, ())


def _proportional(a: Combination, b: Combination) -> bool:
    """Whether two combinations differ by a factor that is positive where parameters are."""
    if [n for n, _ in a.terms] != [n for n, _ in b.terms] or a.is_scalar:
        return False
    ratios = {c * d.inverse() for (_, c), (_, d) in zip(a.terms, b.terms, strict=True)}
    if not (a.constant.is_zero and b.constant.is_zero):
        ratios.add(a.constant * b.constant.inverse())
    return len(ratios) == 1 and ratios.pop().number > 0


class SeriesCode:
    """Writes the C of one tape.

    The generated function takes the state, the scalars of the mode, which ramps are alive, the
    order, and dt, bend of the time t = dt u + bend u²/2 that the series in u run along. It fills
    the columns of `v`, order by order: states, then ramps and whatever else guards are made of. A
    second function takes them and the powers of a step and returns, order by order, the guards and
    then the ramps, whose step is [0, 1].

    Parameters
    ----------
    tape : Tape
    name : str
        Of the C function.
    """

    def __init__(self, tape: Tape, name: str) -> None:
        self.tape, self.name = tape, name
        self.states = len(tape.rates)
        self._slots: dict[Scalar, int] = {}
        self._live = tape.reachable()
        kept = {n for g in tape.guards for n, _ in g.terms if n >= self.states} | set(self.ramps)
        self._columns = {n: n for n in range(self.states)}
        self._columns |= {n: self.states + i for i, n in enumerate(sorted(kept))}
        self._pairs = {i: tape.pair(i) for i in self._live}
        products = {i: _products(i, tape.nodes[i], self._pairs[i]) for i in self._live}
        # Equal left factors side by side are one number spread over a vector.
        order = sorted((p[0], i, k) for i, ps in products.items() for k, p in enumerate(ps))
        self._products = [products[i][k] for _, i, k in order]
        self._lanes = {(i, k): lane for lane, (_, i, k) in enumerate(order)}
        factors = {f for p in self._products for f in p}
        sums = [*tape.rates, *(n.inner for n in tape.nodes if n.inner is not None)]
        self._read = factors | {f"c{n}" for c in sums for n, _ in c.terms}
        self._read |= {f"c{n}" for i in self._live for n in tape.nodes[i].args}
        self._slopes = {int(f[1:]) for f in factors if f[0] == "d"}
        self.text, self.guards_text = self._function(), self._guards()

    @property
    def columns(self) -> int:
        """How many columns it fills."""
        return len(self._columns)

    def column(self, node: int) -> int:
        """Return the column of a node that is kept."""
        return self._columns[node]

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

    def guarded(self, ramp: int) -> bool:
        """Whether some guard is a positive multiple of the ramp's argument."""
        inner = self.tape.nodes[ramp].inner
        return inner is not None and any(_proportional(g, inner) for g in self.tape.guards)

    def operations(self, order: int) -> int:
        """Return how many additions and multiplications a series of that order takes."""
        sums = sum(2 * (k - 1) * len(self._products) for k in range(1, order))
        each = len(self._slopes) + sum(2 * len(r.terms) + 1 for r in self.tape.rates)
        for i in self._live:
            node = self.tape.nodes[i]
            if node.inner is not None:
                each += 2 * len(node.inner.terms)
            elif node.op != "state":
                rule = _EACH[node.op]
                each += rule.count("*") + rule.count("- ") + 2 * rule.count("PS_FMA")
        return sums + each * (order - 1)

    # ---- pieces of C ----

    def scalar(self, s: Scalar) -> str:
        """Return a scalar in C: a number, or an entry of `w`."""
        if not s.factors:
            return repr(s.number)
        return f"w[{self._slots.setdefault(s, len(self._slots))}]"

    def sum(self, a: Combination, value: str, *, constant: bool = False) -> str:
        """Return a combination in C, its constant included where asked; `value` names a node."""
        text = f" + {self.scalar(a.constant)}" if constant and not a.constant.is_zero else ""
        for n, c in a.terms:
            if c.factors or abs(c.number) != 1:
                text += f" + {self.scalar(c)} * {value.format(n)}"
            else:
                text += f" {'+' if c.number > 0 else '-'} {value.format(n)}"
        return text.removeprefix(" + ") or "0.0"

    def _function(self) -> str:
        packs = range(-(-len(self._products) // WIDTH))
        rates = list(enumerate(self.tape.rates))
        start = [line for i in self._live for line in self._start(i)]
        start += [f"double f{i} = {self.sum(r, 'o{}', constant=True)}, b{i} = 0;" for i, r in rates]
        each = [line for i in self._live for line in self._each(i)]
        end = [f"b{i} = f{i}; f{i} = {self.sum(r, 'c{}')};" for i, r in rates]
        for g in packs:
            lanes = self._products[g * WIDTH : (g + 1) * WIDTH]
            lanes += [("0", "0")] * (WIDTH - len(lanes))
            for side, name in enumerate("LR"):
                end.append(f"{name}[k][{g}] = (ps_vector){{{', '.join(p[side] for p in lanes)}}};")
        lines = [
            f"static void {self.name}(const double *x, const double *w, const double *live,",
            "    int p, double dt, double bend, double (*restrict v)[PS_COLUMNS]) {",
            f"  ps_vector L[PS_ORDER + 1][{max(1, len(packs))}], R[PS_ORDER + 1]"
            f"[{max(1, len(packs))}];",
            *(f"  {line}" for line in start),
            "  for (int k = 1;; k++) {",
            "    const double r = PS_INVERSE[k], q = dt * r, qb = bend * r;",
            *(f"    v[k][{i}] = q * f{i} + qb * b{i};" for i, _ in rates),
            "    if (k == p) break;",
            *(f"    {line}" for line in self._sums(packs)),
            *(f"    {line}" for line in each),
            *(f"    {line}" for line in end),
            "  }",
            "  (void)w; (void)live; (void)L; (void)R;",
            "}",
        ]
        return "\n".join(lines) + "\n"

    def _sums(self, packs: range) -> list[str]:
        lines = [f"ps_vector s{g} = {{0}};" for g in packs]
        for first in range(0, len(packs), _CHUNK):
            some = packs[first : first + _CHUNK]
            add = "s{0} = PS_VECTOR_FMA(L[{1}][{0}], R[{2}][{0}], s{0});"
            lines.append("for (int j = 2; j < k - 1; j++) {")
            lines += [f"  {add.format(g, 'j', 'k - j')}" for g in some]
            # The newest coefficients, on which the sums wait, come last.
            lines.append("}")
            lines.append("if (k > 1) {")
            lines += [f"  {add.format(g, '1', 'k - 1')}" for g in some]
            lines.append("}")
            lines.append("if (k > 2) {")
            lines += [f"  {add.format(g, 'k - 1', '1')}" for g in some]
            lines.append("}")
        return lines

    def _start(self, i: int) -> list[str]:
        node = self.tape.nodes[i]
        args = [f"o{n}" for n in node.args]
        if node.op == "state":
            value = f"x[{node.index}]"
        elif node.inner is not None:
            value = self.sum(node.inner, "o{}", constant=True)
            if node.op == "ramp":
                floor = repr(self.floor(i))
                value = f"live[{self.ramps.index(i)}] > 0 ? fmax({value}, {floor}) : {floor}"
        elif node.op == "pow" and node.scalar is not None:
            value = f"pow({args[0]}, {self.scalar(node.scalar)})"
        else:
            value = _START.get(node.op, f"{node.op}({{0}})").format(*args)
        lines = [f"const double o{i} = {value};"]
        if i in self._columns:
            # Of a ramp what is kept is its argument, which goes on where the ramp is dead.
            kept = f"o{i}"
            if node.op == "ramp" and node.inner is not None:
                kept = self.sum(node.inner, "o{}", constant=True)
            lines.append(f"v[0][{self._columns[i]}] = {kept};")
        if node.op in _FACTOR:
            lines.append(f"const double r{i} = {_FACTOR[node.op].format(*args, o=f'o{i}')};")
        if node.op == "pow" and node.scalar is not None:
            lines.append(f"const double e{i} = {self.scalar(node.scalar)} + 1;")
        return lines

    def _each(self, i: int) -> list[str]:
        node = self.tape.nodes[i]
        if node.op == "state":
            if not {f"c{i}", f"d{i}"} & self._read:
                return []
            value = f"v[k][{i}]"
        elif node.inner is not None:
            value = self.sum(node.inner, "c{}")
            if node.op == "ramp":
                column = f"v[k][{self._columns[i]}]"
                live = f"live[{self.ramps.index(i)}]"
                return [f"{column} = {value};", f"const double c{i} = {live} * {column};"] + (
                    [f"const double d{i} = k * c{i};"] if i in self._slopes else []
                )
        else:
            names = {f"{kind}{j}": f"{kind}{n}" for kind in "cdo" for j, n in enumerate(node.args)}
            for j in range(3):
                lane = self._lanes.get((i, j))
                if lane is not None:
                    names[f"s{j}"] = f"s{lane // WIDTH}[{lane % WIDTH}]"
            value = _EACH[node.op].format(i=i, o=f"o{i}", pair=f"o{self._pairs[i]}", **names)
        lines = [f"const double c{i} = {value};"]
        if i in self._columns and node.op != "state":
            lines.append(f"v[k][{self._columns[i]}] = c{i};")
        if i in self._slopes:
            lines.append(f"const double d{i} = k * c{i};")
        return lines

    def _guards(self) -> str:
        """Series of guards and ramps; the last order is known of states only."""
        watched = [*self.tape.guards, *(Combination(ZERO, ((r, ONE),)) for r in self.ramps)]
        each, last, zero = [], [], []
        for j, a in enumerate(watched):
            terms = tuple((self._columns[n], c) for n, c in a.terms)
            states = tuple(t for t in terms if t[0] < self.states)
            each.append(f"g[k][{j}] = h[k] * ({self.sum(Combination(ZERO, terms), 'v[k][{}]')});")
            last.append(f"g[p][{j}] = h[p] * ({self.sum(Combination(ZERO, states), 'v[p][{}]')});")
            if not a.constant.is_zero:
                zero.append(f"g[0][{j}] += {self.scalar(a.constant)};")
        lines = [
            f"static void {self.name}_guards(const double *w, int p, const double *h,",
            "    const double (*v)[PS_COLUMNS], double (*restrict g)[PS_WATCHED]) {",
            "  for (int k = 0; k < p; k++) {",
            *(f"    {line}" for line in each),
            "  }",
            *(f"  {line}" for line in (*last, *zero)),
            "  (void)w; (void)h; (void)v; (void)g; (void)p;",
            "}",
        ]
        return "\n".join(lines) + "\n"
