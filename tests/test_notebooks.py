"""The notebooks run from top to bottom, and are kept without outputs."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import matplotlib.pyplot as plt
import pytest

FOLDER = Path(__file__).parents[1] / "docs" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
SLOW = {"regenerate-the-paper", "your-own-mechanism"}


def cells(path):
    return json.loads(path.read_text("utf-8"))["cells"]


def run_cell(source, names):
    """Execute a cell; show its last expression as a notebook would."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    exec(compile(tree, "cell", "exec"), names)
    if last is not None:
        value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
        show = getattr(value, "_repr_html_", None) or getattr(value, "_repr_latex_", None)
        assert show() if show else repr(value)


@pytest.mark.parametrize(
    "path",
    [
        pytest.param(p, id=p.stem, marks=pytest.mark.slow if p.stem in SLOW else ())
        for p in NOTEBOOKS
    ],
)
def test_a_notebook_runs(path, monkeypatch):
    # The backend without a display ignores this, with a warning.
    monkeypatch.setattr(plt, "show", lambda: plt.close("all"))
    names = {"__name__": "__main__"}
    for cell in cells(path):
        if cell["cell_type"] == "code":
            run_cell("".join(cell["source"]), names)


def test_there_are_three_notebooks_without_outputs():
    assert len(NOTEBOOKS) == 3
    for path in NOTEBOOKS:
        for cell in cells(path):
            assert cell.get("outputs", []) == [] and cell.get("execution_count") is None
