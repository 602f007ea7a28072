"""Which velocity does a step of a convex contact solver give to a contact that slides?"""

from __future__ import annotations

import sympy as sp

from derivations._page import Derivation, Quantity, Step, cited
from derivations.contact_coefficients import COEFFICIENTS, W_NN, W_NT, W_TT
from derivations.equations_of_motion import quantities, symbol

SLIP, APPROACH = sp.symbols("v_t v_n", real=True)
SLIP_AFTER, NORMAL_AFTER = sp.symbols("v_t_after v_n_after", real=True)
IMPULSE, P_STICK = sp.symbols("P P_stick", real=True)
D, ENERGY = sp.symbols("D Delta_T", real=True)
R_N, R_T = sp.symbols("R_n R_t", nonnegative=True)
P_SOFT = sp.Symbol("P_regularized", real=True)

QUANTITIES = (
    Quantity(SLIP, "v_t^-", "m/s", "slip velocity before the step, negative"),
    Quantity(APPROACH, "v_n^-", "m/s", "normal velocity before the step"),
    Quantity(SLIP_AFTER, "v_t^+", "m/s", "slip velocity after the step"),
    Quantity(NORMAL_AFTER, "v_n^+", "m/s", "normal velocity after the step"),
    Quantity(IMPULSE, "P", "N s", "normal impulse of the step"),
    Quantity(P_STICK, "P_{stick}", "N s", "normal impulse after which the contact is at rest"),
    Quantity(D, "D", "1/kg", "mobility along the edge of the cone of friction"),
    Quantity(ENERGY, r"\Delta T", "J", "change of kinetic energy"),
    Quantity(R_N, "R_n", "1/kg", "regularization of the normal direction"),
    Quantity(R_T, "R_t", "1/kg", "regularization of the tangential direction"),
    Quantity(P_SOFT, "P_R", "N s", "normal impulse of a regularized step"),
)


def edge_steps() -> list[Step]:
    """Return the steps to the impulse on the edge of the cone."""
    mu = symbol("mu")
    normal = APPROACH + W_NN * IMPULSE + W_NT * mu * IMPULSE
    slip = SLIP + W_NT * IMPULSE + W_TT * mu * IMPULSE
    # P v_n + P_t v_t, divided by P.
    orthogonal = sp.expand(normal + mu * slip)
    impulse = sp.simplify(sp.solve(orthogonal, IMPULSE)[0])
    edge = sp.expand(orthogonal.diff(IMPULSE))
    touching = {APPROACH: 0}
    growth = W_NN + mu * W_NT
    after = sp.factor(normal.subs(IMPULSE, impulse).subs(touching))
    slip_after = sp.factor(slip.subs(IMPULSE, impulse).subs(touching))
    assert sp.simplify(after + mu * slip_after) == 0
    energy = sp.factor(
        impulse * (APPROACH + normal.subs(IMPULSE, impulse)) / 2
        + mu * impulse * (SLIP + slip.subs(IMPULSE, impulse)) / 2
    )
    assert sp.simplify(after - growth * -mu * SLIP / edge) == 0
    return [
        Step(
            "A convex step minimizes $\\tfrac12 p^T W p + p^T v^-$ over the impulses "
            "$p = (P, P_t)$ in the cone $|P_t| \\le \\mu P$. With a definite $W$ there is exactly "
            "one minimum. It is where the velocity after the step, $v^+ = v^- + W p$, lies in the "
            "dual cone, $v_n^+ \\ge \\mu |v_t^+|$, and is orthogonal to the impulse. The end "
            "slides to the left. On the edge that resists, $P_t = \\mu P$, so that",
            sp.Eq(NORMAL_AFTER, normal),
        ),
        Step("and", sp.Eq(SLIP_AFTER, slip)),
        Step(
            "Orthogonality, $P v_n^+ + P_t v_t^+ = 0$, is therefore $v_n^+ = -\\mu v_t^+ = "
            "\\mu |v_t^+|$: **the contact opens while its impulse acts**. Solved for the impulse, "
            "with",
            sp.Eq(D, edge),
        ),
        Step(
            "which is $(1, \\mu)\\, W (1, \\mu)^T$ and so positive for every definite $W$:",
            sp.Eq(IMPULSE, impulse),
        ),
        Step(
            "It contains no length of the step: as the step tends to zero, the impulse does not. "
            "For an end that touches without approach, $v_n^- = 0$, the normal velocity is "
            "$A P$ with $A = W_{nn} + \\mu W_{nt}$,",
            sp.Eq(NORMAL_AFTER, after),
            function="v_n_after_edge",
        ),
        Step("and the slip", sp.Eq(SLIP_AFTER, slip_after), function="v_t_after_edge"),
        Step(
            "The velocity must lie on the edge of the dual cone, $v_n^+ \\ge 0$. So this is the "
            "minimum exactly if $A \\ge 0$. A step loses energy all the same, by",
            sp.Eq(ENERGY, energy),
        ),
    ]


def stick_steps() -> list[Step]:
    """Return the steps on the other minimum, and on regularized solvers."""
    unknown = sp.Symbol("P_t")
    at_rest = (W_NN * IMPULSE + W_NT * unknown, SLIP + W_NT * IMPULSE + W_TT * unknown)
    rest = sp.solve(at_rest, (IMPULSE, unknown))
    stick = sp.simplify(rest[IMPULSE])
    share = sp.simplify(rest[unknown] / rest[IMPULSE])
    # It lies in the cone: with A < 0 the ratio is W_nn/|W_nt| < μ, and W_nt < 0.
    assert sp.simplify(share + W_NN / W_NT) == 0
    soft = {W_NN: W_NN + R_N, W_TT: W_TT + R_T}
    impulse = edge_steps()[3].derived.rhs
    return [
        Step(
            "For $A < 0$, where Painlevé's paradox is possible, the minimum is the apex of the "
            "dual cone, $v^+ = 0$. The other edge, $P_t = -\\mu P$ with $v_n^+ = \\mu |v_t^+|$, "
            "needs $P = \\mu v_t^-/(W_{nn} - 2 \\mu W_{nt} + \\mu^2 W_{tt}) < 0$, a pull. "
            "The impulse that stops both velocities is",
            sp.Eq(P_STICK, stick),
        ),
        Step(
            "with $P_t/P = -W_{nn}/W_{nt}$, which $A < 0$ makes less than $\\mu$: it lies in the "
            "cone. This is the plastic impact of a rigid contact. So a convex step does not notice "
            "the border $A = 0$ by failing: it throws the end up on one side, and stops it on the "
            "other. Solvers add a regularization to the diagonal of $W$, which stands "
            "for a compliance. The edge then has the impulse",
            sp.Eq(P_SOFT, impulse.subs(soft, simultaneous=True)),
        ),
    ]


def derive() -> Derivation:
    """Derive what a step whose velocity lies in the dual cone gives to a sliding contact."""
    return Derivation(
        "cone_dual_step",
        "A step of a convex contact solver",
        "Continues the contact coefficients. Solvers that replace Coulomb's law by a convex "
        f"problem ({cited('Anitescu2006')}, {cited('Todorov2014')}) end a step with a velocity "
        "in the dual of the cone of friction. These formulas hold for every mechanism with "
        "these coefficients, not for the rod alone.",
        (*quantities(), *COEFFICIENTS, *QUANTITIES),
        (*edge_steps(), *stick_steps()),
        {"frozen configuration": "no", "rigid bodies": "in part"},
    )
