"""Expressions as straight-line Python code for floats, numpy arrays, or intervals of floats, common
parts computed once."""

from __future__ import annotations

import marshal
import math
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import lru_cache, reduce
from math import inf, isfinite, log, log1p, nan, nextafter, prod
from operator import truediv
from types import CodeType, FunctionType
from typing import Any, TypeAlias, TypeVar

import numpy as np

from rulesheets.evaluate.gradient import SMALLEST
from rulesheets.evaluate.number import Arithmetic
from rulesheets.functions import ARRAYS, INTERVALS, LOGARITHMS, TABLE, intervals
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
    call,
    names,
    terms,
    walk,
)

CALLED, POWER = "f_", "POWER"
"""The prefix of tokens of functions, and a power: no function of the language has capitals."""


T = TypeVar("T")


def is_square(node: Power) -> bool:
    return node.exponent == Number(2.0)


def _power(base: float, exponent: float) -> float:
    """A real power; raises ValueError if it would be complex, as ``math.pow``."""
    result = base**exponent
    if isinstance(result, complex):
        raise ValueError("power of a negative number")
    return float(result)


class CodeLines(Arithmetic[T]):
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


class Emitter(CodeLines[str]):
    """Code for expressions of named numbers, or of ``arrays`` of them."""

    def __init__(self, arguments: Sequence[str], arrays: bool) -> None:
        self._arrays = arrays
        names = {name: f"a{i}" for i, name in enumerate(arguments)}
        super().__init__([*names.values()], names)

    def function(self, results: Iterable[str]) -> Callable[..., Any]:
        """A function of the arguments, in their order, that returns the values of these tokens."""
        lines = [*self.lines, f"return ({''.join(f'{token}, ' for token in results)})"]
        return function_of(self.code(lines), self._arrays)

    def bound(self, name: str, low: float, high: float, low_open: bool, high_open: bool) -> None:
        """Raise ValueError if the value called ``name`` lies outside the range, or move arrays into
        it."""
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
    """The function of code for floats, or for arrays, which calls those of the language by their
    tokens."""
    own = {POWER: np.power if arrays else _power}
    known: dict[str, Any] = {
        "__builtins__": {"ValueError": ValueError},
        "nan": nan,
        "inf": inf,
        "clip": np.clip,
    }
    for token in code.co_names:
        if token.startswith(CALLED):
            name = token.removeprefix(CALLED)
            known[token] = own.get(name) or (ARRAYS[name] if arrays else TABLE[name].value)
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

    With floats it raises what Python arithmetic raises outside the domain (ArithmeticError,
    ValueError).
    """
    emitter = Emitter(arguments, arrays)
    return emitter.function([emitter.of(expression) for expression in expressions])


def divisors(expression: Expression) -> Iterator[Expression]:
    """The divisors of a rule with variables in them (or in a power, or in the cosine of a tangent).
    A base divides if its exponent is negative: of one with names it has a power that is 1 else."""
    for node in walk(expression):
        match node:
            case Quotient(_, divisor) if any(names(divisor)):
                yield divisor
            case Power(_, Number(exponent)) if exponent > 0.0:
                pass
            case Power(base, exponent) if any(names(base)):
                negative = call("min", ONE, call("max", ZERO, -exponent))
                yield base**negative if any(names(exponent)) else base
            case Call("tan" | "tand" as function, arguments):
                yield Call(function.replace("tan", "cos"), arguments)


# --- code for intervals of floats ---

Pair: TypeAlias = tuple[str, str]

ARITHMETIC = {
    name: getattr(intervals, name)
    for name in ("add", "both", "divide", "multiply", "power", "ratio", "square", "scaled")
}
MEAN_ULPS = 8.0
MOST_EXPONENTIALS, MOST_FACTORS = 3, 8
"""Exponentials in a sum each of which is made a common factor; factors that are read in a name."""


def log_means(a: float, b: float, c: float, d: float) -> intervals.Interval:
    """The means ``(u - v)/ln(u/v)`` of numbers of one sign, u between a and b, v between c and d:
    that of positive numbers grows with both, and is 0/0 where they are equal."""
    signs = ((a, b, c, d), (-b, -a, -d, -c))
    bounds = [
        sign * end
        for sign, (low, high, least, most) in zip((1.0, -1.0), signs, strict=True)
        if high > 0.0 and most > 0.0
        for end in (_log_mean(low, least, 0), _log_mean(high, most, 1))
    ]
    return (min(bounds), max(bounds)) if bounds else intervals.EMPTY


def _log_mean(u: float, v: float, end: int) -> float:
    """A lower (0) or upper (1) bound: the mean lies between the geometric and the arithmetic one,
    and nothing is known of numbers from 0 down."""
    if not (u > 0.0 < v and isfinite(u + v)):
        return inf if end else 0.0
    ratio = u / v
    if 0.5 <= ratio <= 2.0:
        mean = v if u == v else (u - v) / log1p((u - v) / v)
    elif SMALLEST <= ratio < inf:
        mean = (u - v) / log(ratio)
    else:
        mean = u + v if end else 0.0
    return intervals.up(mean, MEAN_ULPS) if end else intervals.down(mean, MEAN_ULPS)


def like_signed(a_low: float, a_high: float, b_low: float, b_high: float) -> intervals.Interval:
    """The divisors of a quotient that is not negative."""
    low, high = b_low, b_high
    if a_low > 0.0 and b_low < 0.0:
        low = intervals.least(0.0, b_high)
    if a_high < 0.0 and b_high > 0.0:
        high = intervals.greatest(0.0, b_low)
    return low, high


ARITHMETIC |= {"log_means": log_means, "like_signed": like_signed}

Side: TypeAlias = tuple[Expression, Expression]
"""The operands of a factor x: b and c of ``b*x + c``."""


def shared_factors(node: Quotient) -> Iterator[tuple[Expression, Side, Side]]:
    """Factors shared by some terms of the dividend and of the divisor, with these terms: a quotient
    ``(a*x + d)/(b*x + c)`` is ``(a + d/x)/(b + c/x)``."""
    above, below = ([factors(term) for term in terms(side)] for side in (node.left, node.right))
    if len(below) == 1:
        return
    inside = [part for term in below for part in term]
    for part in dict.fromkeys(part for term in above for part in term if part in inside):
        if not isinstance(part, Number):
            yield part, _split(part, above), _split(part, below)


def log_mean(node: Quotient) -> tuple[Expression, Expression, Expression] | None:
    """f, u and v of ``f*(u - v)/ln(u/v)``; None for other quotients."""
    match node.right:
        case Call("ln", (Quotient(u, v),)) | Sum((Call("ln", (u,)), Negative(Call("ln", (v,))))):
            parts = factors(node.left)
            for part in parts:
                rest = times(*without(parts, [part]))
                if Counter(terms(part)) == Counter(terms(u - v)):
                    return rest, u, v
                if Counter(terms(part)) == Counter(terms(v - u)):
                    return -rest, u, v
    return None


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
    return prod(some, start=ONE)


def _split(part: Expression, products: Sequence[list[Expression]]) -> Side:
    """The terms that have a factor, without it, and the others."""
    having = [times(*without(some, [part])) for some in products if part in some]
    return add(*having), add(*(times(*some) for some in products if part not in some))


class IntervalEmitter(CodeLines[Pair]):
    """Code for the two ends of expressions. Names in ``points`` are single numbers, with one end.

    ``forms`` are further operations for ``apply``.
    """

    def __init__(
        self, boxes: Sequence[str], points: Sequence[str], **forms: Callable[..., Any]
    ) -> None:
        pairs = [(f"l{i}", f"h{i}") for i in range(len(boxes))]
        single = [f"p{i}" for i in range(len(points))]
        ends = (*pairs, *zip(single, single, strict=True))
        names = dict(zip((*boxes, *points), ends, strict=True))
        self._ends = ", ".join(end for pair in pairs for end in pair)
        self._fixed, self._once = set(single), list[str]()
        self._points: dict[str, tuple[float, Pair, Pair]] = {}
        """Of names that are directions of points: a full turn, and the coordinates y and x."""
        self._meanings: dict[str, tuple[list[Expression], list[Expression]]] = {}
        """The factors and divisors of names."""
        self._has_exponentials = False
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
        """A sum, also with each of its exponentials as a common factor: ``b*exp(-s*t) - a*exp(-r*t)
        = exp(-s*t)*(b - a*exp((s - r)*t))``, which has bounds far from 0."""
        total = self._added(node.terms)
        if not self._has_exponentials:
            return total
        parts = [(term, self._exponential(term)) for term in self._expanded(node.terms)]
        found = [exponential for _, exponential in parts if exponential]
        others = [term for term, exponential in parts if not exponential]
        powers = list(dict.fromkeys(power for _, power in found))
        for power in powers if 2 <= len(powers) <= MOST_EXPONENTIALS else ():
            distances = ((one, self._apart(one, power)) for one in powers if one != power)
            apart = {one: distance for one, distance in distances if distance is not None}
            if len(apart) == len(powers) - 1:
                inside = (x * call("exp", apart[y]) if y in apart else x for x, y in found)
                whole = self._added([call("exp", power) * add(*inside), *others])
                total = self.apply("both", total, whole)
        return total

    def _added(self, some: Sequence[Expression]) -> Pair:
        total = self.of(some[0])
        for term in some[1:]:
            part = self.of(term)
            if {total[0], part[0]} <= self._fixed:
                total = self.apply("add", total, part)
            else:
                total = self._assigned(
                    f"{total[0]} + {part[0]}, {total[1]} + {part[1]}", total, part
                )
                low, high = total  # a sum that is 0 is exact
                rounded = f"{low} and nextafter({low}, -inf), {high} and nextafter({high}, inf)"
                total = self._assigned(rounded, total)
        return total

    def _expanded(self, some: Iterable[Expression]) -> Iterator[Expression]:
        """Terms, with products of sums of exponentials multiplied out."""
        for term in some:
            above, below = self._parts(term)
            sums = (part for part in above if isinstance(part, Sum))
            inside = next((part for part in sums if any(map(self._exponential, part.terms))), None)
            if inside is None:
                yield term
                continue
            rest = times(*without(above, [inside])) / times(*below)
            yield from (one * rest for one in inside.terms)

    def _exponential(self, term: Expression) -> tuple[Expression, Expression] | None:
        """The factor of the exponentials that vary in a product, and their arguments together."""
        powers, rests = list[Expression](), list[list[Expression]]([[], []])
        for side, (parts, rest) in enumerate(zip(self._parts(term), rests, strict=True)):
            for part in parts:
                match part:
                    case Call("exp", (power,)) if not self._is_fixed(power):
                        powers.append(-power if side else power)
                    case Power(base, power) if self._is_fixed(base) and not self._is_fixed(power):
                        power *= call("ln", base)
                        powers.append(-power if side else power)
                    case _:
                        rest.append(part)
        return (times(*rests[0]) / times(*rests[1]), add(*powers)) if powers else None

    def _is_fixed(self, node: Expression) -> bool:
        return all(self.names[name][0] in self._fixed for name in names(node))

    def _apart(self, one: Expression, other: Expression) -> Expression | None:
        """``one - other``, with a single term for all that differ in known factors only; None if
        there are no such ones."""
        found = defaultdict[Expression, list[Expression]](list)
        every = [*terms(one), *(-term for term in terms(other))]
        for term in every:
            sides = self._parts(term)
            fixed = [list(filter(self._is_fixed, side)) for side in sides]
            moving = map(without, sides, fixed)
            found[reduce(truediv, (times(*side) for side in moving))].append(
                reduce(truediv, (times(*side) for side in fixed))
            )
        if len(found) == len(every):
            return None
        return add(*(add(*factors) * moving for moving, factors in found.items()))

    def _parts(self, node: Expression) -> tuple[list[Expression], list[Expression]]:
        """The factors and the divisors of a product, those of the names in it among them."""
        match node:
            case Negative(operand):
                above, below = self._parts(operand)
                return [Number(-1.0), *above], below
            case Product(left, right):
                (above, below), (over, under) = map(self._parts, (left, right))
                return above + over, below + under
            case Quotient(left, right):
                (above, below), (under, over) = map(self._parts, (left, right))
                return above + over, below + under
            case Name(name) if name in self._meanings:
                return self._meanings[name]
        return [node], []

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
        match node:
            case Quotient(Power(a, exponent), Power(b, other)) if exponent == other:
                found = self.apply("both", found, self.of(Power(a / b, exponent)))
        for part, *sides in shared_factors(node):
            x = self.of(part)
            if x[0] not in self._fixed:
                over = [
                    self.apply("add", self.of(having), self.of(Quotient(others, part)))
                    for having, others in sides
                ]
                found = self.apply("both", found, self.apply("divide", *over))
        if mean := log_mean(node):
            factor, *ends = map(self.of, mean)
            found = self.apply(
                "both", found, self.apply("multiply", factor, self.apply("log_means", *ends))
            )
        return found

    def raised(self, node: Power, base: Pair, exponent: Pair) -> Pair:
        self._has_exponentials |= exponent[0] not in self._fixed
        return (
            self.apply("square", base) if is_square(node) else self.apply("power", base, exponent)
        )

    def let(self, name: str, expression: Expression) -> None:
        """Let a name stand for an expression. Of the direction of a point the sine, cosine and
        tangent are ratios of the coordinates, which lose nothing next to a right angle."""
        parts = self._parts(expression)
        if len(parts[0]) + len(parts[1]) <= MOST_FACTORS:
            self._meanings[name] = parts
        if isinstance(expression, Call) and (row := TABLE[expression.function]).direction:
            y, x = map(self.of, expression.arguments)
            self._points[name] = row.angle or nan, y, x

    def applied(self, node: Call, arguments: list[Pair]) -> Pair:
        turn = TABLE[node.function].turn
        self._has_exponentials |= node.function == "exp" and arguments[0][0] not in self._fixed
        match node.arguments:
            case (Name(name),) if turn and self._points.get(name, (nan,))[0] == turn:
                _, y, x = self._points[name]
                match node.function[:3]:
                    case "sin":
                        return self.apply("ratio", y, x)
                    case "cos":
                        return self.apply("ratio", x, y)
                    case "tan":
                        return self.apply("divide", y, x)
            case (Quotient(left, right),) if node.function in ("sqrt", *LOGARITHMS):
                above, below = self.of(left), self.of(right)
                signed = self.apply("divide", above, self.apply("like_signed", above, below))
                arguments = [self.apply("both", *arguments, signed)]
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


def enclose(expression: Expression, box: Mapping[str, intervals.Interval]) -> intervals.Interval:
    """Bounds of an expression for every value of its variables between the two ends in ``box``.

    They contain every exact value for which all operations are defined; nan if there is none on the
    box, or for arithmetic with a symbol. Raises KeyError for a variable that is not in the box.
    """
    ends = {name: box[name] for name in dict.fromkeys(names(expression))}
    wide = [name for name, (low, high) in ends.items() if low != high]
    points = [name for name in ends if name not in wide]
    emitter = IntervalEmitter(wide, points)
    on_box = emitter.function(emitter.of(expression))(*(ends[name][0] for name in points))
    bounds: intervals.Interval = on_box(*(end for name in wide for end in ends[name]))
    return bounds
