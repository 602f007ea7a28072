"""A folder of the cache of each test's own."""

import pytest


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """Folder of the cache, which is not made yet."""
    folder = tmp_path / "cache"
    monkeypatch.setenv("PAINLEVE_CACHE", str(folder))
    return folder
