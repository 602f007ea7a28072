"""What the paper prints, typed here once and only compared with; nothing is computed from it.

The states of the tables are inputs. Formulas are text in the paper's letters, with ``x_A_dot_0``
for ẋ_A(t0) and so on; they are compared symbolically.

References
----------
Zhao, Liu & Chen, Impact model resolution on Painlevé's paradox.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from painleve_sym.papers.claim import Printed


@dataclass(frozen=True)
class PrintedTable:
    """An initial state with its coefficients.

    Attributes
    ----------
    state : mapping of str to float
        What the table says, misprints corrected; absent entries are 0. SI units, rad.
    A, B : Printed
        As printed; 1/kg and m/s².
    corrected_A : Printed or None
        Where A is misprinted: what the other tables print at the same θ.
    row : str
        The printed row, where its columns are damaged.
    """

    state: Mapping[str, float]
    A: Printed
    B: Printed
    corrected_A: Printed | None = None
    row: str = ""


_INDETERMINATE = PrintedTable(
    {"x_A_dot": -1.0, "theta": 1.0, "theta_dot": 5.0}, Printed("-0.0337"), Printed("11.2368")
)

TABLES: dict[int, PrintedTable] = {
    1: PrintedTable(
        {"x_A_dot": -1.0, "theta": 0.5, "theta_dot": 1.0}, Printed("1.5434"), Printed("-9.3206")
    ),
    2: PrintedTable(
        {"x_A_dot": -1.0, "theta": 0.5, "theta_dot": 5.0},
        Printed("1.5434"),
        Printed("2.1856"),
        row="-1 0 0 0.5 5 1.5434 2.1856",
    ),
    3: PrintedTable(
        {"x_A_dot": -1.0, "theta": 1.0, "theta_dot": 1.0},
        Printed("-0.0037"),
        Printed("-8.9585"),
        corrected_A=Printed("-0.0337"),
    ),
    4: _INDETERMINATE,
    5: _INDETERMINATE,
    6: _INDETERMINATE,
}
"""Tables 1–6 by number."""

COLUMNS = ("x_A", "x_A_dot", "y_A", "y_A_dot", "theta", "theta_dot", "A", "B")
"""Columns of every table, in order."""


@dataclass(frozen=True)
class PrintedForce:
    """An initial compression with the force it carries: Tables 5 and 6, §3.4."""

    table: int
    force: Printed
    height: Printed
    modulus: float


SOFT, STIFF, STIFFER = 20.9e10, 20.9e14, 20.9e16
"""The elastic moduli of §3.1, §3.3 and Table 6; Pa."""

# A force named in words has no digits to round: 0.05 N is what five digits of y_A leave of it.
INITIAL_FORCES: tuple[PrintedForce, ...] = (
    PrintedForce(5, Printed("150", 0.05), Printed("-1.7628e-7"), STIFF),
    PrintedForce(5, Printed("300", 0.05), Printed("-2.6113e-7"), STIFF),
    PrintedForce(6, Printed("350", 0.05), Printed("-2.0942e-8"), STIFFER),
    PrintedForce(6, Printed("500", 0.05), Printed("-2.5635e-8"), STIFFER),
    PrintedForce(6, Printed("1000", 0.05), Printed("-3.7974e-8"), STIFFER),
)

SLIDING_FORCE = Printed("6.039")
"""§3.1: −B/A of Table 1; N."""
STABLE_FORCES = {SOFT: Printed("6.40"), STIFF: Printed("6.071")}
"""§3.1: what F_n is said to become stable at, by modulus; N."""
# Read off a plot, one or two digits: a fifth of the value.
SETTLING_TIMES = {SOFT: Printed("0.01", 0.2e-2), STIFF: Printed("0.75e-3", 0.15e-3)}
"""§3.1: how long F_n oscillates, by modulus; s."""
STICKING_TIME = Printed("4e-4")
"""§3.3: when the slip has stopped, about; s."""
STICKING_COMPRESSION = Printed("1e-4")
"""§3.3: how long the second period lasts, about; s."""
PENDULUM_PERIOD = Printed("2.3")
"""§3.3: period of the rod as a pendulum in gravity; s."""
PRECISE_FROM = 1e14
"""§4: elastic modulus above which the jump rule is called quite precise; Pa."""
GRAVITY_UNIT = "kg·m/s²"
"""§3: the unit printed with g."""


@dataclass(frozen=True)
class PrintedFormula:
    """A formula of the paper.

    Attributes
    ----------
    text : str
        For people.
    expression : str
        Its right side; empty where the paper leaves the line out.
    corrected : str
        The right side with the misprint removed, where there is one.
    holds : str
        The same for people.
    misprint : str
        What is wrong with it.
    """

    text: str
    expression: str
    corrected: str = ""
    holds: str = ""
    misprint: str = ""


_D = "(mu - 3*sin(theta)*cos(theta) + 3*mu*sin(theta)**2)"
_A = "(1 + 3*cos(theta)*(cos(theta) - mu*sin(theta)))/m"
_A_STICK = "4/(m*(1 + 3*sin(theta)**2))"
_FOUR_CURVATURES = (
    "the sum of the four principal curvatures is twice the relative curvature: a ball on a plane "
    "would get R/2, but the paper's own initial forces need R"
)

FORMULAS: dict[str, PrintedFormula] = {
    "eq-1": PrintedFormula("ÿ_A = A F_n + B", f"({_A})*F_n + l*theta_dot**2*sin(theta) - g"),
    "eq-2": PrintedFormula("A = (1 + 3 cosθ (cosθ − μ sinθ))/m", _A),
    "eq-3": PrintedFormula("B = l θ̇² sinθ − g", "l*theta_dot**2*sin(theta) - g"),
    "eq-4": PrintedFormula("F_n = K_e δⁿ", "K_e*delta**n"),
    "eq-4-stiffness": PrintedFormula(
        "K_e = (4/3) E* √R*, 1/E* = Σ(1 − ν²)/E",
        "4/3*R_star**(1/2)/((1 - nu**2)/E + (1 - nu**2)/E)",
    ),
    "eq-4-radius": PrintedFormula(
        "1/R* = 1/R₁′ + 1/R₁″ + 1/R₂′ + 1/R₂″",
        "1/R_1 + 1/R_1 + 1/R_2 + 1/R_2",
        "1/R_1 + 1/R_2",
        "1/R* = 1/R₁ + 1/R₂",
        _FOUR_CURVATURES,
    ),
    "eq-5": PrintedFormula(
        "F_n = F_max ((δ − δ_p)/(δ_max − δ_p))ⁿ",
        "F_n_max*((delta - delta_p)/(delta_max - delta_p))**n",
    ),
    "eq-6": PrintedFormula("δ_p = δ_max (1 − e_s²)", "delta_max*(1 - e_s**2)"),
    "eq-7": PrintedFormula("W_c = F_max δ_max/(n + 1)", "F_n_max*delta_max/(n + 1)"),
    "eq-8": PrintedFormula(
        "W_r = −F_max (δ_max − δ_p)/(n + 1)", "-F_n_max*(delta_max - delta_p)/(n + 1)"
    ),
    "eq-9": PrintedFormula("W_r = −e_s² W_c", "-e_s**2*W_c"),
    "eq-10": PrintedFormula("E_n0 = F_n0 δ₀/(n + 1)", "F_n0*delta_0/(n + 1)"),
    "eq-11-x": PrintedFormula("m ẍ = 0", "0"),
    "eq-11-y": PrintedFormula("m ÿ = −m g", "-g"),
    "eq-11-spin": PrintedFormula("J θ̈ = 0", "0"),
    "eq-12": PrintedFormula(
        "ÿ_A = ÿ − l θ̈ cosθ + l θ̇² sinθ",
        "y_ddot - l*theta_ddot*cos(theta) + l*theta_dot**2*sin(theta)",
    ),
    "eq-13": PrintedFormula("ÿ_A = −g + l θ̇² sinθ", "-g + l*theta_dot**2*sin(theta)"),
    "sticking-force": PrintedFormula(
        "F_t = (3 sinθ cosθ F_n − m l θ̇² cosθ)/(3 sin²θ + 1)",
        "(3*sin(theta)*cos(theta)*F_n - m*l*theta_dot**2*cos(theta))/(3*sin(theta)**2 + 1)",
    ),
    "eq-14-normal": PrintedFormula(
        "ẏ_A(t1) = ẏ_A(t0) − (1 − 3μ sinθ cosθ + 3 cos²θ)/D ẋ_A(t0), "
        "D = μ − 3 sinθ cosθ + 3μ sin²θ",
        f"y_A_dot_0 - (1 - 3*mu*sin(theta)*cos(theta) + 3*cos(theta)**2)/{_D}*x_A_dot_0",
    ),
    "eq-14-impulse": PrintedFormula("P_n1 = −m ẋ_A(t0)/D", f"-m/{_D}*x_A_dot_0"),
    "eq-14-spin": PrintedFormula(
        "no line for θ̇(t1)",
        "",
        "theta_dot_0 + 3*(mu*sin(theta) - cos(theta))*P_n1/(m*l)",
        "θ̇(t1) = θ̇(t0) + 3 (μ sinθ − cosθ) P_n1/(m l)",
        "the line for θ̇(t1), which (18) starts from, is lost",
    ),
    "eq-15": PrintedFormula(
        "ÿ_A = A F_n + B while F_t = μ F_n", f"({_A})*F_n + l*theta_dot**2*sin(theta) - g"
    ),
    "eq-16": PrintedFormula(
        "(ẏ_A²(t1) − ẏ_A²(t0))/2 = −A E_n1", f"-(y_A_dot_1**2 - y_A_dot_0**2)/(2*({_A}))"
    ),
    "eq-17": PrintedFormula("E_n1 = −ẏ_A²(t1)/(2A)", f"-y_A_dot_1**2/(2*({_A}))"),
    "eq-18-spin": PrintedFormula(
        "θ̇(t2) = θ̇(t1) + 3 cosθ ẏ_A(t1)/(4l)", "theta_dot_1 + 3*cos(theta)/(4*l)*y_A_dot_1"
    ),
    "eq-18-impulse": PrintedFormula(
        "P_n2 = −m (1 + 3 sin²θ) ẏ_A(t1)/(4l)",
        "-m*(1 + 3*sin(theta)**2)/(4*l)*y_A_dot_1",
        "-m*(1 + 3*sin(theta)**2)/4*y_A_dot_1",
        "P_n2 = −m (1 + 3 sin²θ) ẏ_A(t1)/4",
        "4l in the denominator, where dimensions and derivation give 4",
    ),
    "eq-19-A": PrintedFormula("A′ = 4/(m (1 + 3 sin²θ))", _A_STICK),
    "eq-19-B": PrintedFormula(
        "B′ = 4l sinθ θ̇²/(3 sin²θ + 1) − g", "4*l*sin(theta)/(3*sin(theta)**2 + 1)*theta_dot**2 - g"
    ),
    "eq-20": PrintedFormula("E_n2 = ẏ_A²(t1)/(2A′)", f"y_A_dot_1**2/(2*({_A_STICK}))"),
    "eq-21-normal": PrintedFormula(
        "ẏ_A(t3) = √(−2A′ E_nr), E_nr = −e_s² E_nc", f"(-2*({_A_STICK})*(-e_s**2*E_nc))**(1/2)"
    ),
    "eq-21-spin": PrintedFormula(
        "θ̇(t3) = θ̇(t2) − 3 cosθ ẏ_A(t3)/(4l)", "theta_dot_2 - 3*cos(theta)/(4*l)*y_A_dot_3"
    ),
    "critical-friction": PrintedFormula("the paradox needs μ > 4/3", "4/3"),
    "sliding-force": PrintedFormula("F_n* = −B/A", f"-(l*theta_dot**2*sin(theta) - g)/({_A})"),
}
"""Formulas by the id of their item."""
