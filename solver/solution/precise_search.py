"""The path followed again in many decimal digits, until two precisions agree.

The search in floats gives the number of answers of every step and block, up to the resolution of
floats; here each is refined by Newton's method. If two may be closer than that, both are found, or
one double root, or none.
"""

from __future__ import annotations

import math
from collections import ChainMap
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import partial
from itertools import chain, repeat
from typing import Any

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.digits import context, extended
from rulesheets.model import Equation, Row, Value, Values
from rulesheets.syntax.nodes import Comparison, Expression, names
from solver.accuracy.digits import DigitWork, ManyDigits, Unresolved, null_vectors, resolve_fold
from solver.accuracy.forward_error import forward_errors
from solver.accuracy.rule_check import absorbs, check_rule
from solver.accuracy.rule_sides import gross, half_unit, perturbation, sides
from solver.derivatives.linearization import kinks
from solver.facts import Attempt, Beside, DoubleRoot, Method, NoRoot, RestsOnRounding
from solver.kernel.block import kernel_of
from solver.kernel.candidates import Answer, BlockOutcome, Undecided
from solver.kernel.chain import Chain, followed, slope_chain
from solver.kernel.enclosure import Enclosure
from solver.kernel.linear_block import undetermined
from solver.kernel.problem import BlockProblem, InputErrors
from solver.kernel.step import NoPreimage, StepOutcome, StepSolver, in_floats
from solver.leaves import Asked, Branch, Exploration
from solver.numerics.elimination import eliminate
from solver.numerics.linear_algebra import are_alike
from solver.numerics.tolerances import (
    AGREEMENT,
    BACKWARD,
    CLOSE,
    COMMON,
    DRIFT,
    MAX_UNKNOWNS,
    MOVES,
    PRECISIONS,
    ROUNDED,
    SMALL,
    SPARE,
)
from solver.path import TARGET, Evaluate, SolveBlock, Stage, Step, equations_of
from solver.solution.explore import PathSearch

INVERSE = math.exp(-1.0)
"""A power of x moved to where its tangent is 0 keeps a smaller share of itself, an inverse power a
larger; moved as far the other way, it grows to less than the inverse of that, or to more."""


def explore_precisely(asked: Asked, floats: Exploration) -> Exploration | None:
    """The exploration on which two precisions agree; None if none do. ``floats`` is the one in
    floats."""
    if any(len(step.unknowns) > MAX_UNKNOWNS for step, _ in floats.outcomes):
        return None
    rough: Exploration | None = None
    for digits in PRECISIONS:
        fine: Exploration | None = None
        search = _PreciseSearch(asked, floats, digits)
        with suppress(Unresolved):
            fine = search.run()
        if search.work.left < 0:
            return None  # more digits take as many operations
        if rough is not None and fine is not None and _agree(rough, fine, asked.judged):
            return fine
        rough = fine
    return None


def _agree(rough: Exploration, fine: Exploration, judged: Sequence[str]) -> bool:
    """Whether twice the digits lead to the same answers."""
    some, others = ((found.leaves, found.contradicted, found.open_cases) for found in (rough, fine))
    if [*map(len, some)] != [*map(len, others)]:
        return False
    for one, other in (
        (a.branch, b.branch) for a, b in zip(chain(*some), chain(*others), strict=True)
    ):
        if one.values.keys() != other.values.keys() or one.inactive.keys() != other.inactive.keys():
            return False
        for name in one.precise.keys() & other.precise.keys() & {*judged}:
            exact = other.precise[name]
            if not abs(one.precise[name] - exact) <= AGREEMENT * abs(exact):
                return False
    return True


def _known(branch: Branch) -> Mapping[str, Any]:
    return ChainMap(branch.precise, branch.values)


