"""The contact of a robot as a mechanism, for `classify`, `jump` and `contrast`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from painleve_sym.at.delassus import (
    ContactNumbers,
    Delassus,
    MotionNumbers,
    NumericalMechanism,
)
from painleve_sym.at.sticking import sticking_formulas
from painleve_sym.checks import StateLike
from painleve_sym.errors import InputError
from painleve_sym.mechanics.declarations import Parameter, ParameterSet
from painleve_sym.mechanics.mechanism import Place
from painleve_sym.mechanics.outline import ContactOutline, MechanismOutline
from painleve_sym.problem.risk import holding_forces, schur_complement
from painleve_sym.robots.dynamics import BASE, RobotDynamics
from painleve_sym.units import Value

if TYPE_CHECKING:
    import casadi as ca

CAVEATS = (
    "The torques of joints are taken as given, whatever the contact does: ideal torque control.",
    "Links, joints and ground are taken as rigid.",
    "The contact is one point; a round foot moves it as it rolls.",
)
"""Assumptions that every result of a robot depends on."""
_AT_REST = 1e-9
"""Normal velocity of a contact that neither opens nor closes, m/s, for a slip up to 1 m/s."""
_STUCK = 1e-6
"""Speed of a stuck contact that counts as rest, m/s, for velocities of six digits."""
_UPRIGHT = 1e-9
"""Least cosine of the pitch of a base whose angles still have velocities."""


@dataclass(frozen=True)
class FirstContact(Delassus):
    """The numbers of the first contact of a robot, the others free or stuck.

    Attributes
    ----------
    fixed : mapping of str to float
        Arguments of the functions that a place of the mechanism does not hold: the axes.
    stuck : bool
        Whether the other contacts do not accelerate, nor change their velocity in an impact.
    """

    fixed: Mapping[str, float] = field(default_factory=dict)
    stuck: bool = False

    def at(self, values: Mapping[str, float]) -> ContactNumbers:
        """Return the numbers of the contact at one state."""
        return self._first(super().at({**self.fixed, **values}))

    def whole_at(self, values: Mapping[str, float]) -> tuple[ContactNumbers, MotionNumbers]:
        """Return the numbers of the contact at one state, and how impulses move the robot."""
        numbers, moves = super().whole_at({**self.fixed, **values})
        return self._first(numbers), self._moved(numbers, moves)

    def at_each(self, values: Mapping[str, Any]) -> ContactNumbers:
        """Return the numbers of the contact at an array of states."""
        return self._first(super().at_each({**self.fixed, **values}))

    def whole_at_each(self, values: Mapping[str, Any]) -> tuple[ContactNumbers, MotionNumbers]:
        """Return the same as `whole_at` at an array of states."""
        numbers, moves = super().whole_at_each({**self.fixed, **values})
        return self._first(numbers), self._moved(numbers, moves)

    def arrays(self, values: Mapping[str, ca.SX]) -> dict[str, ca.SX]:
        """Return the arrays of the contact as CasADi formulas."""
        import casadi as ca

        arrays = super().arrays({**{n: ca.SX(v) for n, v in self.fixed.items()}, **values})
        W, b = arrays["W"], arrays["b"]
        first = {name: value[0, :] for name, value in arrays.items()}
        if self.stuck and W.rows() > 3:
            gain = ca.solve(W[3:, 3:], ca.horzcat(W[3:, :3], b[3:])).T
            W, b = W[:3, :3] - gain[:3, :] @ W[3:, :3], b[:3] - W[:3, 3:] @ gain[3, :].T
            first["A_stick"], first["B_stick"] = sticking_formulas(W, b)
        return first | {"W": W[:3, :3], "b": b[:3]}

    def stuck_velocities(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the speed of each contact that is stuck, which must be 0, by its frame; m/s."""
        others = self.dynamics.outline.contacts[1:] if self.stuck else ()
        if not others:
            return {}
        v = super().at({**self.fixed, **values}).v[3:].reshape(-1, 3)
        return dict(zip((c.name for c in others), np.linalg.norm(v, axis=1).tolist(), strict=True))

    def _first(self, numbers: ContactNumbers) -> ContactNumbers:
        W, b = numbers.W[:3, :3], numbers.b[:3]
        alone: dict[str, Any] = {
            n: v[:1] for n, v in numbers._asdict().items() if n not in ("W", "b", "margins")
        }
        slip = np.linalg.norm(alone["slip_velocity"], axis=1)
        alone["rate_tolerance"] = _AT_REST * np.maximum(1.0, slip)
        if self.stuck:
            W, b = schur_complement(numbers.W, numbers.b)
            A, B = schur_complement(W, b, 1)
            alone |= {"A_stick": A[0], "B_stick": B}
        return ContactNumbers(**{**numbers._asdict(), **alone, "W": W, "b": b})

    def _moved(self, numbers: ContactNumbers, moves: MotionNumbers) -> MotionNumbers:
        D, free = moves.D[:, :3], moves.free
        if self.stuck and len(numbers.mu) > 1:
            gain, force = holding_forces(numbers.W, numbers.b)
            D = D - np.einsum("qr...,rk...->qk...", moves.D[:, 3:], gain)
            free = free - np.einsum("qr...,r...->q...", moves.D[:, 3:], force)
        speeds = moves.drive_speeds[:3]
        return moves._replace(J=moves.J[:3], D=D, free=free, drive_speeds=speeds)


