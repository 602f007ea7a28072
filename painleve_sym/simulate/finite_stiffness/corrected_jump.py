"""The velocity jump at finite stiffness: the three phases with A and B frozen but not dropped."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.codegen.pointwise import Pointwise
from painleve_sym.errors import InputError
from painleve_sym.laws.compliance import DELTA, DELTA_DOT, ContactLaw, without_ramps
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.simulate.finite_stiffness.frozen_impact import (
    COEFFICIENTS,
    FrozenImpacts,
    FrozenImpactSolver,
)

CONFIGURATIONS = ("frozen", "carried")
"""Coefficients of the start throughout, or moved to the mean time of the impulse of each phase."""
RESTITUTION = "e_energetic"


@dataclass(frozen=True)
class CorrectedJumps:
    """Jumps at finite stiffness; every array has the shape of the cases.

    Attributes
    ----------
    impacts : FrozenImpacts
        The contact: phases, impulses, v_t and v_n at the end, how it ends.
    velocity : mapping of str to ndarray
        Velocities of the mechanism after the impact, by state name.
    configuration : str
    """

    impacts: FrozenImpacts
    velocity: Mapping[str, Array]
    configuration: str


@dataclass(frozen=True)
class CorrectedJumpRule:
    """The jump rule of a mechanism with a contact law of the form K δⁿ; build once, use often.

    Parameters
    ----------
    mechanism : Mechanism
        With exactly one contact.
    law : ContactLaw
        Elastic or elasto-plastic: a dashpot has to be switched off (c = 0).
    engine : {"auto", "compiled", "python"}
        Of the impact; see `FrozenImpactSolver`.

    References
    ----------
    docs/corrected-jump.md; Zhao, Liu & Chen, section 4, for the limit K → ∞.
    """

    mechanism: Mechanism
    law: ContactLaw
    engine: str = "auto"

    @cached_property
    def _solver(self) -> FrozenImpactSolver:
        return FrozenImpactSolver(self.engine)

    @cached_property
    def _symbols(self) -> tuple[Any, ...]:
        return (*self.mechanism.motion, *(p.symbol for p in self.mechanism.system.parameters))

    @cached_property
    def _evaluate(self) -> Pointwise:
        c, system = self.mechanism.coefficients, self.mechanism.system
        contact = self.mechanism.contact
        normal, tangential = c.force_directions
        rows = [c.W_nn, c.W_nt, c.W_tt, c.b_n, c.b_t, c.mu]
        rows += [contact.slip_velocity, contact.gap_rate]
        rows += [*normal, *tangential, *system.free_acceleration]
        engine = "casadi" if self.engine == "python" else "auto"
        return Pointwise(rows, self._symbols, engine=engine)

    def __call__(
        self,
        state: Mapping[str, ArrayLike],
        parameters: Mapping[str, ArrayLike],
        compression: ArrayLike = 0.0,
        configuration: str = "frozen",
    ) -> CorrectedJumps:
        """Return the jumps from the states.

        The contact counts as touching, or compressed by δ₀ = `compression`.

        Parameters
        ----------
        state : mapping of str to float or ndarray
            Coordinates and velocities; absent ones are 0.
        parameters : mapping of str to float or ndarray
            Every parameter of the mechanism and of the law.
        compression : float or ndarray
            δ₀ ≥ 0; m. Its surface energy is K δ₀^(n+1)/(n+1).
        configuration : {"frozen", "carried"}
        """
        if configuration not in CONFIGURATIONS:
            raise InputError(
                f"corrected jump: configuration: got {configuration!r}, need one of "
                f"{', '.join(CONFIGURATIONS)}."
            )
        point = self._point(state, parameters)
        law: dict[str, ArrayLike] = {**self.law_inputs(parameters), "compression": compression}
        if np.any(law.pop("dashpot")):
            raise InputError(
                f"corrected jump with law {self.law.name!r}: no closed form with a dashpot. "
                "Fix: set its damping to 0, or use evaluate_corrected_jump, which integrates."
            )
        start = self._coefficients(point)
        impacts = self._impacts(start, start, start, law)
        if configuration == "frozen":
            return self._jumps(point, (start, start), impacts, configuration)
        sets = self._carried(point, (start, start), impacts)
        impacts = self._impacts(start, *sets, law)
        return self._jumps(point, sets, impacts, configuration)

    @cached_property
    def _law_constants(self) -> Pointwise:
        symbols = [p.symbol for p in self.law.parameters]
        rest = {DELTA: sp.Integer(1), DELTA_DOT: sp.Integer(0)}
        force = without_ramps(self.law.loading.force)
        dashpot = force.subs({**rest, DELTA_DOT: sp.Integer(1)}) - force.subs(rest)
        rows = [self.law.stiffness, self.law.exponent, dashpot]
        for symbol, value in reversed(list(self.law.definitions.items())):
            rows = [sp.sympify(row).subs(symbol, value) for row in rows]
        return Pointwise(rows, symbols, engine="casadi")

    def law_inputs(self, parameters: Mapping[str, ArrayLike]) -> dict[str, Array]:
        """Return K, n, e of the law and its ``dashpot``, the force it adds at δ = δ̇ = 1."""
        values = {p.symbol: np.asarray(parameters[p.name], float) for p in self.law.parameters}
        K, n, dashpot = self._law_constants(values)
        e = next((v for s, v in values.items() if str(s) == RESTITUTION), np.ones(()))
        return {"K": K, "n": n, "e": e, "dashpot": dashpot}

    def coefficients(
        self, state: Mapping[str, ArrayLike], parameters: Mapping[str, ArrayLike]
    ) -> dict[str, Array]:
        """Return what the impact needs of the mechanism at the states.

        The keys are W_nn, W_nt, W_tt, b_n, b_t, mu, slip_velocity, normal_velocity, and by
        velocity of the mechanism ``normal`` and ``tangential`` (M⁻¹J_Nᵀ, M⁻¹J_Tᵀ) and ``free``.
        """
        return self._coefficients(self._point(state, parameters))

    def _point(
        self, state: Mapping[str, ArrayLike], parameters: Mapping[str, ArrayLike]
    ) -> dict[Any, Array]:
        given = {**state, **parameters}
        return {s: np.asarray(given.get(str(s), 0.0), float) for s in self._symbols}

    def _coefficients(self, point: Mapping[Any, Array]) -> dict[str, Array]:
        rows = self._evaluate(point)
        size = len(self.mechanism.system.q_dot)
        names = (*COEFFICIENTS, "mu", "slip_velocity", "normal_velocity")
        found = dict(zip(names, rows, strict=False))
        for k, name in enumerate(("normal", "tangential", "free")):
            found[name] = rows[8 + k * size : 8 + (k + 1) * size]
        return found

    def _impacts(
        self,
        start: Mapping[str, Array],
        before: Mapping[str, Array],
        after: Mapping[str, Array],
        law: Mapping[str, ArrayLike],
    ) -> FrozenImpacts:
        inputs: dict[str, ArrayLike] = {name: before[name] for name in COEFFICIENTS}
        inputs |= {f"{name}_after": after[name] for name in COEFFICIENTS}
        rate = 0.0 - start["normal_velocity"]
        contact = {"mu": start["mu"], "slip_velocity": start["slip_velocity"]}
        return self._solver(**inputs, **contact, compression_rate=rate, **law)

    def _moved(
        self, coefficients: Mapping[str, Array], P: Array, P_t: Array, t: Array
    ) -> list[Array]:
        """Return M⁻¹(J_Nᵀ P_n + J_Tᵀ P_t) + f t, one array per velocity."""
        c = coefficients
        rows = zip(c["normal"], c["tangential"], c["free"], strict=True)
        return [n * P + d * P_t + f * t for n, d, f in rows]

    def _jumps(
        self,
        point: Mapping[Any, Array],
        sets: tuple[Mapping[str, Array], Mapping[str, Array]],
        impacts: FrozenImpacts,
        configuration: str,
    ) -> CorrectedJumps:
        parts = _halves(impacts, sets[0]["slip_velocity"] != 0)
        velocity = {}
        moved = [
            self._moved(c, p["normal_impulse"], p["tangential_impulse"], p["duration"])
            for c, p in zip(sets, parts, strict=True)
        ]
        for k, symbol in enumerate(self.mechanism.system.q_dot):
            velocity[str(symbol)] = point[symbol] + moved[0][k] + moved[1][k]
        return CorrectedJumps(impacts, velocity, configuration)

    def _carried(
        self,
        point: Mapping[Any, Array],
        sets: tuple[Mapping[str, Array], Mapping[str, Array]],
        impacts: FrozenImpacts,
    ) -> tuple[dict[str, Array], dict[str, Array]]:
        """Return the coefficients at the means of both parts of the impact.

        W belongs to the mean time of the impulse, T − ∫P dt/P; b to the mean time and velocities.
        """
        system = self.mechanism.system
        now, found = dict(point), []
        for coefficients, part in zip(
            sets, _halves(impacts, sets[0]["slip_velocity"] != 0), strict=True
        ):
            t, P, P_t = part["duration"], part["normal_impulse"], part["tangential_impulse"]
            moment = part["impulse_time"]
            ratio = np.divide(P_t, P, out=np.zeros_like(P), where=P != 0)
            mean = t - np.divide(moment, P, out=np.zeros_like(P), where=P != 0)
            share = np.divide(moment, t, out=np.zeros_like(P), where=t != 0)
            by_impulse, by_time, end = dict(now), dict(now), dict(now)
            whole = self._moved(coefficients, P, P_t, t)
            partly = self._moved(coefficients, share, ratio * share, t / 2)
            for q, v, jump, half in zip(system.q, system.q_dot, whole, partly, strict=True):
                by_impulse[q] = now[q] + now[v] * mean
                by_time[q], by_time[v] = now[q] + now[v] * t / 2, now[v] + half
                end[q], end[v] = now[q] + (now[v] + half) * t, now[v] + jump
            for clock in system.clock:
                if clock in now:
                    by_impulse[clock], by_time[clock] = now[clock] + mean, now[clock] + t / 2
                    end[clock] = now[clock] + t
            mobile, free = self._coefficients(by_impulse), self._coefficients(by_time)
            found.append(mobile | {name: free[name] for name in ("b_n", "b_t", "free")})
            now = end
        return found[0], found[1]


def _halves(impacts: FrozenImpacts, moving: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Return time, impulses and ∫P dt of the part until the slip stops, and of the rest."""
    phase = {name: np.nan_to_num(values) for name, values in impacts.phase.items()}
    slip, real = impacts.phase["slip"], ~np.isnan(impacts.phase["slip"])
    first = np.logical_and.accumulate((slip == slip[..., :1]) & moving[..., None], axis=-1)
    found = []
    for part in (first & real, ~first & real):
        own = np.where(part, phase["normal_impulse"], 0.0)
        # The impulse of the earlier phases of this part acts throughout a phase.
        moment = phase["impulse_time"] + (np.cumsum(own, axis=-1) - own) * phase["duration"]
        sums = {n: phase[n] for n in ("duration", "normal_impulse", "tangential_impulse")}
        sums["impulse_time"] = moment
        found.append({n: np.where(part, v, 0.0).sum(axis=-1) for n, v in sums.items()})
    return found[0], found[1]
