"""Expressions compiled to Python source: straight-line code, common parts computed once.

For floats, numpy arrays and intervals of floats. A large block is a sparse system: residual and exact
Jacobian, with rules of one shape (``path/graph.py``) as rows of one function of arrays.
"""

from __future__ import annotations

import marshal
import math
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from copy import copy
from functools import cached_property, lru_cache, partial
from graphlib import CycleError, TopologicalSorter
from math import inf, nan, nextafter
from types import CodeType, FunctionType
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray

from rulesheets.evaluate import differentiate, less_one, slopes_by_name
from rulesheets.evaluate.number import INTERVALS, Arithmetic
from rulesheets.functions import TABLE, intervals
from rulesheets.functions.arrays import ARRAYS
from rulesheets.functions.row import Forms
from rulesheets.syntax.nodes import (
    ONE,
    ZERO,
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    Symbol,
    add,
    children,
    names,
    negative,
    rebuilt,
    subtract,
)
from solver.numerics.linear_algebra import Array, Triplets
from solver.path.graph import Alike, Family, shape_of

CALLED, POWER, EXPM1 = "f_", "POWER", "EXPM1"
"""Prefixes of tokens of functions; a power, and ``exp(x) - 1`` on arrays: no function of the language has
capitals."""
VALUES = Forms(TABLE, lambda row: row.value)
"""The functions of the language on floats."""


T = TypeVar("T")


def is_square(node: Power) -> bool:
    return node.exponent == Number(2.0)


def _power(base: float, exponent: float) -> float:
    """A real power; raises ValueError if it would be complex, as ``math.pow``."""
    result = base**exponent
    if isinstance(result, complex):
        raise ValueError("power of a negative number")
    return float(result)


class _Source(Arithmetic[T]):
    """Lines of a function in three-address code. Equal texts are computed once (hash-consing)."""

    def __init__(self, arguments: Sequence[str], names: dict[str, T]) -> None:
        self.lines: list[str] = []
        self.names = names
        """The value of each name: an argument, or an earlier assignment."""
        self._header = ", ".join(arguments)
        self._tokens: dict[str, str] = {}

    def line(self, text: str) -> None:
        self.lines.append(text)

    def temporary(self, text: str) -> str:
        """A name for the value of the text."""
        token = self._tokens.get(text)
        if token is None:
            token = self._tokens[text] = f"t{len(self._tokens)}"
            self.lines.append(f"{token} = {text}")
        return token

    def code(self, lines: Iterable[str]) -> CodeType:
        """The code of a function of the arguments with these lines."""
        body = "\n    ".join(lines)
        return _compiled(f"def kernel({self._header}):\n    {body}\n")

    def assign(self, name: str, value: T) -> None:
        """Let ``name`` stand for the value from here on."""
        self.names[name] = value

    def name(self, node: Name) -> T:
        return self.names[node.name]


@lru_cache(maxsize=1_000)
def _compiled(text: str) -> CodeType:
    """The code of a function; blocks of one shape share it."""
    return next(c for c in compile(text, "<kernel>", "exec").co_consts if isinstance(c, CodeType))


class Emitter(_Source[str]):
    """Code for expressions of named numbers, or of ``arrays`` of them."""

    def __init__(self, arguments: Sequence[str], arrays: bool = False) -> None:
        self._arrays = arrays
        names = {name: f"a{i}" for i, name in enumerate(arguments)}
        super().__init__([*names.values()], names)

    def function(self, results: Iterable[str]) -> Callable[..., Any]:
        """A function of the arguments, in their order, that returns the values of these tokens."""
        lines = [*self.lines, f"return ({''.join(f'{token}, ' for token in results)})"]
        return function_of(self.code(lines), self._arrays)

    def bound(self, name: str, low: float, high: float, low_open: bool, high_open: bool) -> None:
        """Raise ValueError if the value called ``name`` lies outside the range, or move arrays into it."""
        sides = ((low, "<=" if low_open else "<"), (high, ">=" if high_open else ">"))
        tests = [f"{self.names[name]} {sign} {end!r}" for end, sign in sides if math.isfinite(end)]
        if tests and self._arrays:
            self.names[name] = self.temporary(f"clip({self.names[name]}, {low!r}, {high!r})")
        elif tests:
            self.line(f"if {' or '.join(tests)}: raise ValueError")

    # --- the arithmetic ---

    def number(self, node: Number) -> str:
        return repr(node.value) if node.value >= 0 else f"({node.value!r})"

    def symbol(self, node: Symbol) -> str:
        return "nan"  # what is computed with it is no number either

    def negative(self, node: Negative) -> str:
        return self.temporary(f"- {self.of(node.operand)}")

    def sum(self, node: Sum) -> str:
        token = self.of(node.terms[0])
        for term in node.terms[1:]:
            sign, part = ("-", term.operand) if isinstance(term, Negative) else ("+", term)
            token = self.temporary(f"{token} {sign} {self.of(part)}")
        return token

    def product(self, node: Product) -> str:
        return self.temporary(f"{self.of(node.left)} * {self.of(node.right)}")

    def divided(self, node: Quotient, above: str, below: str) -> str:
        return self.temporary(f"{above} / {below}")

    def raised(self, node: Power, base: str, exponent: str) -> str:
        if is_square(node):
            return self.temporary(f"{base} * {base}")
        return self.temporary(f"{CALLED}{POWER}({base}, {exponent})")

    def applied(self, node: Call, arguments: list[str]) -> str:
        if not arguments:
            return repr(TABLE[node.function].value())
        return self.temporary(f"{CALLED}{node.function}({', '.join(arguments)})")


