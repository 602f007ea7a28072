"""Functions that compute the same are compiled once; the parts of a file make one library."""

from __future__ import annotations

import ctypes
import re

import casadi as ca
import numpy as np

from painleve_sym.codegen import compile as compiling
from painleve_sym.codegen.c_functions import Written, c_file, for_single_motions

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
    text = c_file(FUNCTIONS, CALLERS, "#define FACTOR 2\n", [Written(MORE)])
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


def _straight(length):
    """Return a function of that many statements, with two results of many variables."""
    kept = [X[0], X[1]]
    for i in range(length // 3):
        kept.append(ca.sin(kept[-1]) * kept[i // 2] + kept[i // 3])
    halves = [ca.vertcat(*kept[1::2]), ca.cos(kept[7]) - kept[-1]]
    return ca.Function("straight", [X], halves)


def test_a_long_function_is_compiled_in_pieces_with_the_same_bits(tmp_path, monkeypatch):
    monkeypatch.setenv("PAINLEVE_CACHE", str(tmp_path))
    function = _straight(1500)
    rows = function.numel_out(0)
    call = CALLERS.partition("{")[0] + (
        f"{{\n  const double *arg[1] = {{x}};\n  double w[{function.sz_w() + 1}], "
        f"*res[2] = {{y, y + {rows}}};\n  straight(arg, res, 0, w, 0);\n}}\n"
    )
    text = c_file([function], call)
    assert (
        len(re.findall(r"^static __attribute__\(\(noinline\)\) void casadi_f0_\d+\(", text, re.M))
        > 4
    )
    library = ctypes.CDLL(str(compiling.compiled_library(text)))
    x, y = np.array([0.7, -0.3]), np.empty(rows + 1)
    library.all(ctypes.c_void_p(x.ctypes.data), ctypes.c_void_p(y.ctypes.data))
    expected = np.concatenate([np.array(r).ravel() for r in function(x)])
    assert y.tobytes() == expected.tobytes()


def test_no_part_of_a_file_is_empty():
    lanes = "#if PS_LANES > 1\nPS_SHARED double wide(double x) {\n  return x;\n}\n#endif\n"
    short = for_single_motions(
        c_file([_straight(9000), *FUNCTIONS], CALLERS, "", [Written(MORE), Written([lanes])])
    )
    parts = re.split(r"^#if PS_HAS\(\d+\).*\n", short, flags=re.M)[1:]
    assert len(parts) == 4
    assert all(part.partition("#endif")[0].strip() for part in parts)
