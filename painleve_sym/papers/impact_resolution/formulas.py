"""The formulas of the paper: each derived again and compared with the print as an identity."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import sympy as sp

from painleve_sym.laws.catalogue import compliant_law
from painleve_sym.laws.compliance import DELTA, DELTA_MAX, K_E, without_ramps
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.laws.impact_cases import ImpactCase, three_phase_jump
from painleve_sym.laws.restitution_equation import E_C
from painleve_sym.mechanics.bodies import Body
from painleve_sym.mechanics.coefficients import F_N, ContactCoefficients
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.declarations import Coordinate
from painleve_sym.mechanics.impact.impulse_rays import V_N, V_N_PLUS, V_T, raw
from painleve_sym.mechanics.mathml import mathml, with_marks
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.paradox.critical_friction import critical_friction
from painleve_sym.mechanics.simplify import readable
from painleve_sym.mechanics.system import LagrangianSystem
from painleve_sym.papers.claims import Claims
from painleve_sym.papers.formula import identical
from painleve_sym.papers.impact_resolution.claims import CLAIMS
from painleve_sym.papers.impact_resolution.runs import Workbench
from painleve_sym.papers.item import ItemOutcome, Verdict

POSITIVE = (
    "delta delta_0 delta_max delta_p n e_s E nu R R_1 R_2 R_star l_0 K_e F_n_max F_n0 W_c E_nc "
    "depth"
)
REAL = (
    "x_A_dot_0 y_A_dot_0 y_A_dot_1 y_A_dot_3 theta_dot_0 theta_dot_1 theta_dot_2 P_n1 "
    "y_ddot theta_ddot"
)


_LETTERS = {"e_energetic": "e_s"}
"""Letters of the paper for parameters of its law that have another name here."""


@dataclass(frozen=True)
class Derived:
    """The right sides the paper prints, derived for the rod by the package's symbolic stages."""

    mechanism: Mechanism

    @cached_property
    def names(self) -> dict[str, Any]:
        """Return every symbol a printed formula may use, by name."""
        system = self.mechanism.system
        names: dict[str, Any] = {s.name: s for s in sp.symbols(POSITIVE, positive=True)}
        names |= {s.name: s for s in sp.symbols(REAL, real=True)}
        names |= {s.name: s for s in (*system.q, *system.q_dot)}
        names |= {p.name: p.symbol for p in system.parameters}
        names |= {"F_n": F_N, "K_e": K_E, "E_nr": -(names["e_s"] ** 2) * names["E_nc"]}
        return names

    def printed(self, formula: str, corrected: bool = False) -> sp.Expr:
        """Return a printed right side as an expression, as printed or corrected."""
        return CLAIMS.expression(formula, self.names, corrected)

    def __getitem__(self, name: str) -> Any:
        return self.names[name]

    @property
    def contact(self) -> ContactCoefficients:
        """Coefficients of the contact."""
        return self.mechanism.coefficients

    def sliding(self) -> sp.Expr:
        """Return ÿ_A while sliding left."""
        return self.contact.A(-1) * self["F_n"] + self.contact.B

    # ---- free flight, in the coordinates of the centre ----

    @cached_property
    def centre(self) -> Contact:
        """Return the contact of the rod described by its centre (x, y): a second derivation."""
        x, y = (Coordinate(n, f"centre of the rod, {n}", "m") for n in ("x", "y"))
        theta = self.mechanism.system.coordinates[2]
        m, l, g = (self[n] for n in ("m", "l", "g"))
        body = Body(m, (x.symbol, y.symbol), m * l**2 / 3, theta.symbol)
        system = LagrangianSystem.of_bodies(
            "rod by its centre", (x, y, theta), self.mechanism.system.parameters, (body,), gravity=g
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
        swap = {p.symbol: self[_LETTERS.get(p.name, p.name)] for p in self.law.parameters}
        swap |= {DELTA: self["delta"], DELTA_MAX: self["delta_max"]}
        squared = {s: self["e_s"] ** 2 for s in self.law.definitions if s != K_E}
        return without_ramps(expr).subs(squared).subs(swap)

    def loading(self) -> sp.Expr:
        """Return F_n on the loading curve."""
        return self.of_law(self.law.loading.force)

    def stiffness(self) -> sp.Expr:
        """Return K_e in N/mⁿ, with R* = R on a plane."""
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
    def jump(self) -> ImpactCase:
        """Return the three-phase jump; its course has the phases in velocities at their start."""
        return three_phase_jump(self.contact, write=raw)

    def named(self, expr: sp.Expr, phase: int) -> sp.Expr:
        """Return an expression of a phase in the velocities the paper names at its start."""
        spin = self.mechanism.system.q_dot[2]
        start = {spin: self[f"theta_dot_{phase}"], V_T: self["x_A_dot_0"]}
        if phase < 2:
            start[V_N] = self[f"y_A_dot_{phase}"]
        return sp.sympify(expr).subs({**start, V_N_PLUS: self["y_A_dot_3"]})

    def spin(self, phase: int) -> sp.Expr:
        """Return θ̇ at the end of a phase."""
        velocity = self.jump.course.phases[phase].velocity
        return self.named(velocity[self.mechanism.system.q_dot[2]], phase)

    def spin_after_slip(self) -> sp.Expr:
        """Return θ̇(t1) in θ̇(t0) and P_n1."""
        per_impulse = self.contact.slip_rate_coefficient(-1)
        return self.spin(0).subs(self["x_A_dot_0"], -per_impulse * self["P_n1"])

    def first_energy(self, start: sp.Expr) -> sp.Expr:
        """Return E_n1 in ẏ_A(t0) = `start` and ẏ_A(t1)."""
        first = self.jump.course.phases[0]
        energy, end = (self.named(e, 0) for e in (first.stored_energy, first.normal_velocity))
        # ẏ_A(t1) is linear in ẋ_A(t0).
        rest = end.subs(self["x_A_dot_0"], 0)
        x_0 = (self["y_A_dot_1"] - rest) / end.diff(self["x_A_dot_0"])
        return energy.subs(self["x_A_dot_0"], x_0).subs(self["y_A_dot_0"], start)

    def rebound(self) -> sp.Expr:
        """Return ẏ_A(t3) from the energy of compression."""
        law_symbol = self.jump.law.parameter.symbol
        rebound = self.jump.rebound
        return rebound.subs({E_C: self["E_nc"], law_symbol: self["e_s"]})


def abbreviations(d: Derived) -> dict[sp.Symbol, sp.Expr]:
    """Return the meaning of the abbreviations in the printed formulas."""
    peak = K_E * d["delta_max"] ** d["n"]
    return {
        d["F_n_max"]: peak,
        d["F_n0"]: K_E * d["delta_0"] ** d["n"],
        d["W_c"]: peak * d["delta_max"] / (d["n"] + 1),
        d["delta_p"]: d["delta_max"] * (1 - d["e_s"] ** 2),
    }


Derive = Callable[[Derived], sp.Expr]

DERIVE: dict[str, Derive] = {
    "eq-1": Derived.sliding,
    "eq-2": lambda d: d.contact.A(-1),
    "eq-3": lambda d: d.contact.B,
    "eq-4": Derived.loading,
    "eq-4-stiffness": Derived.stiffness,
    "eq-4-radius": Derived.relative_curvature,
    "eq-5": Derived.unloading,
    "eq-6": Derived.permanent,
    "eq-7": Derived.work_in,
    "eq-8": Derived.work_back,
    "eq-9": Derived.work_back,
    "eq-10": Derived.surface_energy,
    "eq-11-x": lambda d: d.free(0),
    "eq-11-y": lambda d: d["m"] * d.free(1),
    "eq-11-spin": lambda d: d.free(2),
    "eq-12": Derived.end_acceleration,
    "eq-13": Derived.free_end,
    "sticking-force": lambda d: d.contact.sticking_force,
    "eq-14-normal": lambda d: d.named(d.jump.course.phases[0].normal_velocity, 0),
    "eq-14-impulse": lambda d: d.named(d.jump.course.phases[0].normal_impulse, 0),
    "eq-14-spin": Derived.spin_after_slip,
    "eq-15": Derived.sliding,
    "eq-16": lambda d: d.first_energy(d["y_A_dot_0"]),
    "eq-17": lambda d: d.first_energy(sp.Integer(0)),
    "eq-18-spin": lambda d: d.spin(1),
    "eq-18-impulse": lambda d: d.named(d.jump.course.phases[1].normal_impulse, 1),
    "eq-19-A": lambda d: d.contact.A_stick,
    "eq-19-B": lambda d: d.contact.B_stick,
    "eq-20": lambda d: d.named(d.jump.course.phases[1].stored_energy, 1),
    "eq-21-normal": Derived.rebound,
    "eq-21-spin": lambda d: d.spin(2),
    "critical-friction": lambda d: critical_friction(d.contact, -1).minimum("theta").value,
    "sliding-force": lambda d: -d.contact.B / d.contact.A(-1),
}


def compare(claims: Claims, name: str, d: Derived) -> ItemOutcome:
    """Return the verdict on one formula: an identity, a misprint, or a difference."""
    claim, derived, meaning = claims.formulas[name], DERIVE[name](d), abbreviations(d)
    names = _latex_names(d)
    data = {"derived": str(derived), "derived_mathml": mathml(readable(derived))}
    if claim.expression:
        printed = claims.expression(name, d.names)
        data |= {"printed": str(printed), "printed_latex": sp.latex(printed, symbol_names=names)}
        data["printed_mathml"] = mathml(printed)
        if identical(printed.subs(meaning), derived):
            return ItemOutcome("identical", Verdict.REPRODUCED, data=data)
    if claim.corrected:
        corrected = claims.expression(name, d.names, corrected=True)
        if identical(corrected.subs(meaning), derived):
            data["derived_latex"] = sp.latex(corrected, symbol_names=names)
            data["derived_mathml"] = mathml(corrected)
            if claim.expression:
                marked, parts = with_marks(printed, corrected)
                data["printed_mathml"] = mathml(marked, marked=parts)
            return ItemOutcome(claim.holds, claim.expected, data=data)
    data["derived_latex"] = sp.latex(derived, symbol_names=names)
    return ItemOutcome(f"derived: {derived}", Verdict.DIFFERS, data=data)


def _latex_names(d: Derived) -> dict[sp.Symbol, str]:
    """Return LaTeX for symbols whose names stand for dots, times and stars."""
    special = {"R_star": "R^*", "delta_max": r"\delta_{\max}", "F_n_max": r"F_{n\,\max}"}
    texts = {}
    for name, symbol in d.names.items():
        base, dot, time = name.partition("_dot")
        if dot or "_ddot" in name:
            base = name.partition("_d")[0]
            letter, _, index = base.partition("_")
            letter = r"\theta" if letter == "theta" else letter
            accent = r"\ddot" if "_ddot" in name else r"\dot"
            text = f"{accent}{{{letter}}}" + (f"_{index}" if index else "")
            texts[symbol] = text + (f"(t_{time[1:]})" if time else "")
        elif name in special:
            texts[symbol] = special[name]
    return texts


def derived_forms(bench: Workbench) -> Derived:
    """Return the derived forms, shared by the items."""
    return bench.shared("derived", lambda: Derived(bench.rod))


def _compute(name: str, bench: Workbench) -> ItemOutcome:
    return compare(CLAIMS, name, derived_forms(bench))


COMPUTE = {name: partial(_compute, name) for name in DERIVE}
