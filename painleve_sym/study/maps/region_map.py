"""Maps of the rigid contact: which case holds over any two states or parameters."""

from __future__ import annotations

import json
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from painleve_sym.arrays import Array, load_npz, npz_faults, save_npz, table_library
from painleve_sym.at.closing import closing_hint
from painleve_sym.at.inputs import digits_left
from painleve_sym.checks import StateLike, by_name
from painleve_sym.codegen.named_mechanisms import MechanismLike, as_mechanism
from painleve_sym.equality import Compared
from painleve_sym.errors import InputError, PainleveWarning
from painleve_sym.hooks import upper
from painleve_sym.mechanics.mechanism import Mechanism
from painleve_sym.notebooks import Shown
from painleve_sym.plain_data import plain_fields
from painleve_sym.problem.case_codes import LEGEND
from painleve_sym.progress import progress
from painleve_sym.study.maps.axes import MapPlace, checked_slip, map_place, reaching
from painleve_sym.study.maps.contact_map import CURVES, ContactMap
from painleve_sym.units import Value

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMAT = "painleve-sym map 1"

_ARRAYS = ("case", "A", "B", "A_stick", "B_stick", "stick_feasible", "crossings")
_OPTIONAL = ("flow", "A_pull")
_PLACE = ("over", "labels", "units", "values", "state", "parameters", "close")
_HELD = ("state", "state_units", "parameters")
_TEXTS = ("mechanism", "over", "labels", "units", "slip", "thresholds", *_HELD)
_MORE_TEXTS = ("close", "shared_zeros")
_GRID_UNITS = dict.fromkeys(("A", "A_stick", "A_pull"), "1/kg") | dict.fromkeys(
    ("B", "B_stick"), "m/s^2"
)


