"""Drawings: the numbers in them, their scales and labels, and the pictures as files."""

from __future__ import annotations

import math
from functools import cache
from itertools import cycle, pairwise
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib")
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.figure import Figure

import rulesheets
import solver
from rulesheets.checks import ARROWS
from rulesheets.diagnosis import RuleSheetError
from solver.pictures import (
    Diagram,
    LabelRequest,
    Stroke,
    View,
    bar,
    diagram,
    drawable,
    inside,
    overlaps,
    place,
    scale,
    variables,
)
from solver.pictures.page import compose, draw_page, encode, gif, images, layout, window
from tests.oracles.mechanisms import MECHANISMS, Mechanism

MODELS = Path(__file__).parent.parent.parent.parent / "models"

LADDER = """\
variables
  length = 5
  foot = 3
  h
  side = 'left
rules
  foot^2 + h^2 = length^2
  call turn(h; up)
figure position [m]  " a ladder
  pin O = (0, 0)
  point A = (foot, 0)
  point B = (0, turn.twice/2)
  line ladder = (A, B)
  slider (B, 90)
figure slope
  pole o = (0, 0)
  point s = (1/foot, h)
  vector v = (o, s)
function turn(h; up)
rules
  twice = 2*h
  up = -twice
"""


@cache
def ladder():
    return rulesheets.loads(LADDER, "ladder")


def at(inputs=None) -> Diagram:
    return diagram(ladder().figures[0], solver.solve(ladder(), inputs).solutions[0])


# --- numbers --------------------------------------------------------------------


def test_a_diagram_has_the_numbers_of_the_answer() -> None:
    found = at()
    assert (found.name, found.caption, found.unit, found.polar) == (
        "position",
        "a ladder",
        "m",
        False,
    )
    assert found.places == {"O": (0.0, 0.0), "A": (3.0, 0.0), "B": (0.0, 4.0)}
    assert found.kinds == {"O": "pin", "A": "point", "B": "point"}
    line, guide = found.strokes
    assert (line.kind, line.points, line.label) == ("line", ("A", "B"), "ladder")
    assert (guide.kind, guide.points, guide.angle) == ("slider", ("B",), 90.0)


def test_a_figure_says_which_variables_it_needs() -> None:
    assert variables(ladder().figures) == ("foot", "turn.twice", "h")


def test_what_keeps_a_figure_from_being_drawn() -> None:
    position, slope = ladder().figures
    with pytest.raises(ValueError, match=r"^turn\.twice has no value$"):
        diagram(position, {"foot": 3.0})
    with pytest.raises(ValueError, match=r"^a coordinate has no value: division by 0"):
        diagram(slope, {"foot": 0.0, "h": 1.0})
    assert drawable([slope], {"foot": "left", "h": 1.0}) == (None,)
    assert drawable([slope], {"foot": 2.0, "h": 1.0}) == (diagram(slope, {"foot": 2.0, "h": 1.0}),)


@cache
def mechanism_state(mechanism: Mechanism, theta: float, mode: int = 1):
    model = rulesheets.load(MODELS / mechanism.model / "model.tk")
    driver = {
        f"{rate}{mechanism.crank}": v
        for rate, v in (("theta", theta), ("omega", 7.0), ("alpha", -11.0))
    }
    cleared = {
        n: None
        for n, v in model.variables.items()
        if v.value is not None and n not in mechanism.lengths
    }
    inputs = {**cleared, **driver, **mechanism.choices.get(mode, {})}
    return model, solver.solve(model, inputs, want=variables(model.figures))


@pytest.mark.parametrize("theta", [37.0, -120.0])
@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda mechanism: mechanism.model)
def test_a_mechanism_is_drawn_where_the_oracle_puts_it(mechanism: Mechanism, theta: float) -> None:
    """Links have their lengths and directions, relative velocities are at right angles to them."""
    for mode in mechanism.modes:
        model, result = mechanism_state(mechanism, theta, mode)
        assert str(result.status) == "solved"
        exact = mechanism.state(theta, 7.0, -11.0, mode)
        assert any(_agrees(model, answer, exact) for answer in result.solutions)


