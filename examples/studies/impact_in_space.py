"""Does an impact without collision end sticking in space, as it must in the plane?

Random mobilities with entries of small integers, each with a random friction and a random slip in
the paradox (v_n = 0, A < 0): how many of these impacts end sticking, in slip that began again after
a stop, and in slip that never stopped. Then three of them, kept, and the rod, for which the theorem
of the plane holds: their phases, and the energy that they lose.

`... impact_in_space.py COUNT` looks at COUNT impacts (1000 by default); COUNT STEM also draws the
hodographs (the paths of the slip velocity) to STEM.png and STEM.svg. SI units.
"""

import math
import sys
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import painleve_sym as ps
from painleve_sym.present.style import PAGE, PALETTE, legend_below, legend_entries, save, styled
from painleve_sym.problem import Impact, invariant_directions

Array = np.ndarray


@dataclass(frozen=True)
class Case:
    """An impact by the energetic law."""

    title: str
    W: Array
    mu: float
    velocity: tuple[float, float, float]
    e: float

    @property
    def impact(self) -> Impact:
        """The impact, as the package solves it."""
        return ps.solve_impact(self.W, self.mu, self.velocity, "energetic", self.e)

    def rates(self, phi: float) -> tuple[float, float, float]:
        """Return A, k and h of a direction."""
        w, T = self.W[1:, 0], self.W[1:, 1:]
        e = np.array([math.cos(phi), math.sin(phi)])
        along = w - self.mu * T @ e
        A, k, h = self.W[0, 0] - self.mu * w @ e, e @ along, e[0] * along[1] - e[1] * along[0]
        return float(A), float(k), float(h)

    def hodograph(self, slip: Array, least: float = 1e-3) -> Array:
        """Return points of the path of a slip velocity, by the method of Runge and Kutta.

        It ends where less than the part `least` of the slip is left, or more than twice of it.
        """
        step = 0.02 / (self.mu * np.trace(self.W[1:, 1:]) + np.linalg.norm(self.W[1:, 0]))
        phi, growth, points = math.atan2(slip[1], slip[0]), 0.0, [slip]
        while math.log(least) < growth < math.log(2) and len(points) < 20000:
            ones = self.rates(phi)
            twos = self.rates(phi + step / 2 * ones[2])
            threes = self.rates(phi + step / 2 * twos[2])
            fours = self.rates(phi + step * threes[2])
            _, k, h = (np.array([*ones, *twos, *threes, *fours]).reshape(4, 3).T) @ [1, 2, 2, 1]
            phi, growth = phi + step / 6 * h, growth + step / 6 * k
            size = math.exp(growth) * np.linalg.norm(slip)
            points.append(size * np.array([math.cos(phi), math.sin(phi)]))
        return np.array(points)


def rod(theta: float) -> Array:
    """Return m W of a slender rod in space, whose centre lies towards t1 from the contact."""
    axis = np.array([math.sin(theta), math.cos(theta), 0.0])
    return 4 * np.eye(3) - 3 * np.outer(axis, axis)


CASES = (
    Case("rod, θ = 1, μ = 1.4", rod(1.0), 1.4, (0.0, -math.cos(0.15), -math.sin(0.15)), 0.75),
    Case(
        "slides out of the paradox",
        np.array([[1.0, -1, 0], [-1, 6, 2], [0, 2, 1]]),
        *(2.4, (0.0, -0.5, 0.9), 0.75),
    ),
    Case(
        "stops in it, slips again",
        np.array([[9.0, -2, 6], [-2, 1, -2], [6, -2, 5]]),
        *(2.1, (0.0, -0.5, 0.9), 0.75),
    ),
    Case(
        "is compressed twice",
        np.array([[8.0, -2, -6], [-2, 2, 1], [-6, 1, 5]]),
        *(1.3, (-1.0, -2.7, -1.5), 1.0),
    ),
)
"""The rod, two that do not stick, and one in which slip turns into the paradox in restitution."""


def drawn_case(rng: np.random.Generator) -> Case:
    """Draw an impact without collision."""
    while True:
        J = rng.integers(-3, 4, size=(3, 3)).astype(float)
        W, mu, phi = J @ J.T, float(rng.integers(1, 31)) / 10, rng.uniform(0, math.tau)
        case = Case("drawn", W, mu, (0.0, math.cos(phi), math.sin(phi)), float(rng.uniform()))
        if abs(np.linalg.det(J)) > 0.5 and case.rates(phi)[0] < 0:
            return case


