"""A contact of a robot: its mobility, its risk at a pose and over all poses, its impacts."""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.at.cases import classify
from painleve_sym.at.classification import Classification
from painleve_sym.at.delassus import ContactNumbers, Delassus
from painleve_sym.at.jump import JumpResult, evaluate_jump
from painleve_sym.at.positive import (
    NO_PARADOX,
    PositiveFunction,
    own_inertia,
    positive_where,
    shares,
)
from painleve_sym.blas_threads import one_blas_thread
from painleve_sym.checks import by_name, number, spatial_mobility_faults, whole_number
from painleve_sym.choices import (
    ImpactFriction,
    ImpactFrictionLike,
    Restitution,
    RestitutionLike,
    chosen,
)
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.errors import (
    CompilerMissing,
    InputError,
    PainleveWarning,
    refuse_unknown,
    unknown_name,
)
from painleve_sym.laws.restitution import restitution_law
from painleve_sym.problem.coefficients import Sector
from painleve_sym.problem.friction_set import unit_vector
from painleve_sym.problem.impact.one_contact import Impact, solve_impact
from painleve_sym.problem.impact.within_plane import in_plane, is_regular, moving_tangent
from painleve_sym.problem.risk import (
    LEAST,
    friction_threshold,
    least_over_normals,
    schur_complement,
)
from painleve_sym.robots.contact_mechanism import RobotMechanism, contact_mechanism
from painleve_sym.robots.contact_risk import ContactRisk, LeastRisk
from painleve_sym.robots.contact_subject import ContactSubject
from painleve_sym.robots.dynamics import BASE, NORMAL, TANGENT, RobotDynamics
from painleve_sym.robots.tree import Joint
from painleve_sym.units import Value

if TYPE_CHECKING:
    import casadi as ca

POSES = 2000
"""Random poses by default."""
_STARTS, _SHORT, _LONG = 12, 30, 300
"""Searches for the least, their iterations, and those of the best ones, which continue."""
_NEVER = 1e3
"""Stands for the logarithm of an infinite μ_P² in a search: a number beyond all others."""
_SINGULAR_MASS = 1e-12
"""Least eigenvalue of a regular mass matrix, scaled to a diagonal of ones."""
_SINGULAR = 1e-9
"""Part of the largest mobility below which one is 0 but for rounding: a singular pose."""
INFINITE = 1e9
"""Thresholds of friction from this on are infinite but for rounding."""


