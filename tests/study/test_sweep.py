"""Sweeps: points, checks before anything runs, chunks that resume, labelled results."""

from __future__ import annotations

import contextlib
import functools
import itertools
import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import painleve_sym as ps
from painleve_sym.at.cases import classify
from painleve_sym.codegen.named_mechanisms import model
from painleve_sym.errors import InputError, PainleveError
from painleve_sym.laws.catalogue import law
from painleve_sym.mechanics.toml.faults import Faults
from painleve_sym.motion.simulator import Simulator
from painleve_sym.study.sweeps import store as sweep_store
from painleve_sym.study.sweeps.runner import check_room, run_sweep
from painleve_sym.study.sweeps.space import Grid, Range, Sample, read_space
from painleve_sym.study.sweeps.store import Store, open_store, parts_folder
from painleve_sym.study.sweeps.sweep import CASES, Sweep
from tests.study.sweep_cases import SAMPLED, SMALL


def sweep_of(text: str) -> Sweep:
    return Sweep.from_text(text, "small.toml")


def finished(sweep: Sweep, out: Path) -> bytes:
    run_sweep(sweep, out, threads=2)
    assert not parts_folder(out).exists()
    return out.read_bytes()


def written(sweep: Sweep, out: Path) -> Path:
    """Write all chunks but not the result; return the folder of the columns."""
    with open_store(out, sweep, sweep.check_run()) as store:
        for start in store.missing():
            store.write(start, sweep.compute(start, sweep.stop(start)))
    return parts_folder(out)


def arrays(path: Path) -> dict[str, np.ndarray]:
    with np.load(path, allow_pickle=False) as data:
        return {n: data[n] for n in data.files if n != "text"}


# ---- points ----


@settings(max_examples=50)
@given(
    st.sampled_from(["sobol", "uniform"]),
    st.integers(1, 60),
    st.integers(0, 5),
    st.lists(st.integers(1, 59), max_size=4),
)
def test_points_of_a_sample_do_not_depend_on_the_chunks(method, points, seed, cuts):
    sample = Sample({"a": Range(1.0, 2.0), "b": Range(1e-3, 1e3, "log")}, points, method, seed)
    whole = sample.values(0, points)
    ends = sorted({0, points, *(c for c in cuts if c < points)})
    for start, stop in itertools.pairwise(ends):
        part = sample.values(start, stop)
        for name in sample.names:
            assert part[name].tobytes() == whole[name][start:stop].tobytes()
    assert ((whole["a"] >= 1) & (whole["a"] <= 2)).all()
    assert ((whole["b"] >= 1e-3) & (whole["b"] <= 1e3 * (1 + 1e-12))).all()


def test_a_sobol_sample_fills_the_box_more_evenly_than_chance():
    n = 1024
    for method, worst in (("sobol", 2), ("uniform", 60)):
        values = Sample({"a": Range(0.0, 1.0)}, n, method, 1).values(0, n)["a"]
        counts = np.histogram(values, bins=64, range=(0, 1))[0]
        assert np.abs(counts - n / 64).max() <= worst
        assert (method == "uniform") == (np.abs(counts - n / 64).max() > 0)


@settings(max_examples=50)
@given(st.lists(st.integers(1, 5), min_size=1, max_size=4))
def test_a_grid_holds_every_combination_once_in_order(shape):
    grid = Grid({f"a{i}": np.arange(k) + 10.0 * i for i, k in enumerate(shape)})
    values = grid.values(0, grid.points)
    expected = np.meshgrid(*grid.axes.values(), indexing="ij")
    for name, array in zip(grid.names, expected, strict=True):
        assert values[name].tolist() == array.ravel().tolist()


def test_log_axis_ends_where_it_says_and_has_even_ratios():
    axes = {"E": {"from": 1e10, "to": 1e14, "points": 9, "scale": "log"}}
    values = read_space(Faults("x", None), axes, None, lambda value, *_: value).axes["E"]
    assert values[0] == 1e10 and values[-1] == 1e14
    assert np.diff(np.log10(values)) == pytest.approx(0.5)


