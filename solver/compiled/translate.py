"""From a path to a straight-line program, along the decisions that one run of it took.

The program computes what the step-by-step way computes, and beside it whether it did: every
condition that chose the way, every domain, every rule that does not hold by the way its unknown was
computed. Where one of these fails the results do not count, and the step-by-step way has the word.
"""

from __future__ import annotations

import math

from rulesheets import nodes
from rulesheets.construct import subtract
from rulesheets.evaluate import NotDifferentiable, Undefined, differentiate, holds, value
from rulesheets.nodes import And, Comparison, Expression, Given, Name, Not, Or, Symbol
from rulesheets.record import dataclass, field, replace
from solver.compiled.flow import Flow, NotCompilable
from solver.compiled.merge import less
from solver.compiled.program import Ending, Program
from solver.compiled.roots import RootFinder, root_values
from solver.compiled.rounding import accurate
from solver.compiled.trim import trimmed
from solver.kernel.block import BlockKernel
from solver.kernel.question import Question
from solver.path.activity import activity
from solver.path.closed_form import Circle, ClosedForm, Let, Parabola
from solver.path.isolate import TARGET
from solver.path.steps import Check, Decide, Evaluate, Select, SolveBlock
from solver.witness import BACKWARD

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from rulesheets.model import Equation, Model, Value, Variable
    from solver.path.closed_form import Coefficient
    from solver.path.isolate import Isolation, Quadratic, Stage
    from solver.path.planner import Planner
    from solver.path.steps import Step

MAX_ENDINGS = 8
MAX_TURNS = 8
CLEAR = 1e-6
"""Discriminants and divisors smaller than this, relative to their terms, are left to the step-by-step way."""
STRANGE = 1e-6
"""A root that came out negative by more than this, relative to its terms, belongs to no answer."""
_DIRECTIONS = frozenset({"atan2", "atan2d", "acosd", "asind", "atand", "acos", "asin", "atan"})
_LINEAR = frozenset({"negative", "sum", "product", "quotient"})


@dataclass(frozen=True)
class Pattern:
    """What is fixed before the numbers: which inputs vary, what the others are, what is wanted."""

    inputs: tuple[str, ...]
    given: Mapping[str, Value]
    want: tuple[str, ...]
    guesses: Mapping[str, float]
    pruned: tuple[str, ...] | None = ()
    """The names that the path is pruned to where it is not to ``want``; None: a path to all there is."""
    clear: float = CLEAR
    as_written: bool = False
    """Whether every value must satisfy the rules as they are evaluated in floats."""
    accuracy: tuple[tuple[str, ...], float] | None = None
    """Names whose values count only if rounding cannot have changed them by more than a share."""


@dataclass
class Way:
    """What is known along one way through the forks."""

    values: dict[str, int]
    symbols: dict[str, str]
    decided: dict[int, bool]
    settled: set[int] = field(default_factory=set)
    chosen: list[int] = field(default_factory=list)
    checks: list[int] = field(default_factory=list)
    finite: list[int] = field(default_factory=list)
    order: list[int] = field(default_factory=list)
    gone: int = 1

    def fork(self) -> Way:
        return replace(
            self,
            values=dict(self.values),
            symbols=dict(self.symbols),
            decided=dict(self.decided),
            settled=set(self.settled),
            chosen=list(self.chosen),
            checks=list(self.checks),
            finite=list(self.finite),
            order=list(self.order),
        )


def translate(
    model: Model,
    planner: Planner,
    pattern: Pattern,
    sample: Mapping[str, Value],
    plain: bool = False,
    first: bool = False,
) -> Program:
    """The program for all rows that decide as ``sample`` does: values of every variable that has one there.

    ``first``: follow the primary one of several values only, chosen as soon as they are there.
    Raises NotCompilable where a step has no straight-line form.
    """
    return Translation(model, planner, pattern, sample, plain, first).run()


