"""Polynomials in several generators with exact rational coefficients.

A generator is a variable, the cosine or the sine of an angle, a root, or any other part of an
expression that is not opened. Like terms are merged, so that terms cancel by algebra; for
elimination, the square of a sine is written by that of the cosine.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from typing import TypeAlias

from rulesheets.syntax import nodes

Monomial: TypeAlias = tuple[tuple[str, int], ...]
"""Generators with their exponents, sorted."""

UNIT: Monomial = ()
MAX_TERMS = 400


class NoForm(Exception):
    """The equations are not polynomials, have too many terms, or contradict one another."""


class Polynomial(dict[Monomial, Fraction]):
    """Coefficients by monomials, none of them 0. Sums and products raise NoForm."""

    @classmethod
    def of(cls, terms: Iterable[tuple[Monomial, Fraction]]) -> Polynomial:
        """Like terms merged."""
        total = cls()
        for monomial, coefficient in terms:
            total[monomial] = total.get(monomial, 0) + coefficient
            if not total[monomial]:
                del total[monomial]
        if len(total) > MAX_TERMS:
            raise NoForm
        return total

    def __add__(self, other: Polynomial) -> Polynomial:
        return Polynomial.of((*self.items(), *other.items()))

    def __neg__(self) -> Polynomial:
        return Polynomial({monomial: -coefficient for monomial, coefficient in self.items()})

    def __sub__(self, other: Polynomial) -> Polynomial:
        return self + -other

    def __mul__(self, other: Polynomial | Fraction) -> Polynomial:
        if isinstance(other, Fraction):
            return Polynomial(
                {monomial: other * c for monomial, c in self.items()} if other else {}
            )
        terms = []
        for one, a in self.items():
            for two, b in other.items():
                joined = one or two
                if one and two:
                    exponents = dict(one)
                    for name, exponent in two:
                        exponents[name] = exponents.get(name, 0) + exponent
                    joined = tuple(sorted(item for item in exponents.items() if item[1]))
                terms.append((joined, a * b))
        return Polynomial.of(terms)

    @property
    def generators(self) -> set[str]:
        return {name for monomial in self for name, _ in monomial}

    def degree(self, name: str) -> int:
        return max((exponent for m in self for other, exponent in m if other == name), default=0)

    @property
    def highest(self) -> int:
        """The highest degree in one of its generators."""
        return max((exponent for monomial in self for _, exponent in monomial), default=0)

    def coefficients(self, name: str) -> dict[int, Polynomial]:
        """By powers of one generator."""
        parts: dict[int, Polynomial] = {}
        for monomial, coefficient in self.items():
            rest = tuple(item for item in monomial if item[0] != name)
            parts.setdefault(dict(monomial).get(name, 0), Polynomial())[rest] = coefficient
        return parts

    def substituted(self, name: str, value: Polynomial) -> Polynomial:
        """With a generator replaced."""
        parts, raised, total = self.coefficients(name), constant(1.0), Polynomial()
        for exponent in range(max(parts, default=0) + 1):
            raised = raised * value if exponent else raised
            total += parts.get(exponent, Polynomial()) * raised
        return total

    def reduced(self, pairs: Mapping[str, str]) -> Polynomial:
        """With every square of a sine replaced: sin² = 1 - cos². ``pairs`` gives the cosine of each
        sine."""
        reduced = self
        for sine, cosine in pairs.items():
            square = generator(cosine) * generator(cosine)
            while reduced.degree(sine) >= 2:
                total = Polynomial()
                for exponent, part in reduced.coefficients(sine).items():
                    squares, rest = divmod(exponent, 2)
                    for _ in range(squares):
                        part -= part * square
                    total += part * generator(sine) if rest else part
                reduced = total
        return reduced

    def expression(self, meaning: Mapping[str, nodes.Expression], by: str = "") -> nodes.Expression:
        """As an expression; ``meaning`` gives the expression of every generator. Terms are
        collected ``by`` one of them, so that it occurs once for each of its powers (W. G. Horner's
        form)."""
        if by and (degree := self.degree(by)):
            parts = self.coefficients(by)
            found = parts[degree].expression(meaning)
            for power in reversed(range(degree)):
                found = found * meaning[by] + parts.get(power, Polynomial()).expression(meaning)
            return found
        terms: list[nodes.Expression] = []
        for monomial, coefficient in self.items():
            product: nodes.Expression = nodes.ONE
            for name, exponent in monomial:
                product = product * meaning[name] ** float(exponent)
            if abs(coefficient) != 1:
                product = float(abs(coefficient)) * product
            terms.append(product if coefficient > 0 else -product)
        return nodes.add(*terms)


def constant(value: float | Fraction) -> Polynomial:
    return Polynomial({UNIT: Fraction(value)} if value else {})


def generator(name: str) -> Polynomial:
    return Polynomial({((name, 1),): Fraction(1)})


def in_parts(
    expression: nodes.Expression,
    number: Callable[[nodes.Expression], Fraction | None],
    meaning: dict[nodes.Expression, str],
) -> Polynomial:
    """An expression as a sum of products of powers, negative ones too; ``number`` gives the known
    parts.

    Generators are names, and parts that ``meaning`` names: functions, and sums that have unknown
    factors, divide, or have an exponent. Raises ZeroDivisionError where a divisor or a base is 0,
    and NoForm.
    """

    def part(node: nodes.Expression) -> Polynomial:
        known = number(node)
        match node:
            case _ if known is not None:
                return constant(known)
            case nodes.Number(value):
                return constant(value)
            case nodes.Name(name):
                return generator(name)
            case nodes.Negative(operand):
                return -part(operand)
            case nodes.Sum(terms):
                return Polynomial.of(item for term in terms for item in part(term).items())
            case nodes.Product(left, right) if (
                number(left) is not None or number(right) is not None
            ):
                return part(left) * part(right)
            case nodes.Product(left, right):
                return factor(left) * factor(right)
            case nodes.Quotient(left, right):
                return (factor if number(right) is None else part)(left) * raised(right, -1)
            case nodes.Power(base, nodes.Number(exponent)) if exponent in range(1, 65):
                return raised(base, int(exponent))
        return named(node)

    def factor(node: nodes.Expression) -> Polynomial:
        found = part(node)
        return found if len(found) < 2 else named(node)

    def raised(node: nodes.Expression, exponent: int) -> Polynomial:
        if not (base := factor(node)):
            raise ZeroDivisionError
        ((monomial, coefficient),) = base.items()
        return Polynomial({tuple((n, e * exponent) for n, e in monomial): coefficient**exponent})

    def named(node: nodes.Expression) -> Polynomial:
        return generator(meaning.setdefault(node, f"#{len(meaning)}"))

    return part(expression)


CIRCULAR = {"sind": "d", "cosd": "d", "sin": "", "cos": ""}
_QUARTER = {"d": 90.0, "": math.pi / 2}


@dataclass
class Generators:
    """The meaning of the generators."""

    unknowns: frozenset[str]
    turning: Collection[str]
    meaning: dict[str, nodes.Expression] = field(default_factory=dict)
    pairs: dict[str, str] = field(default_factory=dict)
    angles: dict[str, tuple[str, str, str]] = field(default_factory=dict)
    open: set[str] = field(default_factory=set)
    roots: list[str] = field(default_factory=list)
    extra: list[Polynomial] = field(default_factory=list)

    def polynomial(self, node: nodes.Expression) -> Polynomial:
        """A part without unknowns: opened as far as it is a polynomial, else a generator of its
        own.

        Raises NoForm for a part with unknowns that is not a polynomial.
        """
        known = not self.unknowns.intersection(nodes.names(node))
        match node:
            case nodes.Number(value):
                return constant(value)
            case nodes.Name(name):
                if name in self.angles:
                    raise NoForm
                self.meaning[name] = node
                if not known:
                    self.open.add(name)
                return generator(name)
            case nodes.Negative(operand):
                return -self.polynomial(operand)
            case nodes.Sum(terms):
                return Polynomial.of(
                    item for term in terms for item in self.polynomial(term).items()
                )
            case nodes.Product(left, right):
                return (self.polynomial(left) * self.polynomial(right)).reduced(self.pairs)
            case nodes.Quotient(left, nodes.Number(value)) if value:
                return self.polynomial(left) * (1 / Fraction(value))
            case nodes.Power(base, nodes.Number(value)) if value == 2.0 or (
                value in (3.0, 4.0) and not known
            ):
                inner = raised = self.polynomial(base)
                for _ in range(int(value) - 1):
                    raised = (raised * inner).reduced(self.pairs)
                return raised
            case nodes.Call(function, (argument,)) if function in CIRCULAR:
                return self._circular(function, argument)
            case _ if known:
                return generator(self._named(node))
            case nodes.Quotient(left, right) if not self.unknowns.intersection(nodes.names(right)):
                return self.polynomial(left) * generator(self._named(1.0 / right))
            case nodes.Quotient(left, right):  # one more unknown, and a product
                dividend, quotient = self.polynomial(left), self._auxiliary()
                self.extra.append(
                    (quotient * self.polynomial(right)).reduced(self.pairs) - dividend
                )
                return quotient
            case nodes.Power(base, nodes.Number(0.5)) | nodes.Call("sqrt", (base,)):
                inside, root = self.polynomial(base), self._auxiliary()
                self.roots += root.generators
                self.extra.append(root * root - inside)
                return root
        raise NoForm

    def _named(self, node: nodes.Expression) -> str:
        """The generator of a known part that is not opened."""
        for name, meaning in self.meaning.items():
            if meaning == node:
                return name
        name = f"#k{len(self.meaning)}"
        self.meaning[name] = node
        return name

    def _auxiliary(self) -> Polynomial:
        name = f"#u{len(self.meaning)}"
        self.meaning[name] = nodes.Name(name)
        self.open.add(name)
        return generator(name)

    # --- angles ---

    def _circular(self, function: str, argument: nodes.Expression) -> Polynomial:
        """By the sums of angles ``±name ± name + 90·quarters + rest`` of which the rest is
        known."""
        unit, cosine = CIRCULAR[function], function.startswith("cos")
        turns = right_angles(argument, _QUARTER[unit])
        if turns is not None and unit:
            whole = (1.0, 0.0, -1.0, 0.0)
            return constant(whole[(turns if cosine else turns - 1) % 4])
        terms = argument.terms if isinstance(argument, nodes.Sum) else (argument,)
        unknown = [term for term in terms if self.unknowns.intersection(nodes.names(term))]
        bases = unknown or [term for term in terms if name_of(term)][:1]
        if not all(map(name_of, bases)):
            raise NoForm
        quarters, rest = 0, []
        for term in terms:
            count = right_angles(term, _QUARTER[unit])
            if count is not None:
                quarters += count
            elif not any(term is base for base in bases):
                rest.append(term)
        if not bases or (rest and not unknown):
            return self._pair(argument, unit)[not cosine]
        (c, s), *others = [self._turned(base, unit, bool(unknown)) for base in bases]
        for _ in range(quarters % 4):
            c, s = -s, c
        for cos, sin in (*others, self._pair(nodes.add(*rest), unit)) if rest else others:
            c, s = (c * cos - s * sin).reduced(self.pairs), (s * cos + c * sin).reduced(self.pairs)
        return c if cosine else s

    def _turned(
        self, base: nodes.Expression, unit: str, unknown: bool
    ) -> tuple[Polynomial, Polynomial]:
        """The cosine and the sine of a name with either sign."""
        name = name_of(base)
        if unknown:
            if name in self.open or name not in self.turning:
                raise NoForm
            cosine, sine, known = self.angles.setdefault(name, (f"#c {name}", f"#s {name}", unit))
            if known != unit:
                raise NoForm
            self.pairs[sine] = cosine
            self.open.update((cosine, sine))
            self.meaning.update({cosine: nodes.Name(cosine), sine: nodes.Name(sine)})
            c, s = generator(cosine), generator(sine)
        else:
            c, s = self._pair(nodes.Name(name), unit)
        return c, -s if isinstance(base, nodes.Negative) else s

    def _pair(self, argument: nodes.Expression, unit: str) -> tuple[Polynomial, Polynomial]:
        cosine = self._named(nodes.call("cos" + unit, argument))
        sine = self._named(nodes.call("sin" + unit, argument))
        self.pairs[sine] = cosine
        return generator(cosine), generator(sine)


def name_of(term: nodes.Expression) -> str:
    """The name of a term, with either sign; blank if it is not a name."""
    inner = term.operand if isinstance(term, nodes.Negative) else term
    return inner.name if isinstance(inner, nodes.Name) else ""


def right_angles(term: nodes.Expression, quarter: float) -> int | None:
    """A term as a number of right angles."""
    inner, sign = (term.operand, -1) if isinstance(term, nodes.Negative) else (term, 1)
    count = sign * inner.value / quarter if isinstance(inner, nodes.Number) else 0.5
    return int(count) if count == int(count) and abs(count) < 1e6 else None
