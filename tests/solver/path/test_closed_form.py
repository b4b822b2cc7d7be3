"""Closed forms of blocks: the planted state is among the candidates."""

from __future__ import annotations

import math
from collections.abc import Mapping

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import rulesheets
from rulesheets.model import Model
from rulesheets.syntax.nodes import Number
from solver.kernel.block import FLOATS, Unclear, candidates
from solver.path import Circle, Coefficient, Let, Parabola
from solver.path.elimination import closed_form
from solver.path.graph import ModelGraph

LOOPS = {
    "two circles": ("x^2 + y^2 = r^2\n(x - a)^2 + (y - b)^2 = s^2", ("x", "y")),
    "four bar": (
        "xQ + q*cosd(u) = c + r*cosd(v)\nyQ + q*sind(u) = r*sind(v)",
        ("u", "v"),
    ),
    "slider drives": (
        "xA = q*cosd(u)\nyA = q*sind(u)\n(xB - xA)^2 + (yB - yA)^2 = L^2",
        ("xA", "yA", "u"),
    ),
    "root": (
        "xA = q*cosd(u)\nyA = q*sind(u)\nxB - xA = sqrt(L^2 - (yB - yA)^2)",
        ("xA", "yA", "u"),
    ),
    "slot": ("x = d*cosd(u) - g*sind(u)\ny = d*sind(u) + g*cosd(u)", ("d", "u")),
    "shifted angles": (
        "x = q*cosd(u + 90) + r*cosd(v - k)\ny = q*sind(u + 90) + r*sind(v - k)",
        ("u", "v"),
    ),
    "guide": ("x + L*cosd(u) = d*cosd(f)\ny + L*sind(u) = d*sind(f)", ("d", "u")),
    "lines": ("a*x + b*y = p\nc*x + d*y = q", ("x", "y")),
    "relative angles": (
        "x = q*cosd(u) + r*cosd(u + v + k)\ny = q*sind(u) + r*sind(u + v + k)",
        ("u", "v"),
    ),
    "radians": ("x = q*cos(u) + r*cos(v)\ny = q*sin(u) + r*sin(v)", ("u", "v")),
}


def graph_of(text: str) -> tuple[Model, ModelGraph]:
    model = rulesheets.loads(text)
    return model, ModelGraph(model)


def planted(
    text: str, unknowns: tuple[str, ...], numbers: Mapping[str, float]
) -> dict[str, float] | None:
    """Values for every variable: the generators at random, what a rule gives outright computed."""
    x = dict(numbers)
    by_hand = {
        LOOPS["two circles"][0]: lambda: {
            "r": math.hypot(x["x"], x["y"]),
            "s": math.hypot(x["x"] - x["a"], x["y"] - x["b"]),
        },
        LOOPS["four bar"][0]: lambda: {
            "xQ": x["c"] + x["r"] * _c(x["v"]) - x["q"] * _c(x["u"]),
            "yQ": x["r"] * _s(x["v"]) - x["q"] * _s(x["u"]),
        },
        LOOPS["slider drives"][0]: lambda: _slider(x),
        LOOPS["root"][0]: lambda: _slider(x),
        LOOPS["slot"][0]: lambda: {
            "x": x["d"] * _c(x["u"]) - x["g"] * _s(x["u"]),
            "y": x["d"] * _s(x["u"]) + x["g"] * _c(x["u"]),
        },
        LOOPS["shifted angles"][0]: lambda: {
            "x": x["q"] * _c(x["u"] + 90) + x["r"] * _c(x["v"] - x["k"]),
            "y": x["q"] * _s(x["u"] + 90) + x["r"] * _s(x["v"] - x["k"]),
        },
        LOOPS["guide"][0]: lambda: {
            "x": x["d"] * _c(x["f"]) - x["L"] * _c(x["u"]),
            "y": x["d"] * _s(x["f"]) - x["L"] * _s(x["u"]),
        },
        LOOPS["lines"][0]: lambda: {
            "p": x["a"] * x["x"] + x["b"] * x["y"],
            "q": x["c"] * x["x"] + x["d"] * x["y"],
        },
        LOOPS["relative angles"][0]: lambda: {
            "x": x["q"] * _c(x["u"]) + x["r"] * _c(x["u"] + x["v"] + x["k"]),
            "y": x["q"] * _s(x["u"]) + x["r"] * _s(x["u"] + x["v"] + x["k"]),
        },
        LOOPS["radians"][0]: lambda: {
            "x": x["q"] * math.cos(x["u"]) + x["r"] * math.cos(x["v"]),
            "y": x["q"] * math.sin(x["u"]) + x["r"] * math.sin(x["v"]),
        },
    }
    return {**x, **by_hand[text]()}