@dataclass(frozen=True, eq=False, repr=False)
class RobotContact:
    """A contact of a robot at a pose; `Robot.contact` makes it.

    Attributes
    ----------
    dynamics : RobotDynamics
        Of all named contacts; the first one is the contact in question.
    values : dict of str to float
        Every argument of its functions.
    stuck : bool
        Whether the other contacts do not accelerate.
    file : str
        From which the robot was read.
    pose : str or None
        Name of the pose from which the joint values come that were not given.
    """

    dynamics: RobotDynamics
    values: Mapping[str, float]
    stuck: bool = False
    file: str = ""
    pose: str | None = None

    def __repr__(self) -> str:
        """Return the title."""
        return f"RobotContact {self.title}"

    @property
    def title(self) -> str:
        """Robot, base, joints and contacts in one line."""
        contact, *others = (c.frame for c in self.dynamics.contacts)
        locked = len(self.dynamics.locked)
        held_joints = f", {locked} locked" if locked else ""
        beside = f", {', '.join(others)} {'stuck' if self.stuck else 'free'}" if others else ""
        return f"{self.dynamics.tree.title}{held_joints}: contact {contact}{beside}"

    @cached_property
    def _delassus(self) -> Delassus:
        return Delassus(self.dynamics, compiles=False)

    @property
    def joints(self) -> dict[str, Joint]:
        """Joints that are not locked, by name."""
        every, locked = self.dynamics.tree.joints, self.dynamics.locked
        return {name: joint for name, joint in every.items() if name not in locked}

    @property
    def axes(self) -> Array:
        """Normal and both tangents in the axes of the world, shape (3, 3)."""
        n, t = (np.array([self.values[k] for k in names]) for names in (NORMAL, TANGENT))
        return np.array([n, t, np.cross(n, t)])

    def numbers(self) -> ContactNumbers:
        """Return the numbers of all contacts at the pose."""
        return self._delassus.at(self.values)

    def numbers_at(self, values: Mapping[str, Any]) -> ContactNumbers:
        """Return the numbers of all contacts at arrays of all arguments."""
        return self._delassus.at_each(values)

    def thresholds_of(self, numbers: ContactNumbers) -> Array:
        """Return μ_P of the contact in question; infinite, or nan, as `thresholds` has it."""
        return _thresholds(self.in_question(numbers)[0])

    def heights(self, values: Mapping[str, Any]) -> Array:
        """Return the height of the contact at arrays of all arguments, along the normal; m.

        It is that above the plane through the origin of the world.
        """
        function = quantities(
            "height",
            self.dynamics.definition,
            self.arguments,
            lambda: (["height"], self.dynamics.height_function()),
            compiles=False,
        )
        arrays = np.broadcast_arrays(*(np.asarray(values[n], float) for n in self.arguments))
        return np.asarray(function.rows(dict(zip(self.arguments, arrays, strict=True)))[0])

    def in_question(self, numbers: ContactNumbers) -> tuple[Array, Array]:
        """Return W and b of the contact in question."""
        if not self.stuck:
            return numbers.W[:3, :3], numbers.b[:3]
        return schur_complement(numbers.W, numbers.b)

    @cached_property
    def mechanism(self) -> RobotMechanism:
        """The contact as a mechanism, which `classify`, `evaluate_jump` and others take.

        Its states that are not given are those of the pose, its velocities 0.
        """
        self._check_mass()
        return contact_mechanism(self.dynamics, self.values, self.stuck, self.subject.sentence)

    @property
    def subject(self) -> ContactSubject:
        """All that answers about the contact are of: file, base, contact, surface and pose."""
        return ContactSubject(
            self.dynamics, self.values, self.axes, self.stuck, self.file, self.pose
        )

    def classify(
        self,
        mu: float,
        velocities: Mapping[str, Value] | None = None,
        torques: Mapping[str, Value] | None = None,
        *,
        contact_velocity: Sequence[float] | None = None,
    ) -> Classification:
        """Return the rigid contact problem of the contact at the pose, with every solution.

        Parameters
        ----------
        mu : float
            Friction coefficient, >= 0.
        velocities : mapping of str to (float or str), optional
            Of joints and of coordinates of the base (`base_x`, ...), in rad/s or m/s; 0 by default.
        torques : mapping of str to (float or str), optional
            Of joints, N m or N; 0 by default.
        contact_velocity : sequence of 3 float, optional
            Of the contact along n, t1, t2, m/s: `velocities` are changed so that it has this one,
            with the least kinetic energy of the change.

        Raises
        ------
        InputError
            Unknown names; a contact that approaches or leaves, or that cannot move so.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> foot = ps.robot("examples/robots/quadruped.urdf").contact("LF_foot", pose="standing")
        >>> foot.classify(2.0, contact_velocity=(0.0, 1.0, 0.0)).case
        <ContactCase.INCONSISTENT: 'inconsistent'>
        """
        state, of_joints = self._named(velocities, torques)
        parameters = {"mu": mu, **of_joints}
        answer: Any = classify(
            self.mechanism, state, parameters=parameters, contact_velocity=contact_velocity
        )
        assert isinstance(answer, Classification)
        return answer

    def jump(
        self,
        restitution: RestitutionLike,
        mu: float,
        e: float | None = None,
        velocities: Mapping[str, Value] | None = None,
        *,
        contact_velocity: Sequence[float] | None = None,
        impact_friction: ImpactFrictionLike = ImpactFriction.PATH,
    ) -> JumpResult:
        """Return the impact of the contact at the pose: phases, impulses, velocities after it.

        The configuration is frozen. Where the contact slides with A < 0 and does not approach, it
        is the impact without collision.

        Parameters
        ----------
        restitution : Restitution or its text
            ``energetic``, ``poisson`` or ``newton``.
        mu : float
            Friction coefficient, >= 0.
        e : float, optional
            Coefficient of restitution, by default 0.75.
        velocities, contact_velocity
            As for `classify`.
        impact_friction : ImpactFriction or its text
            Which slip friction opposes: ``path`` or ``final_slip``; see `evaluate_jump`.

        Raises
        ------
        InputError
            Unknown names; a contact that leaves, that has no impact, or that cannot move so.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> foot = ps.robot("examples/robots/quadruped.urdf").contact("LF_foot", pose="standing")
        >>> jump = foot.jump("energetic", 2.0, 0.5, contact_velocity=(0.0, 1.0, 0.0))
        >>> [phase.name for phase in jump.phases]
        ['tangential', 'sticking compression', 'sticking restitution']
        """
        law = restitution_law(chosen(Restitution, restitution, "restitution law", "jump"))
        state, _ = self._named(velocities, None)
        return evaluate_jump(
            self.mechanism,
            law,
            state,
            e=e,
            impact_friction=impact_friction,
            parameters={"mu": mu},
            contact_velocity=contact_velocity,
        )

    def _named(
        self, velocities: Mapping[str, Value] | None, torques: Mapping[str, Value] | None
    ) -> list[dict[str, Value]]:
        """Return velocities and torques by the names that they have in the mechanism."""
        where, named = f"robot {self.dynamics.tree.name}", list[dict[str, Value]]()
        own = self.dynamics.coordinates
        # A joint has its name in the file, too, unless it is that of a coordinate.
        coordinates = own | {c.name: c.name for c in self.dynamics.outline.coordinates}
        for noun, given, form, names in (
            ("velocity", velocities, "{}_dot", coordinates),
            ("torque", torques, "torque_{}", {name: own[name] for name in self.joints}),
        ):
            values = by_name(given, f"{where}: {noun}", "{'knee': 0.5}")
            for name in values:
                refuse_unknown(noun, name, names, where)
            named.append({form.format(names[name]): value for name, value in values.items()})
        return named

    def mobility(self, joints: Mapping[str, Array] | None = None) -> Array:
        """Return W at the pose, or at arrays of joint values that differ from it.

        Returns
        -------
        ndarray, shape (3, 3, ...)
            Rows n, t1, t2; 1/kg.

        Raises
        ------
        InputError
            Without `joints`: the mass matrix is singular at the pose.
        """
        if not joints:
            self._check_mass()
            return self.in_question(self.numbers())[0]
        own = self.dynamics.coordinates
        given = {own.get(name, name): values for name, values in joints.items()}
        return self.in_question(self.numbers_at({**self.values, **given}))[0]

    @property
    def arguments(self) -> tuple[str, ...]:
        """Names of all that W depends on, in the order of `mobility_of`."""
        return self.dynamics.outline.argument_names

    def mobility_of(self, x: ca.SX) -> ca.SX:
        """Return W as CasADi formulas of a vector of all `arguments`."""
        import casadi as ca

        entries, size = self._delassus.contact_quantities, self.dynamics.rows.size
        begin = entries.names.index("W_0_0")
        W = ca.reshape(entries.function(x)[begin : begin + size**2], size, size).T
        if not self.stuck:
            return W[:3, :3]
        return W[:3, :3] - W[:3, 3:] @ ca.solve(W[3:, 3:], W[3:, :3])

    def positive_function(
        self, over: Mapping[str, tuple[float, float]], mu: float | None = None
    ) -> PositiveFunction:
        """Return W_nn² − μ² |w|², after the pivots of the mass matrix, on the quantities of a box.

        Where all are positive on the whole box, A > 0 for every direction of slip there. The angles
        of a floating base may be in gimbal lock, since W does not depend on their velocities.

        Parameters
        ----------
        over : mapping of str to (float, float)
            Ends of joint values within their limits, by the names of states, rad or m, of angles
            of a floating base
            (`base_roll`, `base_pitch`, `base_yaw`), rad, and of the friction coefficient `mu`.
        mu : float, optional
            Friction coefficient, >= 0, unless it varies.

        Returns
        -------
        PositiveFunction
            Fixed is all that W depends on and that does not vary, and `mu`.

        Raises
        ------
        InputError
            Unknown names; ends in the wrong order or outside limits; no friction coefficient, or
            two; a contact that cannot move along its normal in the middle of the box.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> dog = ps.robot("examples/robots/quadruped.urdf")
        >>> foot = dog.contact("LF_foot", pose="standing")
        >>> positive = foot.positive_function({"LF_KFE": (-1.45, -1.35)}, mu=1.0)
        >>> round(float(positive.function(-1.4)[-1]), 3), positive.fixed["LF_HFE"]
        (5.486, 0.7)
        """
        import casadi as ca

        where, tree = "robot: over", self.dynamics.tree
        own = self.dynamics.coordinates
        limits = {own[j.name]: (j.lower, j.upper) for j in tree.joints.values()}
        limits |= dict.fromkeys(BASE[3:] * tree.floating, (-math.inf, math.inf))
        limits["mu"] = (0.0, math.inf)
        if (mu is None) != ("mu" in over):
            given = "no friction coefficient" if mu is None else "mu both varied and set"
            raise InputError(f"{where}: got {given}, need it once.")
        faults = []
        for name, (low, high) in over.items():
            if name not in limits:
                faults.append(unknown_name("quantity", name, limits))
            elif not low < high:
                faults.append(f"{name} from {low:g} to {high:g}, need ends that grow.")
            elif not limits[name][0] <= low < high <= limits[name][1]:
                lower, upper = limits[name]
                faults.append(
                    f"{name} from {low:g} to {high:g}, need a range within its limits {lower:g} "
                    f"and {upper:g}."
                )
        if faults:
            raise InputError(f"{where}: " + " ".join(faults))
        middle = {name: low + (high - low) / 2 for name, (low, high) in over.items()}
        values = {**self.values, **({} if mu is None else {"mu": mu})}
        replace(self, values=values | middle).risk(mu)
        x = ca.SX.sym("x", len(over))
        at = values | dict(zip(over, ca.vertsplit(x), strict=True))
        place = ca.vertcat(*(at[name] for name in self.arguments))
        kept = (*limits, *NORMAL, *TANGENT)
        fixed = {name: values[name] for name in kept if name not in over}
        moving = self.dynamics.velocities
        units = {c.name: c.unit for c in self.dynamics.outline.coordinates}
        mass = ca.reshape(self.dynamics.mass_function()(place), len(moving), len(moving))
        bounds = shares(mass, [units[name] for name in moving])
        conditions = (*map(own_inertia, moving), NO_PARADOX)
        return PositiveFunction(
            positive_where(x, bounds, self.mobility_of(place), at["mu"]), conditions, fixed
        )

    @cached_property
    def _ratio(self) -> Quantities:
        """|w|²/W_nn² = 1/μ_P², and its derivatives by the joints that are not locked."""
        dynamics, names, arguments = self.dynamics, tuple(self.joints), self.arguments

        def derive() -> tuple[list[str], ca.Function]:
            import casadi as ca

            x = ca.SX.sym("x", len(arguments))
            W = self.mobility_of(x)
            ratio = (W[1, 0] ** 2 + W[2, 0] ** 2) / W[0, 0] ** 2
            own = dynamics.coordinates
            slopes = ca.gradient(ratio, x)[[arguments.index(own[name]) for name in names]]
            whole = ca.densify(ca.vertcat(ratio, slopes))
            return ["ratio", *names], ca.Function("ratio", [x], ca.cse([whole]))

        title = f"risk {self.stuck}"
        return quantities(title, dynamics.definition, arguments, derive, compiles=False)

    def risk(self, mu: float | None = None) -> ContactRisk:
        """Return the risk of the contact at the pose.

        Parameters
        ----------
        mu : float, optional
            Friction coefficient, >= 0.

        Raises
        ------
        InputError
            Where the contact cannot move along its normal, or the mass matrix is singular.
        """
        if mu is not None:
            mu = number(mu, "mu", where="robot", lower=0.0)
        W = self.mobility()
        if not W[0, 0] > _SINGULAR * np.trace(W):
            raise InputError(
                f"robot: contact {self.dynamics.contacts[0].frame!r} cannot move along the normal "
                f"in this pose: W_nn = {W[0, 0]:g} 1/kg. Fix: choose another pose or normal, or "
                "lock fewer joints."
            )
        mu_P = float(_thresholds(W))
        bounded = math.isfinite(mu_P)
        direction = unit_vector(W[1:, 0].tolist()) if bounded else (math.nan, math.nan)
        ratio, *slopes = self._ratio.of_vector([self.values[n] for n in self._ratio.arguments])
        factor = -0.5 * ratio**-1.5 if bounded and ratio > 0 else math.nan
        _, t1, t2 = self.axes
        least = float(least_over_normals(W))
        return ContactRisk(
            W=W,
            mu=mu,
            mu_P=mu_P,
            direction=direction,
            worst_direction=direction[0] * t1 + direction[1] * t2,
            sector=Sector.of(W, mu, mu_P) if mu is not None and mu > mu_P else None,
            least_over_normals=_bounded(least) if least > LEAST else 0.0,
            gradient={n: factor * s for n, s in zip(self.joints, slopes, strict=True)},
            impact=_worst_impact(W, mu, direction) if mu is not None and mu > mu_P else None,
        )

    def _check_mass(self) -> None:
        """Raise where the mass matrix is singular at the pose: W is its rounding then."""
        names, arguments = self.dynamics.velocities, self.arguments
        places = [f"M_{i}_{k}" for i in range(len(names)) for k in range(len(names))]
        function = quantities(
            "mass matrix",
            self.dynamics.definition,
            arguments,
            lambda: (places, self.dynamics.mass_function()),
            compiles=False,
        )
        M = np.array(function.of_vector([self.values[n] for n in arguments]))
        M = M.reshape(len(names), len(names))
        scale = 1 / np.sqrt(np.maximum(np.diag(M), np.finfo(float).tiny))
        values, vectors = np.linalg.eigh(M * np.outer(scale, scale))
        if values[0] < _SINGULAR_MASS:
            name = names[int(np.argmax(np.abs(vectors[:, 0])))]
            raise InputError(
                f"robot: the mass matrix is singular at this pose: {name!r} turns links without "
                "inertia about its axis. Fix: give them an inertia, give joints a rotor inertia "
                "(armature), or lock the joint."
            )

    def _ranges(self) -> dict[str, tuple[float, float]]:
        """Return the ranges of the varied joints: a turn for a joint without limits.

        Their order is the one of the robot itself, so that random poses of it are the same whatever
        the order in its file.
        """
        ranges, joints = {}, self.joints
        for joint in (joints[n] for n in self.dynamics.tree.joints_by_place if n in joints):
            lower, upper = joint.lower, joint.upper
            if joint.unit == "rad":
                lower, upper = max(lower, -math.pi), min(upper, math.pi)
                if not lower < upper:
                    lower, upper = joint.lower, joint.upper
            if math.isfinite(upper - lower) and lower < upper:
                ranges[joint.name] = (lower, upper)
        return ranges

    def random_poses(self, count: int = POSES, seed: int = 0) -> dict[str, Array]:
        """Return joint values drawn uniformly within the limits, each of shape (count,).

        Joints without limits turn by one turn; those that slide keep their value.
        """
        count = whole_number(count, "count", where="random_poses", lower=1, upper=10_000_000)
        random = np.random.default_rng(seed)
        return {n: random.uniform(*ends, size=count) for n, ends in self._ranges().items()}

    def thresholds(self, joints: Mapping[str, Array]) -> Array:
        """Return μ_P at arrays of joint values; nan where the contact cannot move."""
        return _thresholds(self.mobility(joints))

    @one_blas_thread()
    def least(self, joints: Mapping[str, Array] | None = None) -> LeastRisk:
        """Return the least μ_P over joint values within their limits, with its pose.

        Searches by gradients start at the poses with the smallest μ_P of those given, by default
        `random_poses`. It is the least that they reach, not a proof; `certify` proves.

        Raises
        ------
        InputError
            Where no joint has a range.
        """
        ranges = self._ranges()
        if not ranges:
            raise InputError("robot: no joint has a range to search. Fix: lock fewer joints.")
        from scipy.optimize import minimize

        joints = self.random_poses() if joints is None else joints
        mu_P = self.thresholds(joints)
        order = np.argsort(mu_P)[:_STARTS]
        names, of = list(ranges), self._ratio
        own = self.dynamics.coordinates
        place = [of.arguments.index(own[name]) for name in names]
        slopes_of = [1 + list(self.joints).index(name) for name in names]
        point = np.array([self.values[name] for name in of.arguments])

        def objective(q: Array) -> tuple[float, Array]:
            point[place] = q
            numbers = np.array(of.of_vector(point.tolist()))
            if not numbers[0] > INFINITE**-2 or not np.isfinite(numbers).all():
                return _NEVER, np.zeros(len(q))
            # Of the logarithm, whose size is the same for all robots.
            return -math.log(numbers[0]), -numbers[slopes_of] / numbers[0]

        def descended(start: Array, iterations: int) -> tuple[float, Array]:
            settings = {"method": "L-BFGS-B", "bounds": list(ranges.values())}
            options = {"maxiter": iterations}
            answer = minimize(objective, start, jac=True, options=options, **settings)
            return float(answer.fun), answer.x

        starts = [np.array([joints[name][k] for name in names]) for k in order]
        reached = sorted((descended(q, _SHORT) for q in starts), key=lambda pair: pair[0])
        best, best_q = min((descended(q, _LONG) for _, q in reached[:2]), key=lambda pair: pair[0])
        pose = {n: float(v) for n, v in zip(names, best_q, strict=True)}
        whole = {name: pose.get(name, float(self.values[own[name]])) for name in self.joints}
        least_mu_P = math.exp(best / 2) if best < _NEVER else math.inf
        return LeastRisk(least_mu_P if least_mu_P > LEAST else 0.0, whole)


