"""States of the paper's rod for frozen impacts, as the solver takes them."""

from __future__ import annotations

import math

import numpy as np

from painleve_sym.motion.frozen_impact import COEFFICIENTS, START

SIN, COS = math.sin(1.0), math.cos(1.0)
ROD = {
    "W_nn": 1 + 3 * COS**2,
    "W_nt": -3 * SIN * COS,
    "W_tt": 1 + 3 * SIN**2,
    "b_n": SIN - 9.8,
    "b_t": COS,
    "mu": 1.4,
    "K": 1.229683914e14,
    "n": 1.764,
    "e": 0.75,
    "slip_velocity": -1.0,
}
"""The state of Table 3 of the paper at E = 20.9e14."""
OBLIQUE = {**ROD, "compression_rate": 1e-3}
LOADED = {**ROD, "b_n": 11.2368, "compression": 3e-7}


def inputs(case):
    """Return contact, start and parameters of the law whose loading curve is K δⁿ."""
    contact = {name: case[name] for name in (*COEFFICIENTS, "mu")}
    start = {name: case[name] for name in START if name in case}
    # One body with E = 3 K/2, ν = 0 and R = 1 has the stiffness K.
    parameters = {"E": np.multiply(1.5, case["K"]), "nu": 0.0, "R": 1.0, "n": case["n"]}
    return contact, start, {**parameters, "e_energetic": case["e"]}
