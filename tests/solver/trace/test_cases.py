"""Plans of sheets whose rules depend on a case that the answer decides."""

from __future__ import annotations

from collections.abc import Callable
from math import pi, sqrt
from typing import Any

import numpy as np
import pytest

import rulesheets
import solver

PIPE = """variables
  D = 0.05 > 0
  nu = 1e-6
  v = 0.5 > 0
  f > 0
rules
  Re = v*D/nu
  if Re < 2300 then f = 64/Re else f = 0.316/Re^0.25
  dp = f*10/D*1000*v^2/2
"""


def pipe(dp: float) -> list[float]:
    """The velocities in a smooth pipe: laminar (Hagen-Poiseuille), turbulent (Blasius), none in
    between."""
    laminar = dp * 0.05**2 / (32 * 1e-3 * 10)
    turbulent = (dp * 2 * 0.05**1.25 / (0.316 * 1e-6**0.25 * 1e4)) ** (1 / 1.75)
    return [
        v for v, there in ((laminar, laminar < 0.046), (turbulent, turbulent >= 0.046)) if there
    ]


COLUMN = """variables
  E = 200e9
  Sy = 250e6
  A = 1e-3
  r = 0.01
  L = 1 > 0
rules
  Sr = L/r
  Sc = sqrt(2*pi^2*E/Sy)
  if Sr < Sc then S = Sy*(1 - Sr^2/(2*Sc^2)) else S = pi^2*E/Sr^2
  P = S*A
"""


def column(force: float) -> list[float]:
    """The length at which a column buckles: Johnson's parabola for a short one, Euler's
    hyperbola."""
    share, slender = force / 250e3, sqrt(2 * pi**2 * 800)
    return [0.01 * slender * (sqrt(2 * (1 - share)) if share > 0.5 else sqrt(1 / (2 * share)))]


CYLINDER = """variables
  D = 0.02 > 0
rules
  Re = 2*D/1.6e-5
  if Re < 40 then Nu = 0.8*Re^0.4
  else if Re < 4000 then Nu = 0.6*Re^0.48
  else Nu = 0.17*Re^0.63
  h = Nu*0.026/D
"""


def cylinder(h: float) -> list[float]:
    """The diameters of a wire or tube in wind, by one power law each for three ranges of Re =
    125000 D."""
    laws = ((0.8, 0.4, 0.0, 40.0), (0.6, 0.48, 40.0, 4000.0), (0.17, 0.63, 4000.0, np.inf))
    found = [((h / (c * 125e3**n * 0.026)) ** (1 / (n - 1)), low, high) for c, n, low, high in laws]
    return [d for d, low, high in found if low <= 125e3 * d < high]


QUESTIONS: dict[str, tuple[str, str, str, Callable[[float], list[float]], tuple[float, float]]] = {
    "a pipe": (PIPE, "dp", "v", pipe, (0.5, 500.0)),
    "a column": (COLUMN, "P", "L", column, (3e4, 2.4e5)),
    "a cylinder in wind": (CYLINDER, "h", "D", cylinder, (8.0, 900.0)),
}


@pytest.mark.parametrize("name", QUESTIONS)
def test_a_sweep_through_all_cases_takes_a_record_for_each(name: str) -> None:
    text, given, wanted, formula, ends = QUESTIONS[name]
    plan: Any = solver.prepare(rulesheets.loads(text), [given], [wanted], {wanted: None})
    numbers = np.geomspace(*ends, 800)
    for _ in range(2):
        table = plan.sweep(numbers)
        for number, found, count, status in zip(
            numbers.tolist(), table[wanted], table.answers, table.status, strict=True
        ):
            expected = formula(number)
            assert count == len(expected), number
            assert not expected or min(abs(found / one - 1.0) for one in expected) < 1e-12
            assert status == (0 if expected else 3)
    for number in numbers[::40].tolist():
        try:
            found = sorted(row[0] for row in plan.all(number))
        except solver.Unsolved:
            found = []
        assert found == pytest.approx(sorted(formula(number)), rel=1e-12)
    assert len(plan.records.programs) + len(plan.records.refusals) <= 8


def test_a_root_on_the_boundary_of_a_case_is_counted_as_in_a_solve() -> None:
    model = rulesheets.loads(PIPE)
    plan: Any = solver.prepare(model, ["dp"], ["v"], {"v": None})
    ends = 64 / 2300 * 1e5 * 0.046**2, 0.316 / 2300**0.25 * 1e5 * 0.046**2
    for end in ends:
        plan.sweep(np.linspace(0.9 * end, 1.1 * end, 200))
    for end in ends:
        for share in (-1e-6, -1e-12, -2e-16, 0.0, 2e-16, 1e-12, 1e-6):
            dp = end * (1.0 + share)
            solved = solver.solve(model, {"dp": dp, "v": None})
            try:
                found = [row[0] for row in plan.all(dp)]
            except solver.Unsolved as none:
                assert none.status is solved.status
                continue
            assert found == pytest.approx([answer["v"] for answer in solved.solutions], rel=1e-9)