class Translation:
    """Follows a path as the sample did."""

    def __init__(
        self,
        model: Model,
        planner: Planner,
        pattern: Pattern,
        sample: Mapping[str, Value],
        plain: bool = False,
        first: bool = False,
    ) -> None:
        self.model, self.planner, self.pattern = model, planner, pattern
        self.graph = planner.graph
        self.sample, self.first = sample, first
        self.flow = Flow(plain)
        self.given = frozenset((*pattern.given, *pattern.inputs))
        pruned = pattern.want if pattern.pruned == () else pattern.pruned
        self.want = None if pruned is None else frozenset(pruned)
        self.endings: list[Ending] = []

    def run(self) -> Program:
        flow = self.flow
        values: dict[str, int] = {}
        symbols: dict[str, str] = {}
        for name, known in self.pattern.given.items():
            if isinstance(known, str):
                symbols[name] = known
            else:
                values[name] = flow.constant(known)
        told: list[tuple[int, str]] = []
        for place, name in enumerate(self.pattern.inputs):
            if isinstance(said := self.sample[name], str):
                symbols[name] = said
                told.append((place, said))
            else:
                values[name] = flow.input(place)
        way = Way(values, symbols, {}, gone=flow.false)
        flow.checks = way.checks
        for name in self.pattern.inputs:
            if name in values:
                self._within(way, self.model.variables[name], values[name])
        self._decide(way, range(len(self.model.conditions)))
        self._plan(way)
        return Program(flow, len(self.pattern.inputs), tuple(self.endings), tuple(told))

    # --- the way ---

    def _plan(self, way: Way) -> None:
        for condition in way.chosen:
            self._pin(way, condition)
        way.chosen.clear()
        known = frozenset((*way.values, *way.symbols))
        path = self.planner.path(known, way.decided, frozenset(), self.want)
        self._follow(way, path.steps)

    def _follow(self, way: Way, steps: Sequence[Step]) -> None:
        for place, step in enumerate(steps):
            self.flow.checks, self.flow.finite = way.checks, way.finite
            if isinstance(step, Decide):
                self._decide(way, step.conditions)
                self._plan(way)
                return
            found = self._taken(way, step)
            if self.first and len(found) > 1:
                found = [self._merged(found)]
            if len(found) != 1:
                for fork in found:
                    self._follow(fork, steps[place + 1 :])
                return
            way = found[0]
        self._finish(way)

    def _taken(self, way: Way, step: Step) -> list[Way]:
        """The way after a step, or the ways that it forks into."""
        match step:
            case Evaluate(equation=equation, unknown=unknown):
                return list(self._evaluated(way, equation, unknown))
            case Select():
                return [self._selected(way, step)]
            case SolveBlock():
                return list(self._block(way, step))
            case Check():
                return [way]
            case _:
                raise NotCompilable

    def _merged(self, ways: list[Way]) -> Way:
        """The first of several ways that is not gone, as one; all that tells which it is must hold."""
        flow = self.flow
        best, *others = ways
        for other in others:
            sooner = less(flow, tuple(other.order), tuple(best.order))
            instead = flow.add("and", flow.add("not", other.gone), flow.add("or", best.gone, sooner))
            for name, node in best.values.items():
                best.values[name] = flow.add("where", instead, other.values[name], node)
            pairs = zip(other.order, best.order, strict=True)
            best.order = [flow.add("where", instead, *pair) for pair in pairs]
            best.gone = flow.add("and", best.gone, other.gone)
            best.checks += [check for check in other.checks if check not in best.checks]
            best.finite += [node for node in other.finite if node not in best.finite]
        best.order = []
        flow.checks = best.checks
        flow.require(flow.add("not", best.gone))
        best.gone = flow.false
        return best

    # --- conditions ---

    def _decide(self, way: Way, conditions: Sequence[int]) -> None:
        """Take the outcome that the sample had, and require it."""
        self.flow.checks = way.checks
        known = {n: v for n, v in self.sample.items() if n in way.values or n in way.symbols}
        for index in conditions:
            if index in way.decided:
                continue
            try:
                outcome = holds(self.model.conditions[index], known, self.given)
            except KeyError:
                continue
            except Undefined:
                raise NotCompilable from None
            way.decided[index] = outcome
            self._pin(way, index, outcome)

    def _pin(self, way: Way, index: int, outcome: bool | None = None) -> None:
        self.flow.checks = way.checks
        if outcome is None:
            known = {n: v for n, v in self.sample.items() if n in way.values or n in way.symbols}
            outcome = holds(self.model.conditions[index], known, self.given)
            way.decided[index] = outcome
        node = self._condition(way, self.model.conditions[index], outcome)
        if node is None:
            raise NotCompilable
        self.flow.require(node if outcome else self.flow.add("not", node))

    def _condition(self, way: Way, condition: nodes.Condition, missing: bool | None = None) -> int | None:
        """The node of a condition; None where a variable is missing.

        With ``missing``, terms that are not known are left out where the others settle that outcome.
        """
        flow = self.flow
        match condition:
            case Comparison(operator, left, right):
                return self._comparison(way, operator, left, right)
            case And(terms) | Or(terms):
                join = "and" if isinstance(condition, And) else "or"
                found = [self._condition(way, term) for term in terms]
                known = [node for node in found if node is not None]
                if len(known) < len(found) and (missing is None or missing is (join == "and") or not known):
                    return None
                total = known[0]
                for node in known[1:]:
                    total = flow.add(join, total, node)
                return total
            case Not(term):
                inside = self._condition(way, term)
                return None if inside is None else flow.add("not", inside)
            case Given(name):
                return flow.constant(name in self.given)
        raise NotCompilable

    def _comparison(self, way: Way, operator: str, left: Expression, right: Expression) -> int | None:
        used = {*nodes.names(left), *nodes.names(right)}
        if not all(name in way.values or name in way.symbols for name in used):
            return None
        symbols = [_symbol(side, way.symbols) for side in (left, right)]
        if symbols != [None, None]:
            same = symbols[0] == symbols[1]
            return self.flow.constant(same is (operator == "=") and operator in ("=", "<>"))
        return self.flow.compare(operator, *(self._expression(way, side) for side in (left, right)))

    def _active(self, way: Way, equation: Equation) -> int | None:
        """The node of an equation's guard; None where it is not known."""
        total = self.flow.true
        for premise in equation.guard:
            node = self._condition(way, self.model.conditions[premise.condition])
            if node is None:
                return None
            total = self.flow.add("and", total, node if premise.holds else self.flow.add("not", node))
        return total

    # --- one equation for one unknown ---

    def _expression(self, way: Way, expression: Expression) -> int:
        try:
            return self.flow.expression(expression, way.values)
        except KeyError:
            raise NotCompilable from None

    def _isolation(self, equation: int, unknown: str) -> Isolation:
        isolation = self.graph.isolation(equation, self.graph.number[unknown])
        assert isolation is not None
        return isolation

    def _evaluated(self, way: Way, equation: int, unknown: str) -> Iterator[Way]:
        isolation = self._isolation(equation, unknown)
        if _certified(isolation):
            way.settled.add(equation)
        said = _symbol(isolation.start, way.symbols) if isolation.identity else None
        if said is not None:
            way.symbols[unknown] = said
            yield way
            return
        found = self._preimages(way, isolation)
        variable = self.model.variables[unknown]
        if len(found) == 1:
            self._within(way, variable, found[0])
            way.values[unknown] = found[0]
            yield way
            return
        for place, node in enumerate(found):
            fork = way.fork()
            fork.values[unknown] = node
            fork.order.append(self.flow.constant(float(place)))
            self._leave(fork, variable, node)
            if fork.gone != self.flow.true:
                yield fork

    def _within(self, way: Way, variable: Variable, node: int) -> None:
        """Values outside the declared range do not count; how they fail is for the step-by-step way."""
        self.flow.require(self._in_range(variable, node))

    def _leave(self, way: Way, variable: Variable, node: int) -> None:
        """One of several values is no answer outside the declared range."""
        outside = self.flow.add("not", self._in_range(variable, node))
        way.gone = self.flow.add("or", way.gone, outside)

    def _in_range(self, variable: Variable, node: int) -> int:
        flow, inside = self.flow, self.flow.true
        if variable.low > -math.inf:
            low = flow.constant(variable.low)
            inside = flow.add("and", inside, flow.add("lt" if variable.low_open else "le", low, node))
        if variable.high < math.inf:
            high = flow.constant(variable.high)
            inside = flow.add("and", inside, flow.add("lt" if variable.high_open else "le", node, high))
        return inside

    def _preimages(self, way: Way, isolation: Isolation) -> list[int]:
        """The nodes of all preimages, the principal one first."""
        if isolation.quadratic is not None:
            return self._quadratic(way, isolation.quadratic)
        targets = [self._expression(way, isolation.start)]
        for place, stage in enumerate(isolation.stages):
            rest = isolation.stages[place + 1 :]
            targets = [node for target in targets for node in self._undone(way, stage, target)]
            if stage.period is not None:
                return self._turned_values(way, isolation, stage, rest, targets)
        return targets

    def _undone(self, way: Way, stage: Stage, target: int) -> list[int]:
        flow = self.flow
        several = len(stage.forms) > 1
        if stage.low > -math.inf:
            strict = stage.low_open or several
            flow.require(flow.add("lt" if strict else "le", flow.constant(stage.low), target))
        if stage.high < math.inf:
            strict = stage.high_open or several
            flow.require(flow.add("lt" if strict else "le", target, flow.constant(stage.high)))
        here = {**way.values, TARGET.name: target}
        if stage.divisor is not None:
            divisor = flow.expression(stage.divisor, here)
            flow.require(flow.add("not", flow.add("eq", divisor, flow.constant(0.0))))
        return [flow.expression(form, here) for form in stage.forms]

    def _turned_values(
        self, way: Way, isolation: Isolation, stage: Stage, rest: Sequence[Stage], targets: list[int]
    ) -> list[int]:
        """What is left to undo of an angle, and its whole turns: within the range, else within one turn."""
        variable = self.model.variables[isolation.unknown]
        period, turn = stage.period or 0.0, self.graph.turn(isolation.unknown)
        if any(step.operation not in ("sum", "negative") for step in rest):
            raise NotCompilable
        for step in rest:
            targets = [node for target in targets for node in self._undone(way, step, target)]
        if variable.low > -math.inf or variable.high < math.inf:
            images = [_image(form, stage) if not rest else None for form in stage.forms]
            images *= len(targets) // len(images)
            return [
                node
                for form, image in zip(targets, images, strict=True)
                for node in self._whole_turns(variable, form, image, period, turn)
            ]
        if turn != period:
            raise NotCompilable
        return [self._wrapped(form, period) for form in targets]

    def _wrapped(self, node: int, turn: float) -> int:
        """The angle in the turn around 0, its upper end included."""
        flow = self.flow
        half, whole = flow.constant(turn / 2), flow.constant(turn)
        count = flow.add("rint", flow.add("div", node, whole))
        moved = flow.add("sub", node, flow.add("mul", whole, count))
        outside = flow.add("lt", half, flow.add("abs", node))
        wrapped = flow.add("where", outside, moved, node)
        return flow.add("where", flow.add("eq", wrapped, flow.constant(-turn / 2)), half, wrapped)

    def _whole_turns(
        self,
        variable: Variable,
        node: int,
        image: tuple[float, float] | None,
        period: float,
        turn: float | None,
    ) -> list[int]:
        """The angle with every whole turn that can bring it into a range; those outside drop out later."""
        low, high = variable.low, variable.high
        span = turn or period
        if high == math.inf:
            high = low + span
        if low == -math.inf:
            low = high - span
        least, most = image or (-1.5 * period, 1.5 * period)
        first, last = math.ceil((low - most) / period), math.floor((high - least) / period)
        if last - first > MAX_TURNS:
            raise NotCompilable
        counts = sorted(range(first, last + 1), key=lambda k: (abs(k), k < 0))
        return [self.flow.add("add", node, self.flow.constant(k * period)) for k in counts]

    def _quadratic(self, way: Way, quadratic: Quadratic) -> list[int]:
        a, b, c = (self._expression(way, part) for part in (quadratic.a, quadratic.b, quadratic.c))
        one, other = self._roots(a, b, c)
        larger = self.flow.add("lt", other, one)
        return [self.flow.add("where", larger, one, other), self.flow.add("where", larger, other, one)]

    def _roots(self, a: int, b: int, c: int) -> tuple[int, int]:
        """Both roots of ``a x² + b x + c`` without cancellation, required to be apart."""
        flow = self.flow
        square, four_ac, size = self._discriminant(a, b, c)
        discriminant = flow.add("sub", square, four_ac)
        flow.require(flow.add("lt", flow.add("mul", flow.constant(self.pattern.clear), size), discriminant))
        root = flow.add("sqrt", discriminant)
        signed = flow.add("where", flow.add("lt", b, flow.constant(0.0)), flow.add("neg", root), root)
        q = flow.add("mul", flow.constant(-0.5), flow.add("add", b, signed))
        for divisor in (a, q):
            flow.require(flow.add("not", flow.add("eq", divisor, flow.constant(0.0))))
            flow.bound(divisor)
        return flow.add("div", q, a), flow.add("div", c, q)

    def _discriminant(self, a: int, b: int, c: int) -> tuple[int, int, int]:
        """``b²``, ``4 a c``, and the sum of their sizes."""
        flow = self.flow
        four_ac = flow.add("mul", flow.constant(4.0), flow.add("mul", a, c))
        square = flow.add("mul", b, b)
        return square, four_ac, flow.add("add", square, flow.add("abs", four_ac))

    # --- guarded equations for one unknown ---

    def _selected(self, way: Way, step: Select) -> Way:
        """A selection between the values of those that can be active; exactly one value may come out."""
        flow, unknown = self.flow, step.unknown
        groups: dict[int, int] = {}
        for index in step.equations:
            equation = self.model.equations[index]
            if activity(equation, way.decided) is False:
                continue
            active = self._active(way, equation)
            if active is None:
                raise NotCompilable
            if active == flow.false:
                continue
            isolation = self._isolation(index, unknown)
            if isolation.branches > 1 or (isolation.identity and _symbol(isolation.start, way.symbols)):
                raise NotCompilable
            with flow.only_if(active):
                (node,) = self._preimages(way, isolation)
            groups[node] = flow.add("or", groups[node], active) if node in groups else active
            if _certified(isolation):
                way.settled.add(index)
            way.chosen += [p.condition for p in equation.guard if p.condition not in way.decided]
        if not groups:
            raise NotCompilable
        *others, (value, some) = groups.items()
        for place, (node, active) in enumerate(reversed(others)):
            value = flow.add("where", active, node, value)
            if place == len(others) - 1:
                some = flow.add("xor", active, some)
            else:
                flow.require(flow.add("not", flow.add("and", active, some)))
                some = flow.add("or", active, some)
        flow.require(some)
        self._within(way, self.model.variables[unknown], value)
        way.values[unknown] = value
        return way

    # --- simultaneous blocks ---

    def _block(self, way: Way, step: SolveBlock) -> Iterator[Way]:
        if self._kernel(step).closed is None:
            yield self._iterated(way, step)
            return
        ways = [(way, dict(way.values))]
        for formula in self._closed(step).formulas:
            ways = [found for one, letters in ways for found in self._formula(one, letters, formula)]
        for one, letters in ways:
            self.flow.checks, self.flow.finite = one.checks, one.finite
            for name in step.unknowns:
                one.values[name] = letters[name]
                self._leave(one, self.model.variables[name], letters[name])
            if len(ways) > 1:
                self._prefer(one, step)
            if one.gone != self.flow.true:
                yield one

    def _closed(self, step: SolveBlock) -> ClosedForm:
        form = self._kernel(step).closed
        if form is None:
            raise NotCompilable
        return form

    def _kernel(self, step: SolveBlock) -> BlockKernel:
        kernels: dict[SolveBlock, BlockKernel] = self.graph.kernels
        if step not in kernels:
            kernels[step] = BlockKernel(self.graph, step)
        return kernels[step]

    def _iterated(self, way: Way, step: SolveBlock) -> Way:
        """A block without a formula: one root, where it is known to be the only one."""
        kernel = self._kernel(step)
        if len(step.tears) != 1 or any(name in way.symbols for name in kernel.known):
            raise NotCompilable
        question = Question(kernel, self.sample, self.pattern.guesses)
        start = self.sample.get(step.tears[0])
        if not isinstance(start, float):
            raise NotCompilable
        finder = RootFinder(kernel, question.domain(step.tears[0]), start)
        found = root_values(self.flow, finder, way.values)
        for name in step.unknowns:
            way.values[name] = found[name]
            self._within(way, self.model.variables[name], found[name])
        return way

    def _formula(
        self, way: Way, letters: dict[str, int], formula: Let | Parabola | Circle
    ) -> Iterator[tuple[Way, dict[str, int]]]:
        flow = self.flow
        flow.checks, flow.finite = way.checks, way.finite
        match formula:
            case Let(name):
                yield way, {**letters, name: self._let(way, letters, formula)}
            case Parabola(name, a, b, c):
                first, second = self._roots(*self._coefficients(letters, a, b, c))
                for node in (first, second):
                    yield way.fork(), {**letters, name: node}
            case Circle(x, y, a, b, k, square):
                points = self._meets(*self._coefficients(letters, a, b, k, square))
                for point in points:
                    yield way.fork(), {**letters, x: point[0], y: point[1]}

    def _let(self, way: Way, letters: Mapping[str, int], formula: Let) -> int:
        flow = self.flow
        match formula.expression:
            case nodes.Call("atan2d" | "atan2" as function, (Name(sine), Name(cosine))):
                return flow.direction(letters[sine], letters[cosine], function.removeprefix("atan2"))
        node = flow.expression(formula.expression, letters)
        if formula.size is not None:
            size = flow.expression(formula.size, letters)
            if formula.divisor:
                self._apart(node, size, self.pattern.clear)
                flow.bound(node)
            else:
                self._apart(node, size, STRANGE)
                way.gone = flow.add("or", way.gone, flow.add("lt", node, flow.constant(0.0)))
        return node

    def _apart(self, node: int, size: int, share: float) -> None:
        """Require a number to be apart from zero."""
        flow = self.flow
        if flow.value_of(node) is None:
            limit = flow.add("mul", flow.constant(share), size)
            flow.require(flow.add("lt", limit, flow.add("abs", node)))

    def _coefficients(self, letters: Mapping[str, int], *coefficients: Coefficient) -> list[int]:
        return [self.flow.expression(coefficient.expression, letters) for coefficient in coefficients]

    def _meets(self, a: int, b: int, k: int, square: int) -> Iterator[tuple[int, int]]:
        flow = self.flow
        length = flow.add("add", flow.add("mul", a, a), flow.add("mul", b, b))
        reach, across, size = self._reach(a, b, k, square)
        discriminant = flow.add("sub", reach, across)
        limit = flow.add("mul", flow.constant(self.pattern.clear), size)
        flow.require(flow.add("lt", limit, discriminant))
        root = flow.add("sqrt", discriminant)
        flow.require(flow.add("not", flow.add("eq", length, flow.constant(0.0))))
        flow.bound(length)
        for sign in ("sub", "add"):
            opposite = "add" if sign == "sub" else "sub"
            x = flow.add(sign, flow.add("mul", a, k), flow.add("mul", b, root))
            y = flow.add(opposite, flow.add("mul", b, k), flow.add("mul", a, root))
            yield flow.add("div", x, length), flow.add("div", y, length)

    def _reach(self, a: int, b: int, k: int, square: int) -> tuple[int, int, int]:
        """``(a² + b²) square``, ``k²``, and the sum of their sizes."""
        flow = self.flow
        length = flow.add("add", flow.add("mul", a, a), flow.add("mul", b, b))
        reach, across = flow.add("mul", length, square), flow.add("mul", k, k)
        return reach, across, flow.add("add", flow.add("abs", reach), across)

    def _prefer(self, way: Way, step: SolveBlock) -> None:
        """The order of a block's answers: nearest to the guesses; angles by size; positive first."""
        flow = self.flow
        guessed = [name for name in step.unknowns if name in self.pattern.guesses]
        if guessed:
            total = flow.constant(0.0)
            for name in guessed:
                apart = flow.add("sub", way.values[name], flow.constant(self.pattern.guesses[name]))
                total = flow.add("add", total, flow.add("mul", apart, apart))
            way.order.append(total)
            return
        first = step.tears[0] if step.tears else step.unknowns[0]
        node = way.values[first]
        zero, one = flow.constant(0.0), flow.constant(1.0)
        behind = flow.add("where", flow.add("lt", node, zero), one, zero)
        size = flow.add("abs", node)
        way.order += [size, behind] if self.graph.turn(first) else [behind, size]

    # --- the end ---

    def _finish(self, way: Way) -> None:
        flow = self.flow
        flow.checks, flow.finite = way.checks, way.finite
        for equation in self.model.equations:
            known = all(name in way.values or name in way.symbols for name in equation.names)
            if not known or equation.index in way.settled or activity(equation, way.decided) is False:
                continue
            active = self._active(way, equation)
            if active is None or active == flow.false:
                continue
            holds = self._witness(way, equation, active)
            with flow.only_if(active):
                flow.require(holds)
        for name, variable in self.model.variables.items():
            self._turned(way, name, variable)
        self._accurate(way)
        results = tuple(self._result(way, name) for name in self.pattern.want)
        for node in results:
            if isinstance(node, int):
                flow.bound(node)
        ending = Ending(results, tuple(way.checks), tuple(way.finite), way.gone, tuple(way.order))
        self.endings.append(trimmed(flow, ending))
        if len(self.endings) > MAX_ENDINGS:
            raise NotCompilable

    def _accurate(self, way: Way) -> None:
        if self.pattern.accuracy is not None:
            names, share = self.pattern.accuracy
            found = [way.values[name] for name in names if name in way.values and name not in self.given]
            self.flow.require(accurate(self.flow, found, share))

    def _result(self, way: Way, name: str) -> int | str:
        if name in way.symbols:
            return way.symbols[name]
        if name not in way.values:
            raise NotCompilable
        return way.values[name]

    def _turned(self, way: Way, name: str, variable: Variable) -> None:
        """An angle outside of one turn is for the step-by-step way to move."""
        turn, node = self.graph.turn(name), way.values.get(name)
        bounded = variable.low > -math.inf or variable.high < math.inf
        if node is None or turn is None or bounded or not variable.posted or name in self.given:
            return
        flow = self.flow
        if self._is_direction(node):
            return
        half = flow.constant(turn / 2)
        flow.require(flow.add("lt", flow.add("neg", half), node))
        flow.require(flow.add("le", node, half))

    def _is_direction(self, node: int) -> bool:
        kind = self.flow.nodes[node]
        return (kind[0] == "call" and kind[1] in _DIRECTIONS) or kind[0] in ("direction", "directiond")

    def _witness(self, way: Way, equation: Equation, active: int) -> int:
        """Whether an equation holds: |F| ≤ 64 eps · Σ|∂F/∂v · v|. One of several values that is far
        from that is no answer."""
        flow = self.flow
        symbols = [_symbol(side, way.symbols) for side in (equation.left, equation.right)]
        if symbols != [None, None]:
            return flow.constant(symbols[0] == symbols[1])
        form = subtract(equation.left, equation.right)
        miss = flow.add("sub", *(self._expression(way, side) for side in (equation.left, equation.right)))
        if flow.value_of(miss) == 0.0:
            return flow.true
        size = flow.constant(0.0)
        for name in equation.names:
            try:
                slope = self._expression(way, differentiate(form, name))
            except NotDifferentiable:
                raise NotCompilable from None
            size = flow.add("add", size, flow.add("abs", flow.add("mul", slope, way.values[name])))
        flow.bound(size)
        limit = flow.add("mul", flow.constant(BACKWARD), size)
        if way.order:
            far = flow.add("lt", flow.add("mul", flow.constant(STRANGE), size), flow.add("abs", miss))
            way.gone = flow.add("or", way.gone, flow.add("and", active, far))
        return flow.add("le", flow.add("abs", miss), limit)


def _image(form: Expression, stage: Stage) -> tuple[float, float] | None:
    """Where the values of a form lie, from those at the ends of the stage's image."""
    ends = [max(-1e300, stage.low), min(1e300, stage.high)]
    try:
        found = sorted(value(form, {TARGET.name: end}) for end in ends)
    except (Undefined, KeyError):
        return None
    return found[0], found[1]


def _certified(isolation: Isolation) -> bool:
    """Whether a rule holds by the way its unknown is computed: one rounding an operation, no more.

    True of sums, products and quotients undone one after the other. Each rounding is one of a variable
    of the rule, or of a term of the size of one.
    """
    linear = all(stage.operation in _LINEAR for stage in isolation.stages)
    return linear and isolation.quadratic is None and not isolation.verify


def _symbol(expression: Expression, symbols: Mapping[str, str]) -> str | None:
    match expression:
        case Symbol(name):
            return name
        case Name(name):
            return symbols.get(name)
        case _:
            return None
