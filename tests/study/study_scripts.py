"""Scripts of `examples/studies` as modules."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

STUDIES = Path(__file__).parents[2] / "examples" / "studies"


def study_script(path):
    """Return the script at `path` in the folder of the studies, run as a module."""
    spec = importlib.util.spec_from_file_location(f"{Path(path).stem}_study", STUDIES / path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module