@dataclass(frozen=True, repr=False, eq=False)
class RobotMechanism(NumericalMechanism):
    """The contact of a robot at a pose, as a mechanism in space; `RobotContact.mechanism` is one.

    Its coordinates are those of a floating base and the joint values; those of a state that are
    not given are those of the pose. Its parameters are the friction coefficient `mu`, which has no
    default, and the torques of the joints (`torque_NAME`), by default 0.

    Attributes
    ----------
    robot : RobotDynamics
    subject : str
        A sentence on file, base, contact, surface and locked joints.
    """

    numbers: FirstContact = field(kw_only=True)
    robot: RobotDynamics = field(kw_only=True)
    subject: str = field(kw_only=True)

    @property
    def notices(self) -> tuple[str, ...]:
        """Sentences on the subject of results, on omissions of the file, and on assumptions."""
        return (self.subject, *self.robot.notices, " ".join(CAVEATS))

    def at(
        self,
        state: StateLike | None = None,
        parameters: Mapping[str, Value] | None = None,
        *,
        declared: ParameterSet | None = None,
        where: str = "",
    ) -> Place:
        """Return a state with parameters, all names and numbers checked; see `Mechanism.at`.

        Raises
        ------
        InputError
            Also for no friction coefficient, joint values outside their limits, velocities of
            locked joints and of stuck contacts, and a base whose pitch is a right angle, where its
            angles have no velocities.
        """
        own_state = (
            {} if state is None else self.outline.named_state(f"state of {self.name!r}", state)
        )
        given = {**self.start, **own_state}
        place = super().at(given, parameters, declared=declared, where=where)
        at, faults, units = place.state, list[str](), self.state_units
        for name, joint in self.robot.tree.joints.items():
            own = self.robot.coordinates[name]
            faults += filter(None, [joint.fault(at[own])])
            if name in self.robot.locked and at[rate := f"{own}_dot"]:
                faults.append(
                    f"{rate}: got {at[rate]:g} {units[rate]}, need 0: joint {name} is locked."
                )
        if BASE[4] in at and abs(math.cos(at[BASE[4]])) < _UPRIGHT:
            faults.append(
                f"{BASE[4]}: got {at[BASE[4]]:g} rad, need less than a right angle: the angles of "
                "the base have no velocities there. Fix: turn the axes of the robot's base link."
            )
        if math.isnan(place.parameters["mu"]):
            faults.append(
                "mu: missing, need the friction coefficient >= 0. Fix: such as --set mu=0.8, in "
                "Python mu=0.8."
            )
        if not faults:
            for name, speed in self.numbers.stuck_velocities(place.values).items():
                if speed > _STUCK:
                    faults.append(
                        f"contact {name} is stuck and moves with {speed:g} m/s, need 0. Fix: give "
                        "the velocity of the contact in question instead (--contact-velocity), or "
                        "leave the others free."
                    )
        if faults:
            raise InputError(f"robot {self.name!r}: " + " ".join(faults))
        return place


def refuse(name: str) -> NoReturn:
    """Raise InputError: a robot has no formulas."""
    raise InputError(
        f"robot {name!r}: its contact has numbers in space but no formulas, which are needed here. "
        "Fix: describe the mechanism in Python or in a mechanism file."
    )


def contact_mechanism(
    robot: RobotDynamics, values: Mapping[str, float], stuck: bool, subject: str
) -> RobotMechanism:
    """Return the first contact of a robot as a mechanism.

    Parameters
    ----------
    robot : RobotDynamics
    values : mapping of str to float
        Every argument of its functions, of which the pose and the axes are kept.
    stuck : bool
        Whether the other contacts do not accelerate.
    subject : str
        That of the mechanism.
    """
    name, first = robot.tree.name, robot.outline.contacts[0]
    text = f"velocity of {first.name} along t"
    contact = ContactOutline(first.name, slip_velocity=f"{text}1", slip_across=f"{text}2")
    joints = robot.coordinates.items()
    torques = {f"torque_{own}" for joint, own in joints if joint not in robot.locked}
    friction = Parameter("mu", math.nan, "1", "friction coefficient", lower=0.0)
    parameters = (friction, *(p for p in robot.outline.parameters if p.name in torques))
    outline = MechanismOutline(robot.outline.coordinates, parameters, (contact,), (), False)
    own = {*outline.argument_names}
    numbers = FirstContact(robot, False, {n: v for n, v in values.items() if n not in own}, stuck)

    return RobotMechanism.deferred(
        partial(refuse, name),
        name=name,
        title=f"contact {first.name} of the robot {name}",
        source="",
        sketch="",
        start={c.name: float(values[c.name]) for c in outline.coordinates},
        outline=outline,
        definition=f"{robot.definition} {stuck}",
        numbers=numbers,
        robot=robot,
        subject=subject,
    )
