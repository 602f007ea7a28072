"""The formulas of the paper: each derived again and compared with the print as an identity."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import sympy as sp

from painleve_sym.laws.catalogue import compliant_law
from painleve_sym.laws.compliance import DELTA, DELTA_MAX, K_E, ContactLaw, without_ramps
from painleve_sym.laws.restitution import E_C, ThreePhaseJump, three_phase_jump
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_N_PLUS, V_T, raw
from painleve_sym.mechanics.models import Mechanism
from painleve_sym.mechanics.paradox.critical_friction import critical_friction
from painleve_sym.mechanics.system import Coordinate, LagrangianSystem
from painleve_sym.papers.claim import Entry, Outcome, Verdict
from painleve_sym.papers.impact_resolution.claims import FORMULAS, PrintedFormula
from painleve_sym.papers.run_cache import Workbench

GROUP = "formula"
POSITIVE = (
    "delta delta_0 delta_max delta_p n e_s E nu R R_1 R_2 R_star K_e F_n_max F_n0 W_c E_nc depth"
)
REAL = (
    "x_A_dot_0 y_A_dot_0 y_A_dot_1 y_A_dot_3 theta_dot_0 theta_dot_1 theta_dot_2 P_n1 "
    "y_ddot theta_ddot"
)


def identical(left: sp.Expr, right: sp.Expr) -> bool:
    """Return whether two expressions are equal for all values of their symbols.

    Sines and cosines become rational functions of the half angle's tangent, where equality is
    decided exactly; SymPy simplifies what is left. Square roots are compared by their squares and
    their sign at one point.
    """
    if any(p.exp == sp.Rational(1, 2) for p in (left - right).atoms(sp.Pow)):
        symbols = sorted((left - right).free_symbols, key=str)
        point = {s: sp.Rational(2 + i, 3) for i, s in enumerate(symbols)}
        near = abs(sp.N((left - right).subs(point), 30)) < sp.Float("1e-20")
        return bool(near) and identical(sp.expand(left**2), sp.expand(right**2))
    difference = sp.expand_trig(sp.expand_power_base(left - right, force=True))
    swap = {}
    for angle in {a.args[0] for a in difference.atoms(sp.sin, sp.cos)}:
        u = sp.Dummy("u", real=True)
        swap[sp.sin(angle)] = 2 * u / (1 + u**2)
        swap[sp.cos(angle)] = (1 - u**2) / (1 + u**2)
    return bool(sp.simplify(sp.together(difference.subs(swap))) == 0)


@dataclass(frozen=True)
class Derived:
    """The right sides the paper prints, derived by the package's symbolic stages.

    Parameters
    ----------
    mechanism : Mechanism
        The rod.
    """

    mechanism: Mechanism

    @cached_property
    def names(self) -> dict[str, Any]:
        """Return every symbol a printed formula may use, by name."""
        system = self.mechanism.system
        found: dict[str, Any] = {s.name: s for s in sp.symbols(POSITIVE, positive=True)}
        found |= {s.name: s for s in sp.symbols(REAL, real=True)}
        found |= {s.name: s for s in (*system.q, *system.q_dot)}
        found |= {p.name: p.symbol for p in system.parameters}
        found |= {"F_n": sp.Symbol("F_n", nonnegative=True), "K_e": K_E}
        return found

    def parse(self, text: str) -> sp.Expr:
        """Return a printed right side as an expression."""
        return sp.sympify(text, locals=self.names, rational=True)

    def __getitem__(self, name: str) -> Any:
        return self.names[name]

    # ---- sliding and sticking ----

    def sliding(self) -> sp.Expr:
        """Return ÿ_A while sliding left."""
        c = self.mechanism.coefficients
        return c.A(-1) * self["F_n"] + c.B

    def a(self) -> sp.Expr:
        """Return A of leftward sliding."""
        return self.mechanism.coefficients.A(-1)

    def b(self) -> sp.Expr:
        """Return B."""
        return self.mechanism.coefficients.B

    def a_stick(self) -> sp.Expr:
        """Return A′."""
        return self.mechanism.coefficients.A_stick

    def b_stick(self) -> sp.Expr:
        """Return B′."""
        return self.mechanism.coefficients.B_stick

    def sticking_force(self) -> sp.Expr:
        """Return F_t that keeps the end at rest."""
        return self.mechanism.coefficients.sticking_force

    def sliding_force(self) -> sp.Expr:
        """Return F_n* of sliding on."""
        return -self.b() / self.a()

    def least_critical_friction(self) -> sp.Expr:
        """Return the smallest friction with A < 0 at some θ."""
        return critical_friction(self.mechanism.coefficients, -1).minimum("theta").value

    # ---- free flight, in the coordinates of the centre ----

    @cached_property
    def centre(self) -> Contact:
        """Return the contact of the rod described by its centre (x, y): a second derivation."""
        x, y = (Coordinate(n, f"centre of the rod, {n}", "m") for n in ("x", "y"))
        theta = self.mechanism.system.coordinates[2]
        m, l, g = (self[n] for n in ("m", "l", "g"))
        system = LagrangianSystem(
            name="rod by its centre",
            coordinates=(x, y, theta),
            parameters=self.mechanism.system.parameters,
            kinetic_energy=m * (x.rate**2 + y.rate**2) / 2 + m * l**2 * theta.rate**2 / 6,
            potential_energy=m * g * y.symbol,
        )
        end = (x.symbol - l * sp.cos(theta.symbol), y.symbol - l * sp.sin(theta.symbol))
        return Contact.of_point("A", system, end, self["mu"])

    def free(self, index: int) -> sp.Expr:
        """Return ẍ, ÿ or θ̈ without contact."""
        return self.centre.system.free_acceleration[index]

    def end_acceleration(self) -> sp.Expr:
        """Return ÿ_A from the accelerations of the centre."""
        moved = sp.Matrix([0, self["y_ddot"], self["theta_ddot"]])
        return (self.centre.J_N * moved)[0] + self.centre.normal_bias

    def free_end(self) -> sp.Expr:
        """Return ÿ_A in free flight."""
        contact = self.centre
        return (contact.J_N * contact.system.free_acceleration)[0] + contact.normal_bias

    # ---- the contact law ----

    @cached_property
    def law(self) -> ContactLaw:
        """Return the paper's law."""
        return compliant_law("bilinear-hertz")

    def of_law(self, expr: sp.Expr) -> sp.Expr:
        """Return an expression of the law in the letters of the paper."""
        own = {"e_energetic": "e_s", "n": "n", "E": "E", "nu": "nu", "R": "R"}
        swap = {p.symbol: self[own[p.name]] for p in self.law.parameters}
        swap |= {DELTA: self["delta"], DELTA_MAX: self["delta_max"]}
        squared = {s: self["e_s"] ** 2 for s in self.law.definitions if s != K_E}
        return without_ramps(expr).subs(squared).subs(swap)

    def loading(self) -> sp.Expr:
        """Return F_n on the loading curve."""
        return self.of_law(self.law.loading.force)

    def stiffness(self) -> sp.Expr:
        """Return K_e, with R* = R on a plane."""
        return self.of_law(self.law.definitions[K_E]).subs(self["R"], self["R_star"])

    def relative_curvature(self) -> sp.Expr:
        """Return 1/R*: d²/dr² at r = 0 of the distance between two spheres in contact."""
        r = sp.Symbol("r", real=True)
        gap = sum(R - sp.sqrt(R**2 - r**2) for R in (self["R_1"], self["R_2"]))
        return sp.diff(gap, r, 2).subs(r, 0)

    def unloading(self) -> sp.Expr:
        """Return F_n on the unloading curve."""
        return self.of_law(self.law.branch("restitution").force)

    def permanent(self) -> sp.Expr:
        """Return δ_p that makes the work given back the part e_s² of the work done."""
        delta_p = self["delta_p"]
        span, rest = self["delta_max"] - delta_p, self.work_in() * self["e_s"] ** 2
        # ∫F_n dδ of (5) over the unloading curve, in the depth.
        peak = K_E * self["delta_max"] ** self["n"]
        given_back = sp.integrate(self["depth"] ** self["n"], self["depth"])
        given_back = peak * given_back.subs(self["depth"], span) / span ** self["n"]
        return sp.solve(sp.simplify((given_back - rest) / peak), delta_p)[0]

    def work_in(self) -> sp.Expr:
        """Return W_c = ∫F_n dδ up to δ_max."""
        return sp.integrate(self.loading(), (self["delta"], 0, self["delta_max"]))

    def work_back(self) -> sp.Expr:
        """Return W_r = ∫F_n dδ along the unloading curve, from δ_max to where it ends."""
        depth, remains = self["depth"], self["delta_max"] * (1 - self["e_s"] ** 2)
        force = sp.simplify(self.unloading().subs(self["delta"], remains + depth))
        return -sp.integrate(force, depth).subs(depth, self["delta_max"] - remains)

    def surface_energy(self) -> sp.Expr:
        """Return E_n0 = ∫F_n dδ up to δ_0."""
        return sp.integrate(self.loading(), (self["delta"], 0, self["delta_0"]))

    # ---- the jump ----

    @cached_property
    def jump(self) -> ThreePhaseJump:
        """Return its three phases, each in the velocities at its own start."""
        return three_phase_jump(self.mechanism.coefficients, write=raw)

    def named(self, expr: sp.Expr, phase: int) -> sp.Expr:
        """Return an expression of a phase in the velocities the paper names at its start."""
        spin = self.mechanism.system.q_dot[2]
        start = {spin: self[f"theta_dot_{phase}"], V_T: self["x_A_dot_0"]}
        if phase < 2:
            start[V_N] = self[f"y_A_dot_{phase}"]
        return sp.sympify(expr).subs({**start, V_N_PLUS: self["y_A_dot_3"]})

    def spin(self, phase: int) -> sp.Expr:
        """Return θ̇ at the end of a phase."""
        return self.named(self.jump.phases[phase].velocity[self.mechanism.system.q_dot[2]], phase)

    def first_energy(self, start: sp.Expr) -> sp.Expr:
        """Return E_n1 in ẏ_A(t0) = `start` and ẏ_A(t1)."""
        first = self.jump.tangential
        energy, end = (self.named(e, 0) for e in (first.stored_energy, first.normal_velocity))
        # ẏ_A(t1) is linear in ẋ_A(t0).
        rest = end.subs(self["x_A_dot_0"], 0)
        x_0 = (self["y_A_dot_1"] - rest) / end.diff(self["x_A_dot_0"])
        return energy.subs(self["x_A_dot_0"], x_0).subs(self["y_A_dot_0"], start)

    def rebound(self) -> sp.Expr:
        """Return ẏ_A(t3) from the energy of compression."""
        law_symbol = self.jump.law.parameter.symbol
        rebound = self.jump.separation_velocity
        return rebound.subs({E_C: self["E_nc"], law_symbol: self["e_s"]})


