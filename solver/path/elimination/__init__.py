"""Simultaneous equations solved by formula: elimination until one line, circle or parabola is left.

Every angle stands for two letters, its cosine and its sine, every root for one; the equations
are polynomials in them. What occurs linearly is substituted; two equations that turn a cosine and a sine
(``a c + b s = p``, ``-b c + a s = q``) give ``a² + b² = p² + q²``; circles are subtracted from one another.
That closes the loops of planar linkages (the half-angle formulas of the textbooks, e.g. Norton, Design
of Machinery, chapter 4), slider-driven ones included, and meets of circles and lines.

Each step is valid for every solution as long as its divisor does not vanish: the solutions of the
block are among the candidates then, and there are no others. Roots can bring in strangers, which the
equations themselves have to refuse.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial
from typing import TypeAlias

from rulesheets.model import Equation
from solver.path.closed_form import ClosedForm
from solver.path.elimination.curves import close, line_and_circle, subtract
from solver.path.elimination.lines import cross, direction, rotate, substitute
from solver.path.elimination.system import Letters, NoForm, System
from solver.path.polynomial import TooLarge

MAX_EQUATIONS = 16

Move: TypeAlias = Callable[[System], bool]
"""One step of elimination; False where none of its kind is to be made."""

MOVES: tuple[Move, ...] = (
    partial(substitute, by_number=True),
    close,
    rotate,
    subtract,
    line_and_circle,
    cross,
    partial(substitute, by_number=False),
)
"""In the order in which they are tried: the first that can be made is made, then all are tried again."""


def closed_form(
    equations: Sequence[Equation], unknowns: Collection[str], turning: Collection[str] = ()
) -> ClosedForm | None:
    """A closed form of as many equations as unknowns; None where elimination does not lead to one.

    ``turning`` are the unknowns that whole turns make no difference to.
    """
    if len(equations) > MAX_EQUATIONS:
        return None
    try:
        return _eliminate(System(equations, Letters(unknowns, turning)), unknowns)
    except (NoForm, TooLarge, OverflowError):
        return None


def _eliminate(system: System, unknowns: Collection[str]) -> ClosedForm | None:
    angles = system.letters.angles
    if any(name not in system.open and name not in angles for name in unknowns):
        return None
    while system.open:
        system.tidy()
        if not any(move(system) for move in MOVES):
            return None
    system.tidy()
    if system.equations:
        return None
    return ClosedForm((*system.formulas(), *(direction(name, *angle) for name, angle in angles.items())))
