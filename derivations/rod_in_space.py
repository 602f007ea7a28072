"""When has the rod no solution that slides in space?"""

from __future__ import annotations

from functools import cache

import sympy as sp

from derivations._page import Derivation, Quantity, Step, cited, mechanism_quantities
from derivations.paradox_conditions import MU_P
from painleve_sym.mechanics.coefficients import ContactCoefficients
from painleve_sym.mechanics.formulas.in_space import SLIP_ANGLE
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.mechanics.models.spatial import rod_3d

BETA = sp.Symbol("beta", real=True)
F_N, F_1, F_2 = sp.symbols("F_n F_t1 F_t2", real=True)
A, B, K, H = sp.symbols("A B k h", real=True)
SLIP = sp.Symbol("v", positive=True)
INVARIANT = sp.Symbol("C", real=True)
RATE = sp.Symbol("theta_dot_squared", real=True)
LARGEST, LEAST = sp.symbols("psi_dot_0 psi_dot_m", positive=True)

QUANTITIES = (
    Quantity(BETA, r"\beta", "rad", "angle of the slip from the direction against the azimuth"),
    Quantity(A, "A", "1/kg", "normal acceleration per normal force while sliding"),
    Quantity(B, "B", "m/s²", "normal acceleration without contact force"),
    Quantity(K, "k", "1/kg", "gain of the slip velocity per normal impulse"),
    Quantity(H, "h", "1/kg", "turn of the slip times v, per normal impulse"),
    Quantity(MU_P, r"\mu_P", "1", "critical friction: $A < 0$ above it for $\\beta = 0$"),
    Quantity(SLIP, "v", "m/s", "slip velocity"),
    Quantity(INVARIANT, "C", "1", "constant along an impact"),
    Quantity(RATE, r"\dot\theta^2", "1/s²", "square of the rate of the elevation where $B = 0$"),
    Quantity(LARGEST, r"\dot\psi_0", "1/s", "azimuthal velocity up to which $A = B = 0$ exists"),
    Quantity(LEAST, r"\dot\psi_m", "1/s", "its least value over θ"),
)


@cache
def mechanism() -> Mechanism:
    """Return the package's rod in space, so that its closed forms are derived once."""
    return rod_3d()


def symbol(name: str) -> sp.Symbol:
    """Return a coordinate, velocity or parameter of the rod by name."""
    system = mechanism().system
    symbols = {str(s): s for c in system.coordinates for s in (c.symbol, c.rate)}
    return (symbols | {p.name: p.symbol for p in system.parameters})[name]


@cache
def accelerations() -> sp.Matrix:
    """Return the acceleration of the end A along z, x, y under a force, by Newton and Euler.

    Euler's equation of a symmetric body, crossed with its axis a, is
    ``a'' = -|a'|² a - (l/J)(F - a (a·F)) + (J_3 ω_3/J) a × a'``.
    """
    theta, psi = symbol("theta"), symbol("psi")
    rates = [(theta, symbol("theta_dot")), (psi, symbol("psi_dot"))]
    m, l, g, J_3 = (symbol(name) for name in ("m", "l", "g", "J_3"))
    J = m * l**2 / symbol("alpha")
    axis = sp.Matrix([sp.cos(theta) * sp.cos(psi), sp.cos(theta) * sp.sin(psi), sp.sin(theta)])
    turning = sum((axis.diff(q) * rate for q, rate in rates), sp.zeros(3, 1))
    spin = symbol("phi_dot") + symbol("psi_dot") * sp.sin(theta)
    force = sp.Matrix([F_1, F_2, F_N])
    bend = -(turning.T * turning)[0] * axis + J_3 * spin / J * axis.cross(turning)
    bend -= l / J * (force - axis * (axis.T * force)[0])
    end = force / m - sp.Matrix([0, 0, g]) - l * bend
    return sp.Matrix([end[2], end[0], end[1]])


def slipping(angle: sp.Expr) -> tuple[sp.Expr, sp.Expr, sp.Expr, sp.Expr]:
    """Return A, B, k and h of slip along an angle, from `accelerations`."""
    mu, e = symbol("mu"), (sp.cos(angle), sp.sin(angle))
    friction = {F_1: -mu * F_N * e[0], F_2: -mu * F_N * e[1]}
    normal, one, two = accelerations().subs(friction)
    gain = [sp.expand(part).diff(F_N) for part in (normal, one, two)]
    along, across = gain[1] * e[0] + gain[2] * e[1], gain[2] * e[0] - gain[1] * e[1]
    forms = (gain[0], normal.subs(F_N, 0), along, across)
    short = [sp.trigsimp(sp.expand(form)) for form in forms]
    return short[0], short[1], short[2], short[3]


