"""Formulas as a list of elementary operations: plain data that NumPy evaluates.

A saved motion carries its outputs this way, so that forces can be computed from the file alone,
without the mechanism, the law, a compiler or anything that is executed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.cache import kept_entry
from painleve_sym.codegen.derivation_cache import entry_key
from painleve_sym.errors import InputError, TranslationError, unknown_name

if TYPE_CHECKING:
    from painleve_sym.automata.signature import AutomatonBuilder
    from painleve_sym.codegen.modes import AutomatonFunctions

_ONE: Mapping[str, Callable[[Any], Any]] = {
    "ASSIGN": lambda x: x,
    "NEG": np.negative,
    "INV": lambda x: 1.0 / x,
    "SQ": lambda x: x * x,
    "TWICE": lambda x: 2.0 * x,
    "SQRT": np.sqrt,
    "EXP": np.exp,
    "LOG": np.log,
    "SIN": np.sin,
    "COS": np.cos,
    "TAN": np.tan,
    "ASIN": np.arcsin,
    "ACOS": np.arccos,
    "ATAN": np.arctan,
    "SINH": np.sinh,
    "COSH": np.cosh,
    "TANH": np.tanh,
    "ASINH": np.arcsinh,
    "ACOSH": np.arccosh,
    "ATANH": np.arctanh,
    "FLOOR": np.floor,
    "CEIL": np.ceil,
    "FABS": np.abs,
    "SIGN": np.sign,
    "ERF": np.vectorize(math.erf, otypes=[float]),
    "EXPM1": np.expm1,
    "LOG1P": np.log1p,
    "NOT": lambda x: np.where(x == 0, 1.0, 0.0),
}
_TWO: Mapping[str, Callable[[Any, Any], Any]] = {
    "ADD": np.add,
    "SUB": np.subtract,
    "MUL": np.multiply,
    "DIV": np.divide,
    "POW": np.power,
    "CONSTPOW": np.power,
    "FMOD": np.fmod,
    "COPYSIGN": np.copysign,
    "FMIN": np.fmin,
    "FMAX": np.fmax,
    "ATAN2": np.arctan2,
    "HYPOT": np.hypot,
    "LT": lambda x, y: np.where(x < y, 1.0, 0.0),
    "LE": lambda x, y: np.where(x <= y, 1.0, 0.0),
    "EQ": lambda x, y: np.where(x == y, 1.0, 0.0),
    "NE": lambda x, y: np.where(x != y, 1.0, 0.0),
    "AND": lambda x, y: np.where((x != 0) & (y != 0), 1.0, 0.0),
    "OR": lambda x, y: np.where((x != 0) | (y != 0), 1.0, 0.0),
    "IF_ELSE_ZERO": lambda x, y: np.where(x != 0, y, 0.0),
}


@dataclass(frozen=True)
class Tape:
    """A function of several vectors to one vector, operation by operation.

    Its arguments have the lengths `sizes`, its result that of `outputs`; `work` is the number of
    places that hold intermediate values. Operations are ``("CONST", place, value)``, ``("INPUT",
    place, argument, entry)``, ``("OUTPUT", entry, place)``, or the name of an elementary operation,
    the place of its result and those of its one or two operands. An unknown one, or one that uses a
    place there is not, is rejected.
    """

    sizes: tuple[int, ...]
    outputs: int
    work: int
    operations: tuple[tuple[Any, ...], ...]

    def __post_init__(self) -> None:
        for operation in self.operations:
            fault = self._fault(operation)
            if fault:
                raise InputError(f"formulas as operations: {fault}")

    def _fault(self, operation: tuple[Any, ...]) -> str:
        name, *places = operation
        if name == "CONST" and len(places) == 2 and isinstance(places[1], int | float):
            bounds: tuple[int, ...] = (self.work,)
            places = places[:1]
        elif name == "INPUT" and len(places) == 3 and places[1] in range(len(self.sizes)):
            bounds = (self.work, len(self.sizes), self.sizes[places[1]])
        elif name == "OUTPUT":
            bounds = (self.outputs, self.work)
        elif name in _ONE:
            bounds = (self.work,) * 2
        elif name in _TWO:
            bounds = (self.work,) * 3
        else:
            return unknown_name("operation", str(name)[:40], ("CONST", *_ONE, *_TWO))
        if len(places) != len(bounds):
            return f"{name}: got {len(places)} places, need {len(bounds)}."
        for place, bound in zip(places, bounds, strict=True):
            if type(place) is not int or not 0 <= place < bound:
                return f"{name}: got the place {place!r:.40}, need a whole number below {bound}."
        return ""

    @classmethod
    def of_function(cls, function: Any) -> Tape:
        """Return the operations of a CasADi function of vectors to one dense vector, made of SX.

        TranslationError for an operation that has no counterpart here.
        """
        import casadi as ca

        names = {getattr(ca, n): n.removeprefix("OP_") for n in dir(ca) if n.startswith("OP_")}
        operations: list[tuple[Any, ...]] = []
        for k in range(function.n_instructions()):
            name = names[function.instruction_id(k)]
            into, of = function.instruction_output(k), function.instruction_input(k)
            if name == "CONST":
                operations.append((name, into[0], float(function.instruction_constant(k))))
            elif name == "OUTPUT":
                operations.append((name, into[1], of[0]))
            elif name == "INPUT" or name in _ONE or name in _TWO:
                operations.append((name, into[0], *of))
            else:
                raise TranslationError(f"operation {name} has no counterpart in NumPy.")
        sizes = tuple(function.numel_in(i) for i in range(function.n_in()))
        return cls(sizes, function.numel_out(0), function.sz_w(), tuple(operations))

    def __call__(self, *arguments: Array) -> Array:
        """Return the results at n points, shape (n, outputs); arrays (n, size) by `sizes`."""
        n = max((len(a) for a in arguments), default=1)
        work: list[Any] = [0.0] * self.work
        results = np.zeros((n, self.outputs))
        with np.errstate(all="ignore"):
            for name, place, *rest in self.operations:
                if name == "CONST":
                    work[place] = rest[0]
                elif name == "INPUT":
                    work[place] = arguments[rest[0]][:, rest[1]]
                elif name == "OUTPUT":
                    results[:, place] = work[rest[0]]
                elif name in _ONE:
                    work[place] = _ONE[name](work[rest[0]])
                else:
                    work[place] = _TWO[name](work[rest[0]], work[rest[1]])
        return results

    def to_data(self) -> dict[str, Any]:
        """Return the tape as plain data."""
        return {
            "sizes": list(self.sizes),
            "outputs": self.outputs,
            "work": self.work,
            "operations": [list(operation) for operation in self.operations],
        }

    @classmethod
    def of_data(cls, data: Mapping[str, Any]) -> Tape:
        """Return the tape that `to_data` wrote; InputError where it is not one."""
        try:
            sizes = tuple(_count(n) for n in data["sizes"])
            outputs, work = _count(data["outputs"]), _count(data["work"])
            operations: Sequence[Any] = data["operations"]
            return cls(sizes, outputs, work, tuple(tuple(o) for o in operations))
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"formulas as operations: not readable ({error!r:.80}).") from error


def _count(value: Any) -> int:
    if type(value) is not int or not 0 <= value <= 1_000_000:
        raise ValueError(f"got {value!r:.40}, need a count")
    return value


@dataclass(frozen=True)
class TapeOutputs:
    """Outputs of an automaton, mode by mode, computed from tapes; a single one serves all modes.

    The arguments of a tape are state, memory and constants.
    """

    tapes: tuple[Tape, ...]

    def outputs(self, modes: Any, states: Array, memory: Array, constants: Array) -> Array:
        """Return the outputs at n points, shape (n, no); see `Engine.outputs`."""
        n = len(states)
        values = np.empty((n, self.tapes[0].outputs))
        held = np.tile(constants, (n, 1))
        modes = np.asarray(modes) * (len(self.tapes) > 1)
        for mode in np.unique(modes):
            rows = modes == mode
            values[rows] = self.tapes[int(mode)](states[rows], memory[rows], held[rows])
        return values

    def portable(self) -> TapeOutputs:
        """Return itself: nothing here depends on a process or a machine."""
        return self

    def to_data(self) -> list[dict[str, Any]]:
        """Return the tapes as plain data."""
        return [tape.to_data() for tape in self.tapes]

    @classmethod
    def of_data(cls, data: Any) -> TapeOutputs:
        """Return the tapes of data by `to_data`; InputError for other data."""
        if not isinstance(data, list) or not data:
            raise InputError("formulas as operations: got no list of them.")
        return cls(tuple(Tape.of_data(entry) for entry in data))


def output_tapes(builder: AutomatonBuilder) -> TapeOutputs:
    """Return the outputs of an automaton as tapes; derived only where the cache lacks them."""

    def derived() -> dict[str, Any]:
        from painleve_sym.codegen.modes import AutomatonFunctions

        return {"tapes": tapes_of_functions(AutomatonFunctions(builder.automaton)).to_data()}

    return TapeOutputs.of_data(kept_entry(entry_key("output tapes", builder), derived)["tapes"])


def tapes_of_functions(functions: AutomatonFunctions) -> TapeOutputs:
    """Return the outputs of an automaton's functions as tapes.

    Where local modes are data every mode has the same outputs: then the first one serves all.
    """
    modes = functions.modes[:1] if functions.automaton.parts else functions.modes
    return TapeOutputs(tuple(Tape.of_function(mode.outputs) for mode in modes))
