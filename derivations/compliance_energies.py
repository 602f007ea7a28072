"""What energy does the paper's compression law store, and what does it give back?"""

from __future__ import annotations

import sympy as sp

from derivations._page import Derivation, Quantity, Step
from painleve_sym.laws.compliance import DELTA, DELTA_MAX, K_E, without_ramps
from painleve_sym.laws.compliant_laws import bilinear_hertz
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.mechanics.simplify import readable

delta, delta_max, delta_p, delta_0 = sp.symbols("delta delta_max delta_p delta_0", positive=True)
n, nu, E_s = sp.symbols("n nu e_energetic", positive=True)
E, E_STAR, R, R_1, R_2, l_0 = sp.symbols("E E_star R R_1 R_2 l_0", positive=True)
KAPPA, F_MAX = sp.symbols("kappa_star F_n_max", positive=True)
F_LOADING, F_UNLOADING = sp.symbols("F_n_loading F_n_unloading", real=True)
W_C, W_R, E_N0, F_N0 = sp.symbols("W_c W_r E_n0 F_n0", real=True)
HERTZ = sp.Rational(3, 2)
"""Exponent of Hertz's law."""


QUANTITIES = (
    Quantity(R_1, "R_1", "m", "radius of the first body"),
    Quantity(R_2, "R_2", "m", "radius of the second body"),
    Quantity(R, "R", "m", "radius of the contact end"),
    Quantity(KAPPA, "1/R^*", "1/m", "relative curvature"),
    Quantity(E, "E", "Pa", "elastic modulus of both bodies"),
    Quantity(nu, r"\nu", "1", "Poisson's ratio of both bodies"),
    Quantity(E_STAR, "E^*", "Pa", "contact modulus"),
    Quantity(K_E, "K_e", "N/m^n", "stiffness"),
    Quantity(n, "n", "1", "exponent of the compression law"),
    Quantity(l_0, "l_0", "m", "reference length, 1 m in the paper's numbers"),
    Quantity(E_s, "e_s", "1", "energetic coefficient of restitution"),
    Quantity(delta, r"\delta", "m", "compression"),
    Quantity(delta_max, r"\delta_\mathrm{max}", "m", "largest compression"),
    Quantity(delta_p, r"\delta_p", "m", "permanent compression"),
    Quantity(delta_0, r"\delta_0", "m", "initial compression"),
    Quantity(F_LOADING, r"F_n", "N", "normal force while compressing"),
    Quantity(F_UNLOADING, r"F_n", "N", "normal force in restitution"),
    Quantity(F_MAX, r"F_{n\,\mathrm{max}}", "N", "largest normal force"),
    Quantity(F_N0, "F_{n0}", "N", "initial normal force"),
    Quantity(W_C, "W_c", "J", "work of the normal force during compression"),
    Quantity(W_R, "W_r", "J", "work of the normal force during restitution"),
    Quantity(E_N0, "E_{n0}", "J", "initial surface energy"),
)


def packaged(expr: sp.Expr, law: ContactLaw) -> sp.Expr:
    """Return a force or energy of the package in the symbols of this page."""
    own = {s.name: s for s in (E_s, n, E, nu, R, l_0)}
    swap = {p.symbol: own[p.name] for p in law.parameters}
    swap |= {DELTA: delta, DELTA_MAX: delta_max}
    squared = {s: E_s**2 for s in law.definitions if s != K_E}
    return without_ramps(expr).subs(squared).subs(swap)


def stiffness_steps(law: ContactLaw) -> list[Step]:
    """Return the steps to K_e, with the misprint of R* and the unit of K_e."""
    r = sp.Symbol("r", positive=True)
    caps = sum(radius - sp.sqrt(radius**2 - r**2) for radius in (R_1, R_2))
    curvature = sp.series(caps, r, 0, 3).removeO().coeff(r, 2) * 2
    per_modulus = sp.Mul(2, 1 - nu**2, 1 / E)
    return [
        Step(
            "Hertz needs the relative curvature: near the contact two spheres are "
            "$r^2/(2R^*)$ apart. From their shape, $\\sum (R_i - \\sqrt{R_i^2 - r^2})$:",
            sp.Eq(KAPPA, sp.expand(curvature)),
            "eq-4-radius",
        ),
        Step(
            "Both bodies are of one material, $1/E^* = 2(1 - \\nu^2)/E$:",
            sp.Eq(E_STAR, 1 / per_modulus),
            "eq-4-modulus",
        ),
        Step(
            "On a plane $R^* = R$, and Hertz's force is "
            "$\\tfrac43 E^* \\sqrt{R}\\,\\delta^{3/2}$. "
            "A force $K_e\\delta^n$ of another exponent equals it at one compression $l_0$ only, "
            "where $K_e l_0^n = \\tfrac43 E^* \\sqrt{R}\\,l_0^{3/2}$:",
            sp.Eq(K_E, sp.Rational(4, 3) / per_modulus * sp.sqrt(R) * l_0 ** (HERTZ - n)),
            "eq-4-stiffness",
            where={"R_star": R},
            package=packaged(law.definitions[K_E], law),
        ),
        Step(
            "Compression follows, with a measured exponent,",
            sp.Eq(F_LOADING, K_E * delta**n),
            "eq-4",
            package=packaged(law.loading.force, law),
        ),
    ]


