"""Which restitution laws gain kinetic energy in an impact of several contacts, and how often?

Random impacts of a block that falls on two feet, of a ladder between floor and wall, and of any two
or three contacts with a definite W, each under the three laws; half of them with e = 1. The table
has the impacts that gain, the worst gain in parts of the kinetic energy before, those without an
answer (no impulse at all), those that jam on the way, those where several continuations were
possible, of which the one of least push is taken, and the number of pieces of the longest path.

`... impact_energy.py COUNT` looks at COUNT impacts of each kind (200 by default); COUNT SEED begins
with another seed; COUNT SEED STEM also draws the gains to STEM.png and STEM.svg, and keeps the
table in STEM.json. SI units.
"""

import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.engines.impacts import solve_simultaneous_impact
from painleve_sym.engines.simultaneous import SimultaneousImpact
from painleve_sym.present.style import (
    DASHES,
    PAGE,
    PALETTE,
    legend_below,
    legend_entries,
    save,
    styled,
)
from painleve_sym.problem.impact.one_contact import ImpactEnd

LAWS = ("energetic", "poisson", "newton")
NAMES = {"energetic": "energetic", "poisson": "Poisson", "newton": "Newton"}
Rng = np.random.Generator
Impact = tuple[np.ndarray, np.ndarray, np.ndarray]


def body(rng: Rng, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return W and v of a free body (x, y, θ) whose contacts have these rows and all approach."""
    mass, radius = 10 ** rng.uniform(-1, 1), 10 ** rng.uniform(-1, 0.3)
    mobility = rows @ np.diag([1 / mass, 1 / mass, 1 / (mass * radius**2)]) @ rows.T
    return mobility, approaching(rng, rows)


def approaching(rng: Rng, rows: np.ndarray) -> np.ndarray:
    """Return velocities v = J u of a random motion u under which every contact approaches."""
    while True:
        v = rows @ rng.normal(size=rows.shape[1])
        if np.all(v[::2] < 0):
            return v


def friction(rng: Rng, contacts: int) -> np.ndarray:
    """Return coefficients between 0.001 and 3."""
    return 10 ** rng.uniform(-3, 0.5, contacts)


def block(rng: Rng) -> Impact:
    """Return W, μ, v of a block on two feet, a to either side of the centre and h below it."""
    a, h = 10 ** rng.uniform(-1, 0.3, 2)
    rows = np.array([row for x in (-a, a) for row in ([0, 1, x], [1, 0, h])])
    W, v = body(rng, rows)
    return W, friction(rng, 2), v


def ladder(rng: Rng) -> Impact:
    """Return W, μ, v of a ladder, half length 1, with its foot to the right of a wall."""
    angle = rng.uniform(0.05, 1.5)
    x, y = np.cos(angle), np.sin(angle)
    rows = np.array([[0, 1, x], [1, 0, y], [1, 0, -y], [0, 1, -x]])
    W, v = body(rng, rows)
    return W, friction(rng, 2), v


def general(contacts: int) -> Callable[[Rng], Impact]:
    """Return what draws W = J Jᵀ, μ, v with as many freedoms as W has rows."""

    def draw(rng: Rng) -> Impact:
        rows = rng.normal(size=(2 * contacts, 2 * contacts))
        return rows @ rows.T, friction(rng, contacts), approaching(rng, rows)

    return draw


KINDS: dict[str, Callable[[Rng], Impact]] = {
    "block": block,
    "ladder": ladder,
    "two contacts": general(2),
    "three contacts": general(3),
}


def energy(W: np.ndarray, v: np.ndarray) -> float:
    """Return the kinetic energy that belongs to the contact velocities."""
    return float(v @ np.linalg.pinv(W, rcond=1e-10) @ v) / 2


class Tally:
    """Counts of the impacts of one kind under one law."""

    def __init__(self) -> None:
        self.gains: list[float] = []
        self.unanswered = self.jams = self.several = self.longest = 0

    @property
    def gaining(self) -> int:
        """Number of impacts with more kinetic energy after than before, beyond rounding."""
        return sum(gain > 1e-9 for gain in self.gains)

    def add(self, impact: SimultaneousImpact, W: np.ndarray, v: np.ndarray) -> None:
        """Count an impact."""
        jams, before = impact.end is ImpactEnd.JAM, energy(W, v)
        self.unanswered += jams and not impact.pieces
        self.jams += jams and bool(impact.pieces)
        self.several += not impact.is_unique
        self.gains.append(impact.energy_change / before)
        self.longest = max(self.longest, len(impact.pieces))

    def __str__(self) -> str:
        """Return the row of the table."""
        worst = max(0.0, *self.gains)
        energy = f"{self.gaining:7d} {100 * worst:10.3g} % {self.unanswered:10d}"
        return f"{energy} {self.jams:5d} {self.several:8d} {self.longest:8d}"


def tallies(count: int, seed: int) -> dict[tuple[str, str], Tally]:
    """Return the tally of each kind and law."""
    result: dict[tuple[str, str], Tally] = {}
    for k, (kind, draw) in enumerate(KINDS.items()):
        rng = np.random.default_rng([seed, k])
        own = {law: result.setdefault((kind, law), Tally()) for law in LAWS}
        for _ in range(count):
            W, mu, v = draw(rng)
            e = 1.0 if rng.random() < 0.5 else float(rng.uniform())
            for law, tally in own.items():
                tally.add(solve_simultaneous_impact(W, mu, v, law, e), W, v)
    return result


@styled
def figure(results: dict[tuple[str, str], Tally]) -> Figure:
    """Return the distribution of the change of energy, a panel for each kind of impact."""
    drawn = Figure(figsize=(PAGE, 2.2), layout="constrained")
    panels = drawn.subplots(1, len(KINDS), sharey=True)
    for letter, axes, kind in zip("abcd", panels, KINDS, strict=True):
        for law, color, dashes in zip(LAWS, PALETTE, DASHES, strict=False):
            changes = 100 * np.sort(results[kind, law].gains)
            part = np.arange(1, len(changes) + 1) / len(changes) * 100
            axes.step(changes, part, where="post", color=color, linestyle=dashes, label=NAMES[law])
        axes.axvline(0, color="black", linewidth=0.5, zorder=0)
        axes.set(xlim=(-102, 102), xlabel="energy gained (%)", title=f"({letter}) {kind}")
    panels[0].set_ylabel("impacts below (%)")
    legend_below(drawn, legend_entries(panels))
    return drawn


def main() -> None:
    """Print the table."""
    given = (*sys.argv[1:3], *("200", "1")[len(sys.argv[1:3]) :])
    count, seed = (int(a) for a in given)
    print(f"{count} impacts of each kind, seed {seed}")
    print(
        f"{'impact':<15} {'law':<10} {'gaining':>7} {'worst gain':>12} {'no answer':>10} "
        f"{'jams':>5} {'several':>8} {'longest':>8}"
    )
    results = tallies(count, seed)
    for (kind, law), tally in results.items():
        print(f"{kind:<15} {law:<10} {tally}")
    if len(sys.argv) > 3:
        stem = Path(sys.argv[3])
        given = {"version": ps.__version__, "law": f"rigid, with restitution {', '.join(LAWS)}"}
        rows = [[kind, law, *str(tally).split()] for (kind, law), tally in results.items()]
        data = {"computed": given, "count": count, "seed": seed, "rows": rows}
        save(figure(results), stem)
        stem.with_suffix(".json").write_text(json.dumps(data, indent=1) + "\n", "utf-8")


if __name__ == "__main__":
    main()
