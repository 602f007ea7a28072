"""Registry of named quantities: unit, LaTeX and meaning of outputs, contact states, coefficients.

What belongs to one mechanism (coordinates, velocities, parameters) is declared there:
`Mechanism.units` and `Mechanism.latex_names`.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import NamedTuple

from painleve_sym.escape import figure_text

ROUNDING = 1e-13
"""Part of the size of a quantity below which its values are rounding, whatever the tolerance."""


class Quantity(NamedTuple):
    """Unit, LaTeX and meaning of a named quantity; the unit is empty where it depends on a law."""

    unit: str
    latex: str
    meaning: str


_NORMAL, _SLIP = "normal acceleration", "slip acceleration"
_PER_FORCE = "A, normal acceleration per normal force"

QUANTITIES: Mapping[str, Quantity] = {
    "time": Quantity("s", "t", "time"),
    # States and outputs of a contact.
    "gap": Quantity("m", "g_N", "gap, positive when apart"),
    "gap_dot": Quantity("m/s", r"\dot{g}_N", "normal velocity v_n"),
    "gap_rate": Quantity("m/s", r"\dot{g}_N", "normal velocity v_n"),
    "gap_drift": Quantity(
        "m/s", r"\partial g_N/\partial t", "part of v_n by the surface's own motion"
    ),
    "slip_velocity": Quantity("m/s", "v_t", "slip velocity v_t"),
    "normal_velocity": Quantity("m/s", "v_n", "normal velocity"),
    "compression": Quantity("m", r"\delta", "compression, the negative gap"),
    "tangential_deflection": Quantity("m", r"\xi", "deflection of the tangential spring"),
    "deflection_from_slip": Quantity(
        "m", r"\zeta", "deflection of the tangential spring from that of slip"
    ),
    "normal_force": Quantity("N", "F_n", "normal force F_n"),
    "tangential_force": Quantity("N", "F_t", "tangential force F_t"),
    # Energies.
    "kinetic_energy": Quantity("J", "T", "kinetic energy"),
    "potential_energy": Quantity("J", "V", "potential energy"),
    "stored_energy": Quantity("J", "E_n", "energy stored in the contact"),
    "friction_dissipation": Quantity("J", r"D_\mu", "energy lost in friction so far"),
    "contact_dissipation": Quantity("J", "D_n", "energy lost in the contact law so far"),
    "force_dissipation": Quantity("J", "D_F", "energy lost to loads and drives so far"),
    # Impacts, and what a mode keeps in memory.
    "normal_impulse": Quantity("N s", "P_n", "normal impulse of the impact so far"),
    "tangential_impulse": Quantity("N s", "P_t", "tangential impulse of the impact so far"),
    "approach_velocity": Quantity("m/s", "v_n^{-}", "normal velocity at the start of the impact"),
    "impact_budget": Quantity(
        "", "", "work (J) or impulse (N s) of the compression that restitution draws on"
    ),
    "delta_max": Quantity("m", r"\delta_{\max}", "compression at which unloading began"),
    # Coefficients of the contact problem.
    "W_nn": Quantity("1/kg", "W_{nn}", f"{_NORMAL} per normal force"),
    "W_nt": Quantity("1/kg", "W_{nt}", f"{_NORMAL} per tangential force"),
    "W_tt": Quantity("1/kg", "W_{tt}", f"{_SLIP} per tangential force"),
    "b_n": Quantity("m/s^2", "b_n", f"{_NORMAL} without contact forces"),
    "b_t": Quantity("m/s^2", "b_t", f"{_SLIP} without contact forces"),
    "A_neg": Quantity("1/kg", "A_{-}", f"{_PER_FORCE}, slip to the left (v_t < 0)"),
    "A_pos": Quantity("1/kg", "A_{+}", f"{_PER_FORCE}, slip to the right (v_t > 0)"),
    "B": Quantity("m/s^2", "B", "B, normal acceleration without normal force"),
    "A_stick": Quantity("1/kg", "A'", "A' in sticking"),
    "B_stick": Quantity("m/s^2", "B'", "B' in sticking"),
    "F_t_stick": Quantity(
        "N",
        r"F_t^{\mathrm{stick}}",
        "tangential force that keeps the slip velocity 0 (where |F_t| <= mu F_n)",
    ),
}

_GREEK = frozenset(
    (
        *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda"),
        *("mu", "nu", "xi", "rho", "sigma", "tau", "phi", "chi", "psi", "omega", "Gamma", "Delta"),
        *("Theta", "Lambda", "Xi", "Sigma", "Phi", "Psi", "Omega"),
    )
)


def quantity(name: str) -> Quantity | None:
    """Return what is registered for a name, or None; ``gap_A`` is the gap of the contact A."""
    known = QUANTITIES.get(name)
    if known is None and name.startswith("gap_") and name.endswith("_dot"):
        return QUANTITIES["gap_dot"]
    if known is None:
        of_contact = [key for key in QUANTITIES if name.startswith(f"{key}_")]
        known = QUANTITIES[max(of_contact, key=len)] if of_contact else None
    return known


def unit_of(name: str, own: Mapping[str, str]) -> str:
    """Return the SI unit of a state, parameter or output, or of an extreme, integral or time of it.

    The name may be ``max_NAME``, ``integral_NAME``, ``time_of_EVENT`` and such; `own` are the units
    of coordinates, velocities and parameters by name: `Mechanism.units`.
    """
    if name in own:
        return own[name]
    if name.startswith("time") or name.endswith(("_time", "_times")):
        return "s"
    if name.startswith("integral_"):
        unit = unit_of(name.removeprefix("integral_"), own)
        return "s" if unit == "1" else f"{unit} s"
    if at_event := re.fullmatch(r"(.+?)_(?:before|after)_[a-z_]+", name):
        return unit_of(at_event[1], own)
    for prefix in ("max_", "min_"):
        name = name.removeprefix(prefix)
    known = quantity(name)
    return own.get(name) or (known.unit if known else "") or "1"


def counted(count: int, noun: str) -> str:
    """Return a number of things, one or several.

    >>> counted(1, "event"), counted(2, "event")
    ('1 event', '2 events')
    """
    return f"{count} {noun}{'' if count == 1 else 's'}"


def derivative_latex(latex: str, dots: int = 1) -> str:
    r"""Return the LaTeX of a time derivative: ``x_A`` becomes ``\dot{x}_A``."""
    base, _, index = latex.partition("_")
    return rf"\{'d' * dots}ot{{{base}}}" + (f"_{index}" if index else "")


def symbol_latex(name: str) -> str:
    r"""Return LaTeX for the name of a symbol: ``theta_dot`` becomes ``\dot{\theta}``."""
    base, _, index = name.removesuffix("_dot").partition("_")
    if numbered := re.fullmatch(r"([A-Za-z]+)(\d+)", base):
        base, index = numbered[1], numbered[2] + (f" {index}" if index else "")
    letter = rf"\{base}" if base in _GREEK else base
    if len(base) > 1 and base not in _GREEK:
        letter = rf"\mathrm{{{base}}}"
    if name.endswith("_dot"):
        letter = derivative_latex(letter)
    return letter + (f"_{{{index}}}" if index else "")


def axis_label(latex: str, unit: str = "1") -> str:
    """Return the label of an axis: a formula with its unit in parentheses; no unit for "1"."""
    return text_label(f"${latex}$", unit)


def text_label(text: str, unit: str = "1") -> str:
    """Return the label of an axis that a text names; formulas in it stand between dollar signs."""
    return text if unit in ("1", "") else f"{text} ({figure_text(unit)})"


def scaled_unit(unit: str, largest: float) -> tuple[float, str]:
    """Return a factor and a unit with an SI prefix, such as 1e6 and "μm", that suit a size.

    The size is the largest that is shown, in the unit given. Lengths, times, forces, energies and
    pressures, and their rates per second, take a prefix; others keep their unit and the factor 1.
    """
    base = unit.partition("/")[0]
    if base not in ("m", "s", "N", "J", "Pa") or not 0 < largest < float("inf"):
        return 1.0, unit
    if base not in ("m", "s") and largest >= 1e4:
        larger = {1e-3: "k", 1e-6: "M", 1e-9: "G"}
        factor = min(f for f in larger if largest * f >= (1 if base == "Pa" else 10))
        return factor, f"{larger[factor]}{unit}"
    smaller = {1.0: "", 1e3: "m", 1e6: "μ", 1e9: "n"}
    fitting = [f for f in smaller if largest * f >= (0.1 if f == 1.0 else 1.0)]
    factor = fitting[0] if fitting else 1e9
    return factor, f"{smaller[factor]}{unit}"


def roundest(low: float, high: float) -> float:
    """Return the number with the fewest digits within a positive range; 0 where it is empty."""
    if not 0 < low <= high < float("inf"):
        return 0.0
    power = 10.0 ** math.ceil(math.log10(high))
    while True:
        for step in (power, power / 2, power / 5):
            value = math.ceil(low / step - 1e-9) * step
            if value <= high * (1 + 1e-12):
                return float(f"{value:.12g}")
        power /= 10


def number_latex(value: float, digits: int = 3) -> str:
    r"""Return a number in the one style of figures, such as ``2.09\times 10^{15}``."""
    text = f"{value:.{digits - 1}e}"
    mantissa, exponent = text.split("e")
    mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
    power = f"10^{{{int(exponent)}}}"
    if int(exponent) in range(-3, 4):
        return f"{value:.{digits}g}"
    return power if mantissa == "1" else rf"{mantissa}\times {power}"