def function_of(code: CodeType, arrays: bool = False) -> Callable[..., Any]:
    """The function of code for floats, or for arrays, which calls those of the language by their tokens."""
    own, functions = {POWER: np.power if arrays else _power, EXPM1: np.expm1}, ARRAYS if arrays else VALUES
    known: dict[str, Any] = {
        "__builtins__": {"ValueError": ValueError},
        "nan": nan,
        "inf": inf,
        "clip": np.clip,
    }
    for token in code.co_names:
        if token.startswith(CALLED):
            name = token.removeprefix(CALLED)
            known[token] = own.get(name) or functions[name]
    made = FunctionType(code, known)
    if not arrays:
        made.__dict__["again"] = made_again  # what ``rulesheets.loading`` keeps it by
    return made


def made_again(code: bytes) -> Callable[..., Any]:
    """A function of floats from cached code."""
    return function_of(marshal.loads(code))


def compile_expressions(
    expressions: Sequence[Expression], arguments: Sequence[str], arrays: bool = False
) -> Callable[..., Sequence[Any]]:
    """A function of floats, or of arrays, in the order of ``arguments``, that returns all values.

    With floats it raises what Python arithmetic raises outside the domain (ArithmeticError, ValueError).
    """
    emitter = Emitter(arguments, arrays)
    return emitter.function([emitter.of(expression) for expression in expressions])


Pair: TypeAlias = tuple[str, str]

ARITHMETIC = {
    name: getattr(intervals, name)
    for name in ("add", "both", "divide", "multiply", "power", "square", "scaled")
}


Side: TypeAlias = tuple[Expression, Expression]
"""The operands of a factor x: b and c of ``b*x + c``."""


def shared_factors(node: Quotient) -> Iterator[tuple[Expression, Side, Side]]:
    """Factors shared by some terms of the dividend and of the divisor, with these terms: a quotient
    ``(a*x + d)/(b*x + c)`` is ``(a + d/x)/(b + c/x)``."""
    above, below = ([factors(term) for term in _terms(side)] for side in (node.left, node.right))
    if len(below) == 1:
        return
    inside = [part for term in below for part in term]
    for part in dict.fromkeys(part for term in above for part in term if part in inside):
        if not isinstance(part, Number):
            yield part, _split(part, above), _split(part, below)


def _terms(side: Expression) -> Sequence[Expression]:
    return side.terms if isinstance(side, Sum) else (side,)


def factors(node: Expression) -> list[Expression]:
    """The factors of a product, squares as two equal ones."""
    match node:
        case Product(left, right):
            return factors(left) + factors(right)
        case Negative(operand):
            return [Number(-1.0), *factors(operand)]
        case Power(base, Number(2.0)):
            return 2 * factors(base)
        case _:
            return [node]


def without(some: Sequence[Expression], others: Sequence[Expression]) -> list[Expression]:
    """Factors that others do not have, or less often."""
    return list((Counter(some) - Counter(others)).elements())


def times(*some: Expression) -> Expression:
    product: Expression = ONE
    for factor in some:
        product = product * factor
    return product


def _split(part: Expression, terms: Sequence[list[Expression]]) -> Side:
    """The terms that have a factor, without it, and the others."""
    having = [times(*without(some, [part])) for some in terms if part in some]
    return add(*having), add(*(times(*some) for some in terms if part not in some))


