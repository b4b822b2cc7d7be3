"""Simultaneous equations solved by formula: elimination until one line, circle or parabola is left.

Every angle stands for two letters, its cosine and its sine, every root for one; the equations
are polynomials in them. What occurs linearly is substituted; two equations that turn a cosine and a sine
(``a c + b s = p``, ``-b c + a s = q``) give ``a² + b² = p² + q²``; circles are subtracted from one another.
That closes the loops of planar linkages (the half-angle formulas of the textbooks, e.g. Norton, Design
of Machinery, chapter 4), slider-driven ones included, and meets of circles and lines.

Each step is valid for every solution as long as its divisor does not vanish: the solutions of the
block are among the candidates then, and there are no others. Roots can bring in strangers, which the
equations themselves have to refuse.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from fractions import Fraction

from rulesheets.construct import add, call, divide, multiply, negative
from rulesheets.model import Equation
from rulesheets.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum, names
from rulesheets.record import dataclass
from solver.path.polynomial import (
    UNIT,
    Polynomial,
    TooLarge,
    coefficients,
    constant,
    degree,
    expression,
    letter,
    letters,
    minus,
    plus,
    reduced,
    scaled,
    substituted,
    times,
)

MAX_EQUATIONS = 16
_CIRCULAR = {"sind": "d", "cosd": "d", "sin": "", "cos": ""}
_QUARTER = {"d": 90.0, "": math.pi / 2}


@dataclass(frozen=True, slots=True)
class Let:
    """``name := expression``. A ``divisor`` must not vanish, and a root (any other with a ``size``, which is
    the sum of its terms' sizes) must not be negative."""

    name: str
    expression: Expression
    divisor: bool = False
    size: Expression | None = None


@dataclass(frozen=True, slots=True)
class Coefficient:
    """A known number; ``size`` is the sum of its terms' sizes, which its rounding goes by."""

    expression: Expression
    size: Expression


@dataclass(frozen=True, slots=True)
class Parabola:
    """``name`` is a root of ``a x² + b x + c``: two values, one, or none."""

    name: str
    a: Coefficient
    b: Coefficient
    c: Coefficient


@dataclass(frozen=True, slots=True)
class Circle:
    """The meets of the line ``a x + b y = k`` with the circle ``x² + y² = square``: two values, or none."""

    x: str
    y: str
    a: Coefficient
    b: Coefficient
    k: Coefficient
    square: Coefficient


Formula = Let | Parabola | Circle


@dataclass(frozen=True, slots=True)
class ClosedForm:
    """Formulas in order; they end with every unknown."""

    formulas: tuple[Formula, ...]

    @property
    def branches(self) -> int:
        return int(2 ** sum(1 for formula in self.formulas if not isinstance(formula, Let)))


def closed_form(
    equations: Sequence[Equation], unknowns: Collection[str], turning: Collection[str] = ()
) -> ClosedForm | None:
    """A closed form of as many equations as unknowns; None where elimination does not lead to one.

    ``turning`` are the unknowns that whole turns make no difference to.
    """
    if len(equations) > MAX_EQUATIONS:
        return None
    try:
        return _Elimination(equations, unknowns, turning).run()
    except (_NoForm, TooLarge, OverflowError):
        return None


class _NoForm(Exception):
    pass


class _Letters:
    """What the letters stand for."""

    def __init__(self, unknowns: Collection[str], turning: Collection[str]) -> None:
        self.unknowns, self.turning = frozenset(unknowns), frozenset(turning)
        self.meaning: dict[str, Expression] = {}
        self.pairs: dict[str, str] = {}
        self.angles: dict[str, tuple[str, str, str]] = {}
        self.open: set[str] = set()
        self.roots: list[str] = []
        self.divisors: list[str] = []
        self.lets: list[Let] = []
        self.extra: list[Polynomial] = []

    def polynomial(self, node: Expression) -> Polynomial:
        if not self.unknowns.intersection(names(node)):
            return self._known(node)
        match node:
            case Name(name):
                return self._variable(name)
            case Negative(operand):
                return scaled(self.polynomial(operand), Fraction(-1))
            case Sum(terms):
                return plus(*map(self.polynomial, terms))
            case Product(left, right):
                return self._reduced(times(self.polynomial(left), self.polynomial(right)))
            case Quotient(left, right):
                return self._quotient(left, right)
            case Power(base, Number(value)) if value in (2.0, 3.0, 4.0):
                inner = raised = self.polynomial(base)
                for _ in range(int(value) - 1):
                    raised = self._reduced(times(raised, inner))
                return raised
            case Power(base, Number(0.5)) | Call("sqrt", (base,)):
                return self._root(base)
            case Call(function, (argument,)) if function in _CIRCULAR:
                return self._circular(function, argument)
        raise _NoForm

    def _reduced(self, polynomial: Polynomial) -> Polynomial:
        return reduced(polynomial, self.pairs)

    def _known(self, node: Expression) -> Polynomial:
        """A part without unknowns: opened as far as it is a polynomial, a letter of its own beyond."""
        match node:
            case Number(value):
                return constant(value)
            case Name(name):
                self.meaning[name] = node
                return letter(name)
            case Negative(operand):
                return scaled(self._known(operand), Fraction(-1))
            case Sum(terms):
                return plus(*map(self._known, terms))
            case Product(left, right):
                return self._reduced(times(self._known(left), self._known(right)))
            case Quotient(left, Number(value)) if value:
                return scaled(self._known(left), 1 / Fraction(value))
            case Power(base, Number(2.0)):
                inner = self._known(base)
                return self._reduced(times(inner, inner))
            case Call(function, (argument,)) if function in _CIRCULAR:
                return self._circular(function, argument)
        return letter(self._named(node))

    def _named(self, node: Expression) -> str:
        """The letter of a known part that stays as it is."""
        for name, meaning in self.meaning.items():
            if meaning == node:
                return name
        name = f"#k{len(self.meaning)}"
        self.meaning[name] = node
        return name

    def _variable(self, name: str) -> Polynomial:
        if name in self.angles:
            raise _NoForm
        self.meaning[name] = Name(name)
        self.open.add(name)
        return letter(name)

    def _quotient(self, left: Expression, right: Expression) -> Polynomial:
        """Over something known: times its reciprocal. Over an unknown: one more unknown, and a product."""
        dividend = self.polynomial(left)
        if not self.unknowns.intersection(names(right)):
            if isinstance(right, Number) and right.value:
                return scaled(dividend, 1 / Fraction(right.value))
            return times(dividend, letter(self._named(divide(Number(1.0), right))))
        name = self._auxiliary()
        self.extra.append(minus(self._reduced(times(letter(name), self.polynomial(right))), dividend))
        return letter(name)

    def _root(self, base: Expression) -> Polynomial:
        inside = self.polynomial(base)
        name = self._auxiliary()
        self.roots.append(name)
        self.extra.append(minus(times(letter(name), letter(name)), inside))
        return letter(name)

    def _auxiliary(self) -> str:
        name = f"#u{len(self.meaning)}"
        self.meaning[name] = Name(name)
        self.open.add(name)
        return name

    # --- angles ---

    def _circular(self, function: str, argument: Expression) -> Polynomial:
        unit = _CIRCULAR[function]
        turns = _count(argument, _QUARTER[unit])
        if turns is not None and unit:
            whole = (1.0, 0.0, -1.0, 0.0)
            return constant(whole[turns % 4] if function.startswith("cos") else whole[(turns - 1) % 4])
        base, sign, quarters, rest = self._angle(argument, unit)
        if base is None:
            cosine, sine = self._pair(argument, unit)
            return letter(cosine if function.startswith("cos") else sine)
        pair = self._of_unknown(base, unit) if base in self.unknowns else self._pair(Name(base), unit)
        c, s = letter(pair[0]), scaled(letter(pair[1]), Fraction(sign))
        for _ in range(quarters % 4):
            c, s = scaled(s, Fraction(-1)), c
        if rest is not None:
            cos, sin = map(letter, self._pair(rest, unit))
            c, s = minus(times(c, cos), times(s, sin)), plus(times(s, cos), times(c, sin))
        return self._reduced(c if function.startswith("cos") else s)

    def _angle(self, argument: Expression, unit: str) -> tuple[str | None, int, int, Expression | None]:
        """``sign·base + 90·quarters + rest``: at most one unknown, at most once; no base: all known."""
        terms = argument.terms if isinstance(argument, Sum) else (argument,)
        unknown = [term for term in terms if self.unknowns.intersection(names(term))]
        if len(unknown) > 1:
            raise _NoForm
        base = unknown[0] if unknown else next((t for t in terms if _signed(t)), None)
        signed = None if base is None else _signed(base)
        if signed is None:
            if unknown:
                raise _NoForm
            return None, 1, 0, None
        others = [term for term in terms if term is not base]
        quarters, rest = 0, []
        for term in others:
            count = _count(term, _QUARTER[unit])
            if count is None:
                rest.append(term)
            else:
                quarters += count
        if rest and not unknown:
            return None, 1, 0, None
        return signed[0], signed[1], quarters, add(*rest) if rest else None

    def _of_unknown(self, name: str, unit: str) -> tuple[str, str]:
        if name in self.open or name not in self.turning:
            raise _NoForm
        cosine, sine, known = self.angles.setdefault(name, (f"#c {name}", f"#s {name}", unit))
        if known != unit:
            raise _NoForm
        self.pairs[sine] = cosine
        self.open.update((cosine, sine))
        self.meaning.update({cosine: Name(cosine), sine: Name(sine)})
        return cosine, sine

    def _pair(self, argument: Expression, unit: str) -> tuple[str, str]:
        cosine = self._named(call("cos" + unit, argument))
        sine = self._named(call("sin" + unit, argument))
        self.pairs[sine] = cosine
        return cosine, sine


class _Elimination:
    def __init__(
        self, equations: Sequence[Equation], unknowns: Collection[str], turning: Collection[str]
    ) -> None:
        self.unknowns = tuple(unknowns)
        self.letters = _Letters(unknowns, turning)
        forms = [minus(self.letters.polynomial(e.left), self.letters.polynomial(e.right)) for e in equations]
        self.equations = [reduced(form, self.letters.pairs) for form in (*forms, *self.letters.extra)]
        self.open = self.letters.open
        self.forward: list[Formula] = []
        self.backward: list[list[Formula]] = []

    def run(self) -> ClosedForm | None:
        if any(not self._stated(name) for name in self.unknowns):
            return None
        while self.open:
            self._tidy()
            if not (
                self._substitute(by_number=True)
                or self._close()
                or self._rotate()
                or self._subtract()
                or self._line_and_circle()
                or self._cross()
                or self._substitute(by_number=False)
            ):
                return None
        self._tidy()
        if self.equations:
            return None
        formulas = [*self.forward]
        for group in reversed(self.backward):
            formulas += group
        formulas += [self._direction(name, *angle) for name, angle in self.letters.angles.items()]
        return ClosedForm(tuple(formulas))

    def _stated(self, name: str) -> bool:
        return name in self.open or name in self.letters.angles

    def _tidy(self) -> None:
        self.equations = [e for e in (reduced(p, self.letters.pairs) for p in self.equations) if e]
        if any(not self._unknown(e) for e in self.equations):
            raise _NoForm

    def _unknown(self, polynomial: Polynomial) -> set[str]:
        return letters(polynomial) & self.open

    def _expression(self, polynomial: Polynomial) -> Expression:
        return expression(polynomial, self.letters.meaning)

    def _size(self, polynomial: Polynomial) -> Expression:
        terms = [expression({m: c}, self.letters.meaning) for m, c in polynomial.items()]
        return add(*(call("abs", term) for term in terms))

    def _coefficient(self, polynomial: Polynomial) -> Coefficient:
        return Coefficient(self._expression(polynomial), self._size(polynomial))

    def _plain(self, name: str) -> bool:
        """Neither a cosine nor a sine of an unknown angle."""
        return not name.startswith(("#c ", "#s "))

    # --- a letter that occurs linearly ---

    def _substitute(self, by_number: bool) -> bool:
        """Replace a plain letter that an equation gives as a polynomial in the others.

        Equations free of angles come first: what they make zero is exactly zero then.
        """
        best = None
        for place, equation in enumerate(self.equations):
            unknown = self._unknown(equation)
            turning = sum(1 for name in unknown if not self._plain(name))
            for name in sorted(filter(self._plain, unknown)):
                parts = coefficients(equation, name)
                if set(parts) - {0, 1} or self._unknown(parts[1]):
                    continue
                number = set(parts[1]) == {UNIT}
                cost = (not number, turning, len(equation), place, name)
                if (number or not by_number) and (best is None or cost < best):
                    best = cost
        if best is None:
            return False
        *_, place, name = best
        equation = self.equations.pop(place)
        parts = coefficients(equation, name)
        value = scaled(parts.get(0, {}), Fraction(-1))
        if set(parts[1]) == {UNIT}:
            value = scaled(value, 1 / parts[1][UNIT])
        else:
            value = times(value, letter(self._reciprocal(parts[1])))
        size = self._size(value) if name in self.letters.roots else None
        self.backward.append([Let(name, self._expression(value), size=size)])
        self.open.discard(name)
        self.equations = [substituted(e, name, value) for e in self.equations]
        return True

    def _reciprocal(self, divisor: Polynomial) -> str:
        """A letter for the reciprocal of something known, which must not vanish."""
        count = len(self.letters.meaning)
        name, inverse = f"#d{count}", f"#i{count}"
        self.forward.append(Let(name, self._expression(divisor), divisor=True, size=self._size(divisor)))
        self.forward.append(Let(inverse, divide(Number(1.0), Name(name))))
        self.letters.meaning.update({name: Name(name), inverse: Name(inverse)})
        return inverse

    def _cross(self) -> bool:
        """Two lines in two plain letters, by Cramer's rule: no pivot to choose before there are numbers."""
        for i, one in enumerate(self.equations):
            x, *others = sorted(self._unknown(one))
            if len(others) != 1 or not (self._linear(one) and self._plain(x) and self._plain(others[0])):
                continue
            for j, other in enumerate(self.equations):
                if i < j and self._unknown(other) == {x, *others} and self._linear(other):
                    self._meet_lines(one, other, x, others[0])
                    self.equations = [e for k, e in enumerate(self.equations) if k not in (i, j)]
                    return True
        return False

    def _meet_lines(self, one: Polynomial, other: Polynomial, x: str, y: str) -> None:
        (a, b, p), (c, d, q) = (self._sides(line, x, y) for line in (one, other))
        inverse = Name(self._reciprocal(minus(times(a, d), times(b, c))))
        by_x, by_y = minus(times(p, d), times(b, q)), minus(times(a, q), times(p, c))
        self.forward.append(Let(x, multiply(self._expression(by_x), inverse)))
        self.forward.append(Let(y, multiply(self._expression(by_y), inverse)))
        self._found(x, y)

    # --- an equation in one letter, or in the cosine and sine of one angle ---

    def _close(self) -> bool:
        for place, equation in enumerate(self.equations):
            unknown = sorted(self._unknown(equation))
            if len(unknown) == 1 and self._plain(unknown[0]) and degree(equation, unknown[0]) <= 2:
                self._root_of(equation, unknown[0])
            elif len(unknown) == 2 and self._is_pair(*unknown) and self._linear(equation):
                cosine, sine = unknown
                a, b, k = self._line(equation, cosine, sine)
                self.forward.append(Circle(cosine, sine, a, b, k, self._coefficient(constant(1.0))))
                self._found(cosine, sine)
            else:
                continue
            del self.equations[place]
            return True
        return False

    def _found(self, *found: str) -> None:
        """From here on these letters are known. What stood before them stays before them."""
        self.open.difference_update(found)

    def _root_of(self, equation: Polynomial, name: str) -> None:
        parts = coefficients(equation, name)
        c, b, a = (parts.get(power, {}) for power in range(3))
        if not a:
            inverse = self._reciprocal(b)
            value = negative(multiply(self._expression(c), Name(inverse)))
            self.forward.append(Let(name, value))
        else:
            self.forward.append(Parabola(name, *map(self._coefficient, (a, b, c))))
        self._found(name)

    def _is_pair(self, cosine: str, sine: str) -> bool:
        return self.letters.pairs.get(sine) == cosine

    def _linear(self, equation: Polynomial) -> bool:
        return all(self._degree(monomial) <= 1 for monomial in equation)

    def _degree(self, monomial: tuple[tuple[str, int], ...]) -> int:
        return sum(exponent for name, exponent in monomial if name in self.open)

    def _line(self, equation: Polynomial, x: str, y: str) -> tuple[Coefficient, Coefficient, Coefficient]:
        a, b, k = self._sides(equation, x, y)
        return self._coefficient(a), self._coefficient(b), self._coefficient(k)

    def _sides(self, equation: Polynomial, x: str, y: str) -> tuple[Polynomial, Polynomial, Polynomial]:
        """``a x + b y = k``."""
        by_x = coefficients(equation, x)
        by_y = coefficients(by_x.get(0, {}), y)
        return by_x.get(1, {}), by_y.get(1, {}), scaled(by_y.get(0, {}), Fraction(-1))

    # --- two equations that turn the cosine and sine of an angle ---

    def _rotate(self) -> bool:
        for cosine, sine in self._open_pairs():
            lines = [
                (place, line)
                for place, equation in enumerate(self.equations)
                if (line := self._turned(equation, cosine, sine)) is not None
            ]
            for i, (one, first) in enumerate(lines):
                for other, second in lines[i + 1 :]:
                    matched = _matched(first, second)
                    if matched is not None and self._only_in(cosine, sine, one, other):
                        self._replace(cosine, sine, (one, other), matched)
                        return True
        return False

    def _only_in(self, cosine: str, sine: str, *places: int) -> bool:
        elsewhere = (e for place, e in enumerate(self.equations) if place not in places)
        return not any(letters(equation) & {cosine, sine} for equation in elsewhere)

    def _open_pairs(self) -> Iterator[tuple[str, str]]:
        for cosine, sine, _ in self.letters.angles.values():
            if cosine in self.open and sine in self.open:
                yield cosine, sine

    def _turned(
        self, equation: Polynomial, cosine: str, sine: str
    ) -> tuple[Polynomial, Polynomial, Polynomial] | None:
        """``a c + b s = p`` with the rest free of the two."""
        found = letters(equation)
        if cosine not in found and sine not in found:
            return None
        by_cosine = coefficients(equation, cosine)
        a, rest = by_cosine.get(1, {}), by_cosine.get(0, {})
        by_sine = coefficients(rest, sine)
        b, p = by_sine.get(1, {}), scaled(by_sine.get(0, {}), Fraction(-1))
        if set(by_cosine) - {0, 1} or set(by_sine) - {0, 1} or sine in letters(a):
            return None
        return a, b, p

    def _replace(
        self,
        cosine: str,
        sine: str,
        places: tuple[int, int],
        turn: tuple[Polynomial, Polynomial, Polynomial, Polynomial],
    ) -> None:
        a, b, p, q = turn
        square = reduced(plus(times(a, a), times(b, b)), self.letters.pairs)
        closing = minus(plus(times(p, p), times(q, q)), square)
        self.equations = [e for place, e in enumerate(self.equations) if place not in places]
        self.equations.append(reduced(closing, self.letters.pairs))
        self.open.difference_update((cosine, sine))
        name = f"#d{len(self.letters.meaning)}"
        self.letters.meaning[name] = Name(name)
        c, s = minus(times(a, p), times(b, q)), plus(times(b, p), times(a, q))
        self.backward.append(
            [
                Let(name, self._expression(square), divisor=True, size=self._size(square)),
                Let(cosine, divide(self._expression(c), Name(name))),
                Let(sine, divide(self._expression(s), Name(name))),
            ]
        )

    # --- circles ---

    def _subtract(self) -> bool:
        """Take one equation from another so that what is not linear in them goes."""
        curved = [(i, self._curved(e)) for i, e in enumerate(self.equations)]
        for i, one in curved:
            for j, other in curved:
                if i >= j or not one or set(one) != set(other):
                    continue
                ratio = _ratio(one, other)
                if ratio is not None:
                    self.equations[j] = minus(self.equations[j], scaled(self.equations[i], ratio))
                    return True
        return False

    def _curved(self, equation: Polynomial) -> Polynomial:
        return {m: c for m, c in equation.items() if self._degree(m) > 1}

    def _line_and_circle(self) -> bool:
        """``a x + b y = k`` and ``x² + y² + d x + e y + f = 0``, moved to the centre."""
        for i, line in enumerate(self.equations):
            unknown = sorted(self._unknown(line))
            if len(unknown) != 2 or not self._linear(line) or not all(map(self._plain, unknown)):
                continue
            for j, circle in enumerate(self.equations):
                if i != j and self._unknown(circle) == set(unknown) and self._is_circle(circle, *unknown):
                    self._meet(line, circle, *unknown)
                    self.equations = [e for k, e in enumerate(self.equations) if k not in (i, j)]
                    return True
        return False

    def _is_circle(self, equation: Polynomial, x: str, y: str) -> bool:
        curved = self._curved(equation)
        square = {((x, 2),), ((y, 2),)}
        return set(curved) == square and len(set(curved.values())) == 1

    def _meet(self, line: Polynomial, circle: Polynomial, x: str, y: str) -> None:
        circle = scaled(circle, 1 / circle[((x, 2),)])
        d = coefficients(circle, x).get(1, {})
        rest = coefficients(circle, x)[0]
        e = coefficients(rest, y).get(1, {})
        f = coefficients(rest, y).get(0, {})
        centre = [scaled(part, Fraction(-1, 2)) for part in (d, e)]
        square = minus(plus(*(times(part, part) for part in centre)), f)
        moved = {name: f"#m{len(self.letters.meaning)} {name}" for name in (x, y)}
        self.letters.meaning.update({new: Name(new) for new in moved.values()})
        shifted = line
        for name, part in zip((x, y), centre, strict=True):
            shifted = substituted(shifted, name, plus(letter(moved[name]), part))
        a, b, k = self._line(shifted, moved[x], moved[y])
        self.forward.append(Circle(moved[x], moved[y], a, b, k, self._coefficient(square)))
        for name, part in zip((x, y), centre, strict=True):
            self.forward.append(Let(name, add(Name(moved[name]), self._expression(part))))
        self._found(x, y)

    def _direction(self, name: str, cosine: str, sine: str, unit: str) -> Let:
        return Let(name, call("atan2" + unit, Name(sine), Name(cosine)))


def _signed(term: Expression) -> tuple[str, int] | None:
    match term:
        case Name(name):
            return name, 1
        case Negative(Name(name)):
            return name, -1
        case _:
            return None


def _count(term: Expression, quarter: float) -> int | None:
    """How many right angles a term is."""
    match term:
        case Number(value):
            count = value / quarter
        case Negative(Number(value)):
            count = -value / quarter
        case _:
            return None
    return int(count) if count == int(count) and abs(count) < 1e6 else None


def _matched(
    first: tuple[Polynomial, Polynomial, Polynomial], second: tuple[Polynomial, Polynomial, Polynomial]
) -> tuple[Polynomial, Polynomial, Polynomial, Polynomial] | None:
    """``a, b, p, q`` where the two lines are ``a c + b s = p`` and ``-b c + a s = q`` up to a sign."""
    a, b, p = first
    c, d, q = second
    opposite = scaled(b, Fraction(-1))
    if c == opposite and d == a:
        return a, b, p, q
    if c == b and d == scaled(a, Fraction(-1)):
        return a, b, p, scaled(q, Fraction(-1))
    return None


def _ratio(one: Polynomial, other: Polynomial) -> Fraction | None:
    """The number that takes one polynomial to the other."""
    ratios = {other[m] / one[m] for m in one}
    return ratios.pop() if len(ratios) == 1 else None
