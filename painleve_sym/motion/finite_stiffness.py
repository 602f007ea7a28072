"""The velocity jump at finite stiffness: the phases with A and B constant but not dropped."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.at.delassus import Delassus
from painleve_sym.at.inputs import inside
from painleve_sym.checks import StateLike, number
from painleve_sym.choices import EngineLike, EngineName
from painleve_sym.codegen.named_mechanisms import MechanismLike, as_mechanism
from painleve_sym.codegen.quantities import quantities
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, received
from painleve_sym.laws.catalogue import compliant_law
from painleve_sym.laws.contact_law import ContactLaw
from painleve_sym.mechanics.declarations import TIME_NAME, ParameterSet
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.motion.frozen_impact import (
    COEFFICIENTS,
    SUMS,
    FrozenEnd,
    FrozenImpacts,
    FrozenImpactSolver,
)
from painleve_sym.quantities import counted
from painleve_sym.units import Value

CONFIGURATIONS = ("frozen", "carried")
"""Coefficients of the start throughout, or moved to the mean time of the impulse of each part."""


@dataclass(frozen=True, eq=False)
class CorrectedJumps(Compared):
    """Jumps at finite stiffness; every array has the shape of the cases.

    `impacts` are those of the contact: phases, impulses, v_t and v_n at the end, how it ends.
    `velocity` are the velocities of the mechanism after the impact, by state name.
    """

    impacts: FrozenImpacts
    velocity: Mapping[str, Array]
    configuration: str


@dataclass(frozen=True)
class CorrectedJumpRule:
    """The jump rule of a mechanism with a contact law at finite stiffness; build once, use often.

    Parameters
    ----------
    mechanism : Mechanism
        With exactly one contact.
    law : ContactLaw
    engine : {"auto", "compiled", "taylor", "erk"}
        As for `Simulator`.

    Raises
    ------
    InputError
        W has rank one, as with one coordinate: A' = 0. A law with a tangential spring.

    References
    ----------
    docs/corrected-jump.md; Impact model resolution on Painlevé's paradox, section 4, for the limit
    K → ∞.
    """

    mechanism: Mechanism
    law: ContactLaw
    engine: EngineLike = EngineName.AUTO

    def __post_init__(self) -> None:
        where = f"finite-stiffness jump of {self.mechanism.name!r}"
        self.mechanism.require_one_coefficient(where, "simulate the motion with the law")
        if _rank_one(self.mechanism):
            raise InputError(
                f"{where}: its W has rank one (A' = 0), "
                "so that velocities do not determine the impulse while the contact sticks. "
                "Fix: simulate the motion with the law, or name no law for the rigid jump."
            )

    @cached_property
    def solver(self) -> FrozenImpactSolver:
        """Of the contact with constant coefficients."""
        return FrozenImpactSolver(self.law, self.engine)

    def __call__(
        self,
        state: Mapping[str, ArrayLike],
        parameters: Mapping[str, ArrayLike],
        compression: ArrayLike = 0.0,
        configuration: str = "frozen",
    ) -> CorrectedJumps:
        """Return the jumps from the states; those absent are 0, and every parameter is given.

        The contact counts as touching, or compressed by δ₀ = `compression` ≥ 0, m, with the surface
        energy K δ₀^(n+1)/(n+1). The configuration is one of `CONFIGURATIONS`.
        """
        _check_configuration("finite-stiffness jump", configuration)
        point = self._point(state, parameters)
        start = self._coefficients(point)
        inputs = (
            {name: start[name] for name in (*COEFFICIENTS, "mu")},
            {
                "slip_velocity": start["slip_velocity"],
                "compression": compression,
                "compression_rate": 0.0 - start["normal_velocity"],
            },
            {p.name: parameters[p.name] for p in self.law.parameters},
        )
        impacts = self.solver(*inputs)
        sets = (start, start)
        if configuration == "carried":
            sets = self._carried(point, start, impacts)
            inputs[0].update({name: sets[0][name] for name in COEFFICIENTS})
            impacts = self.solver(*inputs, after={name: sets[1][name] for name in COEFFICIENTS})
        return self._jumps(point, sets, impacts, configuration)

    def coefficients(
        self, state: Mapping[str, ArrayLike], parameters: Mapping[str, ArrayLike]
    ) -> dict[str, Array]:
        """Return the contact coefficients of the impact at the states.

        The keys are W_nn, W_nt, W_tt, b_n, b_t, mu, slip_velocity, normal_velocity, and by
        velocity of the mechanism ``normal`` and ``tangential`` (M⁻¹J_Nᵀ, M⁻¹J_Tᵀ) and ``free``.
        """
        return self._coefficients(self._point(state, parameters))

    def _point(
        self, state: Mapping[str, ArrayLike], parameters: Mapping[str, ArrayLike]
    ) -> dict[str, Array]:
        given, names = {**state, **parameters}, self.mechanism.outline.argument_names
        return {name: np.asarray(given.get(name, 0.0), float) for name in names}

    def _coefficients(self, point: Mapping[str, Array]) -> dict[str, Array]:
        of = Delassus.of(self.mechanism)
        single = not any(values.ndim for values in point.values())
        at, moves = of.whole_at(point) if single else of.whole_at_each(point)
        numbers = (at.W[0, 0], at.W[0, 1], at.W[1, 1], *at.b, *at.mu)
        coefficients = dict(zip((*COEFFICIENTS, "mu"), numbers, strict=True))
        coefficients |= {"slip_velocity": at.slip_velocity[0], "normal_velocity": at.gap_rate[0]}
        return coefficients | {
            "normal": moves.D[:, 0],
            "tangential": moves.D[:, 1],
            "free": moves.free,
        }

    def _moved(
        self, coefficients: Mapping[str, Array], P: Array, P_t: Array, t: Array
    ) -> list[Array]:
        """Return M⁻¹(J_Nᵀ P_n + J_Tᵀ P_t) + f t, one array per velocity."""
        c = coefficients
        rows = zip(c["normal"], c["tangential"], c["free"], strict=True)
        return [n * P + d * P_t + f * t for n, d, f in rows]

    def _jumps(
        self,
        point: Mapping[str, Array],
        sets: tuple[Mapping[str, Array], Mapping[str, Array]],
        impacts: FrozenImpacts,
        configuration: str,
    ) -> CorrectedJumps:
        parts = _halves(impacts, sets[0]["slip_velocity"] != 0)
        first, second = (
            self._moved(c, p["normal_impulse"], p["tangential_impulse"], p["duration"])
            for c, p in zip(sets, parts, strict=True)
        )
        moved = zip(self.mechanism.outline.velocity_names, first, second, strict=True)
        velocity = {name: point[name] + a + b for name, a, b in moved}
        return CorrectedJumps(impacts, velocity, configuration)

    def _carried(
        self, point: Mapping[str, Array], start: Mapping[str, Array], impacts: FrozenImpacts
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return the coefficients at the means of both parts of the impact.

        W belongs to the mean time of the impulse, T − ∫P dt/P; b to the mean time and velocities.
        """
        outline = self.mechanism.outline
        places = [c.name for c in outline.coordinates]
        now, carried = dict(point), []
        for part in _halves(impacts, start["slip_velocity"] != 0):
            t, P, P_t = part["duration"], part["normal_impulse"], part["tangential_impulse"]
            moment = part["impulse_time"]
            ratio = np.divide(P_t, P, out=np.zeros_like(P), where=P != 0)
            mean = t - np.divide(moment, P, out=np.zeros_like(P), where=P != 0)
            share = np.divide(moment, t, out=np.zeros_like(P), where=t != 0)
            by_impulse, by_time, end = dict(now), dict(now), dict(now)
            whole = self._moved(start, P, P_t, t)
            partly = self._moved(start, share, ratio * share, t / 2)
            for q, v, jump, half in zip(places, outline.velocity_names, whole, partly, strict=True):
                by_impulse[q] = now[q] + now[v] * mean
                by_time[q], by_time[v] = now[q] + now[v] * t / 2, now[v] + half
                end[q], end[v] = now[q] + (now[v] + half) * t, now[v] + jump
            if outline.depends_on_time:
                clock = now[TIME_NAME]
                by_impulse[TIME_NAME], by_time[TIME_NAME] = clock + mean, clock + t / 2
                end[TIME_NAME] = clock + t
            mobile, free = self._coefficients(by_impulse), self._coefficients(by_time)
            carried.append(mobile | {name: free[name] for name in ("b_n", "b_t", "free")})
            now = end
        return carried[0], carried[1]


