"""How does the rod move under the forces at its end?"""

from __future__ import annotations

from functools import cache

import sympy as sp

from derivations._page import Derivation, Quantity, Step, mechanism_quantities
from painleve_sym.mechanics.coefficients import F_N, F_T
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.mechanics.models.rods import rod
from painleve_sym.quantities import derivative_latex

TIME = sp.Symbol("t", real=True)
X, Y = sp.symbols("x y", real=True)
X_DOT, Y_DOT = sp.symbols("x_dot y_dot", real=True)
X_DDOT, Y_DDOT = sp.symbols("x_ddot y_ddot", real=True)
J = sp.Symbol("J", positive=True)


@cache
def mechanism() -> Mechanism:
    """Return the package's rod, so that its closed forms are derived once."""
    return rod()


def symbol(name: str) -> sp.Symbol:
    """Return a coordinate, velocity, acceleration or parameter of the rod by name."""
    system = mechanism().system
    symbols = {str(s): s for c in system.coordinates for s in (c.symbol, c.rate, c.acceleration)}
    symbols |= {p.name: p.symbol for p in system.parameters}
    return symbols[name]


def quantities() -> tuple[Quantity, ...]:
    """Return the rod's symbols and those of its centre."""
    centre = []
    for base, text in ((X, "along the ground"), (Y, "above the ground")):
        centre.append(Quantity(base, str(base), "m", f"centre of the rod {text}"))
        for dots, rate in enumerate({X: (X_DOT, X_DDOT), Y: (Y_DOT, Y_DDOT)}[base], 1):
            unit = "m/s" + "²" * (dots == 2)
            kind = ("velocity", "acceleration")[dots - 1]
            latex = derivative_latex(str(base), dots)
            centre.append(Quantity(rate, latex, unit, f"{kind} of ${base}$"))
    return (
        *mechanism_quantities(mechanism()),
        *centre,
        Quantity(J, "J", "kg m²", "moment of inertia about the centre"),
        Quantity(F_N, "F_n", "N", "normal force on the end A, upward"),
        Quantity(F_T, "F_t", "N", "tangential force on the end A, along +x"),
    )


def lagrange() -> list[sp.Expr]:
    """Return d/dt ∂L/∂q̇ − ∂L/∂q of the centre coordinates (x, y, θ), as functions of symbols."""
    m, g = symbol("m"), symbol("g")
    paths = [sp.Function(str(q))(TIME) for q in (X, Y, symbol("theta"))]
    rates = [path.diff(TIME) for path in paths]
    kinetic = m * (rates[0] ** 2 + rates[1] ** 2) / 2 + J * rates[2] ** 2 / 2
    lagrangian = kinetic - m * g * paths[1]
    symbols = (
        (X_DDOT, Y_DDOT, symbol("theta_ddot")),
        (X_DOT, Y_DOT, symbol("theta_dot")),
        (X, Y, symbol("theta")),
    )
    swap: dict[sp.Expr, sp.Symbol] = {}
    for order, names in zip((2, 1, 0), symbols, strict=True):
        swap |= {path.diff(TIME, order): s for path, s in zip(paths, names, strict=True)}
    pairs = zip(paths, rates, strict=True)
    rows = [lagrangian.diff(v).diff(TIME) - lagrangian.diff(q) for q, v in pairs]
    return [row.subs(swap) for row in rows]


def contact_point() -> tuple[sp.Expr, sp.Expr]:
    """Return (x_A, y_A) as functions of the centre coordinates."""
    l, theta = symbol("l"), symbol("theta")
    return X - l * sp.cos(theta), Y - l * sp.sin(theta)


def second_rate(expr: sp.Expr) -> sp.Expr:
    """Return d²/dt² of a function of the centre coordinates."""
    pairs = (
        (X, X_DOT, X_DDOT),
        (Y, Y_DOT, Y_DDOT),
        (symbol("theta"), symbol("theta_dot"), symbol("theta_ddot")),
    )
    rate = sum((expr.diff(q) * v for q, v, _ in pairs), sp.Integer(0))
    return sum((rate.diff(q) * v + rate.diff(v) * a for q, v, a in pairs), sp.Integer(0))


