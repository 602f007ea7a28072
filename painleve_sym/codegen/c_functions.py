"""CasADi functions as C text, less the code about them that nobody calls."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import casadi as ca

# Each function comes with a dozen that describe it (names, sparsity, work space). Static ones that
# are not called cost the compiler nothing; exported ones cost half of its time.
_EXPORT = "#define CASADI_SYMBOL_EXPORT static __attribute__((unused))\n"


def c_functions(functions: Iterable[ca.Function]) -> str:
    """Return the C text of functions, to be used within the same file."""
    options: Any = {"with_header": False, "with_export": True, "casadi_int": "long long int"}
    generator = ca.CodeGenerator("generated.c", options)
    for f in functions:
        generator.add(f)
    with tempfile.TemporaryDirectory() as folder:
        generator.generate(f"{folder}/")
        text = Path(folder, "generated.c").read_text("utf-8")
    # No caller passes null pointers; the tests for them cost half of the compilation.
    text = re.sub(r"if \(res\[(\d+)\]!=0\) res", "res", text)
    return _EXPORT + re.sub(r"arg\[(\d+)\]\? (arg\[\1\]\[\d+\]) : 0", r"\2", text)