def _abbreviations(d: Derived) -> dict[sp.Symbol, sp.Expr]:
    """Return what the abbreviations of the printed formulas stand for."""
    peak = K_E * d["delta_max"] ** d["n"]
    return {
        d["F_n_max"]: peak,
        d["F_n0"]: K_E * d["delta_0"] ** d["n"],
        d["W_c"]: peak * d["delta_max"] / (d["n"] + 1),
        d["delta_p"]: d["delta_max"] * (1 - d["e_s"] ** 2),
    }


Derive = Callable[[Derived], sp.Expr]

_DERIVE: dict[str, tuple[str, Derive]] = {
    "eq-1": ("normal acceleration in sliding", Derived.sliding),
    "eq-2": ("coefficient A", Derived.a),
    "eq-3": ("coefficient B", Derived.b),
    "eq-4": ("loading curve", Derived.loading),
    "eq-4-stiffness": ("stiffness", Derived.stiffness),
    "eq-4-radius": ("relative curvature", Derived.relative_curvature),
    "eq-5": ("unloading curve", Derived.unloading),
    "eq-6": ("permanent compression", Derived.permanent),
    "eq-7": ("work of compression", Derived.work_in),
    "eq-8": ("work of restitution", Derived.work_back),
    "eq-9": ("energetic restitution", Derived.work_back),
    "eq-10": ("surface energy", Derived.surface_energy),
    "eq-11-x": ("free flight along x", lambda d: d.free(0)),
    "eq-11-y": ("free flight along y", lambda d: d.free(1)),
    "eq-11-spin": ("free rotation", lambda d: d.free(2)),
    "eq-12": ("kinematics of the end", Derived.end_acceleration),
    "eq-13": ("free flight of the end", Derived.free_end),
    "sticking-force": ("friction in sticking", Derived.sticking_force),
    "eq-14-normal": (
        "normal velocity after the tangential phase",
        lambda d: d.named(d.jump.tangential.normal_velocity, 0),
    ),
    "eq-14-impulse": (
        "impulse of the tangential phase",
        lambda d: d.named(d.jump.tangential.normal_impulse, 0),
    ),
    "eq-14-spin": (
        "angular velocity after the tangential phase",
        lambda d: d.spin(0).subs(
            d["x_A_dot_0"], -d.mechanism.coefficients.slip_rate_coefficient(-1) * d["P_n1"]
        ),
    ),
    "eq-15": ("normal acceleration in the tangential phase", Derived.sliding),
    "eq-16": (
        "energy balance of the tangential phase",
        lambda d: d.first_energy(d["y_A_dot_0"]),
    ),
    "eq-17": ("energy of the tangential phase", lambda d: d.first_energy(sp.Integer(0))),
    "eq-18-spin": ("angular velocity after sticking compression", lambda d: d.spin(1)),
    "eq-18-impulse": (
        "impulse of sticking compression",
        lambda d: d.named(d.jump.compression.normal_impulse, 1),
    ),
    "eq-19-A": ("coefficient A′", Derived.a_stick),
    "eq-19-B": ("coefficient B′", Derived.b_stick),
    "eq-20": (
        "energy of sticking compression",
        lambda d: d.named(d.jump.compression.stored_energy, 1),
    ),
    "eq-21-normal": ("rebound velocity", Derived.rebound),
    "eq-21-spin": ("angular velocity after the impact", lambda d: d.spin(2)),
    "critical-friction": ("smallest friction with A < 0", Derived.least_critical_friction),
    "sliding-force": ("force of the sliding solution", Derived.sliding_force),
}