def _agrees(model, answer, exact) -> bool:
    """Every point of a diagram that the oracle knows by its name is where the oracle has it."""
    drawn = [diagram(figure, answer) for figure in model.figures]
    known = [
        (value, float(exact[name]))
        for one in drawn
        for point, (x, y) in one.places.items()
        for name, value in ((f"x{point}", x), (f"y{point}", y))
        if name in exact
    ]
    angles = [
        (answer[name], float(exact[name]))
        for name in exact
        if name.startswith("theta") and name in answer
    ]
    return all(a == pytest.approx(b, rel=1e-9, abs=1e-9) for a, b in known) and all(
        math.remainder(float(a) - b, 360.0) == pytest.approx(0.0, abs=1e-9) for a, b in angles
    )


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda mechanism: mechanism.model)
def test_the_parts_of_an_acceleration_stand_at_right_angles(mechanism: Mechanism) -> None:
    """Normal on tangential, Coriolis on sliding; a wrong sign of a component would turn the one by
    itself."""
    model, result = mechanism_state(mechanism, 37.0)
    checked = 0
    for figure in model.figures:
        if "acceleration" not in figure.name:
            continue
        found = diagram(figure, result.solutions[0])
        for one, other in pairwise(found.strokes):
            if (one.kind, other.kind) != ("normal", "tangential") and {one.kind, other.kind} != {
                "coriolis",
                "sliding",
            }:
                continue
            (a, b), (c, d) = found.path(one), found.path(other)
            u, v = (b[0] - a[0], b[1] - a[1]), (d[0] - c[0], d[1] - c[1])
            assert abs(u[0] * v[0] + u[1] * v[1]) <= 1e-9 * math.hypot(*u) * math.hypot(*v)
            checked += 1
    assert checked >= 2


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda mechanism: mechanism.model)
def test_every_mechanism_has_the_three_diagrams(mechanism: Mechanism) -> None:
    names = [figure.name for figure in mechanism_state(mechanism, 37.0)[0].figures]
    assert names[:3] == ["position", "velocity", "acceleration"]


# --- scales ---------------------------------------------------------------------

extents = st.floats(1e-9, 1e9)


@given(extents, extents)
def test_a_scale_is_round_and_fits(width: float, height: float) -> None:
    units = scale(width, height, (50.0, 40.0))
    assert width / units <= 50.0 * (1 + 1e-9) and height / units <= 40.0 * (1 + 1e-9)
    assert max(width / units / 50.0, height / units / 40.0) > 0.65
    assert float(f"{units:.2g}") == units


@given(extents)
def test_a_scale_bar_has_a_round_length(units: float) -> None:
    length = bar(units)
    assert 14.0 * (1 - 1e-9) <= length / units <= 35.0 * (1 + 1e-9)
    assert float(f"{length:.1g}") == length


def test_a_figure_without_extent_has_a_scale() -> None:
    assert scale(0.0, 0.0, (50.0, 40.0)) == 1.0
    assert window([]).bounds == (0.0, 0.0, 0.0, 0.0)


# --- labels ---------------------------------------------------------------------

coordinates = st.floats(-10, 10).map(lambda x: round(x, 3))
boxes = st.tuples(coordinates, coordinates, st.floats(0.1, 5), st.floats(0.1, 5))


@settings(max_examples=50)
@given(boxes, st.tuples(coordinates, coordinates), st.tuples(coordinates, coordinates))
def test_the_length_inside_a_box(box, start, end) -> None:
    """Against a thousand points of the segment."""
    count = 1000
    points = np.linspace(start, end, 2 * count + 1)[1::2]
    among = (np.abs(points - box[:2]) <= box[2:]).all(axis=1).sum()
    length = math.dist(start, end)
    ((found,),) = inside(np.array([box]), np.array([(start, end)]))
    assert found == pytest.approx(among / count * length, abs=2.1 * length / count)


@given(boxes, boxes)
def test_boxes_overlap_alike(one, other) -> None:
    ((area,),) = overlaps(np.array([one]), np.array([other]))
    assert area == overlaps(np.array([other]), np.array([one]))[0, 0]
    assert (area > 0) == (
        np.abs(np.subtract(one[:2], other[:2])) < np.add(one[2:], other[2:])
    ).all()


def test_labels_keep_clear_of_lines_and_of_each_other() -> None:
    label_requests = {str(k): LabelRequest("wide", (20.0 + 4 * k, 20.0)) for k in range(4)}
    line = np.array([((0.0, 20.0), (50.0, 20.0))])
    found = np.array(list(place(label_requests, line, np.empty((0, 4)), (50.0, 40.0), {}).values()))
    assert not inside(found, line).any()
    shared = overlaps(found, found)
    assert not (shared - np.diag(shared.diagonal())).any()


def test_points_at_one_place_share_a_label_and_hidden_ones_have_none() -> None:
    places = {"o": (0.0, 0.0), "g": (0.0, 0.01), "b": (5.0, 0.0), "_f": (9.0, 0.0)}
    one = Diagram("velocity", "", "", places, dict.fromkeys(places, "point"), ())
    (axes,) = compose([View("", (one,))]).axes
    assert [text.get_text() for text in axes.texts] == ["o, g", "b"]


# --- pages and films ------------------------------------------------------------


