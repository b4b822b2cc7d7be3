"""Whether the answers of a block with one tear are all: every root of its eliminant is accounted for."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rulesheets.evaluate.number import enclose
from solver.kernel.blur import astray
from solver.kernel.candidates import Candidates
from solver.kernel.elimination.exact import Polynomial
from solver.kernel.elimination.polynomial_block import (
    STRANGE,
    Forms,
    doubtful_extremum,
    explicit_forms,
    point_at,
)
from solver.kernel.question import Question
from solver.numerics.sturm import real_roots, simple_part

SAME = 1e-9
"""Relative distance within which a root of the polynomial is an answer; looked at when none is there."""


def counted(question: Question, candidates: Candidates) -> bool:
    """Whether the answers are known to be all; one that was missing is added to them.

    Only for algebraic blocks, whose eliminant has no root that rounding might have parted in two, or hidden.
    """
    block = question.kernel.block
    if len(block.tears) != 1 or question.turn(block.tears[0]) is not None or candidates.withheld:
        return False
    forms = explicit_forms(question)
    if forms is None:
        return False
    from rulesheets.algebra.eliminant import eliminant  # sympy waits until a search has left something open

    equation = question.graph.model.equations[block.residuals[0]]
    known = {name: value for name, value in question.here.items() if isinstance(value, float)}
    found = eliminant(equation.left, equation.right, block.tears[0], forms, known)
    if found is None or any(_may_be_free(question, factor) for factor in found.indeterminate):
        return False
    simple = simple_part(found.polynomial)
    roots = real_roots(simple, *question.domain(block.tears[0]))
    if roots is None or doubtful_extremum(simple):
        return False
    return all(_settled(question, candidates, forms, root) for root in roots)


def _may_be_free(question: Question, factor: Polynomial) -> bool:
    """Whether the rules admit a zero of a factor that an explicit form divides by, and into."""
    tear = question.kernel.block.tears[0]
    zeros = real_roots(simple_part(factor), *question.domain(tear))
    return zeros is None or any(_is_admitted(question, tear, zero) for zero in zeros)


def _is_admitted(question: Question, tear: str, zero: float) -> bool:
    """Whether no rule of the block excludes a value of the tear, whatever the other unknowns are."""
    known = {name: (v, v) for name, v in question.here.items() if isinstance(v, float)}
    box = known | {name: question.domain(name) for name in question.unknowns}
    box[tear] = math.nextafter(zero, -math.inf), math.nextafter(zero, math.inf)
    ranges = (enclose(form, box) for form in question.kernel.forms)
    return all(low <= 0.0 <= high for low, high in ranges)


def _settled(question: Question, candidates: Candidates, forms: Forms, root: float) -> bool:
    """Whether a root is one of the answers, or becomes one, or is plainly none."""
    tear = question.kernel.block.tears[0]

    def is_listed() -> bool:
        return any(abs(answer.values[tear] - root) <= SAME * abs(root) for answer in candidates.answers)

    if is_listed():
        return True
    points = list(_points(question, forms, root))
    if all(point is None or astray(question, point, STRANGE) for point in points):
        return True
    for point in points:
        if point is not None:
            candidates.refine(list(point.values()))
    return is_listed()


def _points(question: Question, forms: Forms, root: float) -> Iterator[dict[str, float] | None]:
    """The unknowns at a root and right beside it, where a pole or the end of a domain does not hide them."""
    tear = question.kernel.block.tears[0]
    reach = SAME * (abs(root) or 1.0)
    for at in (root, root - reach, root + reach):
        yield point_at(question, forms, {tear: at})
