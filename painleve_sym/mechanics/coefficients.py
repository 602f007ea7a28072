"""Delassus matrix and the coefficients A, B of slip and of sticking."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from painleve_sym.errors import InputError
from painleve_sym.mechanics.contact import Contact
from painleve_sym.mechanics.simplify import readable

F_N = sp.Symbol("F_n", nonnegative=True)
F_T = sp.Symbol("F_t", real=True)


@dataclass(frozen=True)
class ContactCoefficients:
    """Accelerations of one contact as functions of its forces, a = W F + b.

    In the plane g̈_N = W_nn F_n + W_nt F_t + b_n and v̇_t = W_nt F_n + W_tt F_t + b_t. What has the
    letter t or a slip direction s is of the plane; `W` and `b` are of any number of tangents.

    Parameters
    ----------
    contact : Contact

    References
    ----------
    Impact model resolution on Painlevé's paradox, (1)–(3) and (19).

    Examples
    --------
    >>> import painleve_sym as ps
    >>> coefficients = ps.models.rod().coefficients
    >>> coefficients.A()
    (3*(-mu*sin(theta) + cos(theta))*cos(theta) + 1)/m
    """

    contact: Contact

    @property
    def _J_T(self) -> sp.Matrix:
        """J_T of the only tangent."""
        contact = self.contact
        if contact.n_tangents > 1:
            raise InputError(
                f"contact {contact.name!r} has {contact.n_tangents} tangents, and this coefficient "
                "is that of one. Fix: use W and b."
            )
        return contact.J_T

    @property
    def free_acceleration(self) -> sp.Matrix:
        """M⁻¹ h: q̈ without contact forces, shape (n, 1)."""
        return self.contact.system.free_acceleration

    def _delassus(self, left: sp.Matrix, right: sp.Matrix) -> sp.Expr:
        return readable((left * self.contact.system.inverse_mass_matrix * right.T)[0])

    @cached_property
    def W(self) -> sp.Matrix:
        """Mobility J M⁻¹ Jᵀ, rows n and tangents; 1/kg."""
        J = self.contact.J
        rows = [J[i, :] for i in range(J.rows)]
        upper = [[self._delassus(left, right) for right in rows[i:]] for i, left in enumerate(rows)]
        return sp.Matrix(J.rows, J.rows, lambda i, k: upper[min(i, k)][abs(i - k)])

    @cached_property
    def b(self) -> sp.Matrix:
        """Accelerations without contact forces, rows n and tangents, as a column; m/s²."""
        free = self.contact.J * self.free_acceleration
        return (free + self.contact.biases).applyfunc(readable)

    @cached_property
    def W_nn(self) -> sp.Expr:
        """J_N M⁻¹ J_Nᵀ; 1/kg."""
        return self._delassus(self.contact.J_N, self.contact.J_N)

    @cached_property
    def W_nt(self) -> sp.Expr:
        """J_N M⁻¹ J_Tᵀ; 1/kg."""
        return self._delassus(self.contact.J_N, self._J_T)

    @cached_property
    def W_tt(self) -> sp.Expr:
        """J_T M⁻¹ J_Tᵀ; 1/kg."""
        return self._delassus(self._J_T, self._J_T)

    @cached_property
    def b_n(self) -> sp.Expr:
        """Normal acceleration without contact forces; m/s²."""
        free = (self.contact.J_N * self.free_acceleration)[0]
        return readable(free + self.contact.normal_bias)

    @cached_property
    def b_t(self) -> sp.Expr:
        """Tangential acceleration without contact forces; m/s²."""
        free = (self._J_T * self.free_acceleration)[0]
        return readable(free + self.contact.tangential_bias)

    @cached_property
    def drive_speeds(self) -> tuple[sp.Expr, sp.Expr]:
        """d(T + V)/dt per unit of F_n and of F_t, less v_n and v_t; m/s.

        How fast what moves as prescribed moves along the forces: −∂g_N/∂t and the surface's speed,
        and what a driven pivot or frame adds by its momenta, (∂T/∂q̇ at q̇ = 0)ᵀ M⁻¹ Jᵀ. A force
        times it is the power of the drive.
        """
        contact = self.contact
        normal, tangential = -contact.gap_drift, contact.surface_speed
        momenta = contact.system.still_momenta
        if any(momenta):
            along = [(momenta.T * direction)[0] for direction in self.force_directions]
            normal, tangential = readable(normal + along[0]), readable(tangential + along[1])
        return normal, tangential

    @property
    def mu(self) -> sp.Symbol:
        """Friction coefficient μ."""
        return self.contact.mu

    def A(self, slip: int = -1, friction: sp.Expr | None = None) -> sp.Expr:
        """Return A_s = W_nn − μ s W_nt for slip direction s = sign(v_t); 1/kg.

        Parameters
        ----------
        slip : int
            s.
        friction : sympy.Expr, optional
            In place of μ.
        """
        return self._in_slip(self.W_nn, self.W_nt, slip, friction)

    @property
    def B(self) -> sp.Expr:
        """B = b_n, the free normal acceleration; m/s²."""
        return self.b_n

    def slip_rate_coefficient(self, slip: int = -1, friction: sp.Expr | None = None) -> sp.Expr:
        """Return C_s = W_nt − μ s W_tt, so that v̇_t = C_s F_n + b_t in slip; 1/kg.

        The arguments are those of `A`.
        """
        return self._in_slip(self.W_nt, self.W_tt, slip, friction)

    def _in_slip(
        self, normal: sp.Expr, tangential: sp.Expr, slip: int, friction: sp.Expr | None
    ) -> sp.Expr:
        """Return what a unit of F_n and its friction give together, derived once."""
        key = normal, tangential, slip, friction
        if key not in self._derived:
            mu = self.mu if friction is None else friction
            self._derived[key] = readable(normal - slip * mu * tangential)
        return self._derived[key]

    @cached_property
    def _derived(self) -> dict[tuple[sp.Expr, sp.Expr, int, sp.Expr | None], sp.Expr]:
        return {}

    @property
    def slides(self) -> bool:
        """Whether any motion slides the contact, W_tt ≠ 0; else sticking holds nothing."""
        return bool(self.W_tt != 0)

    @property
    def sticking_ratio(self) -> sp.Expr:
        """F_t per F_n that keeps v_t, −W_nt/W_tt; 0 where no motion slides the contact."""
        return -self.W_nt / self.W_tt if self.slides else sp.Integer(0)

    @cached_property
    def sticking_force(self) -> sp.Expr:
        """F_t(F_n) that keeps v̇_t = 0; N. Sticking needs |F_t| ≤ μ F_n."""
        if not self.slides:
            return sp.Integer(0)
        return readable(-(self.W_nt * F_N + self.b_t) / self.W_tt)

    @cached_property
    def A_stick(self) -> sp.Expr:
        """A′ = W_nn − W_nt²/W_tt; 1/kg."""
        if not self.slides:
            return self.W_nn
        return readable(self.W_nn - self.W_nt**2 / self.W_tt)

    @property
    def rank_one(self) -> bool:
        """Whether A′ = 0: gap and slip velocity are tied, and sticking carries any force."""
        return bool(self.A_stick == 0)

    @cached_property
    def B_stick(self) -> sp.Expr:
        """B′ = b_n − W_nt b_t/W_tt; m/s²."""
        if not self.slides:
            return self.b_n
        return readable(self.b_n - self.W_nt * self.b_t / self.W_tt)

    def slip_force(self, slip: int = -1) -> sp.Expr:
        """Return F_n* = −B/A_s, with which the contact slides at constant gap; N."""
        return -self.B / self.A(slip)

    @cached_property
    def stick_force(self) -> sp.Expr:
        """F_n = −B′/A′, with which the contact sticks at constant gap; N."""
        return -self.B_stick / self.A_stick

    @cached_property
    def force_directions(self) -> tuple[sp.Matrix, sp.Matrix]:
        """M⁻¹J_Nᵀ and M⁻¹J_Tᵀ: acceleration per unit F_n and per unit F_t; shapes (n, 1)."""
        inverse = self.contact.system.inverse_mass_matrix
        normal = (inverse * self.contact.J_N.T).applyfunc(readable)
        return normal, (inverse * self._J_T.T).applyfunc(readable)

    @cached_property
    def accelerations(self) -> sp.Matrix:
        """q̈ as a function of state, F_n and F_t, shape (n, 1)."""
        normal, tangential = self.force_directions
        return self.free_acceleration + normal * F_N + tangential * F_T
