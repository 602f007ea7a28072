"""A compiled function of numbers, evaluated at one point or, in one call, at many."""

from __future__ import annotations

import ctypes
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from painleve_sym.arrays import Array
from painleve_sym.codegen.compile import compiled_library

if TYPE_CHECKING:
    import casadi as ca

_LOOP = """
__attribute__((visibility("default")))
void ps_point(const double *in, double *out) {
  const double *arg[1] = {in};
  double *res[1] = {out}, w[PS_WORK + 1];
  casadi_int iw[PS_INTEGERS + 1];
  PS_FUNCTION(arg, res, iw, w, 0);
}

__attribute__((visibility("default")))
void ps_points(long n, const double *const *in, const long *stride, double *out) {
  double point[PS_IN + 1], value[PS_OUT + 1];
  long k;
  int j;
  for (k = 0; k < n; ++k) {
    for (j = 0; j < PS_IN; ++j) point[j] = in[j][k * stride[j]];
    ps_point(point, value);
    for (j = 0; j < PS_OUT; ++j) out[j * n + k] = value[j];
  }
}
"""


def array_source(function: ca.Function) -> str:
    """Return the C file of a CasADi function of one vector, for `ArrayFunction`."""
    from painleve_sym.codegen.c_functions import c_functions

    sizes = {
        "FUNCTION": function.name(),
        "IN": function.numel_in(0),
        "OUT": function.numel_out(0),
        "WORK": function.sz_w(),
        "INTEGERS": function.sz_iw(),
    }
    lines = [f"#define PS_{name} {value}" for name, value in sizes.items()]
    return "\n".join((c_functions([function]), *lines, _LOOP))


class Selection:
    """A function whose results are arguments, by their indices, or numbers: nothing to compile."""

    def __init__(self, entries: Sequence[int | float]) -> None:
        self.entries = tuple(entries)

    def at_point(self, values: Sequence[float]) -> list[float]:
        """Return the k numbers at one point."""
        return [float(values[e]) if isinstance(e, int) else e for e in self.entries]

    def at_points(self, arrays: Sequence[Array], n: int) -> Array:
        """Return the numbers at n points, shape (k, n); see `ArrayFunction.at_points`."""
        out = np.empty((len(self.entries), n))
        for row, e in zip(out, self.entries, strict=True):
            row[:] = arrays[e] if isinstance(e, int) else e
        return out


class ArrayFunction:
    """A function of m numbers to k numbers from a library made from an `array_source`."""

    def __init__(self, library: Path, arguments: int, outputs: int) -> None:
        self.library = library
        self._arguments, self._outputs = arguments, outputs
        loaded = ctypes.CDLL(str(library))
        self._point, self._points = loaded.ps_point, loaded.ps_points
        self._point.argtypes, self._point.restype = (ctypes.c_char_p, ctypes.c_void_p), None
        self._points.argtypes = (ctypes.c_long, *[ctypes.c_void_p] * 3)
        self._points.restype = None
        self._pack = struct.Struct(f"{arguments}d").pack
        self._result = ctypes.c_double * outputs

    @classmethod
    def of(cls, function: ca.Function) -> ArrayFunction:
        """Return a CasADi function of one vector, compiled or from the cache.

        Raises
        ------
        CompilerMissing, CompileError
        """
        library = compiled_library(array_source(function))
        return cls(library, int(function.numel_in(0)), int(function.numel_out(0)))

    def at_point(self, values: Sequence[float]) -> list[float]:
        """Return the k numbers at one point."""
        result = self._result()
        self._point(self._pack(*values), result)
        return list(result)

    def at_points(self, arrays: Sequence[Array], n: int) -> Array:
        """Return the numbers at n points, shape (k, n), the same bits as one by one.

        Arrays are contiguous, shape (n,) or (), one for each argument; a number is the same at
        every point.
        """
        out = np.empty((self._outputs, n))
        addresses = (ctypes.c_void_p * (self._arguments + 1))(*(a.ctypes.data for a in arrays))
        # A number is an array of one entry that the loop stays on.
        strides = (ctypes.c_long * (self._arguments + 1))(*(int(a.ndim > 0) for a in arrays))
        self._points(n, addresses, strides, out.ctypes.data)
        return out