@cache
def accelerations() -> dict[sp.Symbol, sp.Expr]:
    """Return ẍ, ÿ, θ̈ and ẍ_A, ÿ_A as functions of the state, F_n and F_t."""
    unknown = (X_DDOT, Y_DDOT, symbol("theta_ddot"))
    equations = [row - force for row, force in zip(lagrange(), generalized_forces(), strict=True)]
    solved = sp.solve(equations, unknown, dict=True)[0]
    slender = {J: symbol("m") * symbol("l") ** 2 / 3}
    motion = {a: sp.expand(value.subs(slender)) for a, value in solved.items()}
    for name, place in zip(("x_A_ddot", "y_A_ddot"), contact_point(), strict=True):
        motion[symbol(name)] = sp.expand(second_rate(place).subs(motion))
    return motion


def generalized_forces() -> list[sp.Expr]:
    """Return Q = F_t ∂x_A/∂q + F_n ∂y_A/∂q."""
    along, above = contact_point()
    centre = (X, Y, symbol("theta"))
    return [F_T * along.diff(q) + F_N * above.diff(q) for q in centre]


def balance_steps() -> list[Step]:
    """Return Lagrange's equations of the centre, with contact forces and, (11), without."""
    left, right = lagrange(), generalized_forces()
    inertia = (symbol("m") * X_DDOT, symbol("m") * Y_DDOT, J * symbol("theta_ddot"))
    forced = [
        sp.Eq(i, sp.expand(force - (row - i)))
        for i, row, force in zip(inertia, left, right, strict=True)
    ]
    free = [sp.Eq(e.lhs, e.rhs.subs({F_N: 0, F_T: 0}), evaluate=False) for e in forced]
    texts = (
        "Lagrange's equations of $T = m(\\dot x^2 + \\dot y^2)/2 + J\\dot\\theta^2/2$ and "
        "$V = m g y$, with the work of the contact forces "
        "$F_t\\,\\delta x_A + F_n\\,\\delta y_A$ on the end "
        "$A = (x - l\\cos\\theta,\\ y - l\\sin\\theta)$. Along the ground:",
        "Upward:",
        "Rotation:",
    )
    steps = [Step(text, equation) for text, equation in zip(texts, forced, strict=True)]
    texts = ("Without contact forces, along the ground:", "upward:", "and in rotation:")
    names = ("eq-11-x", "eq-11-y", "eq-11-spin")
    steps += [Step(t, e, name) for t, e, name in zip(texts, free, names, strict=True)]
    return steps


def contact_steps() -> list[Step]:
    """Return the accelerations of the end A: in free flight, (12) and (13), and with forces."""
    motion = accelerations()
    symbols = [c.acceleration for c in mechanism().system.coordinates]
    own = dict(zip(symbols, mechanism().coefficients.accelerations, strict=True))
    y_A_ddot = symbol("y_A_ddot")
    kinematics = second_rate(contact_point()[1])
    flight = motion[y_A_ddot].subs({F_N: 0, F_T: 0})
    steps = [
        Step(
            "The end A is at height $y_A = y - l\\sin\\theta$. Differentiated twice:",
            sp.Eq(y_A_ddot, kinematics),
            "eq-12",
            function="y_A_ddot_from_centre",
        ),
        Step(
            "(11) in (12) gives the normal acceleration of free flight:",
            sp.Eq(y_A_ddot, flight),
            "eq-13",
            package=mechanism().coefficients.b_n,
            function="y_A_ddot_free",
        ),
    ]
    words = ("tangential acceleration of A", "normal acceleration of A", "angular acceleration")
    for name, word in zip(("x_A_ddot", "y_A_ddot", "theta_ddot"), words, strict=True):
        text = (
            f"With forces and $J = m l^2/3$, the {word}. The package derives the same from the "
            f"energies in the contact coordinates $(x_A, y_A, \\theta)$:"
        )
        a = symbol(name)
        steps.append(Step(text, sp.Eq(a, motion[a]), package=own[a]))
    return steps


def derive() -> Derivation:
    """Derive (11)–(13) and the equations with contact forces."""
    return Derivation(
        "equations_of_motion",
        "Equations of motion of the rod",
        "A slender rod of length $2l$ and mass $m$ stands at the angle $\\theta$ on the ground "
        "$y = 0$. Its lower end A carries the contact forces. The derivation uses the centre "
        "$(x, y)$ and is independent of the package, which uses the end A as its coordinates.",
        quantities(),
        (*balance_steps(), *contact_steps()),
        {"constant μ": "no", "tangential rigidity": "no", "frozen configuration": "no"},
    )
