"""Every test run has a store of its own: what it keeps and finds there is nobody else's."""

from __future__ import annotations

import gc
import os
from collections.abc import Iterator
from contextlib import suppress
from importlib import import_module
from pathlib import Path

import pytest
from hypothesis import settings

# The matrices are small, and the processes several: threads would only wait for one another.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Processes that tests start compile a module once, as they do for users.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# The same examples everywhere; the profile `random` draws others. Numbers of the product's source
# are none: which of its modules are loaded depends on the tests that ran before.
with suppress(ImportError):
    import_module("hypothesis.internal.conjecture.providers").is_local_module_file = lambda path: (
        False
    )
# How long an example takes says more about the machine's other work than about the code.
settings.register_profile("backsolve", deadline=None, derandomize=True, max_examples=50)
settings.register_profile("random", deadline=None, derandomize=False)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "backsolve"))


QUICK = (
    *("test_architecture.py", "test_diagnostics.py", "test_slider_crank.py"),
    *("rulesheets/test_variables.py", "rulesheets/functions/test_degrees.py"),
    *(
        "solver/sweeps/test_arguments.py",
        "solver/test_front_door.py",
        "solver/sweeps/test_columns.py",
        "solver/commands/test_codes.py",
    ),
    *("solver/accuracy/test_attained.py", "solver/trace/test_folding.py"),
    *(
        "solver/derivatives/test_tolerances.py",
        "solver/kernel/test_whole_turns.py",
        "solver/numerics/test_newton.py",
    ),
    *(
        "solver/path/test_closed_form.py",
        "solver/ranking/test_homogeneity.py",
        "solver/report/test_table.py",
    ),
    *(
        "solver/solution/test_turns.py",
        "solver/structure/test_matching.py",
        "solver/trace/test_record.py",
    ),
    *("solver/solution/test_close_answers.py", "solver/kernel/test_unattained.py"),
)
"""At least one of each room: what `pytest -m quick` runs, beside tests that say so themselves."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    chosen = {Path(__file__).parent / name for name in QUICK}
    for item in items:
        if item.path in chosen and "slow" not in item.keywords:
            item.add_marker(pytest.mark.quick)


def pytest_collection_finish() -> None:
    """Tests are objects that stay: they are not searched for garbage again and again."""
    gc.collect()
    gc.freeze()
    gc.set_threshold(100_000, 50, 100)


def pytest_sessionfinish() -> None:
    """What is left at the end is searched for garbage once, and not ten times."""
    gc.collect()
    gc.freeze()


# Workers of the test run have the width of its terminal; reports are compared as they are in a
# file.
os.environ.pop("COLUMNS", None)


@pytest.fixture(scope="session", autouse=True)
def store_of_the_run(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    before = os.environ.get("BACKSOLVE_CACHE")
    os.environ["BACKSOLVE_CACHE"] = str(tmp_path_factory.mktemp("store"))
    yield
    if before is None:
        del os.environ["BACKSOLVE_CACHE"]
    else:
        os.environ["BACKSOLVE_CACHE"] = before
