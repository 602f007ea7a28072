"""A tape as C: functions per mode that fill the rows of Taylor coefficients.

Order k of a product is Σ aⱼ b₍ₖ₋ⱼ₎. Of all products of a tape, the part 0 < j < k needs lower
orders only: it is summed first, then the terms with the coefficients of order k follow, operation
by operation. For one motion the sums stand four products side by side in one vector and the rest is
scalar; for several motions at once each number is a vector of theirs, a lane a motion. Both do the
same operations in the same order: a motion's bits do not depend on which of them ran.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from painleve_sym.engines.c_texts import number_text
from painleve_sym.engines.taylor.scalars import ONE, ZERO, Scalar
from painleve_sym.engines.taylor.tape import FLAT, Combination, SeriesTape

WIDTH = 4
"""Products side by side: doubles in a vector."""
_CHUNK = 6
"""Vectors summed in one loop: more would not stay in registers."""

_LOADS = 12
"""Products of lanes summed in one loop, for the same reason."""

_START = {"mul": "{0} * {1}", "sq": "{0} * {0}", "div": "{0} / {1}", "inv": "1 / {0}"}
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
    "tanh": "r * PS_FMA({d0}, {pair}, {s0})",
    "sech2": "-PS_FMA(2 * {pair}, {cpair}, {s0})",
    "atan2": "r{i} * r * (PS_FMA({d0}, {o1}, {s0}) - PS_FMA({d1}, {o0}, {s1}) - {s2})",
}
"""Order k of node i: {c0} … of its arguments, {d0} … their slopes k·cₖ, {o0} … their order 0, {o}
its own, {pair} and {cpair} those of its partner, {s0} … its sums over lower orders."""


@dataclass(frozen=True)
class _Kind:
    """C types of numbers: of one motion, or of several, a lane each.

    Type, ending of a function's name, fused multiplication and addition; a constant as such a
    number, a variable made by a call per lane, and a lane of a variable inside those calls.
    """

    real: str
    ending: str
    fma: str
    number: str
    each: str
    at: str


_ONE = _Kind("double", "", "PS_FMA", "{}", "const double {} = {};", "")
_LANES = _Kind(
    "ps_lanes",
    "_lanes",
    "PS_LANES_FMA",
    "PS_SPREAD({})",
    "ps_lanes {0}; PS_EACH_LANE({0}[l] = {1})",
    "[l]",
)


_PRODUCTS: dict[str, tuple[tuple[str, str], ...]] = {
    "mul": (("{c0}", "{c1}"),),
    "sq": (("{c0}", "{c0}"),),
    "div": (("{c1}", "{c}"),),
    "inv": (("{c0}", "{c}"),),
    "sqrt": (("{c}", "{c}"),),
    "pow": (("{d0}", "{c}"), ("{c0}", "{c}")),
    "exp": (("{d0}", "{c}"),),
    "log": (("{d}", "{c0}"),),
    **dict.fromkeys(("sin", "cos", "sinh", "cosh", "tanh"), (("{d0}", "{cpair}"),)),
    "sech2": (("{cpair}", "{cpair}"),),
    "atan2": (("{d0}", "{c1}"), ("{d1}", "{c0}"), ("{d}", "{c2}")),
}
"""Left and right factors of the sums over lower orders of a node, named as in `_EACH`; {c} and {d}
are its own."""


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
    then the ramps, whose step is [0, 1]. Each comes a second time, for lanes of motions. `first` is
    the column that follows those of the states, the next one by default.
    """

    def __init__(self, tape: SeriesTape, name: str, first: int | None = None) -> None:
        self.tape, self.name = tape, name
        self.states = len(tape.rates)
        self._slots: dict[Scalar, int] = {}
        self._live = tape.reachable()
        watched = {n for g in tape.guards for n, _ in g.terms} | set(self.arguments)
        kept = {n for n in (*watched, *tape.others) if n >= self.states} | set(self.ramps)
        next_column = self.states if first is None else first
        self._columns = {n: n for n in range(self.states)}
        self._columns |= {n: next_column + i for i, n in enumerate(sorted(kept))}
        # A ramp's column holds its argument, which the ramp itself differs from where it is dead.
        ramps = [n for n in tape.others if tape.nodes[n].op == "ramp"]
        self._ramps = {n: next_column + len(kept) + i for i, n in enumerate(ramps)}
        self.columns = next_column + len(kept) + len(ramps)
        self._pairs = {i: tape.pair(i) for i in self._live}
        products = {i: self._factors(i) for i in self._live}
        # Equal left factors side by side are one number spread over a vector.
        order = sorted((p[0], i, k) for i, ps in products.items() for k, p in enumerate(ps))
        self._products = [products[i][k] for _, i, k in order]
        self._places = {(i, k): place for place, (_, i, k) in enumerate(order)}
        factors = {f for p in self._products for f in p}
        sums = [*tape.rates, *(n.inner for n in tape.nodes if n.inner is not None)]
        self._read = factors | {f"c{n}" for c in sums for n, _ in c.terms}
        self._read |= {f"c{n}" for i in self._live for n in tape.nodes[i].args}
        self._slopes = {int(f[1:]) for f in factors if f[0] == "d"}
        self.text, self.guards_text = self._function(), self._guards(_ONE)
        self.lanes_text = self._lanes_function() + self._guards(_LANES)

    def _factors(self, i: int) -> list[tuple[str, str]]:
        names = {"c": f"c{i}", "d": f"d{i}", **self._names(i)}
        pairs = _PRODUCTS.get(self.tape.nodes[i].op, ())
        return [(left.format(**names), right.format(**names)) for left, right in pairs]

    def _names(self, i: int) -> dict[str, str]:
        """Return the variables of C that stand for arguments and partner of a node."""
        args, pair = self.tape.nodes[i].args, self._pairs[i]
        names = {f"{c}{j}": f"{c}{n}" for c in "cdo" for j, n in enumerate(args)}
        return names | {"pair": f"o{pair}", "cpair": f"c{pair}"}

    def row(self, node: int) -> int:
        """Return the column of the series of a node of the tape's `others`, or of a state."""
        return self._ramps.get(node, self._columns[node])

    def column(self, node: int) -> int:
        """Return the column of a node that is kept."""
        return self._columns[node]

    @property
    def scalars(self) -> list[Scalar]:
        """Scalars to be evaluated before, in the order of the argument `w`."""
        return list(self._slots)

    @property
    def ramps(self) -> list[int]:
        """Nodes that are ramps."""
        return [i for i in self._live if self.tape.nodes[i].op == "ramp"]

    @property
    def guards_of_states(self) -> int:
        """Bits of the guards that are sums of states."""
        terms = [[n for n, _ in guard.terms] for guard in self.tape.guards]
        return sum(1 << j for j, own in enumerate(terms) if all(n < self.states for n in own))

    @property
    def arguments(self) -> dict[int, int]:
        """Arguments of the functions that may be flat, with 1, or 2 where on either side."""
        nodes = [self.tape.nodes[i] for i in self._live]
        of = sorted((2 - (n.op == "exp"), n.args[0]) for n in nodes if n.op in FLAT)
        return {argument: sides for sides, argument in of}

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

    def number(self, s: Scalar) -> str:
        """Return a scalar in the C of one motion."""
        return self.scalar(s, _ONE)

    def scalar(self, s: Scalar, kind: _Kind) -> str:
        """Return a scalar in C: a number, or an entry of `w`."""
        if not s.factors:
            return kind.number.format(number_text(s.number))
        return f"w[{self._slots.setdefault(s, len(self._slots))}]"

    def sum(self, a: Combination, value: str, kind: _Kind, *, constant: bool = False) -> str:
        """Return a combination in C, its constant included where asked; `value` names a node."""
        constant &= not a.constant.is_zero
        text = self.scalar(a.constant, kind) if constant else ""
        for n, c in a.terms:
            term = value.format(n)
            if not c.factors and abs(c.number) == 1:
                text += f" {'+' if c.number > 0 else '-'} {term}"
            elif text:
                text = f"{kind.fma}({self.scalar(c, kind)}, {term}, {text})"
            else:
                text = f"{self.scalar(c, kind)} * {term}"
        return text.removeprefix(" + ") or kind.number.format("0.0")

    def _function(self) -> str:
        packs = range(-(-len(self._products) // WIDTH))
        end = []
        for g in packs:
            some = self._products[g * WIDTH : (g + 1) * WIDTH]
            some += [("0", "0")] * (WIDTH - len(some))
            for side, name in enumerate("LR"):
                end.append(f"{name}[k][{g}] = (ps_vector){{{', '.join(p[side] for p in some)}}};")
        sums = {p: f"s{p // WIDTH}[{p % WIDTH}]" for p in self._places.values()}
        head = [
            f"static void {self.name}(const double *x, const double *w, const double *live,",
            "    int p, double dt, double bend, double (*restrict v)[PS_COLUMNS]) {",
        ]
        if packs:
            head.append(
                f"  ps_vector L[PS_ORDER + 1][{len(packs)}], R[PS_ORDER + 1][{len(packs)}];"
            )
        return self._recurrences(_ONE, head, self._sums(packs), sums, end)

    def _lanes_function(self) -> str:
        factors = sorted({f for p in self._products for f in p})
        row = {f: i for i, f in enumerate(factors)}
        sums = {p: f"s{p}" for p in self._places.values()}
        products = range(len(self._products))
        lines = [f"ps_lanes s{i} = {{0}};" for i in products]
        for first in range(0, len(products), _LOADS):
            each = [
                f"s{i} = PS_LANES_FMA(F[{{0}}][{row[a]}], F[{{1}}][{row[b]}], s{i});"
                for i, (a, b) in enumerate(self._products)
                if i in products[first : first + _LOADS]
            ]
            lines += _in_order(each)
        head = [
            f"static void {self.name}_lanes(const ps_lanes *x, const ps_lanes *w,",
            "    const ps_lanes *live, int p, const ps_lanes *time,",
            "    ps_lanes (*restrict v)[PS_COLUMNS]) {",
            "  const ps_lanes dt = time[0], bend = time[1];",
        ]
        if factors:
            head.append(f"  ps_lanes F[PS_ORDER + 1][{len(factors)}];")
        end = [f"F[k][{i}] = {f};" for f, i in row.items()]
        return self._recurrences(_LANES, head, lines, sums, end)

    def _recurrences(
        self,
        kind: _Kind,
        head: list[str],
        sum_lines: list[str],
        sums: Mapping[int, str],
        end: list[str],
    ) -> str:
        """Return the function; `sums` says in which variable each product is summed."""
        rates = list(enumerate(self.tape.rates))
        start = [line for i in self._live for line in self._start(i, kind)]
        for i, r in rates:
            value, zero = self.sum(r, "o{}", kind, constant=True), kind.number.format("0.0")
            start.append(f"{kind.real} f{i} = {value}, b{i} = {zero};")
        each = [line for i in self._live for line in self._each(i, kind, sums)]
        turn = [f"b{i} = f{i}; f{i} = {self.sum(r, 'c{}', kind)};" for i, r in rates]
        lines = [
            *head,
            *(f"  {line}" for line in start),
            "  for (int k = 1;; k++) {",
            "    const double r = PS_INVERSE[k];",
            f"    const {kind.real} q = dt * r, qb = bend * r;",
            *(f"    v[k][{i}] = q * f{i} + qb * b{i};" for i, _ in rates),
            "    if (k == p) break;",
            *(f"    {line}" for line in (*sum_lines, *each, *turn, *end)),
            "  }",
            "  (void)w; (void)live;",
            "}",
        ]
        return "\n".join(lines) + "\n"

    def _sums(self, packs: range) -> list[str]:
        lines = [f"ps_vector s{g} = {{0}};" for g in packs]
        for first in range(0, len(packs), _CHUNK):
            some = packs[first : first + _CHUNK]
            add = "s{0} = PS_VECTOR_FMA(L[{{0}}][{0}], R[{{1}}][{0}], s{0});"
            lines += _in_order([add.format(g) for g in some])
        return lines

    def _start(self, i: int, kind: _Kind) -> list[str]:
        node, real = self.tape.nodes[i], kind.real
        args = [f"o{n}" for n in node.args]
        if node.op == "state":
            lines = [f"const {real} o{i} = x[{node.state_index}];"]
        elif node.op == "linear" and node.inner is not None:
            value = self.sum(node.inner, "o{}", kind, constant=True)
            lines = [f"const {real} o{i} = {value};"]
        elif node.op in _START:
            lines = [f"const {real} o{i} = {_START[node.op].format(*args)};"]
        else:
            lines = self._call(i, kind)
        if i in self._columns:
            # A ramp stores its argument, which continues where the ramp is dead.
            kept = f"{'a' if node.op == 'ramp' else 'o'}{i}"
            lines.append(f"v[0][{self._columns[i]}] = {kept};")
        if i in self._ramps:
            lines.append(f"v[0][{self._ramps[i]}] = o{i};")
        if node.op in _FACTOR:
            # The root of a dead ramp is 0, and so is what would be divided by it.
            root = node.op == "sqrt" and self.tape.base_ramp(i) is not None
            factor = "0.5 * {o} / {0}" if root else _FACTOR[node.op]
            lines.append(f"const {real} r{i} = {factor.format(*args, o=f'o{i}')};")
        if node.op == "pow" and node.scalar is not None:
            value = f"{self.scalar(node.scalar, kind)} + 1"
            lines.append(f"const {kind.real} e{i} = {value};")
        return lines

    def _call(self, i: int, kind: _Kind) -> list[str]:
        """Order 0 of a node that is a function of C, called for one lane after the other."""
        node, at = self.tape.nodes[i], kind.at
        args, lines = [f"o{n}{at}" for n in node.args], []
        if node.op == "ramp" and node.inner is not None:
            value = self.sum(node.inner, "o{}", kind, constant=True)
            lines.append(f"const {kind.real} a{i} = {value};")
            live = f"live[{self.ramps.index(i)}]{at}"
            value = f"ps_ramp({live}, a{i}{at}, {self.floor(i)!r})"
        elif node.op == "pow" and node.scalar is not None:
            exponent = self.scalar(node.scalar, _ONE)
            value = f"pow({args[0]}, {exponent}{at if node.scalar.factors else ''})"
        elif node.op in ("sin", "cos"):
            both = f"t{min(i, self._pairs[i])}"
            if i < self._pairs[i]:
                of = f"o{node.args[0]}"
                pair = f"ps_pair{kind.ending} {both} = ps_sin_cos{kind.ending}({of});"
                lines.append(f"const {pair}")
            return [*lines, f"const {kind.real} o{i} = {both}.{node.op};"]
        else:
            # The third of atan2, the square, is for its recurrence.
            name = "ps_sech2" if node.op == "sech2" else node.op
            value = f"{name}({', '.join(args[:2])})"
        ramp = self.tape.base_ramp(i)
        if ramp is not None and ramp.scalar is not None:
            value = f"{args[0]} > {ramp.scalar.number!r} ? {value} : 0"
        return [*lines, kind.each.format(f"o{i}", value)]

    def _each(self, i: int, kind: _Kind, sums: Mapping[int, str]) -> list[str]:
        node = self.tape.nodes[i]
        if node.op == "state":
            if not {f"c{i}", f"d{i}"} & self._read:
                return []
            value = f"v[k][{i}]"
        elif node.inner is not None:
            value = self.sum(node.inner, "c{}", kind)
        else:
            names = self._names(i)
            for j in range(3):
                place = self._places.get((i, j))
                if place is not None:
                    names[f"s{j}"] = sums[place]
            rule = _EACH[node.op].replace("PS_FMA", kind.fma)
            value = rule.format(i=i, o=f"o{i}", **names)
        if node.op == "ramp":
            column = f"v[k][{self._columns[i]}]"
            live = f"live[{self.ramps.index(i)}]"
            lines = [f"{column} = {value};", f"const {kind.real} c{i} = {live} * {column};"]
        else:
            lines = [f"const {kind.real} c{i} = {value};"]
            if i in self._columns and node.op != "state":
                lines.append(f"v[k][{self._columns[i]}] = c{i};")
        if i in self._ramps:
            lines.append(f"v[k][{self._ramps[i]}] = c{i};")
        if i in self._slopes:
            lines.append(f"const {kind.real} d{i} = (double)k * c{i};")
        return lines

    def _guards(self, kind: _Kind) -> str:
        """Series of guards and ramps; the last order is known of states only."""
        watched = [*self.tape.guards, *(Combination(ZERO, ((r, ONE),)) for r in self.ramps)]
        each, last, zero = [], [], []
        for j, a in enumerate(watched):
            terms = tuple((self._columns[n], c) for n, c in a.terms)
            states = tuple(t for t in terms if t[0] < self.states)
            each.append(
                f"g[k][{j}] = h[k] * ({self.sum(Combination(ZERO, terms), 'v[k][{}]', kind)});"
            )
            last.append(
                f"g[p][{j}] = h[p] * ({self.sum(Combination(ZERO, states), 'v[p][{}]', kind)});"
            )
            if not a.constant.is_zero:
                zero.append(f"g[0][{j}] += {self.scalar(a.constant, kind)};")
        lines = [
            f"static void {self.name}_guards{kind.ending}(const {kind.real} *w, int p,",
            f"    const {kind.real} *h, const {kind.real} (*v)[PS_COLUMNS],",
            f"    {kind.real} (*restrict g)[PS_WATCHED]) {{",
            "  for (int k = 0; k < p; k++) {",
            *(f"    {line}" for line in each),
            "  }",
            *(f"  {line}" for line in (*last, *zero)),
            "  (void)w; (void)h; (void)v; (void)g; (void)p;",
            "}",
        ]
        return "\n".join(lines) + "\n"


def _in_order(add: Sequence[str]) -> list[str]:
    """Sum products of orders {0} and {1} = k - {0}, in one loop for all of them."""

    def lines(first: str, second: str) -> list[str]:
        return [f"  {line.format(first, second)}" for line in add]

    return [
        "for (int j = 2; j < k - 1; j++) {",
        *lines("j", "k - j"),
        # The newest coefficients, on which the sums wait, come last.
        "}",
        "if (k > 1) {",
        *lines("1", "k - 1"),
        "}",
        "if (k > 2) {",
        *lines("k - 1", "1"),
        "}",
    ]