class _PreciseSearch(PathSearch):
    """Follows every branch with values of so many digits, and with the floats nearest to them."""

    def __init__(self, asked: Asked, floats: Exploration, digits: int) -> None:
        super().__init__(asked)
        self.digits, self.careful = digits, True
        self.outcomes, self.work = floats.outcomes, DigitWork()
        self.expected = floats.leaves[0].branch.signs if floats.leaves else {}
        self._before: dict[SolveBlock, list[Row]] = {}
        for (step, known), outcome in floats.outcomes.items():
            if (outcome.complete or outcome.answers) and not outcome.delicate:
                self._before.setdefault(step, []).append(known)
        self.first_path = ()  # none is solved as one block

    # --- steps and blocks ---

    def _stepped(self, branch: Branch, equation: int, unknown: str) -> StepOutcome:
        """The values of a step; or the double root that rules miss by no more than the last places
        of given numbers, such as that of ``x^2 - 1.72*x + 0.7396 = 0`` at 0.86."""
        asked = self.digits, self.graph, equation, unknown, _known(branch)
        guess = self.guesses.get(unknown)
        found = _PreciseStep(*asked, guess, False, branch.origins).outcome()
        if not found.delicate or found.double or len(found.values) not in (0, 2):
            return found
        rule = self.model.equations[equation]
        step = StepSolver(self.graph, equation, unknown, branch.values)
        with suppress(NoPreimage, Undefined):
            for start in step.preimages():
                system = ManyDigits([rule], (step.unknown,), _known(branch), self.digits, self.work)
                sizes = (abs(v) for v in step.floats.values() if isinstance(v, float))
                fold = (
                    None
                    if isinstance(start, str)
                    else resolve_fold(system, [start], [max(sizes, default=0.0)])
                )
                if fold is None or fold[1] is None or not step.variable.admits(float(fold[1][0])):
                    continue
                if check_rule(rule, {**branch.values, step.unknown: float(fold[1][0])}).holds:
                    double = DoubleRoot((equation,), (step.unknown,), {step.unknown: 1.0})
                    return StepOutcome((fold[1][0],), double=double, delicate=True)
        return found

    def _solved(self, step: SolveBlock, branch: Branch, before: Row | None = None) -> BlockOutcome:
        kernel = kernel_of(self.graph, step)
        # known numbers that differ by rounding, which decided nothing in floats
        known, same = tuple(branch.values[name] for name in kernel.known), self._before.get(step)
        near = next((other for other in same or () if are_alike(known, other, BACKWARD)), None)
        floats = super()._solved(step, branch, near)
        problem = BlockProblem(kernel, branch.values, self.guesses)
        if problem.symbolic or floats.free or not step.unknowns:
            return floats
        rules = [self.model.equations[index] for index in step.equations]
        system = ManyDigits(rules, step.unknowns, _known(branch), self.digits, self.work)
        found = _RefinedBlock(problem, system, floats, partial(self._off, branch)).outcome()
        more = max(0, len(found.answers) - len(floats.answers))
        attempts = (Attempt(Method.EXTENDED, more, found.complete),) if more else ()
        return found._replace(attempts=(*floats.attempts, *attempts), cut=floats.cut)

    def _off(self, branch: Branch) -> Mapping[str, float]:
        """The change of each number with the last places of the inputs, and of the numbers in the
        rules."""
        given = {n: half_unit(v) for n, v in self.inputs.items() if isinstance(v, float)}
        steps, decided = branch.steps, branch.conditions
        return forward_errors(self.model, branch.values, steps, decided, inputs=given).error

    def _same(self, branch: Branch, comparison: Comparison, one: float, other: float) -> bool:
        """Numbers are equal if the last places of the given numbers explain their difference."""
        same = super()._same(branch, comparison, one, other)
        if not same or comparison.operator not in ("=", "<>"):
            return same
        sides, known = (comparison.left, comparison.right), _known(branch)
        left, right = (extended(side, known, self.digits) for side in sides)
        parts = [(sign, side, branch.values) for sign, side in zip((1.0, -1.0), sides, strict=True)]
        reach = perturbation(parts, self._off(branch))
        near = 10.0 ** (SPARE - self.digits) * max(abs(left), abs(right))
        return bool(abs(left - right) <= reach + near)

    # --- values ---

    def _learn(self, branch: Branch, step: Step, found: Mapping[str, Any]) -> None:
        numbers = {name: number for name, number in found.items() if not isinstance(number, str)}
        floats = {**found, **{name: float(number) for name, number in numbers.items()}}
        values, nothing = {**branch.values, **floats}, 10.0 ** (-self.digits // 2)
        for name, number in numbers.items():
            if (
                number
                and abs(number) <= nothing
                and self._is_rounding(step, values, name, float(number))
            ):
                numbers[name], floats[name] = 0 * number, 0.0
        super()._learn(branch, step, floats)
        branch.precise.update(numbers)

    def _is_rounding(self, step: Step, values: Values, name: str, number: float) -> bool:
        """Whether a number is only the rounding of the terms that it was solved from."""
        rules = [self.model.equations[index] for index in equations_of(step)]
        readers = [rule for rule in rules if name in rule.names and values.keys() >= {*rule.names}]
        share = 10.0 ** (SPARE - self.digits)
        with suppress(Undefined):
            return all(
                abs(sides(rule, values).slopes.get(name, 0.0) * number)
                <= share * gross(rule, values)
                != 0.0
                for rule in readers
            )
        return False

    def _moved_into_one_turn(self, branch: Branch) -> dict[str, Value]:
        """Whole turns are also subtracted from the digits beyond floats."""
        moved = super()._moved_into_one_turn(branch)
        for name, number in moved.items():
            before = branch.values[name]
            if isinstance(number, str) or isinstance(before, str) or number == before:
                continue
            turn = self.graph.turn(name)
            if turn is not None and name in branch.precise:
                turns = round((number - before) / turn)
                exact = branch.precise[name] + turns * _exact_turn(turn, context(self.digits))
                branch.precise[name], moved[name] = exact, float(exact)
        return moved

    # --- what rests on rounding ---

    def _finish(self, branch: Branch, underdetermined: bool = False) -> None:
        """Wanted variables that are divided by only the last places of the given numbers are
        noted."""
        # what moves far at a double root is no pole
        double = any(isinstance(fact, DoubleRoot) for fact in branch.facts)
        moved = {} if double else self._off(branch)
        for name, step in {} if double else branch.origins.items():
            if name in self.judged and isinstance(step, Evaluate):
                asked = branch, name, self.model.equations[step.equation], moved
                with suppress(Undefined, ZeroDivisionError):
                    if self._drops_out(*asked) or self._inverts(*asked):
                        branch.facts = (*branch.facts, RestsOnRounding(step.equation, name))
        super()._finish(branch, underdetermined)

    def _drops_out(
        self, branch: Branch, name: str, rule: Equation, moved: Mapping[str, float]
    ) -> bool:
        """Whether a coefficient of an unknown may be 0."""
        isolation = self.graph.isolation(rule.index, self.graph.number[name])
        for stage in isolation.stages if isolation else ():
            if stage.divisor is not None and TARGET.name not in names(stage.divisor):
                number = value(stage.divisor, branch.values)
                part = 1.0, stage.divisor, branch.values
                if 0.0 < abs(number) <= perturbation([part], moved) < math.inf:
                    return True
        return False

    def _inverts(
        self, branch: Branch, name: str, rule: Equation, moved: Mapping[str, float]
    ) -> bool:
        """Whether a number is an inverse power of its argument, and so goes through a pole, not
        through 0.

        The known numbers are moved to where the tangent is 0, and as far the other way.
        """
        number, row = branch.values[name], sides(rule, branch.values).slopes
        if isinstance(number, str) or not 0.0 < abs(number) <= moved.get(name, 0.0) < math.inf:
            return False
        if self.graph.turn(name) is not None:
            return False  # an angle that moves by whole turns passes no pole
        reach = sum(abs(row[n]) * moved.get(n, 0.0) for n in row if n != name)

        def share_left(share: float) -> float | None:
            known = dict(_known(branch))
            for n, slope in row.items():
                if n != name and slope and moved.get(n):
                    off = math.copysign(share * moved[n], share * slope)
                    known[n] = context(self.digits).mpf(known[n]) + off
            root = ManyDigits([rule], (name,), known, self.digits, self.work).newton([number])
            return None if root is None else float(root[0] / number)

        there = share_left(row[name] * number / reach)
        if there is None or there <= INVERSE:
            return False
        with suppress(Undefined, ZeroDivisionError):
            back = share_left(-row[name] * number / reach)
            return back is None or not 0.0 < back < 1.0 / INVERSE  # else it is a kink
        return True


def _exact_turn(turn: float, mp: Any) -> Any:
    """A period in all digits: 360 is exact, the float nearest to 2π stands for 2π."""
    halves = round(turn / math.pi)
    return halves * mp.pi if math.isclose(turn, halves * math.pi, rel_tol=ROUNDED) else mp.mpf(turn)


class _PreciseStep(StepSolver):
    """The known ``values`` may be mpmath numbers, or floats, which are exact.

    Targets are not clamped as in floats for their rounding: a target just inside an image keeps
    both of its preimages, and one just outside has none.
    """

    rounds = False

    def __init__(self, digits: int, *asked: Any) -> None:
        super().__init__(*asked)
        self.digits, self.mp = digits, context(digits)
        self.floats = in_floats(self.floats)

    def evaluate(self, expression: Expression, values: Values) -> Any:
        result = extended(expression, values, self.digits)
        if not result and absorbs(expression, values, self.digits):
            raise Unresolved  # 0 for want of digits
        return result

    def _root(self, number: Any) -> Any:
        return self.mp.sqrt(number)

    def _near(self, share: float) -> float:
        return float(10.0 ** (SPARE - self.digits))

    def _on_the_edge(self, undefined: Undefined) -> bool:
        return False

    def _in_image(self, stage: Stage, target: Any) -> Any:
        """Ends that are not floats (π/2) are left to the operation itself."""
        ends = [end for end in (stage.low, stage.high) if math.isfinite(end)]
        return (
            super()._in_image(stage, target)
            if all(float(end).is_integer() for end in ends)
            else target
        )

    def _turns(self, principal: Any, period: float, rest: tuple[Stage, ...]) -> list[Any]:
        return super()._turns(principal, _exact_turn(period, self.mp), rest)

    def uncounted(self) -> None:
        raise Unresolved

    def _in_one_turn(self, number: Any, turn: float) -> Any:
        whole = _exact_turn(turn, self.mp)
        wrapped = number - whole * self.mp.ceil(number / whole - 0.5)
        return wrapped + whole if float(wrapped) == -turn / 2 else wrapped

    def _polished(self, number: Any) -> Any:
        return number


class _RefinedBlock:
    """The answers of a block in floats, each refined."""

    def __init__(
        self, problem: BlockProblem, system: ManyDigits, floats: BlockOutcome, off: InputErrors
    ) -> None:
        self.problem, self.system, self.floats, self.off = problem, system, floats, off
        self.roots: list[list[Any]] = []
        self.folded: list[list[Any]] = []
        self.double: list[Answer] = []

    def outcome(self) -> BlockOutcome:
        """Raises Unresolved if Newton's method leads away from an answer."""
        if self.problem.kernel.linear:
            return self._linear()
        self.double = [answer for answer in self.floats.answers if answer.double and answer.counted]
        known = (answer.values for answer in self.floats.answers if answer not in self.double)
        for seed in (*known, *self.floats.unresolved):
            start = list(seed.values())
            if self._folded(start):
                continue
            root = self.system.newton(start)
            if root is None or not are_alike(root, start, DRIFT, self.problem.scale):
                raise Unresolved
            self._keep(root)
        for suspect in self.floats.suspects:
            self._folded(list(suspect.values()))
        return self._summary()

    def _linear(self) -> BlockOutcome:
        """By elimination; the free unknowns, if rounding may have decided that floats found no
        answer."""
        system, problem = self.system, self.problem
        try:
            matrix, misses = system.linearised([system.mp.zero] * len(system.unknowns))
        except Undefined:  # a coefficient has no value, and floats found none either
            return self.floats
        rhs = [-miss for miss in misses]
        x = eliminate(matrix, rhs, system.tiny)
        if self.floats.doubtful:
            free = undetermined(problem, matrix, rhs, system.mp.mpf, self.off, singular=x is None)
            if free is not None:
                return free
        if x is None or not self.floats.answers:
            return self.floats
        self._keep(x)
        return self._summary()

    def _folded(self, start: Sequence[float]) -> bool:
        """Whether a fold is near: then its roots are kept. Raises Unresolved at a kink, where
        slopes tell nothing."""
        here = {**self.problem.here, **self.problem.named(start)}
        if any(True for rule in self.problem.kernel.equations for _ in kinks(rule, here)):
            raise Unresolved
        if any(
            are_alike(root, start, CLOSE, repeat(SMALL * max(map(abs, start))))
            for root in self.folded
        ):
            return True
        fold = resolve_fold(self.system, start, self.problem.scale)
        if fold is None:
            return False
        roots, double = fold
        self.folded += roots
        for root in roots:
            self._keep(root)
        if double is not None:  # in floats: it is no isolated answer in more digits
            point = _floats(self.system.point(double))
            vectors = null_vectors(self.system, double)
            along = [1.0] * len(point) if vectors is None else vectors[0]
            moving = {n: v for n, v in zip(point, along, strict=True) if abs(v) > MOVES}
            fact = DoubleRoot(self.problem.equations, tuple(moving), moving)
            self.double = [a for a in self.floats.answers if a.double] or [Answer(point, fact)]
        return True

    def _keep(self, root: list[Any]) -> None:
        small, sizes = float(self.system.small), repeat(1e-30 * max(map(abs, root)))
        if not any(are_alike(root, other, small, sizes) for other in self.roots):
            self.roots.append(root)

    def _summary(self) -> BlockOutcome:
        inside, outside = [], None
        points = [self.system.point(root) for root in self.roots]
        doubles = [answer.values for answer in self.double]
        complete = self.floats.complete or self.floats.whole
        complete = complete or _are_counted(
            self.floats.stretches, self.problem.here, self.system, points, doubles
        )
        for point in points:
            floats = _floats(point)
            # what rounding alone takes beyond the end of a range
            moved = self.problem.inside(floats)
            point = {n: v if moved[n] == floats[n] else moved[n] for n, v in point.items()}
            name = self.problem.outside(_floats(point))
            if name is None:
                inside.append(Answer(point))
            else:
                outside = BlockOutcome.out_of_range(
                    self.problem.equations, name, float(point[name])
                )
        answers = sorted(inside, key=lambda answer: self.problem.preference(_floats(answer.values)))
        if answers or self.double:
            # curves along which some unknowns keep their values; others may be points that rounding
            # joins
            curves = tuple(
                fact for fact in self.floats.facts if isinstance(fact, Beside) and fact.values
            )
            return BlockOutcome((*answers, *self.double), complete, curves)
        if outside is not None:
            return outside._replace(complete=complete)
        if self.floats.answers or (complete and not self.floats.complete):
            block = self.problem.kernel.block
            return BlockOutcome(
                complete=complete, facts=(NoRoot(block.equations, block.unknowns, complete),)
            )
        return self.floats


def _floats(point: Mapping[str, Any]) -> dict[str, float]:
    return {name: float(number) for name, number in point.items()}


# --- short stretches of a tear on which the residual is convex or concave: two roots at most ---
#
# If f'' ≥ m > 0 on a stretch, f ≥ f(x) − f'(x)²/2m there, for any x of it. So a value and a slope,
# in many digits, tell that there is no root; and two roots, once they are found, are all.

MARGIN = 8.0
"""Widths by which a stretch is widened on both sides to look for its roots."""


def _are_counted(
    stretches: Sequence[Undecided],
    floats: Values,
    system: ManyDigits,
    roots: Sequence[Mapping[str, Any]],
    doubles: Sequence[Mapping[str, Any]],
) -> bool:
    """Whether all roots on the stretches are among ``roots`` (and the ``doubles``, which count
    twice).

    The known values are in ``system`` in many digits, and among the ``floats``.
    """
    numbers = {name: v for name, v in floats.items() if isinstance(v, float)}
    for stretch in stretches:
        slope = slope_chain(stretch.kernel.chains[stretch.place])
        enclosure = Enclosure(slope, tuple(numbers))
        ((low, high),) = enclosure.slopes_over(
            [(stretch.low, stretch.high)], list(numbers.values())
        )
        if not (low > 0.0 or high < 0.0):  # f'' is not proven not to vanish
            return False
        # the value of f'' that is least in size
        curvature = float(low) if low > 0.0 else float(high)
        count = sum(_lies_on(stretch, root, floats) for root in roots)
        count += 2 * sum(_lies_on(stretch, root, floats) for root in doubles)
        if count < 2 and (count or not _excludes(stretch, slope, curvature, system)):
            return False
    return bool(stretches)


def _lies_on(stretch: Undecided, root: Mapping[str, Any], floats: Values) -> bool:
    """Whether a root of the block is in or next to the stretch, by preimages of its chain."""
    pad = MARGIN * (stretch.high - stretch.low)
    chain = stretch.kernel.chains[stretch.place]
    x, turn = float(root[chain.tears[0]]), stretch.kernel.graph.turn(chain.tears[0]) or 0.0
    if not any(stretch.low - pad <= x + k * turn <= stretch.high + pad for k in (-1, 0, 1)):
        return False
    try:
        values = followed(chain, {**floats, **root}, PRECISIONS[0])
    except (Undefined, OverflowError):
        return False
    names = [item.name for item in chain.assignments if item.name in root]
    return are_alike(map(values.get, names), map(root.get, names), COMMON)


def _excludes(stretch: Undecided, slope: Chain, curvature: float, system: ManyDigits) -> bool:
    """Whether f has no root on the stretch: tried at its middle, and at the root of f'."""
    x = 0.5 * (stretch.low + stretch.high)
    for _ in range(4):
        try:
            values = followed(slope, {**system.known, slope.tears[0]: x}, system.digits)
        except (Undefined, OverflowError):
            return False
        residual = stretch.kernel.chains[stretch.place].residuals[0]
        value, steepness = values[residual], values[slope.residuals[0]]
        if (
            value * curvature > 0
            and abs(value) * 2 * abs(curvature) > 1.001 * steepness * steepness
        ):
            return True
        x = min(max(x + float(-steepness / curvature), stretch.low), stretch.high)
    return False