def _thresholds(W: Array) -> Array:
    """Return μ_P, infinite where w is rounding, nan where the contact cannot move along n."""
    moves = W[0, 0] > _SINGULAR * np.trace(W)
    with np.errstate(invalid="ignore"):
        mu_P = friction_threshold(W)
    return np.where(moves, np.where(mu_P < INFINITE, mu_P, np.inf), np.nan)


def _bounded(threshold: float) -> float:
    """Return a threshold of friction, infinite where it is one over rounding."""
    return threshold if threshold < INFINITE else math.inf


def _worst_impact(W: Array, mu: float, direction: tuple[float, ...]) -> Impact | None:
    """Return the impact without collision of slip at 1 m/s; None where the contact cannot slip so.

    It can where W is regular, or where it is in the plane of the normal and its one tangent. None
    also, with a notice, where the impact needs a C compiler and there is none.
    """
    rows = W.tolist()
    if spatial_mobility_faults(rows, definite=True):
        tangent = moving_tangent(rows)
        if tangent is None or not is_regular(in_plane(rows, tangent)):
            return None
    try:
        return solve_impact(rows, mu, (0.0, *direction))
    except CompilerMissing as error:
        text = f"robot: the impact of slip in the worst direction is left out: {error}"
        warnings.warn(text, PainleveWarning, stacklevel=3)
        return None
