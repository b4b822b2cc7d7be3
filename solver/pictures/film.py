"""A motion as a film: one frame for each of a row of results, with one scale and one window for all."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from io import BytesIO

from matplotlib.figure import Figure
from PIL import Image

from solver.pictures.diagram import Diagram
from solver.pictures.ink import shades
from solver.pictures.layout import View, layout
from solver.pictures.page import Placed, draw_page

MILLISECONDS = 60
"""How long a frame is shown."""


@dataclass(frozen=True)
class Frame:
    """One instant: what it is called, and its views, None in the place of one without an answer."""

    heading: str
    views: tuple[View | None, ...]


@dataclass
class Track:
    """The views of one state through a motion: one, or with ``every`` as many as there are answers."""

    every: bool
    last: list[View] = field(default_factory=list)

    def follow(self, found: Sequence[View]) -> list[View | None]:
        """The found views, each in the place of what it moved on from, None where nothing did.

        The order in which answers are found may change along a motion, but a mechanism does not jump:
        the nearest pairs by their points go together. With ``every``, views that are left over get new
        places.
        """
        distances = sorted(
            (_distance(before, now), place, number)
            for place, before in enumerate(self.last)
            for number, now in enumerate(found)
        )
        taken: dict[int, int] = {}
        for _, place, number in distances:
            if place not in taken and number not in taken.values():
                taken[place] = number
        ordered = [found[taken[place]] if place in taken else None for place in range(len(self.last))]
        rest = [view for number, view in enumerate(found) if number not in taken.values()]
        new = rest if self.every else rest[: 0 if self.last else 1]
        self.last = [now or before for now, before in zip(ordered, self.last, strict=True)] + new
        return [*ordered, *new]


def _distance(one: View, other: View) -> float:
    """How far the first diagram moved, squared: later ones are of other units."""
    for before, after in zip(one.diagrams, other.diagrams, strict=True):
        if before is not None and after is not None:
            return _moved(before, after)
    return 0.0


def _moved(before: Diagram, after: Diagram) -> float:
    pairs = ((before.places[name], after.places[name]) for name in before.places)
    return sum((x1 - x0) ** 2 + (y1 - y0) ** 2 for (x0, y0), (x1, y1) in pairs)


def frames(instants: Iterable[tuple[str, Sequence[Sequence[View]]]], every: bool) -> list[Frame]:
    """The frames of a motion: at each instant, by its heading, the views of every state.

    An instant at which no state has an answer gives no frame.
    """
    tracks: list[Track] = []
    shown: list[tuple[str, list[list[View | None]]]] = []
    for heading, states in instants:
        tracks = tracks or [Track(every) for _ in states]
        views = [track.follow(found) for track, found in zip(tracks, states, strict=True)]
        if any(view for state in views for view in state):
            shown.append((heading, views))
    widths = [len(track.last) for track in tracks]
    return [Frame(heading, tuple(_padded(views, widths))) for heading, views in shown]


def _padded(states: Sequence[Sequence[View | None]], widths: Sequence[int]) -> Iterator[View | None]:
    for views, width in zip(states, widths, strict=True):
        yield from (*views, *(None,) * (width - len(views)))


def images(film: Sequence[Frame], dpi: float) -> Iterator[Image.Image]:
    """The frames as pictures of one size. Labels stay on the same side of their points where they can."""
    plan = layout([frame.views for frame in film], headed=True)
    before: Placed | None = None
    for frame in film:
        figure = Figure(dpi=dpi)
        before = draw_page(figure, frame.views, plan, frame.heading, before)
        pixels = BytesIO()
        figure.savefig(pixels, format="rgba", dpi=dpi)
        size = figure.canvas.get_width_height()
        yield Image.frombytes("RGBA", size, pixels.getvalue()).convert("RGB")


def gif(pictures: Iterable[Image.Image]) -> bytes:
    """An endless GIF of the pictures, in the colours that there are in a drawing."""
    palette = Image.new("P", (1, 1))
    palette.putpalette([part for color in shades() for part in color])
    none = Image.Dither.NONE
    first, *others = (picture.quantize(palette=palette, dither=none) for picture in pictures)
    file = BytesIO()
    first.save(file, "GIF", save_all=True, append_images=others, duration=MILLISECONDS, loop=0)
    return file.getvalue()