def compare(printed: PrintedFormula, derived: sp.Expr, d: Derived) -> Outcome:
    """Return the verdict on one formula: an identity, a misprint, or a difference."""
    back = _abbreviations(d)

    def equal(text: str) -> bool:
        return identical(d.parse(text).subs(back), derived)

    names = _latex_names(d)
    data = {"derived": str(derived)}
    if printed.expression:
        expr = d.parse(printed.expression)
        data |= {"printed": str(expr), "printed_latex": sp.latex(expr, symbol_names=names)}
        if equal(printed.expression):
            return Outcome(printed.text, "identical", Verdict.REPRODUCED, data=data)
    if printed.corrected and equal(printed.corrected):
        right = d.parse(printed.corrected)
        data["derived_latex"] = sp.latex(right, symbol_names=names)
        return Outcome(printed.text, printed.holds, Verdict.MISPRINT, printed.misprint, data)
    data["derived_latex"] = sp.latex(derived, symbol_names=names)
    return Outcome(printed.text, f"derived: {derived}", Verdict.DIFFERS, data=data)


def _latex_names(d: Derived) -> dict[sp.Symbol, str]:
    """Return LaTeX for symbols whose names stand for dots, times and stars."""
    special = {"R_star": "R^*", "delta_max": r"\delta_{\max}", "F_n_max": r"F_{n\,\max}"}
    found = {}
    for name, symbol in d.names.items():
        base, dot, time = name.partition("_dot")
        if dot or "_ddot" in name:
            base = name.partition("_d")[0]
            letter, _, index = base.partition("_")
            letter = r"\theta" if letter == "theta" else letter
            accent = r"\ddot" if "_ddot" in name else r"\dot"
            text = f"{accent}{{{letter}}}" + (f"_{index}" if index else "")
            found[symbol] = text + (f"(t_{time[1:]})" if time else "")
        elif name in special:
            found[symbol] = special[name]
    return found


def derived_forms(bench: Workbench) -> Derived:
    """Return the derived forms, shared by the items."""
    return bench.shared("derived", lambda: Derived(bench.rod))


def _compute(name: str, bench: Workbench) -> Outcome:
    derived = derived_forms(bench)
    return compare(FORMULAS[name], _DERIVE[name][1](derived), derived)


ENTRIES = tuple(
    Entry(
        name,
        GROUP,
        title,
        partial(_compute, name),
        Verdict.MISPRINT if FORMULAS[name].misprint else Verdict.REPRODUCED,
    )
    for name, (title, _) in _DERIVE.items()
)
