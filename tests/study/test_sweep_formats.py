"""Results of sweeps: NetCDF, Zarr and NPZ hold the same numbers; lists of event times."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from painleve_sym.cli import main
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, PainleveError
from painleve_sym.laws.rigid_contact import RigidLaw
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.sweeps.runner import run_sweep
from painleve_sym.study.sweeps.store import Store, check_format, open_store
from painleve_sym.study.sweeps.sweep import Sweep
from tests.study.sweep_cases import SAMPLED, SMALL

BOUNCES = """
model = "rod"
t_end = 0.5
keep = ["y_A", "mode", "event_times", "times_of_touchdown", "time_of_settle"]
events = 4
chunk = 3
state = { theta = 1.5707963267948966 }
law = { name = "rigid" }

[axes]
y_A = [0.01, 0.02, -0.01]
e_energetic = [0.2, 0.5]
"""


def written(text: str, out: Path) -> Path:
    run_sweep(Sweep.from_text(text, "small.toml"), out, threads=1)
    return out


def opened(xarray, path: Path):
    if path.suffix == ".zarr":
        return xarray.open_zarr(path)
    return xarray.open_dataset(path, engine="h5netcdf")


@pytest.mark.parametrize(
    "text",
    [
        pytest.param(SMALL, id="grid"),
        pytest.param(SAMPLED, id="sample", marks=pytest.mark.slow),
        pytest.param(BOUNCES, id="events"),
    ],
)
def test_all_formats_hold_the_same(tmp_path, text):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    with np.load(written(text, tmp_path / "a.npz"), allow_pickle=False) as data:
        plain = {n: data[n] for n in data.files}
    about = json.loads(str(plain.pop("text")))
    seen = []
    for form in ("nc", "zarr"):
        with opened(xarray, written(text, tmp_path / f"a.{form}")) as data:
            assert set(data.variables) == set(plain)
            for name, values in plain.items():
                assert data[name].dtype.kind == values.dtype.kind or name == "event"
                assert np.asarray(data[name].values, values.dtype).tobytes() == values.tobytes()
            assert data.attrs["sweep"] == text
            assert {k: data.attrs[k] for k in data.attrs} == {k: about[k] for k in data.attrs}
            attributes = {
                n: {k: np.asarray(v).tolist() for k, v in data[n].attrs.items()}
                for n in data.variables
            }
            seen.append((attributes, {n: data[n].dims for n in data.variables}))
    assert seen[0] == seen[1]
    assert all(
        "units" in a or "flag_meanings" in a or n in ("event", "occurrence")
        for n, a in seen[0][0].items()
    )


def test_lists_of_event_times_are_those_of_single_runs(tmp_path):
    xarray = pytest.importorskip("xarray")
    data = opened(xarray, written(BOUNCES, tmp_path / "a.nc"))
    assert dict(data.sizes) == {"y_A": 3, "e_energetic": 2, "event": 13, "occurrence": 4}
    simulator = Simulator(model("rod"), RigidLaw())
    for i in range(2):
        for j in range(2):
            point = data.isel(y_A=i, e_energetic=j)
            single = simulator.run(
                {"theta": 1.5707963267948966, "y_A": float(point["y_A"])},
                parameters={"e_energetic": float(point["e_energetic"])},
                t_end=0.5,
            )
            for kind in data["event"].values:
                times = [e.time for e in single.events_of(kind)]
                kept = times[:4] + [np.nan] * (4 - len(times))
                recorded = point["event_times"].sel(event=kind).values
                assert np.array_equal(recorded, kept, equal_nan=True)
                assert point["event_counts"].sel(event=kind) == len(times)
            settled = single.events_of("settle")[0].time
            assert point["time_of_settle"] == settled
            assert point["times_of_touchdown"][0] == single.events_of("touchdown")[0].time
            assert point["count_of_touchdown"] == len(single.events_of("touchdown"))
    below = data.isel(y_A=2)
    meanings = below["stop_reason"].attrs["flag_meanings"].split()
    assert {meanings[k] for k in below["stop_reason"].values} == {"invalid_start"}
    assert np.isnan(below["event_times"].values).all()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("events = 4\n", "", "events says how many"),
        ('"event_times", "times_of_touchdown", ', "", "give both or neither"),
        ("events = 4", "events = 0", "events: got 0, need a whole number from 1"),
        ("events = 4", "events = 1_000_000", "need a whole number from 1 to 10000"),
        ("times_of_touchdown", "times_of_tuchdown", "Did you mean 'times_of_touchdown'"),
        ("time_of_settle", "time_of_setle", r"x: keep: unknown .*'time_of_settle'"),
        ("keep = ", "kep = ", r"kep: unknown key 'kep'. Did you mean 'keep'"),
        ("t_end = 0.5", "t_end = 0.0", r"t_end: got 0.0"),
        ('name = "rigid"', 'name = "rigd"', r"law: unknown contact law 'rigd'"),
        ("chunk = 3", 'chunk = 3\nformat = "zar"', "Did you mean 'zarr'"),
        ("chunk = 3", "chunk = 3\nformat = 3", "unknown format '3'"),
    ],
)
def test_faults_in_events_and_format_are_found_at_once(tmp_path, old, new, message):
    assert old in BOUNCES
    with pytest.raises(InputError, match=message):
        run_sweep(Sweep.from_text(BOUNCES.replace(old, new), "x"), tmp_path / "a.npz")
    assert not list(tmp_path.iterdir())


def test_lists_of_events_count_for_disk_and_memory(tmp_path, monkeypatch):
    large = BOUNCES.replace("[0.2, 0.5]", "{ from = 0.1, to = 0.9, points = 10_000_000 }")
    large = large.replace("events = 4", "events = 1000")
    # Twice 13 kinds and the list of one, 1000 numbers each, at each of 30 million points.
    with pytest.raises(InputError, match=r"30,000,000 points need 6\.7\de\+03 GB of disk"):
        run_sweep(Sweep.from_text(large, "x"), tmp_path / "a.npz")
    monkeypatch.setattr("painleve_sym.motion.batch.machine.available_memory", lambda: 10**9)
    with pytest.raises(InputError, match=r"chunks of 10,000 points need .* GB of memory"):
        run_sweep(
            Sweep.from_text(large.replace("chunk = 3", "chunk = 10_000"), "x"), tmp_path / "a"
        )


def test_a_store_takes_the_place_of_an_older_one_only(tmp_path, monkeypatch):
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    out = written(SMALL, tmp_path / "a.zarr")
    written(SAMPLED, out)
    with xarray.open_zarr(out) as data:
        assert dict(data.sizes) == {"point": 32}
    assert [p.name for p in tmp_path.iterdir()] == ["a.zarr"]
    # A fault at the very end leaves the older one and the chunks.
    sweep = Sweep.from_text(SMALL, "x")

    def full(store, path):
        path.mkdir()
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Store, "_write", full)
        with pytest.raises(PainleveError, match="No space left"):
            run_sweep(sweep, out)
    with xarray.open_zarr(out) as data:
        assert dict(data.sizes) == {"point": 32}
    with open_store(out, sweep, sweep.check_run()) as store:
        assert store.missing() == [] and not (store.folder / "result").exists()


@pytest.mark.parametrize("form", ["npz", "nc", "zarr"])
def test_a_disk_too_full_for_the_result_is_one_clear_error(tmp_path, monkeypatch, form):
    """HDF5 ends the process where a disk becomes full while it writes."""
    pytest.importorskip("xarray")
    pytest.importorskip("zarr")
    out, sweep = tmp_path / f"a.{form}", Sweep.from_text(SMALL, "x")
    free = iter([10**9, 0])
    with monkeypatch.context() as patch:
        patch.setattr("shutil.disk_usage", lambda path: SimpleNamespace(free=next(free)))
        with pytest.raises(
            PainleveError, match=r"No space left on device\. All points are written"
        ):
            run_sweep(sweep, out)
    with monkeypatch.context() as patch:
        patch.setattr(Store, "write", None)  # nothing is computed again
        run_sweep(sweep, out)
    assert [p.name for p in tmp_path.iterdir()] == [out.name]


def test_formats_without_their_package_are_one_clear_error(tmp_path, monkeypatch):
    for form, package in (("zarr", "zarr"), ("nc", "h5netcdf"), ("zarr", "xarray")):
        with monkeypatch.context() as patch:
            patch.setitem(sys.modules, package, None)
            with pytest.raises(InputError, match=r"needs xarray and .*npz"):
                check_format(tmp_path / f"a.{form}")
    check_format(tmp_path / "a.npz")


def test_the_file_names_the_format(tmp_path, monkeypatch, capsys):
    pytest.importorskip("zarr")
    monkeypatch.chdir(tmp_path)
    (tmp_path / "my.bounces.toml").write_text(BOUNCES.replace("chunk = 3", 'format = "zarr"'))
    assert main(["sweep", "my.bounces.toml", "--threads", "1"]) == 0
    shown = capsys.readouterr().out
    assert shown.rstrip().endswith("my.bounces.zarr")
    assert (tmp_path / "my.bounces.zarr" / ".zgroup").is_file()


@pytest.mark.parametrize("kind", ["file", "folder"])
def test_what_is_no_store_is_not_replaced(tmp_path, capsys, kind):
    out = tmp_path / "a.zarr"
    out.write_text("mine") if kind == "file" else out.mkdir()
    (tmp_path / "s.toml").write_text(BOUNCES)
    assert main(["sweep", str(tmp_path / "s.toml"), "--out", str(out)]) == 2
    assert "exists and is not a Zarr store" in capsys.readouterr().err
    assert out.exists() and not (tmp_path / "a.zarr.parts").exists()
