"""The examples of docs/sweeps.md are sweeps."""

import re
from pathlib import Path

import pytest

from painleve_sym.study.sweeps.sweep import Sweep

ROOT = Path(__file__).parents[2]
PAGE = ROOT / "docs" / "sweeps.md"


def test_sweep_files_of_the_page_are_sweeps():
    grid, sample = re.findall(r"```toml\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert Sweep.from_text(grid, "grid").space.points == 200
    text = grid[: grid.index("[axes]")].replace("parameters = { E = 209e9 }", "") + sample
    assert Sweep.from_text(text, "sample").space.points == 1_000_000


@pytest.mark.parametrize("path", sorted((ROOT / "examples" / "sweeps").glob("*.toml")), ids=str)
def test_example_files_are_sweeps_that_run(path):
    sweep = Sweep.read(path)
    results = sweep.compute(0, 8)
    assert {len(v) for v in results.values()} == {8}
    assert tuple(results) == tuple(sweep.columns)
