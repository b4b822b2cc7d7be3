"""Where the panels of a page go, and how large it is: the same for every frame of a film."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

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

    @property
    def on_paper(self) -> Place:
        """Width and height in millimetres."""
        return self.width / self.scale, self.height / self.scale


class Layout(NamedTuple):
    """A page of panels, one for each figure (row) and view (column), in millimetres.

    ``windows`` and ``travel`` (the two farthest places of every slider, by the number of its stroke) are by
    figure and view, and so are ``cells``: the row and column on the page. ``widths`` and ``heights`` are
    those of its columns and rows, ``titled`` tells whether views have titles, ``headed`` whether there is a
    heading above them, ``legend`` has rows of kinds of arrows.
    """

    extents: tuple[Extent, ...]
    windows: Mapping[tuple[int, int], Window]
    travel: Mapping[tuple[int, int], Mapping[int, tuple[Place, Place]]]
    cells: Mapping[tuple[int, int], tuple[int, int]]
    widths: tuple[float, ...]
    heights: tuple[float, ...]
    titled: bool
    headed: bool
    legend: tuple[tuple[str, ...], ...]

    @property
    def size(self) -> Place:
        """Width and height of the page."""
        return _across(self.widths), _across(self.heights) + self.above + ROW * len(self.legend)

    @property
    def above(self) -> float:
        """Height of what stands above the panels."""
        return TITLE * (self.titled + self.headed)

    def corner(self, row: int, column: int) -> Place:
        """The upper left corner of the cell of a figure and view, from the lower left one of the page."""
        y, x = self.cells[row, column]
        return _start(self.widths, x), self.size[1] - self.above - _start(self.heights, y)

    def middle(self, column: int) -> float:
        """The middle of a view: of the page where there is but one."""
        if all(view == 0 for _, view in self.cells):
            return self.size[0] / 2
        return _start(self.widths, column) + self.widths[column] / 2


def layout(frames: Sequence[Sequence[View | None]], *, headed: bool = False) -> Layout:
    """The layout that fits every view: ``frames`` are the views of each frame, one for a still picture."""
    views = [view for frame in frames for view in frame if view]
    rows, columns = len(views[0].diagrams), max(map(len, frames))
    seen = {
        (row, column): [diagram for view in _column(frames, column) if (diagram := view.diagrams[row])]
        for row in range(rows)
        for column in range(columns)
    }
    least = {cell: window(diagrams) for cell, diagrams in seen.items()}
    extents = tuple(
        _extent(
            [least[row, column] for column in range(columns)],
            _longest(diagram.title for column in range(columns) for diagram in seen[row, column]),
        )
        for row in range(rows)
    )
    # figures below each other where there are several views; the figures of one view fill rows
    wide = rows if rows <= _ACROSS else -(-rows // 2)
    cells = {cell: cell if columns > 1 else divmod(cell[0], wide) for cell in seen}
    widths, heights = _tracks(extents, cells)
    if columns > 1:
        titles = (_longest(view.title for view in _column(frames, column)) for column in range(columns))
        pairs = zip(widths, titles, strict=True)
        widths = tuple(max(width, text_width(title, BOLD)) for width, title in pairs)
    return Layout(
        extents=extents,
        windows={
            (row, column): box.resized(extents[row].width, extents[row].height)
            for (row, column), box in least.items()
        },
        travel={cell: _travel(diagrams) for cell, diagrams in seen.items()},
        cells=cells,
        widths=widths,
        heights=heights,
        titled=any(view.title for view in views),
        headed=headed,
        legend=_legend(views, _across(widths) - 2 * EDGE),
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


def _tracks(
    extents: Sequence[Extent], cells: Mapping[tuple[int, int], tuple[int, int]]
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Widths of the columns and heights of the rows of the page."""
    widths: dict[int, float] = {}
    heights: dict[int, float] = {}
    for (row, _), (y, x) in cells.items():
        width, height = extents[row].on_paper
        widths[x] = max(widths.get(x, 0.0), width)
        heights[y] = max(heights.get(y, 0.0), height + HEAD + FOOT)
    return tuple(widths[x] for x in sorted(widths)), tuple(heights[y] for y in sorted(heights))


def _start(tracks: Sequence[float], number: int) -> float:
    return EDGE + sum(tracks[:number]) + GAP * number


def _across(tracks: Sequence[float]) -> float:
    return _start(tracks, len(tracks)) - GAP + EDGE


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