@dataclass(frozen=True, repr=False, eq=False)
class RegionMap(Shown, Compared):
    """The rigid contact over two quantities, for one slip direction.

    Grids have the shape (n_1, n_2) of the two axes, in their order.

    Attributes
    ----------
    mechanism : str
    over : tuple of two str
        Names of the axes: coordinates, velocities (``_dot``) or parameters.
    labels, units : tuple of two str
        Their LaTeX and SI units.
    values : tuple of two ndarray, shape (n_1,), (n_2,)
        Increasing; SI units, rad.
    slip : {-1, +1}, or float
        Direction s of the slip, whatever slip velocity the state has; in space its angle from t1
        towards t2 in rad, unless that is an axis.
    case : ndarray of int8
        Codes of `LEGEND`.
    A, B : ndarray
        g̈_N = A_s F_n + B in slip, 1/kg and m/s²; nan outside.
    A_stick, B_stick : ndarray
        The same in sticking.
    stick_feasible : ndarray of bool
        Whether a contact with v_t = 0 could stick: F_n = −B′/A′ > 0 and |F_t| ≤ μ F_n.
    flow : ndarray, shape (2, n_1, n_2), or None
        Rates of the two axes in slip with F_n = −B/A; nan where the case is not slip. None where
        an axis is a parameter.
    curves : dict of str to ndarray, shape (n, 2, 2)
        ``A`` and ``B``: straight pieces of A = 0 and B = 0, whose ends are zeros to round-off.
    crossings : ndarray, shape (n, 2)
        Where A = B = 0 (the points of Génot & Brogliato 1999), to round-off.
    shared_zeros : list of dict of str to float
        Curves along which A and B vanish together, as where both have a factor cos θ: each by the
        value of the axis that is constant on it, or by both values of one of its points.
    thresholds : dict of str to float
        ``mu_P``: least friction with A < 0 somewhere, where it has a closed form, in space the
        least on the grid; ``least_over_normals``, the least on the grid over all normals of the
        surface; for the rods also ``mu_C`` = (2/√3) μ_P (Génot & Brogliato 1999), where at the
        crossing both rates of approach are equal. None of them where it is infinite.
    state, parameters : dict of str to float
        Values that are constant over the map.
    state_units : dict of str to str
        Unit of each value of `state`.
    close : str
        What was solved for at every point so that the contact is closed, `state` having the first
        guess; empty where nothing was.
    A_pull : ndarray or None
        Of a contact that is held from both sides: A where F_n < 0, `A` being that where F_n > 0.
        `curves` then has ``A_pull``, too, and the cases tell the number of solutions: ``slip``
        one, ``inconsistent`` none, ``indeterminate`` two.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> ranges = {"theta": (0.1, 1.5), "theta_dot": (-6, 6)}
    >>> region = ps.region_map("rod", ("theta", "theta_dot"), ranges=ranges, points=50)
    >>> region.counts
    {'outside': 0, 'slip': 1448, 'liftoff': 602, 'inconsistent': 244, 'indeterminate': 206}
    >>> round(region.thresholds["mu_P"], 4)
    1.3333
    """

    mechanism: str
    over: tuple[str, str]
    labels: tuple[str, str]
    units: tuple[str, str]
    values: tuple[Array, Array]
    slip: float
    case: NDArray[np.int8]
    A: Array
    B: Array
    A_stick: Array
    B_stick: Array
    stick_feasible: NDArray[np.bool_]
    flow: Array | None
    curves: dict[str, Array]
    crossings: Array
    thresholds: dict[str, float]
    state: dict[str, float]
    parameters: dict[str, float]
    state_units: dict[str, str]
    close: str = ""
    A_pull: Array | None = None
    shared_zeros: list[dict[str, float]] = field(default_factory=list)

    def __repr__(self) -> str:
        """Return mechanism, axes and the number of points of each case in one line."""
        counts = ", ".join(f"{count} {case}" for case, count in self.counts.items() if count)
        return f"RegionMap of {self.mechanism!r} over {' and '.join(self.over)}: {counts}"

    @property
    def bilateral(self) -> bool:
        """Whether the contact is held from both sides."""
        return self.A_pull is not None

    @property
    def in_space(self) -> bool:
        """Whether the contact is in space, and `slip` an angle."""
        return isinstance(self.slip, float)

    @property
    def counts(self) -> dict[str, int]:
        """Number of points of each case, every entry of `LEGEND` in its order."""
        return {name: int(np.sum(self.case == code)) for name, code in LEGEND.items()}

    def summary(self) -> dict[str, Any]:
        """Return plain data without the grids."""
        ends = zip(self.over, self.units, self.values, strict=True)
        return {
            "mechanism": self.mechanism,
            "slip": self.slip,
            "axes": [
                {"name": n, "unit": u, "from": float(v[0]), "to": float(v[-1]), "points": len(v)}
                for n, u, v in ends
            ],
            "counts": self.counts,
            "stick_feasible_count": int(np.sum(self.stick_feasible)),
            "crossings": [
                dict(zip(self.over, row, strict=True)) for row in self.crossings.tolist()
            ],
            **plain_fields(self, "shared_zeros", "thresholds", "state", "parameters"),
            **({"close": self.close} if self.close else {}),
            "bilateral": self.bilateral,
        }

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data for JSON: lists for arrays, None for nan."""
        grids = ("A", "B", "A_stick", "B_stick", "flow", *(("A_pull",) if self.bilateral else ()))
        return {
            **self.summary(),
            "legend": dict(LEGEND),
            "values": {n: (v + 0.0).tolist() for n, v in zip(self.over, self.values, strict=True)},
            "case": self.case.tolist(),
            "stick_feasible": self.stick_feasible.tolist(),
            **{name: _without_nan(getattr(self, name)) for name in grids},
            "curves": {n: (pieces + 0.0).tolist() for n, pieces in self.curves.items()},
        }

    # ---- tables and figures ----

    @property
    def _grids(self) -> dict[str, Array]:
        """The grids of numbers by name, each of shape (n_1, n_2)."""
        names = ("A", "B", "A_stick", "B_stick", *(("A_pull",) if self.bilateral else ()))
        return {name: getattr(self, name) for name in names} | {
            "stick_feasible": self.stick_feasible
        }

    @property
    def case_names(self) -> NDArray[np.str_]:
        """Names of the cases in place of their codes, shape (n_1, n_2)."""
        names = {code: name for name, code in LEGEND.items()}
        named: NDArray[np.str_] = np.vectorize(names.get, otypes=[str])(self.case)
        return named

    def plot(self, ax: Axes | None = None, *, width: float | None = None) -> Figure:
        """Return the Matplotlib figure that `painleve map --plot` draws.

        Parameters
        ----------
        ax : Axes, optional
            Axes to draw in, instead of those of a new figure; theirs is returned.
        width : float, optional
            Width of a new figure, in inches.

        Raises
        ------
        InputError
            Other axes than those of Matplotlib.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> regions = ps.region_map("rod", ("theta", "theta_dot"), points=20)
        >>> len(regions.plot().axes)
        1
        """
        figure: Figure = upper("plot_map")(self, width, ax)
        return figure

    def to_dataframe(self) -> pandas.DataFrame:
        """Return a `pandas.DataFrame` with a row for each point: axes, case, A, B and others.

        Raises
        ------
        InputError
            pandas is not installed.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> frame = ps.region_map("rod", ("theta", "theta_dot"), points=20).to_dataframe()
        >>> len(frame), list(frame.columns)[:4]
        (400, ['theta', 'theta_dot', 'case', 'A'])
        """
        frames = table_library("pandas", "a data frame")
        axes = np.meshgrid(*self.values, indexing="ij")
        columns = dict(zip(self.over, axes, strict=True)) | {"case": self.case_names} | self._grids
        frame: pandas.DataFrame = frames.DataFrame({n: c.ravel() for n, c in columns.items()})
        frame.attrs["units"] = dict(zip(self.over, self.units, strict=True)) | _GRID_UNITS
        return frame

    def to_xarray(self) -> xarray.Dataset:
        """Return an `xarray.Dataset` over both axes, every variable with its unit.

        Raises
        ------
        InputError
            xarray is not installed.

        Examples
        --------
        >>> import painleve_sym as ps
        >>> data = ps.region_map("rod", ("theta", "theta_dot"), points=20).to_xarray()
        >>> dict(data.sizes), data["B"].attrs["units"]
        ({'theta': 20, 'theta_dot': 20}, 'm/s^2')
        """
        library = table_library("xarray", "a labelled array")
        triples = zip(self.over, self.values, self.units, strict=True)
        axes = {name: (name, values, {"units": unit}) for name, values, unit in triples}
        grids = {"case": self.case_names} | self._grids
        variables = {
            name: (self.over, grid, {"units": _GRID_UNITS.get(name, "1")})
            for name, grid in grids.items()
        }
        about = {"mechanism": self.mechanism, "slip": self.slip, "close": self.close}
        about |= {name: json.dumps(getattr(self, name)) for name in ("state", "parameters")}
        data: xarray.Dataset = library.Dataset(variables, axes, about)
        return data

    # ---- files ----

    def save(self, path: str | Path) -> None:
        """Write to an NPZ file (arrays and JSON text, no pickle): whole, or not at all.

        Raises
        ------
        InputError
            The folder does not exist or cannot be written.
        """
        texts = {name: getattr(self, name) for name in (*_TEXTS, *_MORE_TEXTS)}
        arrays = {name: getattr(self, name) for name in (*_ARRAYS, *_OPTIONAL)}
        arrays |= {"values_0": self.values[0], "values_1": self.values[1]}
        arrays |= {f"curve_{name}": pieces for name, pieces in self.curves.items()}
        save_npz(path, FORMAT, texts, arrays)

    @classmethod
    def load(cls, path: str | Path) -> RegionMap:
        """Read a file of `save`.

        Raises
        ------
        InputError
            Not readable, or not a map.
        """
        needed = (*_ARRAYS, "values_0", "values_1", *(f"curve_{name}" for name in CURVES[:2]))
        texts, arrays = load_npz(path, FORMAT, "map", _TEXTS, needed, _OPTIONAL)
        fields: dict[str, Any] = {name: texts[name] for name in _TEXTS}
        fields |= {name: texts[name] for name in _MORE_TEXTS if name in texts}
        fields |= {name: arrays[name] for name in (*_ARRAYS, *_OPTIONAL)}
        fields["values"] = (arrays["values_0"], arrays["values_1"])
        names = [name for name in CURVES if f"curve_{name}" in arrays]
        fields["curves"] = {name: arrays[f"curve_{name}"] for name in names}
        with npz_faults(path, "map"):
            fields |= {name: tuple(fields[name]) for name in ("over", "labels", "units")}
            return cls(**fields)


def _without_nan(array: Array | None) -> Any:
    if array is None:
        return None
    plain = (array + 0.0).astype(object)  # -0.0 is 0.0
    plain[~np.isfinite(array)] = None
    return plain.tolist()


def region_map(
    mechanism: MechanismLike,
    over: str | Sequence[str],
    *,
    ranges: Mapping[str, tuple[Value, Value]] | None = None,
    points: int = 400,
    slip: float | None = None,
    state: StateLike | None = None,
    parameters: Mapping[str, Value] | None = None,
    close: str | None = None,
) -> RegionMap:
    """Return the case of the rigid contact over two quantities, for one slip direction.

    By the signs of A_s and B in g̈_N = A_s F_n + B, borders as in `classify`. Of a bilateral
    contact, the number of solutions in slip.

    Parameters
    ----------
    mechanism : Mechanism, or its name, or the path of a mechanism file
        With one contact.
    over : two str, or one with a comma
        Coordinates, velocities or parameters; in space also ``slip_direction``, the angle of slip.
    ranges : mapping of str to two (float or str)
        Ends of the axes, such as ``("10 deg", "80 deg")``; those left out are
        chosen (see `axes.default_range`).
    points : int
        Along each axis, 5 to 2000.
    slip : {-1, +1}, or float
        Sign of the slip velocity, −1 if it is not given; in space the angle of slip in rad, π if it
        is not given: in both the direction against t1.
    state, parameters : mapping of str to (float or str)
        Constant values; absent ones are 0 and the defaults. Without a state the mechanism's
        `start`.
    close : str, optional
        A coordinate for which gap = 0 is solved at every point, a velocity for which gap_rate = 0
        is; see `at.closing.closed_state`. Points that nothing closes are outside.

    Raises
    ------
    InputError
        Unknown or equal axes, ranges that are none, numbers out of range, no point inside the
        mechanism's domain.

    References
    ----------
    Génot & Brogliato (1999) for the crossings and μ_C;
    Impact model resolution on Painlevé's paradox, (1)–(3), Fig. 2.

    Examples
    --------
    >>> import painleve_sym as ps
    >>> regions = ps.region_map("rod", ("theta", "theta_dot"), points=20)
    >>> sum(regions.counts.values())
    400
    """
    mechanism = as_mechanism(mechanism)
    where = f"map of {mechanism.name!r}"
    ranges = by_name(ranges, f"{where}: ranges", "{'mu': (0, 2)}")
    parameters = by_name(parameters, f"{where}: parameters", "{'mu': 0.5}")
    mechanism.require_one_contact()
    slip = checked_slip(mechanism, slip)
    place = map_place(mechanism, over, ranges, points, state, parameters, close)
    contact = ContactMap(mechanism, place, slip)
    thresholds = contact.closed_thresholds()
    place = reaching(place, ranges, thresholds.get("mu_P"))
    with progress(f"{where} at {points} x {points} points"):
        grid = place.grid()
        place = place.with_solved(grid)
        contact = replace(contact, place=place)
        grids, is_open, on_grid, near = contact.grids(grid)
        if not (grids["case"] >= 0).any():
            raise InputError(_nothing_inside(mechanism, place))
        curves, crossings, shared = contact.zeros(grids)
    _tell_where_open(place, is_open)
    if near:
        warnings.warn(
            f"at {len(near)} of {is_open.size} points W and b lose digits near gimbal lock, where "
            f"about {digits_left(min(near))} are certain at the worst. "
            "Fix: turn the body about other axes, or orient it by a quaternion.",
            PainleveWarning,
            stacklevel=2,
        )
    return RegionMap(
        mechanism=mechanism.name,
        slip=contact.slip,
        **{name: getattr(place, name) for name in _PLACE},
        **grids,
        curves=curves,
        crossings=crossings,
        thresholds=thresholds | on_grid,
        state_units={name: mechanism.units[name] for name in place.state},
        shared_zeros=[
            {name: v for name, v in zip(place.over, curve, strict=True) if v is not None}
            for curve in shared
        ],
    )


def _nothing_inside(mechanism: Mechanism, place: MapPlace) -> str:
    bounds = mechanism.outline.domain
    bounded = {name for bound in bounds for name in bound.names}
    held = ", ".join(f"{n} = {v:g}" for n, v in place.state.items() if n in bounded)
    needs = ", ".join(f"{bound.margin} > 0 ({bound.meaning})" for bound in bounds)
    inside = f"inside the domain with {held}" if held else "inside the domain"
    return (
        f"{place.where}: no point of the map is {inside}: "
        f"need {needs or 'finite coefficients'}. Fix: give another state or range."
    )


def _tell_where_open(place: MapPlace, is_open: NDArray[np.bool_]) -> None:
    count = int(is_open.sum())
    if count:
        hint = closing_hint(place.mechanism, 0, place.over, "")
        warnings.warn(
            f"at {count} of {is_open.size} points the state has a gap or a normal velocity; the "
            f"map is drawn as if the contact were closed. {hint + '.' if hint else ''}".strip(),
            PainleveWarning,
            stacklevel=3,
        )
