"""Rigid contact problems of a mechanism at arrays of states: cases and coefficients as arrays."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from painleve_sym.arrays import Array, table_library
from painleve_sym.at.array_inputs import common_shape, given_arrays
from painleve_sym.at.cases import classified, classify_at
from painleve_sym.at.classification import Classification
from painleve_sym.at.closing import closed_states
from painleve_sym.at.delassus import ContactNumbers, Delassus, NumericalMechanism
from painleve_sym.checks import StateLike, names_of, text_of
from painleve_sym.codegen.named_mechanisms import MechanismLike, as_mechanism
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, refuse_unknown
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.problem.case_codes import LEGEND, case_codes
from painleve_sym.problem.risk import slip_slope
from painleve_sym.quantities import unit_of

if TYPE_CHECKING:
    import pandas

NO_PROBLEM = ("outside", "inside", "impact", "apart")
"""Cases of states without a contact problem: outside the domain or without finite numbers; in the
ground; approaching; with no contact closed, or off a guide."""
_CASES: Mapping[int, str] = {code: name for name, code in LEGEND.items()}


@dataclass(frozen=True, repr=False, eq=False)
class ClassificationTable(Compared):
    """Rigid contact problems at an array of states; every array has the shape of the inputs.

    ``table["case"]`` has the case of each state as a text: that of `ContactCase`, or ``outside``
    (of the domain of the mechanism, or no finite numbers), ``inside`` (the ground), ``impact`` (a
    closed contact approaches) and ``apart`` (no contact is closed, or one is off its guide). Other
    names (`names` lists all) are ``A``, ``B``, ``A_stick``, ``B_stick``, ``slip_velocity``,
    ``gap``, ``gap_rate`` and ``mu``, of several contacts with the name of each behind: ``gap_A``. A
    and B are those of slip, nan at rest. ``table[3]`` is the `Classification` of the fourth state,
    with every solution.

    Attributes
    ----------
    mechanism : Mechanism
    shape : tuple of int
    inputs : dict of str to ndarray
        States and parameters, with defaults; they broadcast to `shape`.
    cases : ndarray of str, shape (n,)
        In C order of `shape`.
    numbers : ContactNumbers
        At the n states.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> table = ps.classify_batch("rod", {"theta": [0.5, 1.0], "theta_dot": 1.0, "x_A_dot": -1.0})
    >>> table["case"].tolist(), table["A"].round(6).tolist()
    (['slip', 'inconsistent'], [1.543364, -0.033745])
    >>> table[1].case
    <ContactCase.INCONSISTENT: 'inconsistent'>
    """

    mechanism: Mechanism
    shape: tuple[int, ...]
    inputs: dict[str, Array]
    cases: NDArray[np.str_]
    numbers: ContactNumbers

    def __repr__(self) -> str:
        """Return mechanism, shape and how often each case occurs in one line."""
        counts = ", ".join(f"{count} {case}" for case, count in self.counts().items())
        return f"ClassificationTable of {self.mechanism.name!r}, shape {self.shape}: {counts}"

    def counts(self) -> dict[str, int]:
        """Return how often each case occurs, the most frequent first."""
        return dict(Counter(self.cases.tolist()).most_common())

    def __len__(self) -> int:
        """Return the number of states along the first axis."""
        if not self.shape:
            raise TypeError("a table of one state has no length")
        return self.shape[0]

    def __iter__(self) -> Iterator[Classification]:
        """Yield the classification of each state, in C order."""
        return map(self._classification, range(len(self.cases)))

    def __getitem__(self, name: Any) -> Any:
        """Return a quantity by name, or the classification at an index.

        Raises
        ------
        InputError
            An unknown name; an index of a state without a contact problem: the message says why.
        """
        if not isinstance(name, str):
            try:
                place = np.arange(len(self.cases)).reshape(self.shape)[name]
            except (IndexError, TypeError, ValueError):
                place = np.zeros(0)
            if np.ndim(place):
                raise InputError(
                    f"{self._where}: got {name!r}, need a name or the index of a state in the "
                    f"shape {self.shape}."
                )
            return self._classification(int(place))
        refuse_unknown("quantity", text_of(name, self._where), self.names, self._where)
        return self._named[name].reshape(self.shape)

    @property
    def _where(self) -> str:
        return f"classification of {self.mechanism.name!r}"

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the quantities."""
        return tuple(self._named)

    @cached_property
    def _named(self) -> dict[str, Any]:
        """Quantities by name, n entries each."""
        outline, at = self.mechanism.outline, self.numbers
        named: dict[str, Any] = {"case": self.cases}
        several = len(outline.contacts) > 1
        slopes = _slopes(self.mechanism, at)
        for i, contact in enumerate(outline.contacts):
            row = outline.rows.normal(i)
            slip = at.slip_velocity[i]
            at_rest = ~_speed(slip).astype(bool)
            own = {
                "A": slopes[i][0],
                "B": np.where(at_rest, np.nan, at.b[row]),
                "A_stick": at.A_stick[i],
                "B_stick": at.B_stick[i],
                "slip_velocity": _speed(slip) if slip.ndim > 1 else slip,
                "gap": at.gap[i],
                "gap_rate": at.gap_rate[i],
                "mu": at.mu[i],
            }
            named |= {f"{n}_{contact.name}" if several else n: v for n, v in own.items()}
        return named

    def _row(self, i: int) -> dict[str, float]:
        whole = {n: np.broadcast_to(a, self.shape).flat[i] for n, a in self.inputs.items()}
        return {n: float(v) for n, v in whole.items()}

    def _classification(self, i: int) -> Classification:
        row, names = self._row(i), self.mechanism.state_names
        states = {n: row[n] for n in names}
        return classify_at(
            self.mechanism.at(states, {n: v for n, v in row.items() if n not in states})
        )

    def units(self, name: str) -> str:
        """Return the SI unit of a quantity or an input; "1" where it has none."""
        for contact in self.mechanism.outline.contacts:
            name = name.removesuffix(f"_{contact.name}") if name in self.names else name
        return self.mechanism.units.get(name) or unit_of(name, {})

    def to_dataframe(self, names: str | Sequence[str] | None = None) -> pandas.DataFrame:
        """Return a `pandas.DataFrame`, one row for each state: inputs that vary, then quantities.

        Parameters
        ----------
        names : sequence of str, optional
            Quantities; all where none are given.

        Returns
        -------
        pandas.DataFrame
            With units in its ``attrs["units"]``.

        Raises
        ------
        InputError
            pandas is not installed, or an unknown name.
        """
        frames = table_library("pandas", "a data frame")
        columns = {
            n: np.broadcast_to(a, self.shape).ravel() for n, a in self.inputs.items() if a.ndim
        }
        for name in self.names if names is None else names_of(names, f"{self._where}: names"):
            columns[name] = self[name].ravel()
        frame: pandas.DataFrame = frames.DataFrame(columns)
        frame.attrs["units"] = {n: self.units(n) for n in columns}
        return frame