def test_the_axes_of_a_figure_are_to_scale() -> None:
    pytest.importorskip("matplotlib")
    page = solver.draw(solver.solve(ladder()))
    width, height = (inches * 25.4 for inches in page.get_size_inches())
    position, slope = page.axes
    assert [axes.get_label() for axes in page.axes] == ["position", "slope"]
    for axes, units in ((position, 0.08), (slope, 0.08)):
        box = axes.get_position()
        across = (axes.get_xlim()[1] - axes.get_xlim()[0]) / (box.width * width)
        up = (axes.get_ylim()[1] - axes.get_ylim()[0]) / (box.height * height)
        assert (across, up) == pytest.approx((units, units), rel=1e-9)
    texts = {text.get_text() for text in position.texts} | {text.get_text() for text in page.texts}
    assert {"O", "A", "B", "ladder", "(a) a ladder", "(b) slope", "2 m   (1 mm : 0.08 m)"} <= texts


def test_several_results_and_every_answer_stand_side_by_side() -> None:
    pytest.importorskip("matplotlib")
    result = solver.solve(ladder(), {"foot": None, "h": 4.0})
    assert len(solver.draw(result, every=True).axes) == 4
    page = solver.draw(
        {"short": solver.solve(ladder()), "long": solver.solve(ladder(), {"length": 8})}
    )
    assert {"short", "long"} <= {text.get_text() for text in page.texts}
    assert len(solver.draw(result, figures=["slope"]).axes) == 1
    assert len(solver.draw({"one": result, "two": result}, figures=iter(["slope"])).axes) == 2


def test_what_cannot_be_drawn_is_refused() -> None:
    with pytest.raises(RuleSheetError, match="V has no figure"):
        solver.draw(solver.solve(rulesheets.loads("V = 3", "V")))
    with pytest.raises(RuleSheetError, match="no figure positon"):
        solver.draw(solver.solve(ladder()), figures=["positon"])
    with pytest.raises(solver.Unsolved, match="infeasible"):
        solver.draw(solver.solve(ladder(), {"foot": 6.0}))


def _view(x: float, y: float) -> View:
    return View("", (Diagram("position", "", "", {"A": (x, y)}, {"A": "point"}, ()),))


def test_every_frame_has_the_size_of_the_film() -> None:
    """Though one lacks a view, and with it the only title and the only kind of arrow."""
    pytest.importorskip("matplotlib")
    arrows = (Stroke("vector", ("A", "B")), Stroke("normal", ("B", "A")))
    places = {"A": (0.0, 0.0), "B": (3.0, 1.0)}
    drawn = Diagram(
        "a figure of a long name", "", "", places, dict.fromkeys(places, "point"), arrows
    )
    full, bare = View("a title", (drawn, drawn)), View("", (None, _view(0.0, 0.0).diagrams[0]))
    pictures = list(images([("1", (full, bare)), ("2", (None, bare))], dpi=40))
    assert len({picture.size for picture in pictures}) == 1
    assert gif(pictures).startswith(b"GIF89a")
    assert pictures[0].getpixel((0, 0)) == (255, 255, 255)


def figure_of(places, unit: str = "") -> Diagram:
    names = {f"p{number}": place for number, place in enumerate(places)}
    pairs = tuple((one, other) for one, other in pairwise(names))
    strokes = [Stroke(kind, pair, "v") for kind, pair in zip(cycle(ARROWS), pairs, strict=False)]
    return Diagram("figure", "", unit, names, dict.fromkeys(names, "point"), tuple(strokes))


numbers = st.floats(-1e100, 1e100) | st.sampled_from([0.0, 1e-300, 1e16, 1e16 + 2, -1e100])


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(numbers, numbers), min_size=1, max_size=6))
def test_anything_can_be_drawn(places) -> None:
    """However large, small or close together: windows have an inside, labels a place."""
    view = View("", (figure_of(places),))
    plan = layout([[view]])
    room, page = plan.rooms[0, 0], Figure()
    assert room.window.x0 < room.window.x1 and room.window.y0 < room.window.y1
    wide = room.window.width / room.scale
    assert all(-1e-3 <= (x - room.window.x0) / room.scale <= wide + 1e-3 for x, _ in places)
    offsets = draw_page(page, [view], plan)[0, 0]
    assert len(offsets) == len(page.axes[0].texts)
    assert all(math.isfinite(x) and math.isfinite(y) for x, y in offsets.values())


@pytest.mark.parametrize("places", [[(1e20, 5.0)], [(0.0, 0.0)], [(1e16, 0.0), (1e16 + 2, 0.0)]])
def test_a_figure_at_one_place_is_a_picture(places) -> None:
    pytest.importorskip("matplotlib")
    assert encode(compose([View("", (figure_of(places),))]), "png", 40.0).startswith(b"\x89PNG")


def test_a_page_fits_the_paper() -> None:
    """Three diagrams on A4 across, two states of three upright; margins of 10 mm."""
    wide = View("a title", (figure_of([(0.0, 0.0), (58.0, 50.0)], "m/s^2"),) * 3)
    width, height = layout([[View("", wide.diagrams)]], headed=True).size
    assert width <= 277 and height <= 190
    width, height = layout([[wide, wide]]).size
    assert width <= 190 and height <= 277
