"""A simultaneous block of a path: residual, Jacobian and the chains of its tearing, compiled on
use; and the candidates of its closed form."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from rulesheets.evaluate import differentiate, value
from rulesheets.syntax import nodes
from rulesheets.syntax.nodes import Expression, degree
from solver.kernel.emitter import compile_expressions, divisors
from solver.kernel.step import reach, window
from solver.numerics.linear_algebra import Array
from solver.numerics.tolerances import CLEAR, UNCANCELLED
from solver.path import Circle, ClosedForm, Coefficient, Formula, Let, Parabola, SolveBlock
from solver.path.graph import ModelGraph, phases, repeats, shape_of

if TYPE_CHECKING:
    from solver.kernel.chain import Chain
    from solver.kernel.enclosure import Enclosure
    from solver.kernel.sparse_system import BlockArrays, SparseSystem
    from solver.path.shapes import Alike

FEW = 30
"""Rules up to which each is examined by itself, beyond it one of each shape."""
DENSE = 300
"""Unknowns of a block beyond which its matrix is taken as a sparse one."""
KEPT = (
    "graph",
    "block",
    "equations",
    "unknowns",
    "known",
    "closed",
    "degrees",
    "divisors",
    "repeating",
)
"""The parts of a block that are kept for another run."""
T = TypeVar("T")


class BlockKernel:
    """Residual, Jacobian and chains of a block, each compiled once for a path, on first use.

    Modules for searches are imported on demand: most blocks have a closed form.
    """

    def __init__(self, graph: ModelGraph, block: SolveBlock) -> None:
        self.graph, self.block = graph, block
        self.equations = [graph.model.equations[e] for e in block.equations]
        self.unknowns = block.unknowns
        names = dict.fromkeys(name for e in self.equations for name in e.names)
        unknowns = frozenset(self.unknowns)
        self.known = tuple(name for name in names if name not in unknowns)
        self._enclosures: dict[int, Enclosure] = {}
        kept = graph.kernels
        few = len(self.equations) <= FEW
        self._shared: dict[Any, Any] = (
            kept.setdefault(("alike", self._pattern()), {}) if few else {}
        )

    def __getstate__(self) -> dict[str, Any]:
        """Pickled without functions of arrays and of intervals, and parts that are quickly
        recomputed."""
        found = {name: self.__dict__[name] for name in KEPT if name in self.__dict__}
        shared = {key: part for key, part in self._shared.items() if not isinstance(part, dict)}
        return {**found, "_enclosures": {}, "_shared": shared}

    def _pattern(self) -> tuple[Any, ...]:
        """The block with places for names: results about it hold for all blocks of the same
        pattern, such as those of subsheets that are called again."""
        place = {name: k for k, name in enumerate((*self.unknowns, *self.known))}
        number = {equation: k for k, equation in enumerate(self.block.equations)}
        rules = []
        for equation in self.equations:
            shape, numbers = shape_of(equation)
            told = tuple([v or str(v) for v in numbers])  # zeros have signs
            rules.append((shape, told, tuple([place[name] for name in equation.names])))
        traits = []
        for name in self.unknowns:
            v = self.graph.model.variables[name]
            angle = self.graph.angles.get(name)
            traits.append((*self.domain(name), v.low, v.high, v.low_open, v.high_open, angle))
        tears = tuple([place[name] for name in self.block.tears])
        order = tuple([(number[step.equation], place[step.unknown]) for step in self.block.order])
        residuals = tuple([number[equation] for equation in self.block.residuals])
        return tuple(rules), tuple(traits), tears, order, residuals

    def once(self, key: Any, make: Callable[[], T]) -> T:
        """The result of ``make``, computed once for all blocks of the pattern."""
        if key not in self._shared:
            self._shared[key] = make()
        found: T = self._shared[key]
        return found

    @cached_property
    def forms(self) -> list[Expression]:
        """Left minus right of every equation."""
        return [e.form for e in self.equations]

    @cached_property
    def jumps(self) -> bool:
        """Whether an equation may jump without a sign of it in its Jacobian."""
        from solver.kernel.chain import directions, jumps

        return self.once(
            "jumps", lambda: any(jumps(form) or any(directions(form)) for form in self.forms)
        )

    def domain(self, name: str) -> tuple[float, float]:
        """The range to search an unknown in: its declared range, and at most one turn of an
        angle; of others in periodic functions the one that rules imply."""
        variable, turn = self.graph.model.variables[name], self.graph.turn(name)
        ends = reach(self.graph, name) if name in self._inside else (variable.low, variable.high)
        return ends if turn is None else window(*ends, turn)

    @property
    def finite(self) -> bool:
        """Whether boxes can be searched: ranges are finite, and no equation jumps."""
        ends = (end for name in self.unknowns for end in self.domain(name))
        return not self.jumps and all(map(math.isfinite, ends))

    @cached_property
    def exhaustive(self) -> bool:
        from solver.kernel.chain import exhaustive

        return self.once("exhaustive", lambda: exhaustive(self.graph, self.block))

    @cached_property
    def divisors(self) -> tuple[Expression, ...]:
        """The divisors in the equations that depend on unknowns."""
        unknowns = frozenset(self.unknowns)
        found = dict.fromkeys(divisor for form in self.forms for divisor in divisors(form))
        return tuple(h for h in found if not unknowns.isdisjoint(nodes.names(h)))

    @cached_property
    def _phases(self) -> list[Expression]:
        """The arguments of periodic functions."""
        rules = (rule for rule in self.equations if repeats(shape_of(rule)[0]))
        return phases(*(side for rule in rules for side in rule.sides))

    @cached_property
    def _inside(self) -> set[str]:
        """The names inside periodic functions."""
        return set(nodes.names(*self._phases))

    @cached_property
    def repeating(self) -> tuple[str, ...]:
        """The unknowns inside periodic functions that are no angles, and have no range: each period
        may have an answer of its own."""
        free = (n for n in self.unknowns if n in self._inside and self.graph.turn(n) is None)
        return tuple(name for name in free if any(map(math.isinf, self.domain(name))))

    @property
    def phases(self) -> list[Expression]:
        """The arguments of periodic functions in which these are."""
        unknowns = set(self.repeating)
        return [phase for phase in self._phases if not unknowns.isdisjoint(nodes.names(phase))]

    @cached_property
    def linear(self) -> bool:
        """Whether every equation, as written, is linear in the unknowns."""
        return bool((self.degrees <= 1.0).all())

    @cached_property
    def degrees(self) -> Array:
        """The degrees (n,) of the equations in the unknowns, as written."""
        unknowns = frozenset(self.unknowns)
        if len(self.equations) <= FEW:
            return self.once(
                "degrees", lambda: np.array([degree(form, unknowns) for form in self.forms])
            )
        from solver.path.shapes import same_columns

        inside = np.array([name in unknowns for name in self.alike.names], dtype=bool)
        found = np.zeros(len(self.equations))
        for family in self.alike.families:
            for _, members in same_columns(inside[family.columns]):
                places = family.places[members]
                rule = self.equations[places[0]]
                found[places] = degree(rule.form, unknowns)
        return found

    @cached_property
    def closed(self) -> ClosedForm | None:
        """Formulas for the unknowns, if elimination leads to them."""
        if not self._shared.get("closed", True):
            return None
        from solver.path.elimination import closed_form

        turning = [name for name in self.unknowns if self.graph.is_turning(name)]
        found = closed_form(self.equations, self.unknowns, turning)
        self._shared["closed"] = found is not None
        return found

    @cached_property
    def partials(self) -> list[Expression]:
        """Slopes of every form by every unknown, row by row."""
        return partials_of(self.forms, self.unknowns)

    @cached_property
    def _residual(self) -> Callable[..., Sequence[float]]:
        names = (*self.unknowns, *self.known)
        return self.once("residual", lambda: compile_expressions(self.forms, names))

    @cached_property
    def _flat(self) -> Callable[..., Sequence[float]]:
        names = (*self.unknowns, *self.known)
        return self.once("slopes", lambda: compile_expressions(self.partials, names))

    @cached_property
    def alike(self) -> Alike:
        from solver.path.shapes import shapes

        return shapes(self.graph.model).of(self.equations)

    @cached_property
    def sparse(self) -> SparseSystem:
        """The block as a sparse system."""
        from solver.kernel.sparse_system import SparseSystem

        return SparseSystem(self.alike, self.unknowns, self.known)

    @cached_property
    def arrays(self) -> BlockArrays:
        from solver.kernel.sparse_system import BlockArrays

        return BlockArrays(self.equations, self.unknowns, self.known, self.chains)

    @cached_property
    def others(self) -> tuple[BlockKernel, ...]:
        """The same block with other tearings."""
        return tuple(BlockKernel(self.graph, block) for block in self.block.others)

    @cached_property
    def chains(self) -> tuple[Chain, ...]:
        from solver.kernel.chain import chains

        return chains(self.graph, self.block)

    def chain_function(self, place: int) -> Callable[..., Any]:
        """``f(*tears, *known)`` gives the unknowns in order and then the residuals."""

        def made() -> Callable[..., Any]:
            from solver.kernel.chain import compile_chain

            chain = self.chains[place]
            return compile_chain(chain, self.known, (*self.unknowns, *chain.residuals))

        return self.once(("chain", place), made)

    def enclosure(self, place: int) -> Enclosure:
        """Bounds of the residual of a chain over boxes of its tear."""
        if place not in self._enclosures:
            from solver.kernel.enclosure import Enclosure

            shared = self.once(("enclosure", place), dict[str, Any])
            self._enclosures[place] = Enclosure(self.chains[place], self.known, shared=shared)
        return self._enclosures[place]

    def residual(self, known: Sequence[float]) -> Callable[[Sequence[float]], Sequence[float]]:
        return lambda x: self._residual(*x, *known)

    def jacobian(
        self, known: Sequence[float]
    ) -> Callable[[Sequence[float]], list[Sequence[float]]]:
        n = len(self.unknowns)

        def rows(x: Sequence[float]) -> list[Sequence[float]]:
            flat = self._flat(*x, *known)
            return [flat[i : i + n] for i in range(0, len(flat), n)]

        return rows


def partials_of(forms: Sequence[Expression], unknowns: Sequence[str]) -> list[Expression]:
    """Slopes of every form by every unknown, row by row."""
    pairs = [(form, frozenset(nodes.names(form))) for form in forms]
    return [
        differentiate(form, unknown) if unknown in read else nodes.ZERO
        for form, read in pairs
        for unknown in unknowns
    ]


def kernel_of(graph: ModelGraph, block: SolveBlock) -> BlockKernel:
    """The kernel of a block, the same object each time."""
    kernels: dict[SolveBlock, BlockKernel] = graph.kernels
    if block not in kernels:
        kernels[block] = BlockKernel(graph, block)
    return kernels[block]


# --- the candidates of a closed form, over numbers of any kind ---
#
# The formulas are written once, with the operators of numbers. A ``FormulaNumbers`` says what the
# numbers are: floats, nodes of a program, expressions of a chain.


class FormulaNumbers:
    """The numbers of one branch of candidates, and what it asks of them.

    ``let`` and ``coefficient`` give the value of a formula and the number of a coefficient, at
    known values; ``kept`` the values kept of the numbers of a point. ``apart`` returns a divisor
    that is not 0, ``square_roots`` both roots of the difference of two numbers (none of a negative
    one), ``signed`` one of them with the sign of another number. ``fork`` begins another branch.
    """

    def roots(self: Any, a: Any, b: Any, c: Any) -> tuple[Any, ...]:
        """The roots of ``a x² + b x + c``, without cancellation."""
        below = self.apart(a)
        for root in self.square_roots(b * b, 4.0 * (a * c))[:1]:
            q = -0.5 * (b + self.signed(root, b))
            return q / below, c / q
        return ()


def candidates(
    form: ClosedForm, on: Any, known: Mapping[str, Any]
) -> Iterator[tuple[Any, dict[str, Any]]]:
    """Every candidate: the arithmetic of its branch, and the ``known`` values with those kept of
    all generators."""
    if not form:
        yield on, dict(known)
        return
    formula, rest = form[0], form[1:]
    if isinstance(formula, Let):
        yield from candidates(rest, on, {**known, formula.name: on.let(formula, known)})
        return
    for point in list(_points(formula, on, known)):
        branch = on.fork()
        yield from candidates(rest, branch, {**known, **branch.kept(formula, point)})


def _points(formula: Formula, on: Any, known: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    numbers = (on.coefficient(part, known) for part in formula if isinstance(part, Coefficient))
    match formula:
        case Parabola(name):
            yield from ({name: root} for root in on.roots(*numbers))
        case Circle(x, y):
            a, b, k, square = numbers
            length = on.apart(a * a + b * b)
            for root in on.square_roots(length * square, k * k):
                yield {x: (a * k - b * root) / length, y: (b * k + a * root) / length}


class Unclear(Exception):
    """A divisor or a discriminant is too near to zero for the formulas to cover every solution."""


class Rounded:
    """A float, the sizes of the ``terms`` of its last sum together, and the ``size`` that they had
    before anything cancelled."""

    def __init__(self, number: float, terms: float = 0.0, size: float = 0.0) -> None:
        self.number, self.terms, self.size = number, terms, size

    def __add__(self, other: Rounded) -> Rounded:
        terms = abs(self.number) + abs(other.number)
        return Rounded(self.number + other.number, terms, self.size + other.size)

    def __sub__(self, other: Rounded) -> Rounded:
        return self + -1.0 * other

    def __mul__(self, other: Rounded) -> Rounded:
        return Rounded(self.number * other.number, 0.0, self.size * other.size)

    def __rmul__(self, factor: float) -> Rounded:
        return Rounded(factor * self.number, 0.0, abs(factor) * self.size)

    def __truediv__(self, other: Rounded) -> Rounded:
        return Rounded(self.number / other.number)


class RoundedFloats(FormulaNumbers):
    """Raises Unclear where rounding may hide an answer, or create one."""

    def fork(self) -> RoundedFloats:
        return self

    def let(self, formula: Let, known: Mapping[str, Any]) -> float:
        number, size = value(formula.expression, known), formula.size
        if formula.divisor and (size is None or abs(number) <= CLEAR * value(size, known)):
            raise Unclear
        return number

    def coefficient(self, part: Coefficient, known: Mapping[str, Any]) -> Rounded:
        size = value(part.size, known)
        return Rounded(value(part.expression, known), size, size)

    def apart(self, number: Rounded) -> Rounded:
        least = max(CLEAR * number.terms, UNCANCELLED * number.size)
        if not (math.isfinite(number.size) and abs(number.number) > least):
            raise Unclear
        return number

    def square_roots(self, one: Rounded, other: Rounded) -> tuple[Rounded, ...]:
        square = self.apart(one - other).number
        return tuple(Rounded(s * math.sqrt(square)) for s in (1.0, -1.0) if square >= 0.0)

    def signed(self, root: Rounded, like: Rounded) -> Rounded:
        return Rounded(math.copysign(root.number, like.number))

    def roots(self, a: Rounded, b: Rounded, c: Rounded) -> tuple[Rounded, ...]:
        return super().roots(a, b, c) if a.size else (-1.0 * c / self.apart(b),)

    def kept(self, formula: Any, found: Mapping[str, Rounded]) -> dict[str, float]:
        return {name: number.number for name, number in found.items()}


FLOATS = RoundedFloats()