def _c(angle: float) -> float:
    return math.cos(math.radians(angle))


def _s(angle: float) -> float:
    return math.sin(math.radians(angle))


def _slider(x: dict[str, float]) -> dict[str, float]:
    xA, yA = x["q"] * _c(x["u"]), x["q"] * _s(x["u"])
    span = x["L"] ** 2 - (x["yB"] - yA) ** 2
    assume(span > 1e-3)
    return {"xA": xA, "yA": yA, "xB": xA + math.sqrt(span)}


@pytest.mark.parametrize("name", LOOPS)
@settings(max_examples=40, deadline=None)
@given(data=st.data())
def test_the_planted_state_is_among_the_candidates(name: str, data: st.DataObject) -> None:
    text, unknowns = LOOPS[name]
    model, graph = graph_of(text)
    angles = {"u", "v", "k", "f"}
    span = dict.fromkeys(angles, (-3.0, 3.0) if name == "radians" else (-179.0, 179.0))
    numbers = {
        n: data.draw(st.floats(*span.get(n, (0.25, 4.0))).filter(lambda v: abs(v) > 1e-3), label=n)
        for n in model.variables
    }
    state = planted(text, unknowns, numbers)
    assert state is not None
    turning = [n for n in unknowns if graph.turn(n)]
    form = closed_form(model.equations, unknowns, turning)
    assert form is not None
    try:
        known = {n: v for n, v in state.items() if n not in unknowns}
        found = [values for _, values in candidates(form, FLOATS, known)]
    except (Unclear, ZeroDivisionError):
        return  # too near to a double answer for a formula: it says so
    assert len(found) <= 2 ** sum(not isinstance(formula, Let) for formula in form)
    turn = 2 * math.pi if name == "radians" else 360.0

    def apart(one: Mapping[str, float]) -> float:
        gaps = (
            abs(math.remainder(one[n] - state[n], turn)) if n in turning else abs(one[n] - state[n])
            for n in unknowns
        )
        return max(gap / (1.0 + abs(state[n])) for gap, n in zip(gaps, unknowns, strict=True))

    assert min(map(apart, found)) < 1e-3


def exact(*numbers: float) -> list[Coefficient]:
    return [Coefficient(Number(float(v)), Number(abs(float(v)))) for v in numbers]


def roots(*numbers: float) -> list[float]:
    found = candidates((Parabola("x", *exact(*numbers)),), FLOATS, {})
    return [values["x"] for _, values in found]


def meets(*numbers: float) -> list[tuple[float, float]]:
    found = candidates((Circle("x", "y", *exact(*numbers)),), FLOATS, {})
    return [(values["x"], values["y"]) for _, values in found]


def test_what_has_no_closed_form_says_so() -> None:
    for text, unknowns in (
        ("E - e*sin(E) = M", ("E",)),
        ("x^3 + y = a\ny*x = b", ("x", "y")),
        ("x = abs(y) + 1\ny*x = b", ("x", "y")),
    ):
        model, graph = graph_of(text)
        assert (
            closed_form(model.equations, unknowns, [n for n in unknowns if graph.turn(n)]) is None
        )


@given(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3), st.floats(0.5, 2.0))
def test_roots_of_a_parabola(p: float, q: float, a: float) -> None:
    assume(abs(p - q) > 1e-2 * (abs(p) + abs(q)) and min(abs(p), abs(q)) > 1e-3)
    assert sorted(roots(a, -a * (p + q), a * p * q)) == pytest.approx(sorted((p, q)), rel=1e-9)


@given(st.floats(-179, 179), st.floats(-179, 179), st.floats(0.1, 10))
def test_meets_of_a_line_and_a_circle(u: float, v: float, r: float) -> None:
    """The line through two points of the circle meets it there."""
    assume(abs(math.remainder(u - v, 360)) > 1)
    (x1, y1), (x2, y2) = (r * _c(u), r * _s(u)), (r * _c(v), r * _s(v))
    a, b = y2 - y1, x1 - x2
    found = meets(a, b, a * x1 + b * y1, r * r)
    assert len(found) == 2
    for x, y in ((x1, y1), (x2, y2)):
        assert min(math.hypot(x - p, y - q) for p, q in found) < 1e-6 * r


def test_no_meeting_and_no_root() -> None:
    assert meets(1, 0, 2, 1) == []
    assert roots(1, 0, 1) == []
    with pytest.raises(Unclear):
        meets(1, 0, 1, 1)
    with pytest.raises(Unclear):
        roots(1, 2, 1)