def check_unloading(law: ContactLaw, unloading: sp.Expr) -> None:
    """Assert that the package's unloading curve is this one, where δ > δ_p."""
    depth = sp.Symbol("depth", positive=True)
    package = packaged(law.branch("restitution").force, law)
    difference = (package - unloading).subs(delta, depth + delta_max * (1 - E_s**2))
    assert sp.simplify(sp.expand_power_base(sp.simplify(difference), force=True)) == 0


def energy_steps(law: ContactLaw) -> list[Step]:
    """Return the steps (5)–(10), of which (10) is `surface_step`."""
    loading = K_E * delta**n
    peak = K_E * delta_max**n
    work_in = sp.integrate(loading, (delta, 0, delta_max))
    # ∫ over the unloading curve, in the depth δ − δ_p from its largest value to zero.
    depth, span = sp.Symbol("depth", positive=True), delta_max - delta_p
    rest = sp.integrate(depth**n, depth)
    work_out = -F_MAX * sp.powsimp(rest.subs(depth, span) / span**n)
    given_back = work_out.subs(F_MAX, peak)
    permanent = sp.solve(sp.simplify((given_back + E_s**2 * work_in) / peak), delta_p)[0]
    released = sp.simplify(given_back.subs(delta_p, permanent))
    unloading = F_MAX * ((delta - delta_p) / span) ** n
    check_unloading(law, unloading.subs({F_MAX: peak, delta_p: permanent}))
    stored = packaged(law.loading.stored_energy, law).subs(delta, delta_max)
    return [
        Step(
            "The work done on the contact until the largest compression is its integral,",
            sp.Eq(W_C, work_in),
            "eq-7-stiffness",
        ),
        Step(
            "or, in the largest force $F_{n\\,\\mathrm{max}} = K_e\\delta_\\mathrm{max}^n$,",
            sp.Eq(W_C, sp.simplify(work_in / peak) * F_MAX),
            "eq-7",
            function="W_c_from_force",
        ),
        Step(
            "Restitution is taken to follow a curve of the same exponent down to $\\delta_p$ (the "
            "package's is checked to be this one):",
            sp.Eq(F_UNLOADING, unloading),
            "eq-5",
        ),
        Step(
            "It gives back, as $\\delta$ falls from $\\delta_\\mathrm{max}$ to $\\delta_p$,",
            sp.Eq(W_R, work_out),
            "eq-8",
            function="W_r_from_force",
        ),
        Step(
            "The energetic coefficient demands $W_r = -e_s^2 W_c$. Solved for $\\delta_p$:",
            sp.Eq(delta_p, readable(permanent)),
            "eq-6",
        ),
        Step(
            "With it the restitution gives back",
            sp.Eq(W_R, released),
            "eq-9",
            where={"W_c": work_in},
            package=-stored,
        ),
        surface_step(loading),
    ]


def surface_step(loading: sp.Expr) -> Step:
    """Return the step (10)."""
    mean = sp.simplify(sp.integrate(loading, (delta, 0, delta_0)) / loading.subs(delta, delta_0))
    return Step(
        "A contact that starts compressed by $\\delta_0$ holds, in its initial force "
        "$F_{n0} = K_e\\delta_0^n$, the surface energy",
        sp.Eq(E_N0, mean * F_N0),
        "eq-10",
    )


def derive() -> Derivation:
    """Derive (4)–(10)."""
    law = bilinear_hertz()
    return Derivation(
        "compliance_energies",
        "Energies of the bilinear compression law",
        "The contact is compressed along one curve and released along another; what lies between "
        "them is lost to plastic deformation.",
        QUANTITIES,
        (*stiffness_steps(law), *energy_steps(law)),
        {
            "planar": "no",
            "one contact": "no",
            "constant μ": "no",
            "tangential rigidity": "no",
            "frozen configuration": "no",
        },
    )