def outcome(impact: Impact) -> str:
    """Return in words how an impact ends."""
    if impact.phases[-1].name.startswith("sticking"):
        return "sticks"
    stops = any(phase.name.startswith("reverse slip") for phase in impact.phases)
    return "slips again" if stops else "slides"


def ways_to_end(count: int) -> Counter[str]:
    """Return how many of the drawn impacts end in which way."""
    rng = np.random.default_rng(1)
    return Counter(outcome(drawn_case(rng).impact) for _ in range(count))


@styled
def figure() -> Figure:
    """Return the hodographs of the cases, with the sector of the paradox and what is invariant."""
    page = Figure(figsize=(PAGE, 2.3), layout="constrained")
    panels = page.subplots(1, len(CASES))
    for letter, axes, case in zip("abcd", panels, CASES, strict=True):
        hodographs(axes, case)
        axes.set(title=f"({letter}) {case.title}", xlabel="$v_1$ (m/s)")
        axes.title.set_fontsize(8)
    panels[0].set_ylabel("$v_2$ (m/s)")
    legend_below(page, legend_entries(panels))
    return page


def hodographs(axes: Axes, case: Case) -> None:
    """Draw the hodographs of a case: of its impact, and of slips all around."""
    radius = 1.3 * math.hypot(*case.velocity[1:])
    w = case.W[1:, 0]
    if case.mu * np.linalg.norm(w) > case.W[0, 0]:
        half = math.acos(case.W[0, 0] / (case.mu * np.linalg.norm(w)))
        sector = math.atan2(w[1], w[0]) + np.linspace(-half, half, 60)
        x, y = (np.append(0.0, 2 * radius * f(sector)) for f in (np.cos, np.sin))
        axes.fill(x, y, color=PALETTE[1], alpha=0.25, linewidth=0, label="A < 0")
    angles = np.linspace(0, math.tau, 16)
    for phi in angles[:-1]:
        path = case.hodograph(radius * np.array([math.cos(phi), math.sin(phi)]))
        axes.plot(*path.T, color="0.6", linewidth=0.5, label="hodographs")
    for direction in invariant_directions(case.W, case.mu):
        attracts = direction.turning < 0
        end = radius * np.array([math.cos(direction.angle), math.sin(direction.angle)])
        axes.plot(
            *zip((0, 0), end, strict=True),
            color="black",
            linewidth=0.8,
            linestyle="-" if attracts else ":",
            label="invariant, attracts" if attracts else "invariant, repels",
        )
    path = case.hodograph(np.array(case.velocity[1:]))
    impact = case.impact
    ends = np.array([phase.velocity[1:] for phase in impact.phases])
    # The path of the impact is that part of the hodograph up to where it ends or stops.
    last = ends[-1] if outcome(impact) == "slides" else np.zeros(2)
    near = np.argmin(np.linalg.norm(path - last, axis=1))
    axes.plot(*path[: near + 1].T, color=PALETTE[2], label="impact")
    if outcome(impact) == "slips again":
        axes.plot(*zip((0, 0), ends[-1], strict=True), color=PALETTE[2], label="impact")
    axes.plot(*ends.T, "o", color=PALETTE[2], markersize=3, label="ends of phases")
    axes.plot(*case.velocity[1:], "s", color=PALETTE[2], markersize=3, label="before")
    axes.set(xlim=(-radius, radius), ylim=(-radius, radius), aspect="equal")


def main() -> None:
    """Print the counts and the cases."""
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    counts = ways_to_end(count)
    print(f"{count} impacts without collision of random mobilities")
    for name in ("sticks", "slips again", "slides"):
        print(f"  {name:<12} {100 * counts[name] / count:5.1f} %")
    for case in CASES:
        impact = case.impact
        print(f"{case.title}: {outcome(impact)}, loses {-impact.energy_change:.6f} J")
        for phase in impact.phases:
            v_n, v_1, v_2 = phase.velocity
            print(
                f"  {phase.name:<26} P_n = {phase.normal_impulse:9.6f} N s, v_n = {v_n:9.6f}, "
                f"v_t = ({v_1:9.6f}, {v_2:9.6f}) m/s"
            )
    if len(sys.argv) > 2:
        save(figure(), Path(sys.argv[2]))


if __name__ == "__main__":
    main()