class IntervalEmitter(_Source[Pair]):
    """Code for the two ends of expressions. Names in ``points`` are single numbers, with one end.

    ``forms`` are further operations for ``apply``.
    """

    def __init__(self, boxes: Sequence[str], points: Sequence[str], **forms: Callable[..., Any]) -> None:
        pairs, single = [(f"l{i}", f"h{i}") for i in range(len(boxes))], [f"p{i}" for i in range(len(points))]
        names = dict(zip((*boxes, *points), (*pairs, *zip(single, single, strict=True)), strict=True))
        self._ends = ", ".join(end for pair in pairs for end in pair)
        self._fixed, self._once = set(single), list[str]()
        constants = {"__builtins__": {}, "inf": inf, "nan": nan, "nextafter": nextafter}
        self.globals: dict[str, Any] = {**constants, **ARITHMETIC, **forms}
        super().__init__(single, names)

    def function(self, results: Iterable[str]) -> Callable[..., Any]:
        """A function of the points, in their order, that returns one of the ends of a box.

        Values that depend on points only are computed once for all boxes.
        """
        body = (f"    {line}" for line in (*self.lines, f"return ({', '.join(results)})"))
        code = self.code([*self._once, f"def on_box({self._ends}):", *body, "return on_box"])
        return FunctionType(code, dict(self.globals))

    def apply(self, name: str, *operands: Pair, more: str = "") -> Pair:
        """The pair that the named operation returns for the ends of the operands."""
        ends = ", ".join(end for pair in operands for end in pair)
        return self._assigned(f"{name}({ends}{more})", *operands)

    # --- the arithmetic ---

    def number(self, node: Number) -> Pair:
        token = self._constant(node.value)
        return token, token

    def _constant(self, value: float) -> str:
        """The token of a number: blocks that differ only in numbers share their code."""
        token = self._tokens.setdefault(repr(value), f"n{len(self._tokens)}")
        self.globals[token] = value
        self._fixed.add(token)
        return token

    def symbol(self, node: Symbol) -> Pair:
        return self.number(Number(nan))

    def negative(self, node: Negative) -> Pair:
        low, high = self.of(node.operand)
        return self._assigned(f"-{high}, -{low}", (low, high))

    def sum(self, node: Sum) -> Pair:
        total = self.of(node.terms[0])
        for term in node.terms[1:]:
            part = self.of(term)
            if {total[0], part[0]} <= self._fixed:
                total = self.apply("add", total, part)
            else:
                total = self._assigned(f"{total[0]} + {part[0]}, {total[1]} + {part[1]}", total, part)
                low, high = total  # a sum that is 0 is exact
                rounded = f"{low} and nextafter({low}, -inf), {high} and nextafter({high}, inf)"
                total = self._assigned(rounded, total)
        return total

    def product(self, node: Product) -> Pair:
        left, right = self.of(node.left), self.of(node.right)
        if left == right:
            return self.apply("square", left)
        for factor, other in ((left, right), (right, left)):
            if factor[0] == factor[1]:
                return self.apply("scaled", factor, other)
        return self.apply("multiply", left, right)

    def divided(self, node: Quotient, above: Pair, below: Pair) -> Pair:
        """A quotient, also divided by a factor on both sides, which then occurs once less."""
        found = self.apply("divide", above, below)
        for part, *sides in shared_factors(node):
            x = self.of(part)
            if x[0] not in self._fixed:
                over = [
                    self.apply("add", self.of(having), self.apply("divide", self.of(others), x))
                    for having, others in sides
                ]
                found = self.apply("both", found, self.apply("divide", *over))
        return found

    def raised(self, node: Power, base: Pair, exponent: Pair) -> Pair:
        return self.apply("square", base) if is_square(node) else self.apply("power", base, exponent)

    def applied(self, node: Call, arguments: list[Pair]) -> Pair:
        self.globals[f"f_{node.function}"] = INTERVALS[node.function]
        return self.apply(f"f_{node.function}", *arguments)

    def _assigned(self, text: str, *operands: Pair) -> Pair:
        token = self._tokens.get(text)
        if token is None:
            number = len(self._tokens)
            token = self._tokens[text] = f"a{number}, b{number}"
            fixed = all(pair[0] in self._fixed for pair in operands)
            (self._once if fixed else self.lines).append(f"{token} = {text}")
            self._fixed |= set(token.split(", ") if fixed else ())
        low, high = token.split(", ")
        return low, high


BESIDE = 0.25
"""The largest share of a divisor that the error bars of its variables may have."""


