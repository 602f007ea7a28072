"""Sweeps on a Dask cluster: the same numbers, lost workers, schedulers that do not answer."""

from __future__ import annotations

import os
import signal
import threading
from pathlib import Path

import numpy as np
import pytest

from painleve_sym.errors import InputError, PainleveError, PainleveWarning
from painleve_sym.study.sweeps import dask_backend as sweep_dask
from painleve_sym.study.sweeps.runner import run_sweep
from painleve_sym.study.sweeps.store import Store
from painleve_sym.study.sweeps.sweep import Sweep
from tests.study.sweep_cases import SAMPLED, SMALL

# Sockets and loops that the cluster's own threads close late are not what is tested.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
]


@pytest.fixture(scope="module")
def distributed():
    """Return the package, which is not imported where none of these tests runs."""
    return pytest.importorskip("distributed")


def result(sweep: Sweep, out: Path, **options) -> bytes:
    run_sweep(sweep, out, **options)
    return out.read_bytes()


@pytest.mark.parametrize("text", [SMALL, SAMPLED])
def test_a_cluster_gives_the_same_file_bit_for_bit(tmp_path, text, distributed):
    sweep = Sweep.from_text(text, "small.toml")
    alone = result(sweep, tmp_path / "alone.npz", threads=1)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=2, processes=False, dashboard_address=sweep_dask.ANY_PORT
    ) as cluster:
        clustered = result(sweep, tmp_path / "found.npz", cluster=cluster.scheduler_address)
    assert clustered == alone


def test_a_scheduler_that_does_not_answer_is_one_clear_error(tmp_path, monkeypatch):
    monkeypatch.setattr(sweep_dask, "CONNECT_SECONDS", 0.5)
    sweep = Sweep.from_text(SMALL, "small.toml")
    with pytest.raises(PainleveError, match=r"cannot be reached.*0 of 36.*same command again"):
        run_sweep(sweep, tmp_path / "out.npz", cluster="tcp://127.0.0.1:9")
    assert result(sweep, tmp_path / "out.npz", threads=1)


@pytest.mark.parametrize("address", ["scheduler", "", "http://10.0.0.1:8786", "Local"])
def test_what_is_no_address_is_an_error_before_anything_runs(tmp_path, address):
    sweep = Sweep.from_text(SMALL, "small.toml")
    with pytest.raises(InputError, match=r"need the address of a Dask scheduler.* or local"):
        run_sweep(sweep, tmp_path / "out.npz", cluster=address)
    assert not list(tmp_path.iterdir())


def test_workers_may_join_later(tmp_path, distributed):
    sweep = Sweep.from_text(SMALL, "small.toml")
    alone = result(sweep, tmp_path / "alone.npz", threads=1)
    with distributed.LocalCluster(
        n_workers=0, threads_per_worker=1, processes=False, dashboard_address=sweep_dask.ANY_PORT
    ) as cluster:
        joining = threading.Timer(1.0, cluster.scale, [1])
        joining.start()
        with pytest.warns(PainleveWarning, match="no workers there yet"):
            clustered = result(sweep, tmp_path / "found.npz", cluster=cluster.scheduler_address)
        joining.join()
    assert clustered == alone


@pytest.mark.slow
def test_a_killed_worker_process_loses_nothing(tmp_path, monkeypatch, distributed):
    text = SMALL.replace("points = 4", "points = 200").replace("chunk = 10", "chunk = 50")
    sweep = Sweep.from_text(text, "small.toml")
    alone = result(sweep, tmp_path / "alone.npz", threads=1)
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=sweep_dask.ANY_PORT
    ) as cluster:
        victims = [w.pid for w in cluster.workers.values()]
        killed = []

        write = Store.write

        def kill_one(store, start, chunk):
            write(store, start, chunk)
            if start >= 150 and not killed:
                killed.append(victims[0])
                os.kill(victims[0], signal.SIGKILL)

        monkeypatch.setattr(Store, "write", kill_one)
        clustered = result(sweep, tmp_path / "found.npz", cluster=cluster.scheduler_address)
    assert killed
    assert clustered == alone
    assert np.load(tmp_path / "found.npz")["stop_reason"].shape == (200, 3, 3)
