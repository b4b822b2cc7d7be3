"""Directions that jump lose no root beside a cut; what a jump leaves out is not attained."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from rulesheets.functions import TABLE
from rulesheets.syntax.nodes import Name, Number, Product, Sum, call, subtract
from solver.kernel.chain import RESIDUAL, Assignment, Chain, compile_chain
from solver.kernel.enclosure import Enclosure

T, TARGET = Name("t"), Name("target")
SIZES = st.floats(-3.0, 3.0).map(lambda a: round(a, 2))
ANGLES = st.floats(-200.0, 200.0).map(lambda t: round(t, 1))


def direction_chain(a: float, b: float, c: float, d: float) -> Chain:
    """``atan2d(a*sind(t) + b, c*cosd(t) + d) - target`` along a tear t."""
    y = Sum((Product(Number(a), call("sind", T)), Number(b)))
    x = Sum((Product(Number(c), call("cosd", T)), Number(d)))
    steps = (Assignment("y", y), Assignment("x", x))
    residual = Assignment(RESIDUAL, subtract(call("atan2d", Name("y"), Name("x")), TARGET))
    return Chain(("t",), (*steps, residual), (RESIDUAL,))


def directions_at(chain: Chain, angle: float) -> list[float]:
    """The direction at an angle, if it has one: not at the origin, nor where y has another sign."""
    try:
        return list(compile_chain(chain, ("target",), (RESIDUAL,))(angle, 0.0))
    except ValueError:
        return []


@settings(max_examples=60)
@given(SIZES, SIZES, SIZES, SIZES, ANGLES, st.floats(0.0, 90.0), st.floats(0.0, 90.0))
def test_no_root_is_lost(
    a: float, b: float, c: float, d: float, root: float, before: float, after: float
) -> None:
    """Not even one on the cut itself, where a = b = 0 and x < 0."""
    chain = direction_chain(a, b, c, d)
    targets = directions_at(chain, root)
    assume(targets)
    ((below, above),) = Enclosure(chain, ("target",)).ranges(
        [(root - before, root + after)], targets
    )
    assert below <= 0.0 <= above


@settings(max_examples=15, deadline=None)
@given(st.floats(-178.0, -100.0).map(lambda angle: round(angle, 1)), st.floats(3.0, 5.0))
def test_a_crank_driven_by_its_rod_has_both_positions_proven(rod: float, crank: float) -> None:
    """Pin B is on a slide of offset 2 behind a rod of length 8 at an angle from B to A below the
    slide."""
    height = 2.0 + 8.0 * math.sin(math.radians(rod))
    share = height / crank
    if abs(abs(share) - 1.0) < 1e-3:
        return
    text = f"""
variables
  theta in [-180, 180]
  xB
rules
  {crank!r}*sind(theta) = yA
  xB - {crank!r}*cosd(theta) = sqrt(8^2 - (2 - yA)^2)
  {rod!r} = atan2d(yA - 2, {crank!r}*cosd(theta) - xB)
"""
    result = solver.solve(rulesheets.loads(text))
    if abs(share) > 1.0:
        assert (str(result.status), result.complete) == ("infeasible", True)
        return
    angle = math.degrees(math.asin(share))
    expected = sorted((angle, math.copysign(180.0, angle) - angle))
    assert (str(result.status), result.complete) == ("solved", True)
    assert sorted(answer["theta"] for answer in result.solutions) == pytest.approx(
        expected, rel=1e-9
    )


@settings(max_examples=40, deadline=None)
@given(
    st.sampled_from(("int(x)", "round(x)", "step(x, 1.3)", "x - mod(x, 2)", "int(x) + round(x)")),
    st.floats(0.0, 1.0).map(lambda slope: round(slope, 2)),
    st.floats(-3.0, 9.0).map(lambda target: round(target, 2)),
)
def test_a_jump_over_a_value_is_no_root(steps: str, slope: float, target: float) -> None:
    """What no point of a fine grid comes near to, no point attains."""
    result = solver.solve(
        rulesheets.loads(f"variables\n x in [0, 4]\nrules\n {steps} + {slope!r}*x = {target!r}\n")
    )
    functions = {
        "int": math.trunc,
        "round": lambda x: math.floor(x + 0.5),
        "step": lambda x, a: float(x >= a),
        "mod": math.fmod,
    }
    grid = [k / 5000 for k in range(20001)]
    height = eval(f"lambda x: {steps}", functions)
    heights = [height(x) + slope * x for x in grid]
    if all(abs(height - target) > slope / 5000 + 1e-9 for height in heights):
        assert (str(result.status), result.complete) == ("infeasible", True)
        return
    assert str(result.status) != "infeasible"
    for answer in result.solutions if slope else ():
        assert height(answer["x"]) + slope * answer["x"] == pytest.approx(target)


@pytest.mark.parametrize(
    ("rule", "range_", "said"),
    [
        ("int(x/5) = 3", "", "between 15 and 20"),
        ("int(x/5) = 0", "> 0", "between 0 and 5"),
        ("98 = 24.5*(int(x/11) + 1)", "", "between 33 and 44"),
        ("12*min(x, 40) = 480", "", "above 40"),
        ("0.2*max(0, x - 1000) = 0", "", "below 1000"),
        ("round(1.1*x) = 5", "", "between 4.09091 and 5"),
    ],
)
def test_a_rule_that_leaves_its_unknown_open_says_between_which_values(
    rule: str, range_: str, said: str
) -> None:
    result = solver.solve(rulesheets.loads(f"variables\n x {range_}\nrules\n {rule}\n"))
    assert str(result.status) == "partial"
    assert f"any value {said} " in result.diagnoses[0].message


@pytest.mark.parametrize("direction", [180.0, 0.0, 90.0, -90.0, 45.0, 140.3, -163.2, 200.0])
@pytest.mark.parametrize("seed", range(4))
def test_all_points_of_a_parabola_in_a_direction(direction: float, seed: int) -> None:
    """Where it crosses the line in that direction, ahead of the origin; none beyond half a turn."""
    draw = random.Random(f"{direction} {seed}")
    a, b, c = (round(draw.uniform(-5.0, 5.0), 2) for _ in range(3))
    model = rulesheets.loads(f"x = {a} + s\ny = {b}*s^2 + {c}\ntheta = atan2d(y, x)")
    found = solver.solve(model, {"theta": direction})
    sine, cosine = TABLE["sind"].value(direction), TABLE["cosd"].value(direction)
    crossing = np.roots([b * cosine, -sine, c * cosine - a * sine])
    expected = [
        s.real
        for s in crossing
        if s.imag == 0.0
        and (a + s.real) * cosine + (b * s.real**2 + c) * sine > 0.0
        and direction <= 180.0
    ]
    assert sorted(s["s"] for s in found.solutions) == pytest.approx(sorted(expected), rel=1e-9)
    assert str(found.status) == ("solved" if expected else "infeasible")
    assert found.complete