class SparseSystem:
    """Residual (n,) and Jacobian of n rules as functions of points (n,); ``known`` names in their order.

    Raises NotDifferentiable.
    """

    def __init__(self, rules: Alike, unknowns: Sequence[str], known: Sequence[str]) -> None:
        self.n = len(unknowns)
        place = {name: place for place, name in enumerate((*unknowns, *known))}
        order = np.array([place[name] for name in rules.names], dtype=np.intp)
        self._take([_Shape(family, order[family.columns], self.n) for family in rules.families])

    def _take(self, shapes: list[_Shape]) -> None:
        self.shapes = shapes
        self.rows = np.concatenate([shape.slope_rows for shape in shapes])
        self.columns = np.concatenate([shape.slope_columns for shape in shapes])

    def changed(self, shapes: list[_Shape], n: int) -> SparseSystem:
        """A system of n rules of other shapes, with the same known names."""
        other = copy(self)
        other.__dict__.pop("_explicit", None)
        other.n = n
        other._take(shapes)
        return other

    def at(self, known: Sequence[float]) -> tuple[Callable[[Array], Array], Callable[[Array], Triplets]]:
        """Residual and Jacobian at these values of the known names; nan where undefined."""
        constants = np.array(known, dtype=float)

        def residual(x: Array) -> Array:
            everything, found = np.concatenate([x, constants]), np.empty(self.n)
            for shape in self.shapes:
                found[shape.rows] = shape.residual(everything)
            return found

        def jacobian(x: Array) -> Triplets:
            everything = np.concatenate([x, constants])
            slopes = np.concatenate([shape.slopes(everything) for shape in self.shapes])
            return slopes, self.rows, self.columns

        return residual, jacobian

    def with_explicit(self, x: Array, known: Sequence[float]) -> Array:
        """The point (n,) with every unknown that a rule gives explicitly (``l = sqrt(u^2 + v^2)``) replaced
        by its value; unchanged if such rules are circular."""
        everything = np.concatenate([x, np.array(known, dtype=float)])
        for function, targets, places, numbers in self._explicit:
            with np.errstate(all="ignore"):
                found = np.broadcast_to(function(*everything[places], *numbers)[0], len(targets))
            there = np.isfinite(found)
            everything[targets[there]] = found[there]
        return everything[: self.n]

    @cached_property
    def _explicit(self) -> list[tuple[Callable[..., Any], NDArray[np.intp], NDArray[np.intp], Array]]:
        """Functions of arrays with the unknowns that they give, in an order of evaluation."""
        giving = [shape for shape in self.shapes if shape.explicit]
        across = [shape.places.T.tolist() for shape in giving]
        rules: dict[int, tuple[int, int, int]] = {}
        members = ((place, j, m) for j, s in enumerate(giving) for m, place in enumerate(s.rows.tolist()))
        for _, j, member in sorted(members):
            for side, k in giving[j].explicit.items():
                if (target := across[j][member][k]) < self.n and target not in rules:
                    rules[target] = j, side, member
                    break
        read = [{side: _read(shape.sides[1 - side]) for side in shape.explicit} for shape in giving]
        needed = {
            target: [i for k in read[j][side] if (i := across[j][member][k]) in rules]
            for target, (j, side, member) in rules.items()
        }
        found, order = [], TopologicalSorter(needed)
        try:
            order.prepare()
        except CycleError:
            return []
        while order.is_active():
            groups: dict[tuple[int, int], list[int]] = {}
            for target in (ready := order.get_ready()):
                groups.setdefault(rules[target][:2], []).append(target)
            for (j, side), targets in groups.items():
                shape, mine = giving[j], [rules[target][2] for target in targets]
                owners = np.array(targets, dtype=np.intp)
                other = shape.compiled([shape.sides[1 - side]])
                found.append((other, owners, shape.places[:, mine], shape.numbers[:, mine]))
            order.done(*ready)
        return found

    def divides_by_nothing(self, x: Sequence[float], known: Sequence[float], bars: Sequence[float]) -> bool:
        """Whether a rule has a divisor that may be 0, or nearly, within the error bars of the unknowns."""
        everything = np.array([*x, *known], dtype=float)
        off = np.array([*bars, *[0.0] * len(known)])
        for shape in self.shapes:
            for read, function in shape.divisors:
                with np.errstate(all="ignore"):
                    at, *slopes = function(*everything[shape.places], *shape.numbers)
                    moves = sum(np.abs(s) * off[shape.places[k]] for k, s in zip(read, slopes, strict=True))
                    near = ~np.less(moves, BESIDE * np.abs(at))
                if (near & (shape.places[read] < self.n).any(axis=0)).any():
                    return True
        return False


