"""Every named mechanism once more, as bodies and joints in maximal coordinates."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from tests.mechanics.elastic_rod import ElasticRod
from tests.mechanics.newton_euler import (
    WORLD,
    Angle,
    Array,
    Machine,
    Motion,
    NoTurn,
    Pin,
    Place,
    Rail,
    Touch,
    turn,
)

Numbers = Mapping[str, float]
X, Y = (1.0, 0.0), (0.0, 1.0)


def _weights(masses, g: float, direction=(0.0, -1.0)) -> Array:
    return np.array([[m * g * direction[0], m * g * direction[1], 0.0] for m, _ in masses])


def _of_body(body: int, local) -> Callable[[Motion], Array]:
    return lambda motion: motion.arm(body, local)


def rod(v: Numbers, inertia: float | None = None) -> Machine:
    m, l, theta = v["m"], v["l"], v["theta"]
    masses = [(m, m * l**2 / 3 if inertia is None else inertia)]
    centre = np.array([v["x_A"], v["y_A"]]) + l * np.array([np.cos(theta), np.sin(theta)])
    end = (-l, 0.0)
    return Machine(
        masses,
        np.array([[*centre, theta]]),
        (),
        (Place(0, end, X), Place(0, end, Y), Angle(0)),
        (Touch(0, _of_body(0, end)),),
        lambda motion: _weights(masses, v["g"]),
    )


def rod_inertia(v: Numbers) -> Machine:
    return rod(v, v["m"] * v["l"] ** 2 / v["alpha"])


def _block(v: Numbers, inertia: float, centre, feet) -> Machine:
    masses = [(v["m"], inertia)]
    theta = v["theta"]
    place = np.array([v["x_A"], v["y_A"]]) + turn(theta) @ np.array(centre)
    down = (-np.sin(v["beta"]), -np.cos(v["beta"]))
    local = [np.array(foot) - np.array(centre) for foot in feet]
    return Machine(
        masses,
        np.array([[*place, theta]]),
        (),
        (Place(0, local[0], X), Place(0, local[0], Y), Angle(0)),
        tuple(Touch(0, _of_body(0, p)) for p in local),
        lambda motion: _weights(masses, v["g"], down),
    )


def block(v: Numbers) -> Machine:
    a, b = v["a"], v["b"]
    return _block(v, v["m"] * (a**2 + b**2) / 3, (a, b), [(0.0, 0.0)])


def block_two_feet(v: Numbers) -> Machine:
    return _block(v, v["J"], (v["a"], v["h"]), [(0.0, 0.0), (2 * v["a"], 0.0)])


def eccentric_disc(v: Numbers) -> Machine:
    masses, phi, r, d = [(v["m"], v["J"])], v["phi"], v["r"], v["d"]
    middle = np.array([v["x"], v["y"] + r])
    centre = middle + d * np.array([np.cos(phi), np.sin(phi)])
    rim = Touch(
        0,
        lambda motion: motion.arm(0, (-d, 0.0)) + np.array([0.0, -r]),
        material=False,
        middle=(-d, 0.0),
    )
    return Machine(
        masses,
        np.array([[*centre, phi]]),
        (),
        (Place(0, (-d, 0.0), X), Place(0, (-d, 0.0), Y), Angle(0)),
        (rim,),
        lambda motion: _weights(masses, v["g"]),
    )


def cart_pendulum(v: Numbers) -> Machine:
    masses = [(v["M"], 1.0), (v["m"], v["J"])]
    l, phi = v["l"], v["phi"]
    bob = (v["x"] + l * np.sin(phi), v["y"] - l * np.cos(phi), phi)

    def forces(motion: Motion) -> Array:
        total = _weights(masses, v["g"])
        total[0, 0] += v["F"]
        total[1, 2] -= v["c_j"] * motion.speed[1, 2]
        return total

    return Machine(
        masses,
        np.array([[v["x"], v["y"], 0.0], bob]),
        (NoTurn(0), Pin(0, (0, 0), 1, (0.0, l))),
        (Place(0, (0, 0), X), Place(0, (0, 0), Y), Angle(1)),
        (Touch(0, _of_body(0, (0, 0))),),
        forces,
    )


def two_link_arm(v: Numbers) -> Machine:
    l_1, l_2, h = v["l_1"], v["l_2"], v["h"]
    masses = [(v["m_1"], v["m_1"] * l_1**2 / 12), (v["m_2"], v["m_2"] * l_2**2 / 12)]
    a, b = v["theta_1"], v["theta_2"]
    along = [np.array([np.cos(s), np.sin(s)]) for s in (a, b)]
    base = np.array([0.0, h])
    upper, lower = base + along[0] * l_1 / 2, base + along[0] * l_1 + along[1] * l_2 / 2

    def forces(motion: Motion) -> Array:
        total = _weights(masses, v["g"])
        w_1, w_2 = motion.speed[:, 2]
        elbow = v["tau_2"] - v["c_2"] * (w_2 - w_1)
        total[0, 2] += v["tau_1"] - v["c_1"] * w_1 - elbow
        total[1, 2] += elbow
        return total

    return Machine(
        masses,
        np.array([[*upper, a], [*lower, b]]),
        (Pin(0, (-l_1 / 2, 0), WORLD, base), Pin(0, (l_1 / 2, 0), 1, (-l_2 / 2, 0))),
        (Angle(0), Angle(1)),
        (Touch(1, _of_body(1, (l_2 / 2, 0)), surface_speed=v["u"]),),
        forces,
    )


def pr_robot(v: Numbers) -> Machine:
    l, theta = v["l"], v["theta"]
    masses = [(v["m_1"], 1.0), (v["m_2"], v["m_2"] * l**2 / 3)]
    joint = np.array([v["x"], v["h"]])
    centre = joint - l * np.array([np.cos(theta), np.sin(theta)])

    def forces(motion: Motion) -> Array:
        total = _weights(masses, v["g"])
        total[0, 0] += v["F"]
        torque = v["tau"] - v["c_j"] * motion.speed[1, 2]
        total[1, 2] += torque
        total[0, 2] -= torque
        return total

    return Machine(
        masses,
        np.array([[*joint, 0.0], [*centre, theta]]),
        (NoTurn(0), Rail(0, v["h"]), Pin(0, (0, 0), 1, (l, 0))),
        (Place(0, (0, 0), X), Angle(1)),
        (Touch(1, _of_body(1, (-l, 0))),),
        forces,
    )


def strut(v: Numbers) -> Machine:
    l, theta = v["l"], v["theta"]
    masses = [(v["m"], v["m"] * l**2 / 3)]
    pivot = np.array([0.0, v["h"]])
    centre = pivot - l * np.array([np.cos(theta), np.sin(theta)])

    def forces(motion: Motion) -> Array:
        total = _weights(masses, v["g"])
        total[0, 2] -= v["k_s"] * (theta - v["theta_0"]) + v["c_s"] * motion.speed[0, 2]
        return total

    return Machine(
        masses,
        np.array([[*centre, theta]]),
        (Pin(0, (l, 0), WORLD, pivot),),
        (Angle(0),),
        (Touch(0, _of_body(0, (-l, 0)), surface_speed=v["u"]),),
        forces,
    )


def painleve_klein(v: Numbers) -> Machine:
    L, phi = v["L"], v["phi"]
    height = L * np.sin(v["phi_0"])
    masses = [(v["m_1"], 1.0), (v["m_2"], 1.0), (0.0, 0.0)]
    upper = np.array([v["x"] + L * np.cos(phi), height])
    lower = np.array([v["x"], height - L * np.sin(phi)])

    def forces(motion: Motion) -> Array:
        total = _weights(masses, v["g"])
        total[0, 0] += v["P_1"]
        total[1, 0] += v["P_2"]
        return total

    return Machine(
        masses,
        np.array([[*lower, 0.0], [*upper, 0.0], [*(lower + upper) / 2, phi]]),
        (
            *(NoTurn(0), NoTurn(1), Rail(1, height)),
            *(Pin(2, (-L / 2, 0), 0, (0, 0)), Pin(2, (L / 2, 0), 1, (0, 0))),
        ),
        (Place(0, (0, 0), X), Angle(2)),
        (Touch(0, _of_body(0, (0, 0))),),
        forces,
    )


MACHINES: Mapping[str, Callable[[Numbers], Machine | ElasticRod]] = {
    "rod": rod,
    "rod-inertia": rod_inertia,
    "rod-bending": ElasticRod,
    "block": block,
    "block-two-feet": block_two_feet,
    "eccentric-disc": eccentric_disc,
    "cart-pendulum": cart_pendulum,
    "two-link-arm": two_link_arm,
    "pr-robot": pr_robot,
    "strut": strut,
    "painleve-klein": painleve_klein,
}
