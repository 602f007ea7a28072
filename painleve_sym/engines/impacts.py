"""Impacts of several contacts in compiled code: their path by itself, and what a run tells of them.

The layouts are those of ``loop/impulse.c`` and ``loop/impact.c``, whose numbers are all doubles.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from painleve_sym.arrays import Array
from painleve_sym.choices import ImpactFriction, ImpactFrictionLike, chosen
from painleve_sym.codegen.compile import load as compiled
from painleve_sym.contact_rows import ContactRows
from painleve_sym.engines.c_texts import engine_texts
from painleve_sym.engines.listening import listening
from painleve_sym.engines.simultaneous import (
    AtOnce,
    ImpulsePiece,
    PathEvent,
    PathRecord,
    SimultaneousImpact,
    Straight,
)
from painleve_sym.errors import InputError
from painleve_sym.laws.restitution import Measure, RestitutionLaw, check_final_slip
from painleve_sym.problem.array_checks import finite_array
from painleve_sym.problem.complementarity.solution_sets import BoolArray
from painleve_sym.problem.impact.inputs import impact_inputs
from painleve_sym.problem.impact.one_contact import ImpactEnd

COURSE, STEP, STRUCK, CLOSED = range(4)
"""What a listener hears, as the enumeration in ``loop/impulse.c``."""
STRAIGHT, _AT_ONCE, WEIGHS = range(3)
ENDS = ("border", "energy", "slip", "spent")
MEASURES = tuple(Measure)

_LIBRARY = """
#include <math.h>
#include <string.h>
#define PS_MIN(a, b) ((a) < (b) ? (a) : (b))
#define PS_MAX(a, b) ((a) > (b) ? (a) : (b))
#define PS_RIGID {}
{}
__attribute__((visibility("default"))) int ps_impact(
    const double *W, const double *mu, const double *v, const int *held, const double *pressing,
    const double *e, int measure, int power, int final_slip, double *velocity, double *impulse,
    double *work, ps_listener listener) {{
  return follow_impact(PS_RIGID, W, mu, v, held, pressing, measure, power, final_slip, e, velocity,
                       impulse, work, listener);
}}
"""


def doubles(*fields: str | tuple[str, int | tuple[int, ...]]) -> np.dtype[Any]:
    """Return the type of a C structure of doubles: names of numbers, and of arrays with shapes."""
    return np.dtype([(f, float) if isinstance(f, str) else (f[0], float, f[1]) for f in fields])


def read(kind: np.dtype[Any], address: int) -> Any:
    """Return a copy of a C structure of doubles."""
    return np.frombuffer(ctypes.string_at(address, kind.itemsize), kind)[0]


class PathReader:
    """Reader of the path of an impact of at most `rigid` contacts."""

    def __init__(self, rigid: int) -> None:
        rows = ContactRows(rigid).size
        vectors = ("fixed", "v", "push", "rates", "after")
        numbers = ("budget", "budget_after", "compresses", "rubs")
        self._course = doubles(
            *("n", "mass", "speed", ("W", (rows, rows))),
            *(("mu", rigid), ("v", rows), ("border", rigid)),
        )
        self._step = doubles(
            *("kind", "length", "end", "contact", "work", "alone", "unknowns"),
            *(("row", rows), ("e", rigid), ("column", (rows, rows))),
            *((name, rows) for name in vectors),
            *((name, rigid) for name in numbers),
        )
        self._steps: list[Any] = []
        self._begun: Any = None

    def __call__(self, kind: int, address: int, state: Array) -> None:
        """Take over a beginning or a step."""
        if kind == COURSE:
            self._begun, self._steps = read(self._course, address), []
        elif kind == STEP:
            self._steps.append(read(self._step, address))

    def path(self, bilateral: BoolArray, law: RestitutionLaw, e: Array) -> PathRecord:
        """Return the last path; e of each contact."""
        begun = self._begun
        n = int(begun["n"])
        size = ContactRows(n).size
        return PathRecord(
            W=begun["W"][:size, :size],
            mu=begun["mu"][:n],
            velocity=begun["v"][:size],
            border=begun["border"][:n],
            bilateral=bilateral,
            law=law,
            e=e,
            mass=int(begun["mass"]),
            speed=int(begun["speed"]),
            steps=tuple(_step(step, n, size) for step in self._steps),
        )


def _step(step: Any, n: int, size: int) -> Straight | AtOnce:
    unknowns = int(step["unknowns"])
    rows = tuple(int(row) for row in step["row"][:unknowns])
    columns = step["column"][:size, :unknowns]
    v, push, rates = (step[name][:size] for name in ("v", "push", "rates"))
    if step["kind"] != STRAIGHT:
        return AtOnce(
            weighs=step["kind"] == WEIGHS,
            e=None if np.isnan(step["e"][0]) else step["e"][:n],
            velocities=v,
            impulses=push,
            rates=rates,
            rows=rows,
            columns=columns,
        )
    end = PathEvent(float(step["length"]), ENDS[int(step["end"])], int(step["contact"]))
    return Straight(
        fixed=step["fixed"][:size],
        columns=columns,
        rows=rows,
        velocities=v,
        budget=step["budget"][:n],
        push=push,
        rates=rates,
        compresses=step["compresses"][:n] != 0,
        rubs=step["rubs"][:n] != 0,
        event=end,
        velocities_after=step["after"][:size],
        budget_after=step["budget_after"][:n],
        work_after=float(step["work"]),
        alone=bool(step["alone"]),
    )


@cache
def _impact(contacts: int) -> Callable[..., int]:
    parts = engine_texts("loop/rows", "loop/linear", "loop/problem", "loop/impulse")
    impact: Any = compiled(_LIBRARY.format(contacts, "\n".join(parts))).ps_impact
    address = ctypes.c_void_p
    impact.argtypes = (*[address] * 6, *[ctypes.c_int] * 3, *[address] * 4)
    return impact  # type: ignore[no-any-return]


def solve_simultaneous_impact(
    W: Array,
    mu: Array,
    velocity: Array,
    restitution: RestitutionLaw | str = "energetic",
    e: ArrayLike = 0.75,
    *,
    impact_friction: ImpactFrictionLike = ImpactFriction.PATH,
    load: Array | None = None,
    bilateral: BoolArray | None = None,
) -> SimultaneousImpact:
    """Return the impact of n closed contacts; with one contact it is that of `solve_impact`.

    Parameters
    ----------
    W : ndarray, shape (2 n, 2 n)
        J M⁻¹ Jᵀ with rows as in `ContactRows`; positive semidefinite; 1/kg.
    mu : ndarray, shape (n,)
        Friction coefficients.
    velocity : ndarray, shape (2 n,)
        v_n, v_t of each contact, v_n ≤ 0, and 0 of a bilateral one; exactly 0 means at rest. With
        all v_n = 0 the impact without collision is meant; m/s.
    restitution : RestitutionLaw, or its name, one of {"energetic", "poisson", "newton"}
        The first two never add energy over ground at rest, Newton's can; `notice` says so.
    e : float, or array_like of shape (n,)
        Coefficient of restitution of all contacts, or of each, in [0, 1].
    impact_friction : ImpactFriction or its text
        Which slip friction opposes: that of each moment along the ``path`` of the impulse, or the
        ``final_slip`` alone, 0 ≤ P_n ⟂ v_n⁺ + e v_n⁻ ≥ 0 with friction against v_t⁺ (Moreau), which
        takes Newton's law. Of several such impulses it is that of the least normal impulse, and
        `SimultaneousImpact.is_unique` says so. Without collision it is the stop, v_n⁺ ≥ 0 with
        friction against v_t⁺ and a change of the velocity.
    load : ndarray, shape (2 n,), optional
        Accelerations without contact forces; where several impacts without collision are possible,
        the one whose contacts they press most is taken; m/s².
    bilateral : ndarray of bool, shape (n,), optional
        Contacts that hold from both sides: their v_n stays 0, and P_n has either sign.

    Returns
    -------
    SimultaneousImpact

    Raises
    ------
    InputError
        As by `solve_impact`, all faults at once.
    CompilerMissing
        There is no C compiler.
    """
    held = np.zeros(np.size(mu), dtype=bool)
    if bilateral is not None:
        held = np.asarray(bilateral, dtype=bool).reshape(-1)
    where = "solve simultaneous impact"
    friction = chosen(ImpactFriction, impact_friction, "impact friction", where)
    given = impact_inputs(W, mu, velocity, restitution, e, where=where, bilateral=held.tolist())
    W, mu, v, shares = (np.array(a) for a in (*given[:3], given.e))
    law = given.law
    check_final_slip(friction, law, where)
    at = ContactRows(len(mu))
    pressing = np.zeros(len(mu)) if load is None else _load(load, at, where)
    results, sides = np.zeros((3, at.size)), np.ascontiguousarray(held, dtype=np.intc)
    reader = PathReader(len(mu))
    with listening(reader, at.size) as heard:
        ended = _impact(len(mu))(
            *(a.ctypes.data for a in (W, mu, v, sides, pressing, shares)),
            MEASURES.index(law.measure),
            law.power,
            friction is ImpactFriction.FINAL_SLIP,
            *(row.ctypes.data for row in results),
            heard,
        )
    path, velocities = reader.path(held, law, shares), results[0]
    parted = bool(np.any(velocities[at.normals] > 0))
    end = ImpactEnd.SEPARATION if parted else ImpactEnd.PERSISTENT
    return SimultaneousImpact(
        ImpactEnd.JAM if not ended else end, v, velocities, _pieces(path), path
    )


def _load(load: Array, at: ContactRows, where: str) -> Array:
    """Return the accelerations along the normals."""
    given, fault = finite_array(load, "load")
    if fault or given.shape != (at.size,):
        need = fault or f"load: got shape {given.shape}, need {(at.size,)}: two rows a contact."
        raise InputError(f"{where}: {need}")
    return given[at.normals]


def _pieces(path: PathRecord) -> tuple[ImpulsePiece, ...]:
    """Return the pieces of a path, with their units."""
    pieces, normals = [], ContactRows(len(path.mu)).normals
    for step in path.steps:
        if isinstance(step, Straight):
            impulses, after = step.push * step.event.length, step.velocities_after
        elif step.weighs:
            continue
        else:
            impulses, after = step.impulses, step.rates.copy()
            after[normals] -= step.rebound * step.velocities[normals]
        works = impulses * (step.velocities + after) / 2
        pieces.append(
            ImpulsePiece(
                np.ldexp(impulses, path.speed - path.mass),
                np.ldexp(after, path.speed),
                np.ldexp(works, 2 * path.speed - path.mass),
            )
        )
    return tuple(pieces)