def classify_batch(
    mechanism: MechanismLike,
    states: StateLike | None = None,
    *,
    parameters: Mapping[str, ArrayLike] | None = None,
    close: str | None = None,
) -> ClassificationTable:
    """Return the case of the rigid contact problem at every state of arrays.

    Each state has the case that `classify` gives it. All coefficients come from one compiled
    evaluation. A state without a contact problem has a case of its own.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
    states : mapping of str to array_like, DataFrame, or array_like, optional
        Numbers, or arrays that broadcast against each other; or one array whose last axis is that
        of the mechanism's `state_names`. The mechanism's `start` where no state is given.
    parameters : mapping of str to array_like
        Numbers, or arrays that broadcast.
    close : str, optional
        A coordinate for which gap = 0 is solved at every state, as `classify` does.

    Returns
    -------
    ClassificationTable
        Arrays of the shape that all the given ones broadcast to.

    Raises
    ------
    InputError
        Unknown names, shapes that do not fit, numbers that are not finite or out of range.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> start = {"theta": [0.5, 1.0, 1.5], "theta_dot": 1.0, "x_A_dot": -1.0}
    >>> ps.classify_batch("rod", start)
    ClassificationTable of 'rod', shape (3,): 2 slip, 1 inconsistent
    """
    known = as_mechanism(mechanism)
    where = f"classification of {known.name!r}"
    given = known.start if states is None else states
    values, faults = given_arrays(where, known, given, parameters, known.outline.declared.by_name)
    if faults:
        raise InputError(f"{where}: " + " ".join(faults))
    shape = common_shape(where, values)
    if close is not None:
        whole = {n: np.broadcast_to(a, shape) for n, a in values.items()}
        values |= closed_states(known, whole, close)
    flat = {n: np.broadcast_to(a, shape).ravel() for n, a in values.items()}
    numbers = Delassus.of(known).at_each({n: flat[n] for n in known.outline.argument_names})
    table = ClassificationTable(known, shape, values, np.zeros(0, np.str_), numbers)
    return ClassificationTable(known, shape, values, _cases(table), numbers)


