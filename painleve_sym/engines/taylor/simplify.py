"""Fewer Cauchy products for the same sums: common factors, common denominators, shared products."""

from __future__ import annotations

from collections import Counter

from painleve_sym.engines.taylor.scalars import ONE, ZERO, Scalar
from painleve_sym.engines.taylor.tape import PAIRS, Combination, Node, SeriesTape

_PASSES = 12
"""More passes have never simplified anything."""


def simplify(tape: SeriesTape) -> SeriesTape:
    """Return an equal tape with as few products as the rules below find."""
    best = tape
    # A shared ratio is no longer a term over a common denominator, so it comes last.
    for ratios in (False, True):
        current, before = best, list[tuple[bool, SeriesTape]]()
        for i in range(_PASSES):
            distribute = i % 2 == 1
            # A pass over the same tape once more begins what would only repeat itself.
            if (distribute, current) in before:
                break
            before.append((distribute, current))
            current = _Rebuild(current, distribute=distribute, ratios=ratios).result
            if current.cost < best.cost:
                best = current
    return best


class _Rebuild:
    """One pass over a tape.

    a/d · b becomes (a·b)/d; a₁/d + a₂/d becomes (a₁ + a₂)/d; f·a + f·b becomes f·(a + b); and where
    f·x exists, f·(c + x·y) becomes c·f + (f·x)·y. Only what nothing else uses is taken apart. A sum
    that has another row as a part is made of that row.

    Parameters
    ----------
    tape : Tape
    distribute : bool
        Whether the last of these rules applies, or the others.
    ratios : bool
        Whether (a·b)/d and (a'·b)/d become a·(b/d) and a'·(b/d), where the others apply.
    """

    def __init__(self, tape: SeriesTape, *, distribute: bool, ratios: bool) -> None:
        self._old, self._distribute = tape, distribute
        self._live = tape.reachable()
        roots = [*tape.rates, *tape.guards]
        self._uses = Counter(n for i in self._live for n in tape.nodes[i].operands)
        self._uses.update(n for c in roots for n, _ in c.terms)
        self._products = {
            frozenset(tape.nodes[i].args) for i in self._live if tape.nodes[i].op == "mul"
        }
        self._ratios = self._shared_ratios() if ratios and not distribute else {}
        self._rows = [i for i in self._live if tape.nodes[i].op == "linear"]
        new = self._new = SeriesTape(scalars=tape.scalars)
        self._map: dict[int, Combination] = {}
        for i in range(len(tape.rates)):
            self._map[i] = new.single(tape.nodes[i])
        for i in self._live:
            if i not in self._map:
                self._map[i] = self._node(i, tape.nodes[i])
        new.rates = [self._row(self._sum(c)) for c in tape.rates]
        new.guards = [self._sum(c) for c in tape.guards]
        self.result = new

    def _row(self, a: Combination) -> Combination:
        """Return a rate as a multiple of the row that holds it, where there is one."""
        if len(a.terms) < 2:
            return a
        factor, inner = self._new.unscaled(a)
        node = Node("linear", inner=inner)
        return self._new.single(node).scaled(factor) if self._new.has(node) else a

    def _node(self, i: int, node: Node) -> Combination:
        new = self._new
        args = [self._map[n] for n in node.args]
        if node.op == "linear" and node.inner is not None:
            return self._sum(node.inner)
        if node.op == "ramp" and node.inner is not None:
            return new.single(Node("ramp", inner=self._sum(node.inner), scalar=node.scalar))
        if node.op == "mul":
            return self._product(*node.args)
        if node.op == "sq":
            return new.times(args[0], args[0])
        if node.op == "div":
            return self._quotient(i, *node.args)
        if node.op == "inv":
            return new.over(Combination(ONE), args[0])
        if node.op in PAIRS:
            # The partner comes with it, in the order of the old tape.
            return new.single(Node(node.op, tuple(new.row(a) for a in args)))
        return new.single(Node(node.op, tuple(new.row(a) for a in args), scalar=node.scalar))

    def _quotient(self, i: int, top: int, bottom: int) -> Combination:
        new = self._new
        shared = self._ratios.get(i)
        if shared is None:
            return new.over(self._map[top], self._map[bottom])
        ratio = new.over(self._map[shared], self._map[bottom])
        return new.times(self._map[self._other(top, shared)], ratio)

    def _shared_ratios(self) -> dict[int, int]:
        """Return, of quotients (a·b)/d with the same b and d, the node b by quotient."""
        by: dict[tuple[int, int], list[int]] = {}
        for i in self._live:
            node = self._old.nodes[i]
            top = self._old.nodes[node.args[0]] if node.op == "div" else node
            if node.op == "div" and top.op == "mul" and self._uses[node.args[0]] == 1:
                for b in top.args:
                    by.setdefault((b, node.args[1]), []).append(i)
        shared: dict[int, int] = {}
        for (b, _), quotients in sorted(by.items(), key=lambda item: -len(item[1])):
            free = [i for i in quotients if i not in shared]
            shared |= dict.fromkeys(free, b) if len(free) > 1 else {}
        return shared

    def _product(self, m: int, n: int) -> Combination:
        new = self._new
        for a, b in ((m, n), (n, m)):
            node = self._old.nodes[a]
            if self._distribute:
                spread = self._spread(b, node) if self._uses[a] == 1 else None
                if spread is not None:
                    return spread
            elif node.op == "div" and self._uses[a] == 1:
                top = new.times(self._map[node.args[0]], self._map[b])
                return new.over(top, self._map[node.args[1]])
        return new.times(self._map[m], self._map[n])

    def _spread(self, f: int, row: Node) -> Combination | None:
        """Return f · row with the products of f that exist, or None."""
        if row.op != "linear" or row.inner is None:
            return None
        new = self._new
        total = self._map[f].scaled(row.inner.constant)
        for n, c in row.inner.terms:
            node = self._old.nodes[n]
            if node.op != "mul" or self._uses[n] != 1:
                return None
            x, y = node.args
            if frozenset((f, x)) not in self._products:
                x, y = y, x
            if frozenset((f, x)) not in self._products:
                return None
            shared = new.times(self._map[f], self._map[x])
            total = new.plus(total, new.times(shared, self._map[y]).scaled(c))
        return total

    def _part(self, a: Combination) -> tuple[Combination, Combination]:
        """Return the largest row that is part of a sum, as it is now, and the rest of the sum."""
        best, old = (Combination(), a), self._old
        if self._distribute:
            return best
        most, terms = 1, dict(a.terms)
        for i in self._rows:
            inner = old.nodes[i].inner
            if inner is None or i not in self._map or not len(a.terms) > len(inner.terms) > most:
                continue
            if len(self._map[i].terms) < 2:
                continue
            ratios = {terms[n] / c for n, c in inner.terms if n in terms}
            if len(ratios) != 1 or any(n not in terms for n, _ in inner.terms):
                continue
            factor, own = ratios.pop(), {n for n, _ in inner.terms}
            left = old.scalars.add(a.constant, -(inner.constant * factor))
            rest = Combination(left, tuple(t for t in a.terms if t[0] not in own))
            most, best = len(own), (self._as_row(self._map[i]).scaled(factor), rest)
        return best

    def _as_row(self, a: Combination) -> Combination:
        factor, row = self._new.scaled_row(a)
        return Combination(ZERO, ((row, factor),))

    def _sum(self, a: Combination) -> Combination:
        new = self._new
        total, a = self._part(a)
        total, rest = new.plus(total, Combination(a.constant)), list(a.terms)
        if not self._distribute:
            for op, place in (("div", 1), ("mul", None)):
                while (group := self._group(rest, op, place)) is not None:
                    shared, members = group
                    rest = [t for t in rest if t not in members]
                    inner = Combination()
                    for n, c in members:
                        inner = new.plus(inner, self._map[self._other(n, shared)].scaled(c))
                    common = self._map[shared]
                    join = new.over(inner, common) if op == "div" else new.times(common, inner)
                    total = new.plus(total, join)
        for n, c in rest:
            term = self._map[n]
            # A row in a sum is a part that it shares.
            if self._old.nodes[n].op == "linear" and len(term.terms) > 1:
                term = self._as_row(term)
            total = new.plus(total, term.scaled(c))
        return total

    def _group(
        self, terms: list[tuple[int, Scalar]], op: str, place: int | None
    ) -> tuple[int, list[tuple[int, Scalar]]] | None:
        """Return the common factor of most products of a sum, and the terms that have it."""
        alone = [t for t in terms if self._old.nodes[t[0]].op == op and self._uses[t[0]] == 1]
        by: dict[int, list[tuple[int, Scalar]]] = {}
        for t in alone:
            args = self._old.nodes[t[0]].args
            for n in (args[place],) if place is not None else args:
                by.setdefault(n, []).append(t)
        best = max(by.items(), key=lambda item: (len(item[1]), -item[0]), default=None)
        return best if best is not None and len(best[1]) > 1 else None

    def _other(self, product: int, shared: int) -> int:
        m, n = self._old.nodes[product].args
        return m if n == shared else n
