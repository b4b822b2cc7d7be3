"""Blocks that say the same by other rules: cases of conditions that differ in which guard lets a formula in.

``if and(x >= a, y >= 0) then v = w`` and ``if and(x <= a, y <= 0) then v = w`` put the same equation into a
block, so that what was found for the one case holds for the other: each keeps the answers that fit it.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from rulesheets.model import Equation, Model
from rulesheets.syntax.nodes import Expression
from solver.facts import AsksNothing, NoValue, OutOfRange

if TYPE_CHECKING:
    from typing import Any, TypeAlias

    from solver.kernel.outcome import BlockOutcome
    from solver.path.steps import SolveBlock

    Sense: TypeAlias = tuple[tuple[int, ...], tuple[str, ...]]


class Twins:
    """Which guarded equations of a model have the same two sides."""

    def __init__(self, model: Model) -> None:
        first: dict[tuple[Expression, Expression], int] = {}
        guarded = [equation for equation in model.equations if equation.guard]
        self._first = {e.index: first.setdefault(_sides(e), e.index) for e in guarded}

    def sense(self, step: SolveBlock) -> Sense:
        """The same for blocks of the same equations, by whatever rules, for the same unknowns."""
        return tuple(sorted(map(self._of, step.equations))), step.unknowns

    def told(self, outcome: BlockOutcome, met: SolveBlock, step: SolveBlock) -> BlockOutcome:
        """The outcome of the block that was ``met``, in the rules of ``step``, which has the same sense."""
        own = {self._of(equation): equation for equation in step.equations}
        names = {equation: own[self._of(equation)] for equation in met.equations}
        answers = tuple(
            answer if answer.double is None else replace(answer, double=_renamed(answer.double, names))
            for answer in outcome.answers
        )
        return replace(outcome, answers=answers, facts=tuple(_renamed(fact, names) for fact in outcome.facts))

    def _of(self, equation: int) -> int:
        return self._first.get(equation, equation)


def _sides(equation: Equation) -> tuple[Expression, Expression]:
    return equation.left, equation.right


def _renamed(fact: Any, names: dict[int, int]) -> Any:
    """A fact about a block with its equations under other numbers."""
    match fact:
        case NoValue() | OutOfRange() | AsksNothing():
            return replace(fact, equation=names[fact.equation])
        case _:
            return replace(fact, equations=tuple(names[equation] for equation in fact.equations))
