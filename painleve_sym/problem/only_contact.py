"""Numbers of each contact of a problem, the others open, and scalars of its only one."""

from __future__ import annotations

from functools import cached_property
from typing import Self

import numpy as np

from painleve_sym.checks import checked_number
from painleve_sym.errors import InputError
from painleve_sym.problem.coefficients import NormalCoefficients
from painleve_sym.problem.risk import slip_slope
from painleve_sym.problem.statement import STATED, Statement, is_brake


class OnlyContact(Statement):
    """Problem whose one contact has scalars: W_nn, W_nt, ... in the plane, A, B, A_stick, B_stick.

    Each of them raises InputError for several contacts.
    """

    @cached_property
    def coefficients(self) -> tuple[NormalCoefficients, ...]:
        """A, B, critical friction and more of each contact, the others open.

        With the first ball of friction of each.

        Raises
        ------
        InputError
            For a `Brake`, which has no normal row.
        """
        return tuple(map(self.coefficients_of, range(self.size)))

    def coefficients_of(
        self, i: int, sticking: tuple[float, float] | None = None
    ) -> NormalCoefficients:
        """Return the `coefficients` of one contact.

        Parameters
        ----------
        i : int
            Its index.
        sticking : tuple of float, optional
            A′ and B′ where they are known more exactly than from W and b; 1/kg and m/s².
        """
        own = self.friction[i]
        if is_brake(own):
            raise InputError(
                f"coefficients belong to contacts with a normal row: got {own[0]!r}. "
                "Fix: leave it out."
            )
        ball = own[0] if own else None
        tangents, mu = (ball.n_tangents, ball.mu) if ball else (0, 0.0)
        rows = list(self.rows[i][: 1 + tangents])
        W, b = self.W[np.ix_(rows, rows)], self.b[rows]
        return NormalCoefficients.of(W, b, mu, self.slips[i][:tangents], sticking)

    @classmethod
    def single(
        cls,
        W_nn: float,
        W_nt: float,
        W_tt: float,
        b_n: float,
        b_t: float,
        mu: float,
        slip_velocity: float,
        bilateral: bool = False,
    ) -> Self:
        """State the problem of one contact by its scalars.

        Parameters
        ----------
        W_nn, W_nt, W_tt : float
            Mobility, in 1/kg.
        b_n, b_t : float
            Accelerations without contact force, in m/s². b_n is B of the paradox literature.
        mu : float
            Friction coefficient, >= 0.
        slip_velocity : float
            v_t in m/s; exactly 0 means at rest tangentially.
        bilateral : bool
            Whether the contact holds from both sides.
        """
        given = {"W_nn": W_nn, "W_nt": W_nt, "W_tt": W_tt, "b_n": b_n, "b_t": b_t}
        faults, values = [], []
        for name, value in (given | {"mu": mu, "slip_velocity": slip_velocity}).items():
            number, fault = checked_number(value, name)
            values.append(number)
            if fault:
                faults.append(f"{fault} Fix: check the state it was evaluated at.")
        if faults:
            raise InputError(STATED + " Also, ".join(faults))
        nn, nt, tt, n, t, friction, slip = values
        return cls(
            np.array([[nn, nt], [nt, tt]]),
            np.array([n, t]),
            np.array([friction]),
            np.array([slip]),
            np.array([bilateral]),
        )

    def alone(self, i: int) -> Self:
        """Return the problem of one contact, the others open."""
        own, one = list(self.rows[i]), slice(i, i + 1)
        W, b = self.W[np.ix_(own, own)], self.b[own]
        slip = [self.slips[i]]
        return type(self)(W, b, list(self.friction[one]), slip, self.bilateral[one])

    @property
    def W_nn(self) -> float:
        """Return the normal mobility of the only contact, in 1/kg."""
        return float(self._only("W_nn").W[0, 0])

    @property
    def W_nt(self) -> float:
        """Return the coupling of the only contact, in 1/kg."""
        return float(self._only("W_nt").W[0, 1])

    @property
    def W_tt(self) -> float:
        """Return the tangential mobility of the only contact, in 1/kg."""
        return float(self._only("W_tt").W[1, 1])

    @property
    def b_n(self) -> float:
        """Return the free normal acceleration of the only contact, in m/s²."""
        return float(self._only("b_n").b[0])

    @property
    def b_t(self) -> float:
        """Return the free tangential acceleration of the only contact, in m/s²."""
        return float(self._only("b_t").b[1])

    @property
    def slip_direction(self) -> int:
        """Return the sign of v_t of the only contact: -1, 0 or +1."""
        return self._only("slip_direction").slip_directions[0]

    def A_slip(self, direction: int, side: int = 1) -> float:
        """Return ``A = W_nn - mu s W_nt`` of ``a_n = A F_n + B`` while slipping along s.

        A value within rounding of its two terms is returned as exactly 0, since its sign, and with
        it the case, would be an accident.

        Parameters
        ----------
        direction : int
            s = +1 for v_t > 0, -1 for v_t < 0.
        side : int
            The sign of F_n; -1 (``A = W_nn + mu s W_nt``) is possible for a bilateral contact only.

        Raises
        ------
        InputError
            For another direction. Fix: pass +1 or -1.
        """
        if direction not in (-1, 1):
            raise InputError(
                f"A_slip is not defined, direction: got {direction!r}, need +1 or -1. "
                "Fix: pass the sign of the slip velocity."
            )
        return float(slip_slope(self._only("A_slip").W, self.mu.item(), [direction], side))

    @property
    def A(self) -> float:
        """A of the only contact in slip with F_n > 0, in 1/kg; see `NormalCoefficients`."""
        return self._own.A

    @property
    def B(self) -> float:
        """B = b_n of the only contact, in m/s²."""
        return self._own.B

    @property
    def A_stick(self) -> float:
        """A' of ``a_n = A' F_n + B'`` of the only contact in sticking, in 1/kg.

        In the plane W_nn - W_nt²/W_tt; W_nn where no motion slides the contact.
        """
        return self._own.A_stick

    @property
    def B_stick(self) -> float:
        """B' of the same, in m/s²; b_n where no motion slides the contact."""
        return self._own.B_stick

    @property
    def _own(self) -> NormalCoefficients:
        if self.size != 1:
            raise InputError(
                f"A, B, A_stick and B_stick belong to one contact: got {self._described}. "
                "Fix: use coefficients."
            )
        return self.coefficients[0]

    def _only(self, name: str) -> Self:
        """Return this problem, or raise InputError where it is not one contact in the plane."""
        if self.size != 1 or not self.in_plane:
            raise InputError(
                f"{name} belongs to one contact in the plane: got {self._described}. "
                "Fix: use the arrays W, b, mu and slip_velocity."
            )
        return self

    @property
    def _described(self) -> str:
        contacts = "one contact" if self.size == 1 else f"{self.size} contacts"
        return contacts if self.in_plane else f"{contacts}, not with the rows n, t"