def test_numbers_of_a_sweep_may_have_units():
    in_degrees = SMALL.replace("from = 0.95, to = 1.15", 'from = "45 deg", to = "90 deg"')
    in_degrees = in_degrees.replace("[0.5, 1.0, 2.0]", '["30 deg/s", 1.0]')
    sweep = Sweep.from_text(in_degrees.replace("t_end = 0.01", 't_end = "10 ms"'), "x")
    axes = sweep.space.axes
    assert axes["theta"] == pytest.approx(np.pi / 4 * np.array([1, 4 / 3, 5 / 3, 2]), rel=1e-14)
    assert axes["theta_dot"] == pytest.approx([np.pi / 6, 1.0], rel=1e-14)
    assert sweep.scenario.t_end == 0.01


def test_every_mistake_of_a_sweep_is_named_with_its_line():
    wrong = SMALL.replace("chunk = 10", "chunk = 0").replace("points = 4", "points = 1")
    with pytest.raises(InputError) as caught:
        Sweep.from_text(wrong.replace("[0.5, 1.0, 2.0]", '[0.5, "1 kg"]'), "x")
    for place in ("line 9, chunk: got 0", "line 17, axes.theta.points: got 1"):
        assert place in str(caught.value)
    assert "line 18, axes.theta_dot[2]: got the unit [kg]" in str(caught.value)


# ---- one clear error before anything runs ----


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("theta_dot = [", "thta_dot = [", "unknown axis 'thta_dot'. Did you mean 'theta_dot'"),
        ("theta_dot = [0.5, 1.0, 2.0]", "theta_dot = []", "got no values"),
        ("theta_dot = [0.5, 1.0, 2.0]", "theta_dot = [0.5, nan]", r"axes.theta_dot\[2\]: got nan"),
        ("theta_dot = [0.5, 1.0, 2.0]", "theta_dot = [0.5, 0.5]", "a value twice"),
        ("theta_dot = [0.5, 1.0, 2.0]", 'theta_dot = ["a"]', "need a number"),
        ("theta_dot = [0.5, 1.0, 2.0]", "theta_dot = 3", "need a table"),
        ("points = 4", "points = 1", "from 2 to"),
        ("points = 4", "point = 4", "Did you mean 'points'"),
        ("from = 1.42", "from = -1.42", "> 0 on a log scale"),
        ("from = 0.95, to = 1.15", "from = 1.15, to = 1.15", "two different numbers"),
        ('scale = "log"', 'scale = "lg"', "Did you mean 'log'"),
        ("[axes]", "[axis]", "unknown key 'axis'"),
        ("x_A_dot = -1.0", "x_A_dot = -1.0, theta = 1.0", "both given and varied"),
        ('"case"', '"cse"', "unknown quantity 'cse'"),
        ('"max_normal_force"', '"max_normal_forc"', "Did you mean 'normal_force'"),
        ("chunk = 10", "chunk = 0", "chunk: got 0"),
        ("t_end = 0.01\n", "", "no end time"),
        ("t_end = 0.01\n", "t_end = 0.01\nrule = 'newton'\n", "rule: plays no part"),
        ('"separation"', '"separaton"', "Did you mean 'separation'"),
        ("E = 20.9e14", "EE = 20.9e14", "unknown parameter 'EE'"),
        ("[axes]", "[sample]\npoints = 3\n[axes]", "got both of"),
        ("from = 1.42, to = 1.8", "from = 1.42, to = inf", "need a finite number"),
    ],
)
def test_a_faulty_file_is_one_clear_error_before_anything_runs(tmp_path, old, new, message):
    assert old in SMALL
    out = tmp_path / "out.npz"
    with pytest.raises(InputError, match=message):
        run_sweep(sweep_of(SMALL.replace(old, new)), out)
    assert not list(tmp_path.iterdir())


def test_a_parameter_out_of_range_anywhere_on_an_axis_is_an_error_at_once(tmp_path):
    text = SMALL.replace("theta_dot = [0.5, 1.0, 2.0]", "e_energetic = [0.5, 1.5, 0.6]")
    with pytest.raises(InputError, match="e_energetic"):
        run_sweep(sweep_of(text), tmp_path / "out.npz")
    assert not list(tmp_path.iterdir())