class _Shape:
    """A family as one function of arrays; ``places`` (k, m) of its names among unknowns and known ones.
    ``explicit`` are its sides that are a single name (0: the left one), with the place of that name."""

    def __init__(self, family: Family, places: NDArray[np.intp], n: int) -> None:
        self.rows, self.places, self.numbers = family.places, places, family.numbers
        shape, _ = shape_of(family.first)
        self.sides = shape.left, shape.right
        self.form = subtract(*self.sides)
        alone = {k: _read(side) for k, side in enumerate(self.sides) if isinstance(side, Name)}
        self.explicit = {k: read[0] for k, read in alone.items() if read}
        self.compile(n)

    def compile(self, n: int) -> None:
        """Functions of the form and of its slopes by the names that are among n unknowns."""
        places = self.places
        arguments = [f"#{k}" for k in range(len(places))] + [f"#.{k}" for k in range(len(self.numbers))]
        self.moving = [(k, places[k] < n) for k in range(len(places)) if (places[k] < n).any()]
        self._all_move = [bool(m.all()) for _, m in self.moving]
        self.compiled = partial(compile_expressions, arguments=arguments, arrays=True)
        ones = {f"#.{k}" for k, column in enumerate(self.numbers) if (column == 1.0).all()}
        exact = with_expm1(self.form, ones) if ones else self.form
        self.cancels = exact != self.form
        self._residual = self.compiled([exact])
        slopes = slopes_by_name(self.form, {f"#{k}" for k, _ in self.moving})
        self._partials = self.compiled([slopes.get(f"#{k}", ZERO) for k, _ in self.moving])
        self.slope_rows = np.concatenate([self.rows[m] for _, m in self.moving])
        self.slope_columns = np.concatenate([places[k][m] for k, m in self.moving])

    def changed(self, form: Expression, rows: NDArray[np.intp], places: NDArray[np.intp], n: int) -> _Shape:
        """Another form with the same numbers, in other rows, of names at other places among n unknowns."""
        other = copy(self)
        other.__dict__.pop("divisors", None)
        other.form, other.rows, other.places, other.explicit = form, rows, places, {}
        other.compile(n)
        return other

    def residual(self, everything: Array) -> Any:
        with np.errstate(all="ignore"):
            return self._residual(*everything[self.places], *self.numbers)[0]

    def slopes(self, everything: Array) -> Array:
        with np.errstate(all="ignore"):
            columns = self._partials(*everything[self.places], *self.numbers)
        found = []
        for column, (_, m), all_move in zip(columns, self.moving, self._all_move, strict=True):
            full = column if np.ndim(column) else np.full(len(m), column)
            found.append(full if all_move else full[m])
        return np.concatenate(found)

    @cached_property
    def divisors(self) -> list[tuple[list[int], Callable[..., Any]]]:
        """The divisors, with their slopes by the names in them."""
        found = []
        for divisor in dict.fromkeys(divisors(self.form)):
            read = _read(divisor)
            slopes = [differentiate(divisor, f"#{k}") for k in read]
            if read:
                found.append((read, self.compiled([divisor, *slopes])))
        return found


def with_expm1(expression: Expression, ones: Collection[str]) -> Expression:
    """The expression with ``exp(x) - 1`` as one function; the names ``ones`` stand for 1."""
    expression = rebuilt(expression, tuple([with_expm1(part, ones) for part in children(expression)]))
    terms = expression.terms if isinstance(expression, Sum) else ()
    pair = less_one(terms, lambda part: isinstance(part, Name) and part.name in ones)
    if pair is None:
        return expression
    power, one = pair
    away = isinstance(terms[power], Negative)
    (call,) = children(terms[power]) if away else (terms[power],)
    difference = Call(EXPM1, children(call))
    told = {power: negative(difference) if away else difference}
    return add(*[told.get(place, term) for place, term in enumerate(terms) if place != one])


def _read(expression: Expression) -> list[int]:
    """The places of the names of a template that do not stand for numbers, in order of occurrence."""
    return [int(name[1:]) for name in dict.fromkeys(names(expression)) if not name.startswith("#.")]


def divisors(expression: Expression) -> Iterator[Expression]:
    """The divisors of a rule with variables in them (or in a power, or in the cosine of a tangent)."""
    stack: list[Any] = [expression]
    while stack:
        node = stack.pop()
        match node:
            case Quotient(_, divisor) if any(names(divisor)):
                yield divisor
            case Power(_, Number(exponent)) if exponent > 0.0:
                pass
            case Power(base, _) if any(names(base)):
                yield base
            case Call("tan" | "tand" as function, arguments):
                yield Call(function.replace("tan", "cos"), arguments)
        stack.extend(children(node))
