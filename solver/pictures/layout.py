"""Where the panels of a page go, and how large it is: the same for every frame of a film."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple, TypeAlias

from rulesheets.checks.marks import ARROWS
from solver.pictures import MARGIN, Diagram, Place, Window, scale, window

GAP, HEAD, FOOT, TITLE, EDGE, ROW = 5.0, 6.0, 8.0, 7.0, 4.0, 4.5
"""Millimetres between panels, above one, below one, above a column, around the page, of a row of legend."""

CAPTION, BOLD, LEGEND = 8.5, 9.0, 7.0
"""Sizes of captions, of titles and of what stands below a panel, in points."""

ARROW_NAMES = {
    "vector": "absolute",
    "normal": "normal",
    "tangential": "tangential",
    "sliding": "sliding",
    "coriolis": "Coriolis",
}

_ROOM = (58.0, 50.0)
"""Millimetres that the points of a diagram may take up: three diagrams fit A4 across, twice three upright."""

_FINEST = 1e-9
"""The least extent of a figure that is seen as one, relative to the coordinates."""

_NARROW = 48.0
"""Millimetres that a panel has at least, for its scale."""

_ACROSS = 3
"""Figures that stand in one row at most."""


class View(NamedTuple):
    """One state: a title, and its diagrams in the order of the sheet, None where one cannot be drawn."""

    title: str
    diagrams: tuple[Diagram | None, ...]


class Extent(NamedTuple):
    """How one figure of the sheet is seen in every view: its scale, and the size of its window in units."""

    scale: float
    width: float
    height: float


Cell: TypeAlias = tuple[int, int]
"""A figure (row) of a view (column)."""


class Layout(NamedTuple):
    """A page of panels, one for each cell, in millimetres from its lower left corner.

    ``travel`` has the two farthest places of every slider of a cell, by the number of its stroke. ``places``
    are the rectangles that cells have, caption and scale included; ``middles`` are those of the views.
    ``legend`` has rows of kinds of arrows.
    """

    size: Place
    extents: tuple[Extent, ...]
    windows: Mapping[Cell, Window]
    travel: Mapping[Cell, Mapping[int, tuple[Place, Place]]]
    places: Mapping[Cell, Window]
    middles: tuple[float, ...]
    legend: tuple[tuple[str, ...], ...]


def layout(frames: Sequence[Sequence[View | None]], *, headed: bool = False) -> Layout:
    """The layout that fits every view: ``frames`` are the views of each frame, one for a still picture.

    Above the panels is room for the titles that views have, and for a heading where it is ``headed``.
    """
    views = [view for frame in frames for view in frame if view]
    rows, columns = range(len(views[0].diagrams)), range(max(map(len, frames)))
    seen = {
        (row, column): [diagram for view in _column(frames, column) if (diagram := view.diagrams[row])]
        for row in rows
        for column in columns
    }
    least = {cell: window(diagrams) for cell, diagrams in seen.items()}
    extents = tuple(
        _extent(
            [least[row, column] for column in columns],
            _longest(diagram.title for column in columns for diagram in seen[row, column]),
        )
        for row in rows
    )
    # figures below each other where there are several views; the figures of one view fill rows
    wide = len(rows) if len(rows) <= _ACROSS else -(-len(rows) // 2)
    cells = {cell: cell if len(columns) > 1 else divmod(cell[0], wide) for cell in seen}
    widths, heights = dict[int, float](), dict[int, float]()
    for (row, column), (y, x) in cells.items():
        units, width, height = extents[row]
        title = _longest(view.title for view in _column(frames, column)) if len(columns) > 1 else ""
        widths[x] = max(widths.get(x, 0.0), width / units, text_width(title, BOLD))
        heights[y] = max(heights.get(y, 0.0), height / units + HEAD + FOOT)
    across, up = _start(widths, len(widths)) - GAP + EDGE, _start(heights, len(heights)) - GAP + EDGE
    legend = _legend(views, across - 2 * EDGE)
    above = TITLE * (any(view.title for view in views) + headed)
    up += above + ROW * len(legend)
    places = {}
    for cell, (y, x) in cells.items():
        left, top = _start(widths, x), up - above - _start(heights, y)
        places[cell] = Window(left, top - heights[y], left + widths[x], top)
    middles = tuple(_start(widths, column) + widths[column] / 2 for column in columns)
    return Layout(
        size=(across, up),
        extents=extents,
        windows={
            cell: box.resized(extents[cell[0]].width, extents[cell[0]].height) for cell, box in least.items()
        },
        travel={cell: _travel(diagrams) for cell, diagrams in seen.items()},
        places=places,
        middles=middles if len(columns) > 1 else (across / 2,),
        legend=legend,
    )


def _column(frames: Sequence[Sequence[View | None]], column: int) -> list[View]:
    """The views of all frames in one column."""
    return [view for views in frames if column < len(views) and (view := views[column])]


def _longest(texts: Iterable[str]) -> str:
    return max(texts, key=len, default="")


def text_width(text: str, points: float) -> float:
    """About how wide a text is, in millimetres, in the font that matplotlib brings along."""
    return 0.215 * points * len(text)


def legend_width(kind: str) -> float:
    """Width of a kind of arrow in the legend."""
    return 10.0 + text_width(ARROW_NAMES[kind], LEGEND)


def _extent(windows: Sequence[Window], caption: str) -> Extent:
    width, height = max(w.width for w in windows), max(w.height for w in windows)
    reach = max(w.reach for w in windows)
    least = reach * (_FINEST if max(width, height) > 0.0 else 1.0)
    units = scale(max(width, least), height, _ROOM)
    narrow = max(_NARROW, text_width(f"(a) {caption}", CAPTION))
    return Extent(units, max(width + 2 * MARGIN * units, narrow * units), height + 2 * MARGIN * units)


def _travel(seen: Sequence[Diagram]) -> dict[int, tuple[Place, Place]]:
    found: dict[int, tuple[Place, Place]] = {}
    for diagram in seen:
        for number, stroke in enumerate(diagram.strokes):
            if stroke.kind == "slider":
                place = diagram.path(stroke)[0]
                low, high = found.get(number, (place, place))
                found[number] = min(low, place), max(high, place)
    return found


def _start(tracks: Mapping[int, float], number: int) -> float:
    """Where a column or row of the page begins, from its left or upper edge."""
    return EDGE + sum(tracks[place] + GAP for place in range(number))


def _legend(views: Sequence[View], width: float) -> tuple[tuple[str, ...], ...]:
    """The kinds of arrows in the views, if there are several, in rows of that width."""
    drawn = {
        stroke.kind for view in views for diagram in view.diagrams if diagram for stroke in diagram.strokes
    }
    kinds = [kind for kind in ARROWS if kind in drawn]
    rows: list[tuple[str, ...]] = []
    for kind in kinds if len(kinds) > 1 else ():
        if rows and sum(map(legend_width, (*rows[-1], kind))) <= width:
            rows[-1] = (*rows[-1], kind)
        else:
            rows.append((kind,))
    return tuple(rows)