def test_a_sampled_parameter_out_of_range_is_an_error_at_once(tmp_path):
    with pytest.raises(InputError, match="e_energetic"):
        run_sweep(sweep_of(SAMPLED.replace("to = 0.9", "to = 1.9")), tmp_path / "out.npz")
    assert not list(tmp_path.iterdir())


def test_more_points_than_the_disk_holds_are_an_error(tmp_path):
    text = SAMPLED.replace("points = 32", 'points = 100_000_000_000\nmethod = "uniform"')
    with pytest.raises(InputError, match=r"points need .* GB of disk"):
        run_sweep(sweep_of(text), tmp_path / "out.npz")


def test_a_sweep_that_is_taken_up_needs_room_for_what_is_missing(tmp_path, monkeypatch):
    sweep, out = sweep_of(SMALL), tmp_path / "out.npz"
    row = sweep.compute(0, 1)
    need = 2 * 36 * sum(column.nbytes for column in row.values())

    def room(free):
        monkeypatch.setattr(shutil, "disk_usage", lambda _: SimpleNamespace(free=free))
        check_room(sweep, out, row)

    room(need)
    with pytest.raises(InputError, match="points need"):
        room(need - 1)
    (tmp_path / "out.npz.parts").mkdir()
    (tmp_path / "out.npz.parts" / "theta.npy").write_bytes(bytes(1000))
    written = 512 * (tmp_path / "out.npz.parts" / "theta.npy").stat().st_blocks
    assert written > 0
    room(need - written)
    with pytest.raises(InputError, match="points need"):
        room(need - written - 1)


def test_a_summary_has_the_ranges_and_counts_of_all_chunks(tmp_path):
    out = tmp_path / "out.npz"
    ends = SMALL.replace("t_end = 0.01", "t_end = 4e-4").replace("chunk = 10", "chunk = 5")
    summary = run_sweep(sweep_of(ends), out)
    swept = arrays(out)
    with np.load(out) as data:
        codes = json.loads(json.loads(str(data["text"]))["codes"])
    reasons = codes["stop_reason"]
    counts = {n: int((swept["stop_reason"] == code).sum()) for n, code in reasons.items()}
    assert summary["stop_reasons"] == {n: c for n, c in counts.items() if c}
    assert len(summary["stop_reasons"]) == 2
    for name, held in summary["quantities"].items():
        there = swept[name][np.isfinite(swept[name])]
        assert (held["from"], held["to"]) == (there.min(), there.max())
        assert held["missing"] == swept[name].size - there.size
    assert summary["quantities"]["time_of_separation"]["missing"] > 0


def test_another_seed_draws_other_points():
    first, again = (sweep_of(SAMPLED).space.values(0, 32) for _ in range(2))
    other = sweep_of(SAMPLED.replace("seed = 3", "seed = 4")).space.values(0, 32)
    for name, values in first.items():
        assert values.tobytes() == again[name].tobytes()
        assert not np.intersect1d(values, other[name]).size


# ---- the numbers ----


def test_a_sweep_is_the_single_runs_bit_for_bit(tmp_path):
    sweep, out = sweep_of(SMALL), tmp_path / "out.npz"
    finished(sweep, out)
    swept = arrays(out)
    simulator = Simulator(model("rod"), law("bilinear-hertz", reload="virgin"))
    for i, j, k in ((0, 0, 0), (3, 1, 2), (2, 2, 1)):
        start = {
            "theta": float(swept["theta"][i]),
            "theta_dot": float(swept["theta_dot"][j]),
            "x_A_dot": -1.0,
        }
        single = simulator.run(
            start,
            parameters={"E": 20.9e14, "n": 1.764, "mu": float(swept["mu"][k])},
            t_end=0.01,
            until="separation",
            rtol=1e-8,
        )
        assert swept["final_theta_dot"][i, j, k] == single.final["theta_dot"]
        assert swept["time_of_separation"][i, j, k] == single.final_time
        case = classify(model("rod"), start, parameters={"mu": float(swept["mu"][k])}).case.value
        assert swept["case"][i, j, k] == CASES[case]


