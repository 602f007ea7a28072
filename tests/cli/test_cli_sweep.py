"""The command sweep: result, summary, faults, resumption."""

from __future__ import annotations

import numpy as np
import pytest

from tests.cli.cli_helpers import run
from tests.study.sweep_cases import SMALL


@pytest.fixture
def file(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path


def test_sweep_writes_the_result_and_prints_what_it_holds(capsys, file, tmp_path):
    code, out, _ = run(capsys, "sweep", file, "--out", "small.npz", "--threads", "1")
    assert code == 0
    assert "36 points over theta [rad], theta_dot [rad/s], mu [1]" in out
    assert "ended by 36 until" in out
    assert sorted(p.name for p in tmp_path.iterdir()) == ["small.npz", "small.toml"]
    with np.load("small.npz") as data:
        assert data["final_theta_dot"].shape == (4, 3, 3)


def test_sweep_names_its_result_after_the_file(capsys, file, tmp_path):
    xarray = pytest.importorskip("xarray")
    code, _, _ = run(capsys, "sweep", file)
    assert code == 0
    with xarray.open_dataset(tmp_path / "small.nc", engine="h5netcdf") as data:
        assert data.attrs["title"] == "a small sweep"


def test_sweep_says_how_many_energy_balances_do_not_close(capsys, file, monkeypatch):
    code, out, _ = run(capsys, "sweep", file, "--out", "small.npz", "--threads", "1")
    assert code == 0 and "energy balance" not in out
    with np.load("small.npz") as data:
        residuals = np.sort(data["energy_residual"].ravel())
    assert len(residuals) == 36 and 0 < residuals[0] < residuals[-1] < 1e-6
    # The fifth largest of four chunks, and those above it.
    limits = "painleve_sym.study.sweeps.store.open_from"
    monkeypatch.setattr(limits, lambda rtol: residuals[-5] if rtol == 1e-8 else 0.0)
    code, out, _ = run(capsys, "sweep", file, "--out", "small.npz", "--threads", "1")
    assert code == 3
    said = " ".join(out.split())
    assert "The energy balance of 5 of 36 motions does not close" in said
    assert f"energy_residual up to {residuals[-1]:.2g}" in said