def _cases(table: ClassificationTable) -> NDArray[np.str_]:
    """Return the case of every state."""
    mechanism, at = table.mechanism, table.numbers
    cases = np.empty(at.gap.shape[1], dtype="<U16")
    status, closed = _closed(mechanism, at)
    cases[:] = status
    asked = status == ""
    alone = len(mechanism.outline.contacts) == 1
    by_row = bool(mechanism.outline.quaternions) or isinstance(mechanism, NumericalMechanism)
    if alone and not by_row:
        slopes, B = _slopes(mechanism, at)[0], at.b[0]
        clear = asked & (B != 0) & np.all([np.isfinite(A) & (A != 0) for A in slopes], axis=0)
        codes = case_codes([A[clear] for A in slopes], B[clear])
        for code, name in _CASES.items():
            cases[np.flatnonzero(clear)[codes == code]] = name
        asked &= ~clear
    for i in np.flatnonzero(asked).tolist():
        cases[i] = _case_of_row(table, i, np.flatnonzero(closed[:, i]).tolist(), by_row)
    return cases


def _case_of_row(table: ClassificationTable, i: int, closed: list[int], by_row: bool) -> str:
    """Return the case of one state, with every solution of its contact problem."""
    row, names = table._row(i), table.mechanism.state_names
    states = {n: row[n] for n in names}
    others = {n: v for n, v in row.items() if n not in states}
    place = table.mechanism.at(states, others)
    if by_row:
        return classify_at(place).case.value
    numbers = ContactNumbers(*(np.asarray(a)[..., i] for a in table.numbers))
    try:
        return classified(place, numbers, closed).case.value
    except InputError:  # a mobility without finite numbers in sticking, or beyond all bounds
        return "outside"


def _closed(mechanism: Mechanism, at: ContactNumbers) -> tuple[NDArray[np.str_], NDArray[np.bool_]]:
    """Return why a state has no contact problem, empty where it has; which contacts are closed."""
    guides = np.array(mechanism.outline.bilateral)[:, None]
    near, slow = np.abs(at.gap) <= at.gap_tolerance, np.abs(at.gap_rate) <= at.rate_tolerance
    closed = near & slow
    reasons = {
        "apart": ~closed.any(axis=0) | (guides & ~closed).any(axis=0),
        "impact": (~guides & near & (at.gap_rate < -at.rate_tolerance)).any(axis=0),
        "inside": (~guides & (at.gap < -at.gap_tolerance)).any(axis=0),
        "outside": ~_finite(at) | ~(np.asarray(at.margins) > 0).all(axis=0),
    }
    status = np.full(at.gap.shape[1], "", dtype="<U16")
    for reason, holds in reasons.items():
        status[holds] = reason
    return status, closed


def _finite(at: ContactNumbers) -> NDArray[np.bool_]:
    """Return whether all numbers of a state are finite."""
    parts = (at.W.reshape(-1, at.gap.shape[1]), at.b, at.gap, at.gap_rate, at.gap_tolerance)
    return np.asarray(np.all([np.isfinite(part).all(axis=0) for part in parts], axis=0))


def _speed(slip: Array) -> Array:
    """Return the lengths of slip velocities, shape (n,) or (2, n)."""
    return np.asarray(np.abs(slip) if slip.ndim == 1 else np.hypot(*slip))


def _slopes(mechanism: Mechanism, at: ContactNumbers) -> list[list[Array]]:
    """Return A of each contact in slip, for each sign of its normal force; nan at rest."""
    outline, slopes = mechanism.outline, []
    for i, contact in enumerate(outline.contacts):
        rows = list(outline.rows.each()[i])
        slip = at.slip_velocity[i]
        with np.errstate(all="ignore"):
            speed = _speed(slip)
            along = np.atleast_2d(slip) / speed
            W = at.W[np.ix_(rows, rows)]
            slopes.append([slip_slope(W, at.mu[i], [*along], side) for side in contact.sides])
    return slopes