@pytest.mark.parametrize("text", [SMALL, SAMPLED])
def test_the_result_does_not_depend_on_chunks_or_threads(tmp_path, text):
    numbers = []
    for chunk, threads in ((10, 1), (7, 2), (1000, 3)):
        sweep = sweep_of(text.replace("chunk = 10", f"chunk = {chunk}"))
        out = tmp_path / f"{chunk}.npz"
        run_sweep(sweep, out, threads=threads)
        numbers.append({n: a.tobytes() for n, a in arrays(out).items()})
    assert numbers[0] == numbers[1] == numbers[2]


def test_a_swept_initial_force_separates_lift_off_from_impact():
    text = """
    model = "rod"
    t_end = 2e-3
    until = ["separation"]
    keep = ["count_of_slip_stop", "case"]
    state = { theta = 1.0, theta_dot = 5.0, x_A_dot = -1.0 }
    law = { name = "bilinear-hertz", parameters = { E = 20.9e14 } }
    axes = { initial_force = [300.0, 400.0] }
    """
    results = sweep_of(text).compute(0, 2)
    assert results["case"].tolist() == [CASES["indeterminate"]] * 2
    # The impact stops the slip, lift-off does not.
    assert results["count_of_slip_stop"].tolist() == [0, 1]


# ---- interruption ----


def test_an_interrupted_sweep_resumes_without_repeating(tmp_path, monkeypatch):
    sweep, out = sweep_of(SMALL), tmp_path / "out.npz"
    whole = finished(sweep, tmp_path / "whole.npz")
    computed = []
    compute = Sweep.compute

    def counted(self, start, stop, threads=None):
        if stop - start > 1:
            computed.append(start)
            if len(computed) == 3:
                raise KeyboardInterrupt
        return compute(self, start, stop, threads)

    monkeypatch.setattr(Sweep, "compute", counted)
    with pytest.raises(KeyboardInterrupt):
        run_sweep(sweep, out)
    assert finished(sweep, out) == whole
    assert computed == [0, 10, 20, 20, 30]


def test_a_damaged_chunk_is_computed_again(tmp_path):
    sweep, out = sweep_of(SMALL), tmp_path / "out.npz"
    whole = finished(sweep, tmp_path / "whole.npz")
    folder = written(sweep, out)
    path, row = folder / "final_theta_dot.npy", sweep.check_run()

    def missing() -> list[int]:
        with open_store(out, sweep, row) as store:
            return store.missing()

    assert missing() == []
    content = bytearray(path.read_bytes())
    content[-8 * 36 + 8 * 12] ^= 1  # one bit of point 12
    path.write_bytes(content)
    assert missing() == [10]
    path.write_bytes(content[:-100])
    assert missing() == [0, 10, 20, 30]
    path.unlink()
    assert finished(sweep, out) == whole


@pytest.mark.parametrize(
    "name",
    [
        sweep_store.SUMS,
        pytest.param("final_theta_dot", marks=pytest.mark.slow),
        pytest.param("stop_reason", marks=pytest.mark.slow),
    ],
)
def test_a_flipped_bit_anywhere_in_a_column_is_computed_again(tmp_path, name):
    """Also in its header, which then has any text."""
    sweep, out = sweep_of(SMALL), tmp_path / "out.npz"
    path, row = written(sweep, out) / f"{name}.npy", sweep.check_run()
    rows = functools.cache(lambda start: sweep.compute(start, sweep.stop(start)))
    content = path.read_bytes()
    header = len(content) - len(np.load(path).tobytes())
    for place in (*range(header), header + 5, len(content) - 1):
        damaged = bytearray(content)
        damaged[place] ^= 1 << place % 8
        path.write_bytes(damaged)
        with open_store(out, sweep, row) as store:
            missing = store.missing()
            assert missing == [0, 10, 20, 30] if place < header else len(missing) == 1
            for start in missing[:1]:
                store.write(start, rows(start))
        path.write_bytes(content)
    assert finished(sweep, out) == finished(sweep, tmp_path / "whole.npz")


