"""A block that its tearing makes one polynomial in the tear: every answer, by an exact count of its roots.

The known numbers are taken as the exact fractions that floats are, and the chain is followed in polynomials
of the tear with such coefficients. Nothing is compiled, and nothing is rounded before the roots are. Where
the tear is an angle θ, the polynomials are those of t = tan(θ/2): cos θ = (1-t²)/(1+t²), sin θ = 2t/(1+t²).

``counted``: whether the answers of a block with one tear, found otherwise, are all, because every root of
its eliminant is accounted for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import chain, zip_longest
from typing import TypeAlias

from rulesheets.deadline import expect_time
from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.number import enclose
from rulesheets.syntax.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum
from solver.accuracy.rule_check import BACKWARD
from solver.facts import OutOfRange
from solver.kernel.candidates import Answer, Candidates
from solver.kernel.question import Question
from solver.kernel.root_check import astray, uncertainty
from solver.numerics.linear_algebra import last_singular
from solver.numerics.sturm import real_roots, simple_part
from solver.path.rational import smooth

HIGHEST_DEGREE = 12

Polynomial: TypeAlias = list[Fraction]
"""Coefficients, lowest degree first."""

Sizes: TypeAlias = list[float]
Value: TypeAlias = tuple[Polynomial, Sizes, int]
"""A polynomial over (1 + t²) to that power; second, how large its coefficients were before they cancelled."""

CANCELLED = 1e-9
"""A coefficient this small beside what it was made of may be nothing but the rounding of the inputs."""

CIRCLE: Polynomial = [Fraction(1), Fraction(0), Fraction(1)]
ROUND: Sizes = [1.0, 0.0, 1.0]
COSINE: Value = [Fraction(1), Fraction(0), Fraction(-1)], ROUND, 1
SINE: Value = [Fraction(0), Fraction(2)], [0.0, 2.0], 1


class NotPolynomial(Exception):
    """Something that is no polynomial of low degree, or whose coefficients are not exact."""


class Quarters:
    """An angle that the unknown t is half the tangent of. ``at_half_turn``: how often t = ∞ is a root."""

    def __init__(self, name: str, turn: float) -> None:
        self.name, self.turn = name, turn
        self.functions = ("cosd", "sind") if turn == 360.0 else ("cos", "sin")
        self.at_half_turn = 0

    def wave(self, call: Call) -> Value:
        """Sine or cosine of plus or minus the angle and some quarter turns. Raises NotPolynomial."""
        if call.function not in self.functions:
            raise NotPolynomial
        sign, offset = self._argument(call.arguments[0])
        quarters, rest = divmod(offset, 90.0)
        if rest or (offset and self.turn != 360.0):
            raise NotPolynomial
        cosine, sine = COSINE, (SINE if sign > 0 else _scaled(SINE, -1))
        for _ in range(int(quarters) % 4):
            cosine, sine = _scaled(sine, -1), cosine
        return cosine if call.function == self.functions[0] else sine

    def _argument(self, node: Expression) -> tuple[int, float]:
        match node:
            case Name(name) if name == self.name:
                return 1, 0.0
            case Negative(operand):
                sign, offset = self._argument(operand)
                return -sign, -offset
            case Sum((Number(number), other)) | Sum((other, Number(number))):
                sign, offset = self._argument(other)
                return sign, offset + number
            case Sum((other, Negative(Number(number)))):
                sign, offset = self._argument(other)
                return sign, offset - number
            case _:
                raise NotPolynomial


def closing(
    question: Question, forms: Sequence[tuple[str, Expression]], quarters: Quarters | None = None
) -> Polynomial:
    """What must vanish in the tear, or in the tangent of half of it. Raises NotPolynomial."""
    block = question.kernel.block
    values = {n: _number(v) for n, v in zip(question.kernel.known, question.known, strict=True)}
    if quarters is None:
        values[block.tears[0]] = [Fraction(0), Fraction(1)], [0.0, 1.0], 0
    for name, form in forms:
        expect_time()
        values[name] = _value(form, values, quarters)
    equation = question.graph.model.equations[block.residuals[0]]
    polynomial, gross, power = _value(smooth(equation.left, equation.right), values, quarters)
    if any(0 != abs(c) <= CANCELLED * size for c, size in zip(polynomial, gross, strict=False)):
        raise NotPolynomial
    if quarters is not None:
        quarters.at_half_turn = 2 * power + 1 - len(polynomial)
    return polynomial


def residuals_in(
    question: Question,
    forms: Sequence[tuple[str, Expression]],
    fixed: Mapping[str, Fraction],
    tear: str,
) -> tuple[Polynomial, ...]:
    """What must vanish in one tear, the others ``fixed``. Raises NotPolynomial."""
    block = question.kernel.block
    values = {n: _number(v) for n, v in zip(question.kernel.known, question.known, strict=True)}
    values |= {name: ([x], [abs(float(x))], 0) for name, x in fixed.items()}
    values[tear] = [Fraction(0), Fraction(1)], [0.0, 1.0], 0
    for name, form in forms:
        expect_time()
        values[name] = _value(form, values, None)
    equations = (question.graph.model.equations[index] for index in block.residuals)
    return tuple(_value(smooth(e.left, e.right), values, None)[0] for e in equations)


def _value(node: Expression, known: Mapping[str, Value], quarters: Quarters | None) -> Value:
    match node:
        case Number(number):
            return _number(number)
        case Name(name):
            if name not in known:
                raise NotPolynomial
            return known[name]
        case Negative(operand):
            return _scaled(_value(operand, known, quarters), -1)
        case Sum(terms):
            total = _value(terms[0], known, quarters)
            for term in terms[1:]:
                expect_time()
                total = _plus(total, _value(term, known, quarters))
            return total
        case Product(left, right):
            return _times(_value(left, known, quarters), _value(right, known, quarters))
        case Quotient(left, right):
            divisor, gross, power = _value(right, known, quarters)
            if len(divisor) > 1 or power or abs(divisor[0]) <= CANCELLED * gross[0]:
                raise NotPolynomial
            return _scaled(_value(left, known, quarters), 1 / divisor[0])
        case Power(base, Number(exponent)) if exponent in range(1, HIGHEST_DEGREE + 1):
            factor = total = _value(base, known, quarters)
            for _ in range(int(exponent) - 1):
                total = _times(total, factor)
            return total
        case Call() if quarters is not None:
            return quarters.wave(node)
        case _:
            raise NotPolynomial


def _number(number: float) -> Value:
    if not math.isfinite(number):
        raise NotPolynomial
    return [Fraction(number)], [abs(number)], 0


def _scaled(value: Value, number: Fraction | int) -> Value:
    factor, size = Fraction(number), abs(float(number))
    return [factor * c for c in value[0]], [size * c for c in value[1]], value[2]


def _plus(a: Value, b: Value) -> Value:
    power = max(a[2], b[2])
    a, b = _raised(a, power), _raised(b, power)
    sizes = [x + y for x, y in zip_longest(a[1], b[1], fillvalue=0.0)]
    return _sum(a[0], b[0]), sizes, power


def _raised(value: Value, power: int) -> Value:
    """The same over a higher power of 1 + t²."""
    polynomial, gross, own = value
    for _ in range(power - own):
        polynomial, gross = _product(polynomial, CIRCLE), _size_of_product(gross, ROUND)
    return polynomial, gross, power


def _times(a: Value, b: Value) -> Value:
    return _product(a[0], b[0]), _size_of_product(a[1], b[1]), a[2] + b[2]


def _sum(a: Polynomial, b: Polynomial) -> Polynomial:
    size = max(len(a), len(b))
    padded = ([*p, *[Fraction(0)] * (size - len(p))] for p in (a, b))
    return _trimmed([x + y for x, y in zip(*padded, strict=True)])


def _size_of_product(a: Sizes, b: Sizes) -> Sizes:
    product = [0.0] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        expect_time()
        for j, y in enumerate(b):
            product[i + j] += x * y
    return product


def _product(a: Polynomial, b: Polynomial) -> Polynomial:
    if len(a) + len(b) - 2 > HIGHEST_DEGREE:
        raise NotPolynomial
    product = [Fraction(0)] * (len(a) + len(b) - 1)
    for i, x in enumerate(a):
        expect_time()
        for j, y in enumerate(b):
            product[i + j] += x * y
    return _trimmed(product)


def _trimmed(polynomial: Polynomial) -> Polynomial:
    while len(polynomial) > 1 and not polynomial[-1]:
        polynomial.pop()
    return polynomial


TOUCHING = Fraction(1, 10**9)
"""An extremum this near to 0 beside its terms may be a double root that rounding of inputs has parted."""
STRANGE = 1e-6
"""A zero of a squared rule that misses the rule by more than this, beside its terms, has another sign."""

Forms: TypeAlias = Sequence[tuple[str, Expression]]
Point: TypeAlias = Mapping[str, float]


def solve_as_polynomial(question: Question, candidates: Candidates) -> bool:
    """Find the answers; False where the block is no such polynomial, or rounding leaves a doubt about one.

    Multiple roots are what they are in exact numbers.
    """
    tears = question.kernel.block.tears
    forms = None if len(tears) != 1 or question.turn(tears[0]) is not None else explicit_forms(question)
    if forms is None:
        return False
    try:
        polynomial = closing(question, forms)
    except (NotPolynomial, OverflowError):
        return False
    domain = _widened(*question.domain(tears[0]))
    simple, roots = polynomial, real_roots(polynomial, *domain)
    if roots is None:
        simple = simple_part(polynomial)
        roots = real_roots(simple, *domain)
    if roots is None or doubtful_extremum(simple):
        return False
    trial, several = Candidates(question), len(simple) < len(polynomial)
    for root in roots:
        point = _point(question, forms, root)
        if point is None:
            return False
        plain = not several and _plainly(question, trial, point)
        if not plain and not _tried(question, trial, point, several):
            return False
    candidates.take(trial)
    return True


def _widened(low: float, high: float) -> tuple[float, float]:
    """A range with what rounding may lead beyond its ends."""
    slack = BACKWARD * max([abs(end) for end in (low, high) if math.isfinite(end)], default=0.0)
    return low - slack, high + slack


def _plainly(question: Question, trial: Candidates, point: Point) -> bool:
    """Keep a point that holds: a simple root that is counted needs no further look."""
    if not question.holds(point):
        return False
    point = question.inside(dict(point))
    name = question.outside(point)
    if name is None and trial.stands(point, uncertainty(question, point)):
        trial.answers.append(Answer(point))
    elif name is not None:
        trial.outside = OutOfRange(question.equations[0], name, point[name])
    return True


def solve_by_half_angle(question: Question, candidates: Candidates) -> bool:
    """The same where the tear is an angle free to turn; multiple roots are what they are in exact numbers."""
    tears = question.kernel.block.tears
    turn = question.turn(tears[0]) if len(tears) == 1 else None
    if turn is None or not question.graph.is_turning(tears[0]):
        return False
    if question.domain(tears[0]) != (-turn / 2, turn / 2):
        return False
    forms = explicit_forms(question)
    if forms is None:
        return False
    quarters = Quarters(tears[0], turn)
    try:
        polynomial = closing(question, forms, quarters)
    except (NotPolynomial, OverflowError):
        return False
    simple = simple_part(polynomial)
    roots = real_roots(simple)
    if roots is None or doubtful_extremum(simple):
        return False
    angles = [2.0 * math.atan(t) * turn / math.tau for t in roots]
    if quarters.at_half_turn:
        angles.append(turn / 2)
    trial = Candidates(question)
    several = len(simple) < len(polynomial) or quarters.at_half_turn > 1
    for angle in angles:
        point = _point(question, forms, angle)
        if point is None or not _tried(question, trial, point, several):
            return False
    candidates.take(trial)
    return True


def _tried(question: Question, trial: Candidates, point: Point, several: bool) -> bool:
    """Whether it is plain that the point is an answer (then kept), or that it is none."""
    if question.holds(point):
        trial.keep(dict(point), singular=several and _is_singular(question, point))
        return True
    count = len(trial.answers)
    if not several:
        trial.refine(list(point.values()))
    return len(trial.answers) > count or astray(question, point, STRANGE)


def _is_singular(question: Question, point: Point) -> bool:
    try:
        matrix = question.jacobian(list(point.values()))
    except (ArithmeticError, ValueError):
        return False
    sizes = [max(map(abs, row)) or 1.0 for row in matrix]
    rows = [[a / size for a in row] for row, size in zip(matrix, sizes, strict=True)]
    if not all(map(math.isfinite, chain.from_iterable(rows))):
        return False
    values, _ = last_singular(rows)
    return values[0] > 1e8 * values[-1]


def explicit_forms(question: Question) -> Forms | None:
    """The steps of the block as explicit forms; None where one has several or may be refused."""
    graph, found = question.graph, []
    for step in question.kernel.block.order:
        isolation = graph.isolation(step.equation, graph.number[step.unknown])
        if isolation is None or isolation.branches != 1 or isolation.verify or isolation.period:
            return None
        found.append((step.unknown, isolation.forms()[0]))
    return found


def doubtful_extremum(polynomial: Polynomial) -> bool:
    """Whether an extremum may be a double root but for the rounding of the inputs."""
    if len(polynomial) <= 2:
        return False
    extrema = real_roots(simple_part([k * c for k, c in enumerate(polynomial)][1:]))
    if extrema is None:
        return True
    for x in map(Fraction, extrema):
        terms = [c * x**k for k, c in enumerate(polynomial)]
        if abs(sum(terms, Fraction(0))) <= TOUCHING * sum(map(abs, terms), Fraction(0)):
            return True
    return False


def point_at(question: Question, forms: Forms, tears: Mapping[str, float]) -> dict[str, float] | None:
    """The unknowns where the tears have these values; None where a step has none there."""
    point = dict(tears)
    try:
        for name, form in forms:
            point[name] = value(form, {**question.here, **point})
    except Undefined:
        return None
    return {name: point[name] for name in question.unknowns}


def _point(question: Question, forms: Forms, root: float) -> dict[str, float] | None:
    """The unknowns at a root of the only tear."""
    return point_at(question, forms, {question.kernel.block.tears[0]: root})


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
