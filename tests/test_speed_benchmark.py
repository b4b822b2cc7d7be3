"""What speed is measured against is right: code by hand is as exact as what it is compared with."""

from __future__ import annotations

import gc
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.pages import place
from benchmarks.speed import closed_forms, many_rows, reference, solvers, symbols, task
from benchmarks.speed.by_c import CCrank
from benchmarks.speed.page import Claim, Section
from benchmarks.speed.rules_as_equations import system_of
from benchmarks.speed.stopwatch import Contestant, race

ROWS = 1000
BY_HAND = {"forward": closed_forms.forward_rows, "backward": closed_forms.backward_rows}


def worst(direction: str, run: Callable[[Any], Any]) -> float:
    """In ulp × conditioning, of a sample of rows."""
    numbers = task.column(direction, ROWS)
    found = many_rows.columns(direction, run(numbers))
    rows = ((float(numbers[k]), [float(c[k]) for c in found]) for k in range(0, ROWS, 50))
    return max(max(reference.errors(direction, number, row)) for number, row in rows)


@pytest.mark.parametrize("direction", task.DIRECTIONS)
def test_sweeps_by_hand_and_by_backsolve_are_exact(direction: str) -> None:
    assert worst(direction, lambda numbers: many_rows.filled(BY_HAND[direction], numbers)) < 4
    assert worst(direction, task.plan(direction).sweep) < 4


@pytest.mark.parametrize("direction", task.DIRECTIONS)
def test_sweeps_in_c_are_exact(direction: str, tmp_path: Path) -> None:
    try:
        crank = CCrank(tmp_path)
    except OSError:
        pytest.skip("needs a C compiler")
    for name, threads in (("library", 1), ("own", 1), ("own", 2)):
        assert worst(direction, crank.rows(f"{direction}_rows_{name}", threads)) < 4


def test_errors_are_seen() -> None:
    exact = [float(y) for y in reference.exact("forward", 20.0)]
    assert max(reference.errors("forward", 20.0, exact)) <= 0.5
    assert max(reference.errors("forward", 20.0, [exact[0] * (1 + 1e-12), *exact[1:]])) > 1000


@pytest.mark.parametrize("direction", task.DIRECTIONS)
def test_equations_hold_at_the_closed_form(direction: str) -> None:
    closed = closed_forms.forward(20.0)
    number, unknowns = (
        (20.0, closed) if direction == "forward" else (closed[0], (20.0, *closed[1:]))
    )
    assert symbols.residuals(direction)(number, *unknowns) == pytest.approx([0.0] * 5, abs=1e-11)


@pytest.mark.parametrize("direction", task.DIRECTIONS)
def test_fsolve_finds_the_answer_from_five_equations_and_from_the_rules(direction: str) -> None:
    plan = task.plan(direction)
    here = task.ANGLE if direction == "forward" else task.POSITION
    expected = plan(here)
    assert solvers.fsolve(direction, True)(here) == pytest.approx(expected, rel=1e-6)
    system = system_of(task.model(), plan, plan.judged((here,))[0])
    assert system is not None
    values = plan.judged((here + 0.1,))[0].leaves[0].branch.values
    found = dict(zip(system.unknowns, system.fsolve()(here, system.start(values)), strict=True))
    assert [found[name] for name in plan.want] == pytest.approx(expected, rel=1e-6)


def test_a_race_runs_a_sweep_once_a_round(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gc, "collect", lambda: 0)  # all that other tests have left takes seconds
    seen: list[int] = []
    numbers = np.arange(10.0)
    times = race([Contestant("sweep", lambda column: seen.append(len(column)), numbers, 10)], 3)
    assert seen == [10] * 4  # the first is not counted
    assert 0 <= times["sweep"].cpu < 1


def test_tables_go_where_the_page_has_a_place_for_them(tmp_path: Path) -> None:
    claims = [Claim("fast", 2, 1.5), Claim("faster", 3, 2.5, more=True)]
    section = Section("one", "One", ("µs", "a"), [("x", "1"), ("longer", "20")], claims=claims)
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- speed: one -->\nold\n<!-- end -->\nafter\n")
    assert place(page, "speed: one", section.markdown()) and not place(page, "speed: two", "")
    text = page.read_text()
    assert (
        "old" not in text and text.startswith("before\n") and text.endswith("<!-- end -->\nafter\n")
    )
    assert "| longer | 20 |" in text
    assert [line.split("|")[-2].strip() for line in text.splitlines() if "fast" in line] == [
        "yes",
        "**no**",
    ]
