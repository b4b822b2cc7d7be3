"""A simultaneous block at given numbers, to many digits: the float answers refined, folds resolved.

The search in floats says where the roots are, up to what floats can tell; here each is refined, and where two
may lie closer than that, both are found, or it is seen that there is one double root or none.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from rulesheets.evaluate import Undefined
from solver.attempts import Attempt, Method
from solver.facts import DoubleRoot, NoRoot
from solver.kernel.candidates import Answer
from solver.kernel.elimination.near_rank import Blur, free_to_witness, undetermined
from solver.kernel.outcome import BlockOutcome
from solver.kernel.precise.extended_step import exact_turn
from solver.kernel.precise.extended_system import ExtendedSystem, Unresolved
from solver.kernel.precise.fold import null_vectors, resolve_fold
from solver.kernel.question import Question
from solver.numerics.elimination import eliminate
from solver.numerics.linear import EXACT_LIMIT

CLOSE = 1e-5
"""Relative distance of a root from another whose fold it shares."""
DRIFT = 1e-2
"""How far a root may lie from the float answer that it is taken for, relative to its size."""


def solve_block_extended(
    question: Question, system: ExtendedSystem, outcome: BlockOutcome, off: Blur
) -> BlockOutcome:
    """The answers of ``outcome``, which floats found for the ``question``, for the known values of the
    ``system``, to many digits. ``off`` tells how far these may be from what they stand for.

    Raises Unresolved where the precision, or the method, does not do.
    """
    kernel = question.kernel
    if question.symbolic or not kernel.unknowns:
        return outcome
    if not system.usable:
        raise Unresolved
    refinement = _Refinement(question, system, outcome)
    found = refinement.linear(off) if kernel.linear else refinement.outcome()
    more = max(0, len(found.answers) - len(outcome.answers))
    attempts = (Attempt(Method.EXTENDED, more, found.complete),) if more else ()
    return replace(found, attempts=(*outcome.attempts, *attempts))


class _Refinement:
    def __init__(self, question: Question, system: ExtendedSystem, outcome: BlockOutcome) -> None:
        self.question, self.system, self.floats = question, system, outcome
        self.roots: list[list[Any]] = []
        self.folded: list[list[Any]] = []
        self.double: list[Answer] = []

    def linear(self, off: Blur) -> BlockOutcome:
        """Elimination; where it says that the block is singular, the float outcome may tell how."""
        zero = [self.system.mp.zero] * len(self.question.unknowns)
        try:
            matrix, rhs = self.system.jacobian(zero), [-r for r in self.system.residual(zero)]
        except (Undefined, OverflowError):
            raise Unresolved from None
        x = self._solved(matrix, rhs)
        if self.floats.doubtful:
            free = undetermined(self.question, matrix, rhs, self.system.mp.mpf, off, singular=x is None)
            if free is not None:
                return free
        found = self._eliminated(x)
        if self.floats.doubtful:
            return free_to_witness(self.question, matrix, rhs, self.system.mp.mpf, off, found)
        return found

    def _solved(self, matrix: Sequence[Sequence[Any]], rhs: Sequence[Any]) -> list[Any] | None:
        """By elimination in the digits at hand, and exactly where an equation misses by more than these
        leave of its own terms, as it may where sizes differ: None where the matrix is singular to them."""
        mp, tiny = self.system.mp, self.system.tiny
        x = eliminate(matrix, rhs, tiny)
        if x is None or len(matrix) > EXACT_LIMIT:
            return x
        for row, b in zip(matrix, rhs, strict=True):
            terms = [a * v for a, v in zip(row, x, strict=True)]
            if abs(sum(terms) - b) > tiny * (sum(map(abs, terms)) + abs(b)):
                exact = eliminate([list(map(_rational, r)) for r in matrix], list(map(_rational, rhs)))
                return x if exact is None else [mp.mpf(v.numerator) / v.denominator for v in exact]
        return x

    def _eliminated(self, x: list[Any] | None) -> BlockOutcome:
        """What elimination came to; where it found the matrix singular, what floats did."""
        if x is None:
            if any(not answer.double for answer in self.floats.answers) and not self.floats.free:
                raise Unresolved
            return self.floats
        point = self._inside(self.system.point(x))
        outside = self.question.outside(_floats(point))
        if outside is not None:
            return BlockOutcome.out_of_range(self.question.equations, outside, float(point[outside]))
        return BlockOutcome((Answer(point),), complete=True)

    def outcome(self) -> BlockOutcome:
        if self.floats.free:
            return self.floats
        seeds = [answer.values for answer in self.floats.answers]
        for seed in seeds:
            self._refine(seed)
        for near in self.floats.refused:
            self._refine(near)
        for point in self.floats.blurred:
            self._try(point)
        for suspect in self.floats.suspects:
            start = list(suspect.values())
            if not any(_close(start, root) for root in self.folded):
                self._look(start)
        return self._summary()

    def _refine(self, seed: Mapping[str, float]) -> None:
        """The root that a float answer stands for, and its sibling where they nearly coincide."""
        start = list(seed.values())
        if any(_close(start, root) for root in self.folded) or self._look(start):
            return
        root = self.system.newton(start)
        if root is None or not self._near(root, start):
            raise Unresolved
        self._keep(root)

    def _try(self, blurred: Mapping[str, float]) -> None:
        """The root next to where floats converge, if there is one."""
        start = list(blurred.values())
        root = self.system.newton(start)
        if root is not None and self._near(root, start):
            self._keep(root)

    def _look(self, start: Sequence[float]) -> bool:
        """Whether a fold is near: then it is resolved."""
        fold = resolve_fold(self.system, start, self.question.scale())
        if fold is None:
            return False
        self.folded += fold.roots
        for root in fold.roots:
            self._keep(root)
        if fold.double is not None:
            self.double = [answer for answer in self.floats.answers if answer.double] or [
                self._double(fold.double)
            ]
        return True

    def _double(self, root: list[Any]) -> Answer:
        """The answer where two coincide. (Values in floats: it is no isolated answer to more digits.)"""
        point = _floats(self.system.point(root))
        vectors = null_vectors(self.system, root)
        along = [1.0] * len(root) if vectors is None else vectors[0]
        moving = {n: v for n, v in zip(point, along, strict=True) if abs(v) > 1e-6}
        return Answer(point, DoubleRoot(self.question.equations, tuple(moving), moving))

    def _near(self, root: Sequence[Any], start: Sequence[float]) -> bool:
        sizes = [max(abs(s), scale) for s, scale in zip(start, self.question.scale(), strict=True)]
        return all(abs(r - s) <= DRIFT * size for r, s, size in zip(root, start, sizes, strict=True))

    def _keep(self, root: list[Any]) -> None:
        root = self._turned(root)
        size = max(abs(v) for v in root)
        if not any(
            all(abs(a - b) <= self.system.small * max(abs(a), self.system.tiny * size) for a, b in pairs)
            for pairs in (list(zip(root, other, strict=True)) for other in self.roots)
        ):
            self.roots.append(root)

    def _turned(self, root: list[Any]) -> list[Any]:
        """The root with its angles in (-180, 180], if that is one: sums may tie some of them together."""
        turned = [self._wrapped(n, v) for n, v in zip(self.question.unknowns, root, strict=True)]
        same = all(a is b for a, b in zip(turned, root, strict=True))
        return turned if same or self.question.holds(_floats(self.system.point(turned))) else root

    def _wrapped(self, name: str, number: Any) -> Any:
        """An angle without a declared range in (-180, 180]."""
        turn, variable = self.question.turn(name), self.question.graph.model.variables[name]
        if turn is None or variable.low > float("-inf") or variable.high < float("inf"):
            return number
        whole = exact_turn(turn, self.system.mp)
        turns = self.system.mp.ceil(number / whole - 0.5)
        if not turns:
            return number
        moved = number - whole * turns
        return moved + whole if float(moved) == -turn / 2 else moved

    def _summary(self) -> BlockOutcome:
        inside, outside = [], None
        complete = self.floats.complete or self.floats.whole or self._settled()
        for root in self.roots:
            point = self._inside(self.system.point(root))
            name = self.question.outside(_floats(point))
            if name is None:
                inside.append(Answer(point))
            else:
                outside = BlockOutcome.out_of_range(self.question.equations, name, float(point[name]))
        answers = sorted(inside, key=lambda answer: self.question.preference(_floats(answer.values)))
        if answers or self.double:
            return BlockOutcome((*answers, *self.double), complete)
        if outside is not None:
            return replace(outside, complete=complete)
        if self.floats.answers or complete:
            block = self.question.kernel.block
            fact = NoRoot(block.equations, block.unknowns, complete)
            return BlockOutcome(complete=complete, facts=(fact,))
        return self.floats

    def _inside(self, point: Mapping[str, Any]) -> Mapping[str, Any]:
        """The point with what lies beyond an end of its range by rounding alone on that end."""
        floats = _floats(point)
        moved = self.question.inside(floats)
        return {name: v if moved[name] == floats[name] else moved[name] for name, v in point.items()}

    def _settled(self) -> bool:
        """Whether what floats could not settle is settled now, so that these are all the roots."""
        from solver.kernel.precise.convexity import settled

        points = [self.system.point(root) for root in self.roots]
        doubles = [answer.values for answer in self.double]
        known, digits = self.system.known, self.system.digits
        return settled(self.floats.stretches, self.question.here, known, points, doubles, digits)


def _rational(number: Any) -> Fraction:
    """The number that a finite mpf stands for."""
    mantissa, exponent = abs(number).man_exp
    size = mantissa * Fraction(2) ** exponent
    return Fraction(-size if number < 0 else size)


def _close(start: Sequence[float], root: Sequence[Any]) -> bool:
    """Whether a fold that was resolved is the one near ``start``."""
    size = max(abs(s) for s in start)
    return all(abs(s - r) <= CLOSE * max(abs(s), 1e-3 * size) for s, r in zip(start, root, strict=True))


def _floats(point: Mapping[str, Any]) -> dict[str, float]:
    return {name: float(number) for name, number in point.items()}