@pytest.mark.parametrize("last", ["stop_reason", "final_theta_dot", sweep_store.SUMS])
def test_a_chunk_counts_when_all_of_it_is_written(tmp_path, monkeypatch, last):
    """An end anywhere within the writing of a chunk, also in the middle of a column."""
    sweep, out = sweep_of(SMALL), tmp_path / "out.npz"
    whole = finished(sweep, tmp_path / "whole.npz")
    put = Store._put

    def ended(self, name, first, rows):
        if name == last and first in (2, 20):  # the third chunk
            put(self, name, first, rows[: len(rows) // 2])
            raise KeyboardInterrupt
        put(self, name, first, rows)

    with monkeypatch.context() as patch:
        patch.setattr(Store, "_put", ended)
        with pytest.raises(KeyboardInterrupt):
            run_sweep(sweep, out, threads=1)
    with open_store(out, sweep, sweep.check_run()) as store:
        assert store.missing() == [20, 30]
    assert finished(sweep, out) == whole


def test_a_full_disk_loses_nothing_and_says_how_to_resume(tmp_path, monkeypatch):
    sweep, out = sweep_of(SMALL), tmp_path / "out.npz"
    whole = finished(sweep, tmp_path / "whole.npz")
    write = Store.write

    def full(self, start, chunk):
        if start == 20:
            raise OSError(28, os.strerror(28))
        write(self, start, chunk)

    with monkeypatch.context() as patch:
        patch.setattr(Store, "write", full)
        with pytest.raises(PainleveError, match=r"No space left.*20 of 36.*same command again"):
            run_sweep(sweep, out)
    assert finished(sweep, out) == whole


def test_chunks_of_another_sweep_or_build_are_not_mixed(tmp_path):
    sweep, out = sweep_of(SMALL), tmp_path / "out.npz"
    manifest = written(sweep, out) / sweep_store.MANIFEST
    with pytest.raises(InputError, match="another sweep"):
        run_sweep(sweep_of(SMALL.replace("0.95", "0.96")), out)
    mark = json.loads(manifest.read_text())
    manifest.write_text(json.dumps(mark | {"provenance_cache_key": "other"}))
    with pytest.raises(InputError, match="another cache_key, and"):
        run_sweep(sweep, out)
    manifest.write_text(json.dumps(mark | {"mechanism_file": "other"}))
    with pytest.raises(InputError, match="another sweep"):
        run_sweep(sweep, out)


@pytest.mark.slow
def test_a_folder_is_written_by_one_process_at_a_time(tmp_path):
    out = tmp_path / "out.npz"
    (tmp_path / "s.toml").write_text(SMALL)

    def other():
        command = [sys.executable, "-m", "painleve_sym", "sweep", "s.toml", "--out", "out.npz"]
        where = {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": str(Path.cwd())}}
        return subprocess.run(command, **where, capture_output=True, text=True)

    with open_store(out, sweep_of(SMALL), sweep_of(SMALL).check_run()):
        refused = other()
        assert refused.returncode == 2 and refused.stderr.count("\n") == 1
        assert f"process {os.getpid()} on " in refused.stderr
        assert "Fix: wait until it ends" in refused.stderr and not out.exists()
    # Of another file with the same points: rejected, since its text differs.
    (tmp_path / "s.toml").write_text(SMALL + "\n")
    assert "another sweep" in other().stderr
    (tmp_path / "s.toml").write_text(SMALL)
    assert other().returncode == 0 and out.exists()


@pytest.mark.slow
def test_a_sweep_killed_outright_resumes_from_what_is_written(tmp_path):
    text = SMALL.replace("points = 4", "points = 400").replace("chunk = 10", "chunk = 200")
    (tmp_path / "s.toml").write_text(text)
    command = [sys.executable, "-m", "painleve_sym", "sweep", "s.toml", "--threads", "1"]
    where = {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": str(Path.cwd())}}
    run = subprocess.Popen([*command, "--out", "out.npz"], **where, stderr=subprocess.PIPE)
    sums, kept = tmp_path / "out.npz.parts" / f"{sweep_store.SUMS}.npy", 0
    limit = time.monotonic() + 120
    while kept < 3 and time.monotonic() < limit:
        time.sleep(0.01)
        with contextlib.suppress(OSError, ValueError, EOFError):
            kept = np.count_nonzero(np.load(sums))
    run.send_signal(signal.SIGKILL)
    run.communicate()
    assert 3 <= np.count_nonzero(np.load(sums)) < 18
    again = subprocess.run([*command, "--out", "out.npz"], **where, capture_output=True, text=True)
    assert again.returncode == 0, again.stderr
    assert "painleve: 0 of" not in again.stderr
    subprocess.run([*command, "--out", "whole.npz"], **where, check=True, capture_output=True)
    assert (tmp_path / "out.npz").read_bytes() == (tmp_path / "whole.npz").read_bytes()


KILLED = """
import os, pathlib, signal, sys
from painleve_sym.study.sweeps.runner import run_sweep
from painleve_sym.study.sweeps.sweep import Sweep
from tests.study.sweep_cases import SMALL

sweep, out = Sweep.from_text(SMALL, "small.toml"), pathlib.Path("out.npz")
run_sweep(sweep, out, threads=1)
whole, kills = out.read_bytes(), 0
while True:
    out.unlink()
    child = os.fork()
    if not child:
        left = kills + 1

        def hook(event, given):
            global left
            if event in ("os.remove", "os.rmdir") or any(".parts" in str(g) for g in given):
                left -= 1
                if left == 0:
                    os.kill(os.getpid(), signal.SIGKILL)

        sys.addaudithook(hook)
        run_sweep(sweep, out, threads=1)
        os._exit(0)
    if os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 0:
        break
    kills += 1
    run_sweep(sweep, out, threads=1)
    assert out.read_bytes() == whole and os.listdir() == ["out.npz"], (kills, os.listdir())
print(kills)
"""


@pytest.mark.slow
def test_a_sweep_killed_at_any_file_operation_resumes(tmp_path):
    """The process kills itself at each file operation in its folder, one after another."""
    command = [sys.executable, "-c", KILLED]
    where = {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": str(Path.cwd())}}
    ended = subprocess.run(command, **where, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    assert int(ended.stdout) >= 50


# ---- results ----


def test_a_netcdf_result_is_labelled_and_says_where_it_comes_from(tmp_path):
    xarray = pytest.importorskip("xarray")
    sweep, out = sweep_of(SMALL), tmp_path / "out.nc"
    finished(sweep, out)
    finished(sweep, tmp_path / "out.npz")
    plain = arrays(tmp_path / "out.npz")
    with xarray.open_dataset(out, engine="h5netcdf") as data:
        assert dict(data.sizes) == {"theta": 4, "theta_dot": 3, "mu": 3}
        for name in sweep.kept:
            name = "final_theta_dot" if name == "theta_dot" else name
            assert data[name].values.tobytes() == plain[name].tobytes()
        assert data["theta"].values.tobytes() == plain["theta"].tobytes()
        units = {n: data[n].attrs["units"] for n in ("theta", "mu", "integral_normal_force")}
        assert units == {"theta": "rad", "mu": "1", "integral_normal_force": "N s"}
        assert data["case"].attrs["flag_meanings"].split()[3] == "inconsistent"
        assert data.attrs["sweep"] == SMALL
        for key in ("painleve_sym", "compiler", "flags", "cache_key", "numpy"):
            assert data.attrs[f"provenance_{key}"]


def test_a_sampled_result_holds_its_points(tmp_path):
    xarray = pytest.importorskip("xarray")
    out = tmp_path / "out.nc"
    sweep = sweep_of(SAMPLED)
    finished(sweep, out)
    with xarray.open_dataset(out, engine="h5netcdf") as data:
        assert dict(data.sizes) == {"point": 32}
        expected = sweep.space.values(0, 32)
        for name in sweep.space.names:
            assert data[name].values.tobytes() == expected[name].tobytes()


def test_a_mechanism_file_travels_with_the_sweep(tmp_path):
    file = tmp_path / "own.toml"
    file.write_text(Path("examples/mechanisms/rod.toml").read_text())
    text = SMALL.replace('model = "rod"', f'model = "{file}"')
    sweep = sweep_of(text)
    assert sweep.mechanism_text == file.read_text()
    file.unlink()
    # A worker elsewhere has the texts alone.
    there = Sweep.from_text(text, "x", sweep.mechanism_text)
    assert there.mechanism.name == "rod-from-file"
    about = sweep_store.attributes(sweep)
    assert sweep_store.attributes(there) == about != sweep_store.attributes(sweep_of(SMALL))
    changed = Sweep.from_text(text, "x", sweep.mechanism_text + "\n")
    assert sweep_store.attributes(changed) != about


@pytest.mark.parametrize("name", [sweep_store.MANIFEST, "notes.txt"])
def test_a_folder_is_taken_up_only_if_it_is_one_of_a_sweep(tmp_path, name):
    folder = tmp_path / "out.npz.parts"
    folder.mkdir()
    (folder / name).write_text("[]")
    with pytest.raises(InputError, match="not one of a sweep"):
        run_sweep(sweep_of(SMALL), tmp_path / "out.npz")
    assert (folder / name).read_text() == "[]"


@pytest.mark.parametrize("name", ["lock", "column.npy", f"{sweep_store.SUMS}.npy"])
def test_a_sweep_follows_no_link_that_was_put_into_its_folder(tmp_path, name):
    out, victim = tmp_path / "out.npz", tmp_path / "victim"
    victim.write_text("precious")
    with open_store(out, (sweep := sweep_of(SMALL)), sweep.check_run()):
        pass
    planted = parts_folder(out) / name.replace("column", next(iter(sweep.columns)))
    planted.unlink()
    planted.symlink_to(victim)
    with pytest.raises(InputError, match=r"symbolic links\. Fix: give another --out"):
        run_sweep(sweep, out)
    assert victim.read_text() == "precious"


def test_a_folder_that_another_made_is_not_taken_up(tmp_path, monkeypatch):
    out, elsewhere = tmp_path / "out.npz", tmp_path / "elsewhere"
    elsewhere.mkdir()
    parts_folder(out).symlink_to(elsewhere)
    with pytest.raises(InputError, match=r"it is a link\. Fix: give another --out"):
        run_sweep(sweep_of(SMALL), out)
    parts_folder(out).unlink()
    parts_folder(out).mkdir()
    sweep = sweep_of(SMALL)
    row = sweep.check_run()
    monkeypatch.setattr(os, "geteuid", lambda: out.parent.stat().st_uid + 1)
    with (
        pytest.raises(InputError, match="it belongs to another user"),
        open_store(out, sweep, row),
    ):
        pass
    assert list(elsewhere.iterdir()) == list(parts_folder(out).iterdir()) == []


CLOSED = """
model = "pr-robot"
t_end = 1e-4
close = "theta"
keep = ["theta", "x_dot"]

[law]
name = "hertz"

[axes]
h = [0.7, 0.8, 1.5]
"""


def test_a_sweep_closes_the_contact_at_every_point():
    sweep = sweep_of(CLOSED)
    ends = sweep.compute(0, 3)
    reasons = sweep.codes("stop_reason")
    assert ends["stop_reason"].tolist() == [reasons[r] for r in ("t_end", "t_end", "invalid_start")]
    for i, height in enumerate((0.7, 0.8)):
        # Without a state the motion begins at the start of the mechanism.
        run = ps.simulate("pr-robot", "hertz", parameters={"h": height}, t_end=1e-4, close="theta")
        assert (run.final["theta"], run.final["x_dot"]) == (ends["theta"][i], ends["x_dot"][i])
    with pytest.raises(InputError, match="close: theta is varied"):
        sweep_of(CLOSED.replace("h = [0.7, 0.8, 1.5]", "theta = [0.7, 0.8]"))
