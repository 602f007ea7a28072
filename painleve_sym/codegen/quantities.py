"""Named numbers of a state from formulas, compiled, and taken from the cache the next time."""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.cache import read_entry, write_entry
from painleve_sym.codegen.array_function import ArrayFunction, Selection
from painleve_sym.codegen.compile import compiler_mark, library_named
from painleve_sym.codegen.derivation_cache import FORMULAS, entry_key
from painleve_sym.errors import CompilerMissing, ModelError
from painleve_sym.progress import progress
from painleve_sym.time_limit import within_time

if TYPE_CHECKING:
    import casadi as ca


@dataclass(frozen=True)
class Quantities:
    """Formulas as one function of the arguments, in this order, with its text as CasADi writes it.

    `compiled` is None where there is no C compiler or none is to be used: CasADi then evaluates it.
    """

    names: tuple[str, ...]
    arguments: tuple[str, ...]
    text: str
    compiled: ArrayFunction | Selection | None

    @cached_property
    def function(self) -> ca.Function:
        """CasADi's function of one vector, shape (arguments,), to one of shape (names,)."""
        import casadi as ca

        return ca.Function.deserialize(self.text)

    def of_vector(self, values: Sequence[float]) -> list[float]:
        """Return the numbers for all arguments in their order."""
        if self.compiled is not None:
            return self.compiled.at_point(values)
        return [float(v) for v in np.array(self.function(list(values))).reshape(-1)]

    def __call__(self, values: Mapping[str, float]) -> dict[str, float]:
        """Return the numbers by name; `values` holds every argument and may hold others."""
        return self.of_point([values[name] for name in self.arguments])

    def of_point(self, values: Sequence[float]) -> dict[str, float]:
        """Return the numbers by name, for all arguments in their order."""
        return dict(zip(self.names, self.of_vector(values), strict=True))

    def at(self, values: Mapping[str, Array]) -> dict[str, Array]:
        """Return the numbers at n points by name, each of shape (n,); see `rows`."""
        return dict(zip(self.names, self.rows(values), strict=True))

    def rows(self, values: Mapping[str, Array]) -> Array:
        """Return the numbers at n points, shape (names, n), the same bits as one by one.

        The values are arrays of shape (n,): every argument, and maybe others.
        """
        arrays = [np.ascontiguousarray(values[name], np.float64) for name in self.arguments]
        if self.compiled is not None:
            return self.compiled.at_points(arrays, len(arrays[0]))
        from painleve_sym.codegen.evaluate import at_arrays

        return at_arrays(self.function, arrays)


def quantities(
    title: str,
    of: Any,
    arguments: Sequence[str],
    derive: Callable[[], tuple[Mapping[str, Any], Sequence[Any]] | tuple[list[str], ca.Function]],
    *,
    compiles: bool = True,
) -> Quantities:
    """Return formulas ready to be evaluated; `derive` is called only where the cache lacks them.

    The title distinguishes these formulas from others of the same object `of`, from which they are
    derived (`definition_text`). `arguments` are the names of every symbol that occurs, and `derive`
    returns the formulas by name, and the symbols of the arguments; or names, and the function of
    one vector that has these numbers. Long formulas that are evaluated few times are ready sooner
    without being compiled.
    """
    mark = _mark(*map(os.environ.get, ("CC", "PATH", "PAINLEVE_OPTIMIZE"))) if compiles else None
    key = (_text_key if isinstance(of, str) else _key)(title, mark, of, derive.__module__)
    stored = _stored(key, tuple(arguments), compiles) if key else None
    if stored is not None:
        return stored
    from painleve_sym.codegen.evaluate import expression_function

    def derived() -> tuple[tuple[str, ...], ca.Function, list[int | float] | None]:
        given: Any
        formulas, given = derive()
        if not isinstance(formulas, Mapping):
            sizes = given.numel_in(0), given.numel_out(0)
            if sizes != (len(arguments), len(formulas)):
                need = f"need {len(arguments)} arguments and {len(formulas)} numbers"
                raise ModelError(
                    title, [f"got a function of {sizes[0]} arguments to {sizes[1]} numbers, {need}"]
                )
            return tuple(formulas), given, None
        values = tuple(formulas.values())
        function = expression_function("quantities", values, given)
        return tuple(formulas), function, _selected(values, given)

    with progress(f"deriving {title}"):
        names, function, selected = within_time(title, derived)
    written = function.serialize()
    compiled = _compiled(function) if mark and selected is None else None
    if key:
        library = compiled.library.name if compiled else ""
        entry = {"names": list(names), "text": written, "library": library}
        write_entry(key, entry | {"selected": selected})
        _stored.cache_clear()
    evaluated = compiled if selected is None else Selection(selected)
    return Quantities(names, tuple(arguments), written, evaluated)


def _selected(formulas: Sequence[Any], symbols: Sequence[Any]) -> list[int | float] | None:
    """Return for every formula the index of its symbol, or its number; None where one is more."""
    places = {symbol: i for i, symbol in enumerate(symbols)}
    entries: list[int | float] = []
    for formula in formulas:
        place = places.get(formula)
        if place is None and not getattr(formula, "is_Integer", False):
            return None
        entries.append(float(formula) if place is None else place)
    return entries


def _compiled(function: ca.Function) -> ArrayFunction | None:
    try:
        return ArrayFunction.of(function)
    except CompilerMissing:
        return None


@functools.lru_cache(maxsize=8)
def _mark(*_variables: str | None) -> str | None:
    """Return `compiler_mark`, looked for once for each setting of the variables it depends on."""
    return compiler_mark()


def _key(title: str, mark: str | None, of: Any, module: str) -> str | None:
    """Return the key of formulas that a function of this module derives."""
    package, _, path = module.partition(".")
    folder = path.partition(".")[0]
    own = (folder,) if package == "painleve_sym" and folder not in FORMULAS else ()
    return entry_key(f"quantities\n{title}\n{mark}", of, by=(*FORMULAS, *own))


# Every run asks for the same few.
_text_key = functools.lru_cache(maxsize=256)(_key)


# One entry is asked for again and again, at every state that is looked at.
@functools.lru_cache(maxsize=64)
def _stored(key: str, arguments: tuple[str, ...], compiles: bool) -> Quantities | None:
    entry = read_entry(key)
    if entry is None:
        return None
    names, text = tuple(entry["names"]), entry["text"]
    if entry["selected"] is not None:
        return Quantities(names, arguments, text, Selection(entry["selected"]))
    if not compiles:
        return Quantities(names, arguments, text, None)
    library = library_named(entry["library"]) if entry["library"] else None
    if library is not None:
        return Quantities(
            names, arguments, text, ArrayFunction(library, len(arguments), len(names))
        )
    import casadi as ca

    return Quantities(names, arguments, text, _compiled(ca.Function.deserialize(text)))
