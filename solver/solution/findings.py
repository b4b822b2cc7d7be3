"""What an exploration has found so far, and where it may have left something out."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from rulesheets.model import Model, Value
from solver.accuracy.rule_check import check_rule
from solver.facts import Conflict, Fact, Gap, Truncated
from solver.path.cases import activity
from solver.solution.indeterminacy import indeterminacy
from solver.solution.leaves import Branch, Exploration, Leaf, blocked, excluded, infinite
from solver.solution.requirements import unmet

if TYPE_CHECKING:
    from solver.solution.leaves import Outcomes

MAX_LEAVES = 1_000


class Findings:
    """The leaves of one exploration, and its gaps.

    ``judged`` are the names that a leaf must have; ``enough`` ends the search at the first such leaf.
    ``complete``: no step so far can have more answers than were followed. ``delicate``: somewhere rounding
    decides how many there are, or whether a rule holds.
    """

    def __init__(
        self, model: Model, judged: Sequence[str], enough: Callable[[Leaf], bool] | None = None
    ) -> None:
        self.model, self.judged = model, judged
        self.leaves: list[Leaf] = []
        self.dead: list[Leaf] = []
        self.adrift: list[Leaf] = []
        self.complete = True
        self.delicate = False
        self._gaps: dict[tuple[int, ...], Gap] = {}
        self._enough = enough

    @property
    def full(self) -> bool:
        """Whether nothing more is looked for."""
        if self._enough is not None and any(map(self._enough, self.leaves)):
            return True
        return len(self.leaves) + len(self.dead) + len(self.adrift) >= MAX_LEAVES

    def note(
        self,
        complete: bool,
        equations: tuple[int, ...],
        unknowns: tuple[str, ...],
        listed: Sequence[Mapping[str, Value]],
        cut: bool,
    ) -> None:
        """Remember where a step may have more answers than are listed, the first of each step."""
        self.complete = self.complete and complete
        if complete or equations in self._gaps:
            return
        first = [values[unknowns[0]] for values in listed if unknowns[0] in values]
        numbers = [number for number in first if not isinstance(number, str)]  # in floats, or of many digits
        low, high = (min(numbers), max(numbers)) if numbers else (0.0, 0.0)
        ends, listed_cut = (float(low), float(high)), cut and len(listed) > 1
        self._gaps[equations] = Gap(equations, unknowns, len(listed), *ends, listed_cut, uncounted=cut)

    def truncate(self, branch: Branch, what: str) -> None:
        """Remember that a branch was given up: there are too many ``what``."""
        self.complete = False
        self._gaps.setdefault((), Gap(count=len(self.leaves), cut=what == "answers"))
        branch.facts = (*branch.facts, Truncated(what))

    def loose_since(self, adrift: int) -> bool:
        """Whether the cases since so many were ``adrift`` leave a continuum that nothing contradicts.

        Answers of other cases do not make it a solved one; a case of equality is but its edge.
        """
        return any(not blocked(leaf) and not leaf.on_edge for leaf in self.adrift[adrift:])

    def add(self, branch: Branch, decided: Mapping[int, bool], loose: bool, unverified: bool) -> None:
        """The end of a branch: every rule that is active there is asked of the independent rule check.

        ``unverified``: an assumption was made on what is not known even now.
        """
        values = branch.values
        conflicts: list[Fact] = []
        worst, checked = 0.0, 0
        for equation in self.model.equations:
            if not activity(equation, decided) or not all(name in values for name in equation.names):
                continue
            check = check_rule(equation, values)
            checked += 1
            if check.holds:
                worst = max(worst, check.scaled)
            else:
                self.delicate = self.delicate or check.delicate
                undefined = indeterminacy(equation, values) if check.miss is None else None
                conflicts.append(undefined or Conflict((equation.index,), check.miss, values))
        conflicts += unmet(self.model, values, decided)
        lacking = (name for name in self.judged if name not in values)
        missing = tuple(name for name in lacking if not infinite(self.model, branch, name))
        leaf = Leaf(branch, missing, tuple(conflicts), worst, checked, loose)
        if conflicts:
            self.dead.append(leaf)
        else:
            (self.adrift if missing and unverified else self.leaves).append(leaf)

    def exploration(self, outcomes: Outcomes, work: int, refused: Callable[[Leaf], bool]) -> Exploration:
        """All of it, once every branch has ended. ``refused`` tells of a case that is adrift whether what it
        lacks is refused, so that no answer is hidden there."""
        return Exploration(
            tuple(self.leaves),
            self.complete and all(excluded(leaf) or refused(leaf) for leaf in self.adrift),
            tuple(self.dead),
            tuple(self.adrift),
            self.delicate,
            outcomes,
            work,
            tuple(self._gaps.values()),
        )
