"""Settings of the tests: quick compilation, and the same examples in every run or new ones."""

import gc
import os

import pytest
from hypothesis import settings

# Compiled quickly, since motions of tests are short. An empty value selects the package's own
# levels, as the fixture `optimized`, the scripts of studies and the benchmarks do.
os.environ.setdefault("PAINLEVE_OPTIMIZE", "0")

# Deterministic examples: a failure is caused by the change, not by sampling or by a busy machine.
settings.register_profile("repeatable", derandomize=True, print_blob=True, deadline=None)
settings.register_profile("explore", print_blob=True, deadline=None)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


def pytest_collection():
    """Collect no garbage while modules and tests are made, which stay to the end."""
    gc.disable()


def pytest_collection_finish():
    """Collect garbage from now on, but leave these modules and tests out of it."""
    gc.enable()
    gc.collect()
    gc.freeze()
    gc.set_threshold(20_000, 20, 20)


@pytest.fixture
def optimized(monkeypatch):
    """Compile as for users: for tests of compiled code on every mechanism, and for long motions."""
    monkeypatch.setenv("PAINLEVE_OPTIMIZE", "")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """Folder of the cache, a test's own, which is not made yet."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("PAINLEVE_CACHE", str(folder))
    return folder
