"""Functions that compute the same are compiled once; the parts of a file make one library."""

from __future__ import annotations

import ctypes
import re

import casadi as ca
import numpy as np

from painleve_sym.codegen import compile as compiling
from painleve_sym.codegen.c_functions import c_file

X = ca.SX.sym("x", 2)
FUNCTIONS = [
    ca.Function("first", [X], [X[0] * X[1] + 1]),
    ca.Function("copy", [X], [X[0] * X[1] + 1]),
    ca.Function("other", [X], [X[0] * X[1] - 1]),
]
MORE = ["PS_SHARED double twice(double x) {\n  return FACTOR * x;\n}\n"]
CALLERS = """
__attribute__((visibility("default"))) void all(const double *x, double *y) {
  const double *arg[1] = {x};
  double w[16], *res[1];
  res[0] = y;
  first(arg, res, 0, w, 0);
  res[0] = y + 1;
  copy(arg, res, 0, w, 0);
  res[0] = y + 2;
  other(arg, res, 0, w, 0);
  y[3] = twice(x[0]);
}
"""


def test_copies_are_left_out_and_every_name_still_answers(tmp_path, monkeypatch):
    monkeypatch.setenv("PAINLEVE_CACHE", str(tmp_path))
    text = c_file(FUNCTIONS, CALLERS, "#define FACTOR 2\n", [MORE])
    assert "#define copy first" in text
    assert len(re.findall(r"^static int casadi_f\d+\(", text, re.M)) == 2
    x, y, results = np.array([3.0, 5.0]), np.empty(4), []
    for processors in (1, 4):
        monkeypatch.setattr(compiling.os, "cpu_count", lambda n=processors: n)
        for file in tmp_path.glob("*.so"):
            file.unlink()
        library = ctypes.CDLL(str(compiling.compiled_library(text)))
        y[:] = np.nan
        library.all(ctypes.c_void_p(x.ctypes.data), ctypes.c_void_p(y.ctypes.data))
        results.append(y.tolist())
    assert results == [[16.0, 16.0, 14.0, 6.0]] * 2
