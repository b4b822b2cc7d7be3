"""Every test run has a store of its own: what it keeps and finds there is nobody else's."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest


@pytest.fixture(scope="session", autouse=True)
def store_of_the_run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    before = os.environ.get("BACKSOLVE_CACHE")
    os.environ["BACKSOLVE_CACHE"] = str(tmp_path_factory.mktemp("store"))
    yield
    if before is None:
        del os.environ["BACKSOLVE_CACHE"]
    else:
        os.environ["BACKSOLVE_CACHE"] = before