def _rank_one(mechanism: Mechanism) -> bool:
    """Return `ContactCoefficients.rank_one` of the only contact."""

    def derive() -> tuple[dict[str, Any], tuple[Any, ...]]:
        from sympy import Integer

        return {"rank_one": Integer(int(mechanism.coefficients.rank_one))}, ()

    return bool(quantities("rank of W", mechanism.definition, (), derive)({})["rank_one"])


def _halves(impacts: FrozenImpacts, moving: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return time, impulses and ∫P dt of the part until the slip stops, and of the rest."""
    phase, slip = impacts.phase, impacts.phase["slip"]
    first = np.logical_and.accumulate((slip == slip[..., :1]) & moving[..., None], axis=-1)
    real = ~np.isnan(slip)
    sums_of_parts = []
    for part in (first & real, ~first & real):
        own = np.where(part, phase["normal_impulse"], 0.0)
        # The impulse of the earlier phases of this part acts throughout a phase.
        moment = phase["impulse_time"] + (np.cumsum(own, axis=-1) - own) * phase["duration"]
        sums = {name: phase[name] for name in SUMS} | {"impulse_time": moment}
        sums_of_parts.append({n: np.where(part, v, 0.0).sum(axis=-1) for n, v in sums.items()})
    return sums_of_parts[0], sums_of_parts[1]


@dataclass(frozen=True, eq=False)
class CorrectedPhase(Compared):
    """One phase of a jump at finite stiffness, such as ``reverse slip compression``.

    Duration in s, impulses in N s; δ (m) and the velocities of the contact (m/s) at its end.
    """

    name: str
    duration: float
    normal_impulse: float
    tangential_impulse: float
    compression: float
    slip_velocity: float
    normal_velocity: float


@dataclass(frozen=True, eq=False)
class CorrectedJump(Compared):
    """A jump at finite stiffness.

    Attributes
    ----------
    mechanism, law : str
        Names.
    configuration : {"frozen", "carried"}
    stiffness, exponent : float
        K (N/mⁿ) and n.
    initial_compression : float
        δ₀; m.
    end : FrozenEnd
    phases : tuple of CorrectedPhase
    velocity, velocity_before : mapping of str to float
        Of the mechanism, by state name.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> jump = ps.evaluate_corrected_jump("rod", "bilinear-hertz", state)
    >>> round(jump.velocity["y_A_dot"], 4)
    0.0949
    >>> [phase.name for phase in jump.phases]
    ['slip compression', 'sticking compression', 'sticking restitution', 'reverse slip restitution']
    """

    mechanism: str
    law: str
    configuration: str
    stiffness: float
    exponent: float
    initial_compression: float
    end: FrozenEnd
    phases: tuple[CorrectedPhase, ...]
    velocity: Mapping[str, float]
    velocity_before: Mapping[str, float]
    method: ClassVar[str] = "integration"

    def __repr__(self) -> str:
        """Return mechanism, law, duration and end in one line."""
        phases = counted(len(self.phases), "phase")
        return (
            f"CorrectedJump of {self.mechanism!r} with law {self.law!r}: {phases} "
            f"in {self.duration:.6g} s, ends in {self.end}"
        )

    @property
    def largest_compression(self) -> float:
        """Largest δ at the end of a phase; m."""
        return max([self.initial_compression, *(p.compression for p in self.phases)])

    @property
    def duration(self) -> float:
        """Of the whole impact; s."""
        return float(sum(p.duration for p in self.phases))


_law_of_name = functools.lru_cache(maxsize=64)(compliant_law)


def evaluate_corrected_jump(
    mechanism: MechanismLike,
    law: ContactLaw | str,
    state: StateLike,
    *,
    parameters: Mapping[str, Value] | None = None,
    initial_force: Value = 0.0,
    configuration: str = "frozen",
    engine: EngineLike = EngineName.AUTO,
) -> CorrectedJump:
    """Evaluate the jump at finite stiffness from one state.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
        With one contact.
    law : ContactLaw or its name
        Any, with a dashpot or without.
    state : mapping of str to float
        Coordinates and velocities by name, those absent are 0; SI units, rad. The contact counts
        as closed whatever its gap.
    parameters : mapping of str to float, optional
        Of the mechanism and of the law; those absent keep their default.
    initial_force : float
        Surface energy at the start as the force of the initial compression; N.
    configuration : {"frozen", "carried"}
    engine : {"auto", "compiled", "taylor", "erk"}

    Raises
    ------
    InputError
        Unknown or invalid entries.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> state = {"theta": 1.0, "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> jump = ps.evaluate_corrected_jump("rod", ps.laws.bilinear_hertz(E=209e9), state)
    >>> jump.duration < 2e-3
    True
    """
    mechanism = as_mechanism(mechanism)
    where = f"finite-stiffness jump of {mechanism.name!r}"
    law = _law_of_name(law) if isinstance(law, str) else law
    if not isinstance(law, ContactLaw):
        raise InputError(f"{where}: got {received(law)}, need a compliant law or its name.")
    declared = ParameterSet(*mechanism.outline.parameters, *law.parameters)
    place = inside(mechanism.at(state, parameters, declared=declared, where=where))
    start, given = place.state, place.parameters
    initial_force = number(initial_force, "initial force", where=where, unit="N", lower=0.0)
    _check_configuration(where, configuration)
    rule = CorrectedJumpRule(mechanism, law, engine)
    simulator = rule.solver.simulator
    K, n = simulator.loading_constants(
        simulator.parameters({p.name: given[p.name] for p in law.parameters})
    )
    delta = (initial_force / K) ** (1 / n)
    jump = rule(start, given, delta, configuration)
    numbers = {name: values.tolist() for name, values in jump.impacts.phase.items()}
    phases = []
    for k in range(int(jump.impacts.head["phases"])):
        of_phase = {name: values[k] for name, values in numbers.items()}
        name = _name(of_phase["slip"], of_phase["loading"], numbers["slip"][0])
        velocity = 0.0 - of_phase["compression_rate"]
        of_phase = {f: of_phase[f] for f in _PHASE_FIELDS}
        phases.append(CorrectedPhase(name=name, normal_velocity=velocity, **of_phase))
    return CorrectedJump(
        mechanism=mechanism.name,
        law=law.name,
        configuration=configuration,
        stiffness=K,
        exponent=n,
        initial_compression=delta,
        end=jump.impacts.ends[0],
        phases=tuple(phases),
        velocity={name: float(value) for name, value in jump.velocity.items()},
        velocity_before={name: start[name] for name in mechanism.outline.velocity_names},
    )


def _check_configuration(where: str, name: str) -> None:
    if name not in CONFIGURATIONS:
        known = ", ".join(CONFIGURATIONS)
        raise InputError(f"{where}: configuration: got {name!r}, need one of {known}.")


_PHASE_FIELDS = (*SUMS, "compression", "slip_velocity")


def _name(slip: float, loading: float, first: float) -> str:
    kind = "sticking" if slip == 0 else ("slip" if slip == first else "reverse slip")
    return f"{kind} {'compression' if loading else 'restitution'}"