def slip_steps() -> list[Step]:
    """Return the steps to A and B, and to their limit in the plane."""
    theta, mu, alpha, m = (symbol(name) for name in ("theta", "mu", "alpha", "m"))
    psi = symbol("psi")
    coefficients = ContactCoefficients(mechanism().contact)
    W, b = coefficients.W, coefficients.b
    along = {SLIP_ANGLE: psi + sp.pi + BETA}
    e = sp.Matrix([sp.cos(SLIP_ANGLE), sp.sin(SLIP_ANGLE)]).subs(along)
    own, free, _, _ = slipping(psi + sp.pi + BETA)
    s, c = sp.sin(theta), sp.cos(theta)
    a = (1 + alpha * c**2 - alpha * mu * s * c * sp.cos(BETA)) / m
    assert sp.simplify(a - own) == 0
    planar = rod().coefficients
    names = {str(s): s for s in mechanism().system.symbols}
    flat = {names["psi_dot"]: 0, BETA: 0, alpha: 3}
    swap = {s: names[str(s)] for s in planar.A(-1).free_symbols | planar.B.free_symbols}
    assert sp.simplify(a.subs(flat) - planar.A(-1).subs(swap)) == 0
    assert sp.simplify(free.subs(flat) - planar.B.subs(swap)) == 0
    package = W[0, 0] - mu * (W[1:, 0].T * e)[0]
    return [
        Step(
            "The end A carries the force $F$, the mass centre lies at $l a$ from it. With the "
            "spin $\\omega_3 = \\dot\\varphi + \\dot\\psi \\sin\\theta$, Euler's equation of the "
            "symmetric rod is $\\ddot a = -|\\dot a|^2 a - \\tfrac lJ (F - a (a\\cdot F)) + "
            "\\tfrac{J_3 \\omega_3}{J}\\, a\\times\\dot a$, with $J = m l^2/\\alpha$, and the end "
            "has the acceleration $F/m - g n - l \\ddot a$. It slides along $e$, at β from "
            "$-(\\cos\\psi, \\sin\\psi)$, with the friction $-\\mu F_n e$. The coefficient "
            "of $F_n$ in its normal acceleration is",
            sp.Eq(A, a),
            package=package,
        ),
        Step("and the rest", sp.Eq(B, free), package=b[0]),
        Step(
            "With β = 0, $\\dot\\psi = 0$ and α = 3 both are those of the planar rod. $A < 0$ "
            "first for β = 0, above",
            sp.Eq(MU_P, sp.solve(a.subs(BETA, 0), mu)[0]),
        ),
    ]


def border_steps() -> list[Step]:
    """Return the steps to the azimuthal velocity beyond which A = B = 0 is nowhere."""
    theta, l, g = (symbol(name) for name in ("theta", "l", "g"))
    rate, turn = symbol("theta_dot"), symbol("psi_dot")
    free = slipping(BETA)[1].subs(symbol("J_3"), 0)
    square = g / (l * sp.sin(theta)) - turn**2 * sp.cos(theta) ** 2
    assert sp.simplify(free.subs(rate, sp.sqrt(square))) == 0
    largest = sp.sqrt(g / (l * sp.sin(theta))) / sp.cos(theta)
    assert sp.simplify(square.subs(turn, largest)) == 0
    s = sp.Symbol("s", positive=True)
    place = next(r for r in sp.solve(sp.diff(s * (1 - s**2), s), s) if r > 0)
    least = sp.sqrt(g / (l * place * (1 - place**2)))
    return [
        Step(
            "Without spin, $J_3 = 0$, $B = 0$ at",
            sp.Eq(RATE, square),
        ),
        Step(
            "$A = 0$ is a condition on the direction of slip, $\\cos\\beta = \\mu_P/\\mu$. Both "
            "hold together only where the square is not negative, up to",
            sp.Eq(LARGEST, largest),
        ),
        Step(
            "Its least value over θ, at $\\sin\\theta = 1/\\sqrt3$, depends on no friction",
            sp.Eq(LEAST, sp.simplify(least)),
        ),
    ]


def impact_steps() -> list[Step]:
    """Return the steps to the invariant of an impact."""
    theta, mu, alpha, m = (symbol(name) for name in ("theta", "mu", "alpha", "m"))
    s, c, x = sp.sin(theta), sp.cos(theta), sp.cos(BETA)
    _, _, k, h = slipping(symbol("psi") + sp.pi + BETA)
    turn = -alpha * c * sp.sin(BETA) * (s + mu * c * x) / m
    assert sp.simplify(h - turn) == 0
    slowing = (mu * alpha * c**2 * x**2 - mu * (1 + alpha) + alpha * s * c * x) / m
    assert sp.simplify(k - slowing) == 0
    rest = (
        -sp.log(1 - x) / (2 * (s + mu * c))
        + sp.log(1 + x) / (2 * (s - mu * c))
        + mu * c / (mu**2 * c**2 - s**2) * sp.log(s + mu * c * x)
    )
    invariant = sp.log(SLIP * sp.sin(BETA)) + mu * (1 + alpha) / (alpha * c) * rest
    along = invariant.diff(SLIP) * SLIP * slowing + invariant.diff(BETA) * turn
    assert sp.simplify(along) == 0
    return [
        Step(
            "In an impact with frozen configuration, by the impulse $P$, "
            "$\\mathrm dv/\\mathrm dP = k$ with",
            sp.Eq(K, slowing),
        ),
        Step("and the slip turns by $v\\, \\mathrm d\\beta/\\mathrm dP = h$,", sp.Eq(H, turn)),
        Step(
            "which is negative for β between 0 and π/2: the slip turns towards the plane. Along "
            "the path, $\\mathrm d\\ln v/\\mathrm d\\beta = k/h$. Its integral is the hodograph",
            sp.Eq(INVARIANT, invariant),
        ),
    ]


def derive() -> Derivation:
    """Derive the paradox of the rod in space, and the path of its impact."""
    return Derivation(
        "rod_in_space",
        "The rod in space",
        "Continues the conditions of the paradox in three dimensions "
        f"({cited('ChampneysVarkonyi2016')}, {cited('CheesmanEtAl2021')}).",
        (*mechanism_quantities(mechanism()), *QUANTITIES),
        (*slip_steps(), *border_steps(), *impact_steps()),
        {"planar": "no", "frozen configuration": "in part"},
    )
