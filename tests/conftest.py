"""Every test run has a store of its own: what it keeps and finds there is nobody else's."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest
from hypothesis import settings

# The same examples everywhere; the profile `random` draws others.
# How long an example takes says more about the machine's other work than about the code.
settings.register_profile("backsolve", deadline=None, derandomize=True)
settings.register_profile("random", deadline=None, derandomize=False)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "backsolve"))


@pytest.fixture(scope="session", autouse=True)
def store_of_the_run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    before = os.environ.get("BACKSOLVE_CACHE")
    os.environ["BACKSOLVE_CACHE"] = str(tmp_path_factory.mktemp("store"))
    yield
    if before is None:
        del os.environ["BACKSOLVE_CACHE"]
    else:
        os.environ["BACKSOLVE_CACHE"] = before
