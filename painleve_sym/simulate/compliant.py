"""Softened motion: one frictional contact with a force–compression law, over generated modes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from sympy import Symbol

from painleve_sym.arrays import Array
from painleve_sym.codegen.evaluate import power
from painleve_sym.codegen.quantities import Quantities, quantities
from painleve_sym.contacts.compliant import SoftenedContact
from painleve_sym.errors import InputError
from painleve_sym.laws.compliance import ContactLaw
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.simulate.scales import compliant_scales
from painleve_sym.simulate.simulator import ContactSimulator
from painleve_sym.simulate.trajectory import Trajectory

INITIAL_FORCE = Symbol("initial_force", positive=True)


@dataclass(frozen=True)
class SoftenedSimulator(ContactSimulator):
    """A mechanism with a contact law, ready to run; build once, run often.

    Parameters
    ----------
    mechanism : Mechanism
        With exactly one contact.
    law : ContactLaw
    engine : {"auto", "compiled", "taylor", "erk"}
        ``auto``: compiled code, or CasADi's ``erk`` with a notice where there is no compiler.
    """

    mechanism: Mechanism
    law: ContactLaw
    engine: str = "auto"

    @cached_property
    def contact(self) -> SoftenedContact:
        """Mechanism and law joined."""
        return SoftenedContact(self.mechanism, self.law)

    @property
    def label(self) -> str:
        """Name of the law."""
        return self.law.name

    @property
    def choices(self) -> dict[str, str]:
        """Named choices of the law."""
        return dict(self.law.choices)

    def compression_of_force(self, force: float, parameters: Mapping[str, float]) -> float:
        """Return δ₀ > 0 with F_n(δ₀) = `force` on the loading curve at rest; m.

        The initial surface energy of the paper, (10), is given this way.
        """
        if not (np.isfinite(force) and force >= 0):
            raise InputError(f"{self.where}: initial force: got {force!r}, need >= 0 and finite.")
        k, n = self._curve(parameters)
        return float((force / k) ** (1 / n))

    def start_expressions(self, forced: bool) -> dict[Any, Any]:
        """Return the start values that follow from other ones; see `ContactSimulator`."""
        known = super().start_expressions(forced)
        if not forced:
            return known
        depth = (INITIAL_FORCE / self.law.stiffness) ** (1 / self.law.exponent)
        return known | {self.contact.gap: -depth}

    def surface_energy(self, depth: float, parameters: Mapping[str, float]) -> float:
        """Return the initial surface energy (10) of a compression δ₀ ≥ 0, K δ₀^(n+1)/(n+1); J.

        The whole work of the loading curve. Of it an elasto-plastic law counts e² as stored.
        """
        if not (np.isfinite(depth) and depth >= 0):
            raise InputError(f"{self.where}: compression: got {depth!r}, need >= 0 and finite.")
        k, n = self._curve(parameters)
        return float(k * depth ** (n + 1) / (n + 1))

    def _curve(self, parameters: Mapping[str, float]) -> tuple[float, float]:
        values = {s: np.array([v]) for s, v in self.constants(parameters).items()}
        k, n = self.loading_curve(values)
        return float(k[0]), float(n[0])

    def run(
        self,
        state: Mapping[str, float],
        *,
        parameters: Mapping[str, float] | None = None,
        initial_force: float | None = None,
        **options: Any,
    ) -> Trajectory:
        """Integrate the softened motion from t = 0.

        Parameters
        ----------
        state : mapping of str to float
            Coordinates and velocities; absent ones are 0. A negative gap is a compression.
        parameters : mapping of str to float
            Of mechanism and law; absent ones have their defaults.
        initial_force : float
            Sets the initial compression so that the contact carries this force; N. Where the gap
            is no coordinate, the coordinates stay and the surface counts as raised by it.
        t_end : float
            s, > 0.
        until : str or tuple of str
            Kinds of events that end the run.
        rtol : float
        atol : ndarray, shape (nx,)
            Per state; by default scaled to the contact (see `tolerances`).
        record : {"dense", "events", "end"}
        **options
            Those from t_end on, and first_step, max_step, max_steps, max_events (`RunOptions`).

        Returns
        -------
        Trajectory
            Also when it stopped early: `stop_reason` says why.

        Raises
        ------
        InputError
            Unknown names, numbers out of range, a start outside the domain.
        """
        vector, values = self.start(state, parameters)
        vector = self.checked_start(vector, values, initial_force)
        checked = self.options(vector, values, **options)
        raw = self.integrator.run(vector, self._vector_of(values), checked)
        return self.trajectory(raw, values, checked.rtol)

    def checked_start(self, vector: Array, values: Mapping[str, float], force: Any) -> Array:
        """Return the start vector, compressed so that it carries `force` where that is given."""
        if force is None:
            return vector
        self.compression_of_force(force, values)  # checks the force
        constants = self.integrator.constants(self._vector_of(values))
        compressed: Array = self.with_forces(vector[None], np.array([force]), constants[None])[0]
        return compressed

    def with_forces(self, vectors: Array, forces: Array, constants: Array) -> Array:
        """Return states (n, nx) compressed so that the contact carries the forces (n,); N."""
        index = self.contact.states.index(self.contact.gap)
        gaps = vectors[:, index]
        if gaps.any():
            raise InputError(
                f"{self.where}: initial_force: got a start with gap "
                f"{float(gaps[gaps != 0][0])!r}, need 0. Fix: give the force or the compression, "
                "not both."
            )
        given = (*self.outline.parameters, *self.outline.definitions)
        k, n = self.loading_curve(dict(zip(given, constants.T, strict=True)))
        compressed = vectors.copy()
        compressed[:, index] = -power(forces / k, 1 / n)
        return compressed

    def is_compliant(self, i: int) -> bool:
        """Whether a contact may start compressed."""
        return True

    def contact_scales(
        self, i: int, values: Mapping[Any, Array], numbers: Mapping[str, Array]
    ) -> tuple[Array, ...]:
        """Return the scales of gap (m), gap rate (m/s) and the energy (J) of a contact."""
        return compliant_scales(numbers, values[self.contact.gap], *self.loading_curve(values))

    def loading_curve(self, values: Mapping[Any, Array]) -> tuple[Array, Array]:
        """Return K and n of the law's loading curve K δⁿ, each of shape (n,)."""
        found = self._loading.at(values)
        return found["stiffness"], found["exponent"]

    @cached_property
    def _loading(self) -> Quantities:
        law, symbols = self.law, (*self.outline.parameters, *self.outline.definitions)
        return quantities(
            "loading curve",
            self.contact,
            symbols,
            lambda: {"stiffness": law.stiffness, "exponent": law.exponent},
        )
