"""What the rules imply about units: linear algebra over the exponents of base units.

A product adds exponents, a quotient subtracts, a constant power scales, and what is added or
equated has the same. Each rule therefore gives linear equations between the exponents of its
variables (A. J. Kennedy, *Programming Languages and Dimensions*, 1996; here over the rationals,
since every call of a function is instantiated). The logarithm of a unit's size is one more such
exponent. Rules with one variable left open are taken first; elimination does the rest. Each result
carries the rules that it follows from, so that a conflict names its chain.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from itertools import combinations
from typing import Any, NamedTuple

from rulesheets.evaluate import Undefined, value
from rulesheets.evaluate.number import rounded
from rulesheets.functions import TABLE
from rulesheets.library import ANGLE, Library, Unit
from rulesheets.syntax import Span
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    bare,
    names,
    walk,
)

Exponents = dict[str, Any]
"""Integers or fractions by the names of base units, and a float for SIZE."""

SIZE = "size"
"""The exponent that is the logarithm of a unit's size; nan where it is open: decibels, shares."""
ASIDE = frozenset({SIZE, ANGLE, "dB"})
"""Exponents that are not dimensions: an angle is a number."""

LONGEST_CHAIN = 16
"""Rules after which no more are noted that a unit follows from: a message names fewer."""
LARGEST_COUNT = 9
"""Integers up to this are counts and factors of formulas (`m*v^2/2`), not factors between units."""
RELATIVE = 1e-3
"""How near a factor must be to numbers of the rule that explain it: these are rounded."""


def angle_of(function: str) -> Exponents | None:
    """The unit of the angle that a function takes or returns; None if there is none."""
    row = TABLE[function]
    if row.turn is None and row.angle is None:
        return None
    return {ANGLE: 1, SIZE: math.log(math.pi / 180)} if row.in_degrees else {ANGLE: 1}


def in_other_unit(function: str) -> str | None:
    """``sind`` for ``sin`` and ``sin`` for ``sind``; None for other functions."""
    if TABLE[function].direction or angle_of(function) is None:
        return None
    return function[:-1] if TABLE[function].in_degrees else f"{function}d"


def exponents(unit: Unit) -> Exponents:
    """The exponents of a unit, its size among them."""
    found: Exponents = {b: e.numerator if e.denominator == 1 else e for b, e in unit.bases.items()}
    if unit.factor != 1 or unit.pi:
        found[SIZE] = math.nan if "dB" in found else math.log(unit.scale)
    return found


class Powers(NamedTuple):
    """The exponents of an expression: known ones, and multiples of those of open variables.

    ``any``: 0, or a bare number in a sum, fits any unit. ``numbers`` of the rules that it follows
    from may be factors between units.
    """

    known: Exponents = {}  # noqa: RUF012
    open: Exponents = {}  # noqa: RUF012
    why: frozenset[int] = frozenset()
    any: bool = False
    numbers: frozenset[float] = frozenset()

    def plus(self, other: Powers, times: Any) -> Powers:
        why = self.why if len(self.why) > LONGEST_CHAIN or not other.why else self.why | other.why
        known, open_ = _sum(self.known, other.known, times), _sum(self.open, other.open, times)
        return Powers(known, open_, why, numbers=self.numbers | other.numbers)

    def times(self, exponent: Any) -> Powers:
        return Powers().plus(self, exponent)

    @property
    def sure(self) -> Exponents:
        """The known exponents, without the size if numbers may be factors between units."""
        return {**self.known, SIZE: math.nan} if self.numbers else self.known

    @property
    def dimension(self) -> Exponents:
        return {base: e for base, e in self.known.items() if base not in ASIDE}


def _sum(one: Exponents, other: Exponents, times: Any) -> Exponents:
    if not other:
        return one
    found = dict(one)
    for key, exponent in other.items():
        total = found.get(key, 0) + times * exponent
        if total:
            found[key] = total
        else:
            found.pop(key, None)
    return found


class Statement(NamedTuple):
    """Two expressions that must have the same unit, and the rule that requires it."""

    place: Span
    left: Expression
    right: Expression


class Mismatch(NamedTuple):
    """Two expressions of a statement (by index) that must have the same unit, but do not.

    ``right`` is None if an argument of ``call``, or an exponent, must be a number, or an angle in
    the unit of that function. ``factor``: if the dimensions agree, the size of the left unit in
    right units, but for what is ``counted`` as a factor that the rule writes. ``why`` are the
    statements that the units follow from.
    """

    statement: int
    left: Expression
    right: Expression | None
    forms: tuple[Powers, Powers]
    why: frozenset[int] = frozenset()
    factor: float | None = None
    counted: float = 1.0
    call: Call | None = None


class Dimensions:
    """The exponents of every variable whose unit is written or implied by rules."""

    def __init__(
        self, declared: Mapping[str, Unit], values: Mapping[str, float], units: Library
    ) -> None:
        self.declared, self.values, self.units = declared, values, units
        self.forms = {name: Powers(exponents(unit)) for name, unit in declared.items()}
        self.statements: Sequence[Statement] = ()
        self.mismatches: list[Mismatch] = []

    def infer(self, statements: Sequence[Statement]) -> None:
        """Process the statements, those with a single open variable first."""
        self.statements = statements
        named = [frozenset(names(s.left, s.right)) for s in statements]
        free = [{name for name in some if name not in self.forms} for some in named]
        users: dict[str, list[int]] = {}
        for place, some in enumerate(free):
            for name in some:
                users.setdefault(name, []).append(place)
        ready = deque(place for place, some in enumerate(free) if len(some) < 2)
        taken = [False] * len(statements)
        for first in range(len(statements)):
            while ready or not taken[first]:
                place = ready.popleft() if ready else first
                if taken[place]:
                    continue
                taken[place] = True
                left, right = statements[place].left, statements[place].right
                self._equate(place, left, right, self.form(left, place), self.form(right, place))
                for name in (n for n in named[place] if n in users and self.known(n) is not None):
                    for user in users.pop(name):
                        free[user].discard(name)
                        if len(free[user]) < 2:
                            ready.append(user)

    def again(self, rules: Sequence[Statement], changed: Mapping[str, Unit] = {}) -> Dimensions:
        """What some rules imply, with other units of some variables."""
        trial = Dimensions({**self.declared, **changed}, self.values, self.units)
        trial.infer(rules)
        return trial

    def known(self, name: str) -> Powers | None:
        """The exponents of a variable; None while they are open."""
        found = self._resolved(self.forms[name]) if name in self.forms else None
        return None if found is None or found.open else found

    # --- expressions ---

    def form(self, node: Expression, index: int) -> Powers:
        """The exponents of an expression of a statement; its parts must be consistent."""
        match node:
            case Name(name):
                found = self.forms.get(name)
                if found is None:
                    found = self.forms[name] = Powers(open={name: 1})
                return self._resolved(found) if found.open else found
            case Number(unit=str(unit)):
                return Powers(exponents(self.units.unit(unit)))
            case Product(left, right) | Quotient(left, right):
                one, other = self.form(left, index), self.form(right, index)
                if one.any and other.any:
                    return one
                return one.plus(other, 1 if type(node) is Product else -1)
            case Negative(operand):
                return self.form(operand, index)
            case Sum(terms):
                return self._alike(terms, index)
            case Power(base, exponent):
                return self._power(base, exponent, index)
            case Call():
                return self._call(node, index)
            case _:
                return Powers(any=True)

    def _alike(self, terms: Iterable[Expression], index: int) -> Powers:
        """Terms of the same unit: numbers adopt that of the others."""
        first: tuple[Expression, Powers] | None = None
        for term in terms:
            form = self.form(term, index)
            if form.any or bare(term):
                continue
            if first is not None:
                self._equate(index, first[0], term, first[1], form)
            first = first or (term, form)
        return Powers(any=True) if first is None else self._resolved(first[1])

    def _power(self, base: Expression, exponent: Expression, index: int) -> Powers:
        below = self.form(base, index)
        plain = below.any or not (below.dimension or below.open)
        if plain and self._makes_up(below, index):
            below = Powers()
        if type(exponent) is Number and exponent.unit is None and not below.any:
            return below.times(_rational(exponent.value))
        form = self.form(exponent, index) if plain else Powers()
        if form.dimension.keys() != {"s"} or form.open:  # but periods of time, as in (1 + i)^n
            self._number(exponent, index)
        if below.any:
            return Powers(any=bare(exponent))
        try:
            constant = _rational(float(value(exponent, self.values)))
        except (Undefined, KeyError, ValueError, OverflowError):
            if not plain:
                self._number(base, index)
            return Powers()
        return below.times(constant)

    def _call(self, node: Call, index: int) -> Powers:
        function, arguments = node.function, node.arguments
        if function == "sqrt":
            return self.form(arguments[0], index).times(Fraction(1, 2))
        row = TABLE[function]
        if row.source is not None:  # a function in Python has units of its own, here unknown
            for argument in arguments:
                self.form(argument, index)
            return Powers(open={f"{function} {id(node)}": 1})
        shared = self._alike(arguments, index) if row.alike else Powers()
        for argument in () if row.alike else arguments:
            self._number(argument, index, node)
        if row.keeps_unit:
            return shared
        return Powers((row.angle and angle_of(function)) or {})

    def _number(self, node: Expression, index: int, call: Call | None = None) -> None:
        """Require a number: an exponent, the argument of a logarithm; of a sine, an angle."""
        form = self._resolved(self.form(node, index))
        if form.any:
            return
        if form.open or form.dimension:
            wanted = Powers({**form.dimension, SIZE: math.nan}, form.open, form.why)
            self._meet(wanted, Mismatch(index, node, None, (form, Powers()), call=call))
        elif call is not None and form.known.get(ANGLE) == 1 and (angle := angle_of(call.function)):
            claim = Mismatch(index, node, None, (form, Powers(angle)), call=call)
            self._compare(form.plus(Powers(angle), -1), claim)
        elif ANGLE not in form.known:
            self._compare(form, Mismatch(index, node, None, (form, Powers()), call=call))

    # --- equations between exponents ---

    def _equate(
        self, index: int, left: Expression, right: Expression, one: Powers, other: Powers
    ) -> None:
        if not (one.any or other.any or bare(left) or bare(right)):
            self._meet(one.plus(other, -1), Mismatch(index, left, right, (one, other)))

    def _meet(self, form: Powers, claim: Mismatch) -> None:
        """Require ``form`` to be 0: this determines an open variable, or contradicts known ones."""
        index = claim.statement
        form = self._resolved(form)
        if not form.open:
            self._compare(form, claim)
            return
        name = min(form.open)
        others = {n: e for n, e in form.open.items() if n != name}
        # may be factors between units
        written = {abs(number.value) for number in self._numbers(index)}
        factors = frozenset(n for n in written if not n.is_integer() or n > LARGEST_COUNT)
        rest = Powers(form.known, others, form.why | {index}, numbers=form.numbers | factors)
        found = rest.times(_rational(-1 / form.open[name]))
        if found.numbers and not (found.dimension or found.open):
            found = found._replace(known={**found.known, SIZE: math.nan})  # a share or its percents
        self.forms[name] = found

    def _compare(self, form: Powers, claim: Mismatch) -> None:
        """Record the exponents of ``form``, which has no open variables, that are not 0."""
        if not form.known:
            return
        factor = None
        if not form.dimension:
            size = form.known.get(SIZE, 0.0)
            counted = ANGLE in form.known and not any(side.dimension for side in claim.forms)
            if counted or not abs(size) > 1e-9:  # revolutions may be a number of them
                return
            factor = rounded(math.exp(size), 12)
            if self._explained(factor, claim.statement, form.numbers):
                return
            share = _decades_apart(factor, self._factors(claim.statement, form.numbers))
            claim, factor = claim._replace(counted=share), rounded(factor / share, 12)
        one, other = (self._resolved(side) for side in claim.forms)
        self.mismatches.append(claim._replace(forms=(one, other), why=form.why, factor=factor))

    def _resolved(self, form: Powers) -> Powers:
        """The form with variables filled in that have become known since it was made."""
        while ready := [n for n in form.open if n in self.forms and self.forms[n].open != {n: 1}]:
            others = {n: e for n, e in form.open.items() if n not in ready}
            found = Powers(form.known, others, form.why, numbers=form.numbers)
            for name in ready:
                found = found.plus(self.forms[name], form.open[name])
            form = found
        return form

    # --- factors that numbers explain ---

    def _numbers(self, index: int) -> Iterable[Number]:
        sides = self.statements[index].left, self.statements[index].right
        return [one for one in walk(*sides) if isinstance(one, Number) and one.unit is None]

    def _factors(self, index: int, before: Iterable[float]) -> set[float]:
        """Numbers in the rule, and in those before it, that may be factors between units."""
        statement = self.statements[index]
        written = {abs(n.value) for n in self._numbers(index)}.union(before)
        nodes = walk(statement.left, statement.right)
        if any(isinstance(node, Call) and node.function == "pi" for node in nodes):
            written |= {math.pi, 2 * math.pi}
        return written

    def _makes_up(self, form: Powers, index: int) -> bool:
        """Whether numbers of the rule explain a pure number."""
        share = form.known.get(SIZE, 0.0)
        return bool(share) and self._explained(math.exp(share), index, form.numbers)

    def _explained(self, factor: float, index: int, before: Iterable[float]) -> bool:
        """Whether a factor is explained by numbers in the rule, or in those before it.

        Turns and degrees may be counted as such.
        """
        written, statement = self._factors(index, before), self.statements[index]
        if explained(factor, written):
            return True
        nodes = walk(statement.left, statement.right)
        read = {node.name for node in nodes if isinstance(node, Name)}
        variables = (self.forms[name] for name in read & self.forms.keys())
        if not any(ANGLE in form.known for form in variables):
            return False
        turns = [2 * math.pi] if written else []
        degrees = [math.pi / 180] if written & {90.0, 180.0, 360.0} else []
        shares = (one**sign for one in turns + degrees for sign in (1, -1))
        return any(explained(factor * share, written) for share in shares)


def _rational(number: float) -> Fraction | int:
    return int(number) if number == int(number) else Fraction(number).limit_denominator(60)


def explained(factor: float, written: Iterable[float]) -> bool:
    """Whether a factor is 1, a product of powers of the rule's numbers, or divides one of them,
    perhaps after another is taken out (`kPa*l*rpm/1000/120` is kW)."""
    if math.isclose(factor, 1.0, rel_tol=1e-9):
        return True
    usual = _usual(written)
    for number in usual:
        others = (other for other in usual if other != number)
        for share in (factor, *(factor * other**sign for other in others for sign in (1, -1))):
            count = number / max(share, 1 / share)
            if count > 0.5 and (count + 1e-9) % 1.0 < 2e-9:
                return True
    return any(math.isclose(factor, product, rel_tol=RELATIVE) for product in _products(usual))


def _usual(written: Iterable[float]) -> list[float]:
    return [number for number in written if number not in (0.0, 1.0)]


def _products(numbers: Sequence[float]) -> Iterator[float]:
    powers = [number**e for number in numbers for e in (1, -1, 2, -2, 0.5, -0.5)]
    yield from powers
    yield from (a * b for a, b in combinations(powers, 2))


def _decades_apart(factor: float, written: Iterable[float]) -> float:
    """A product of powers of the rule's numbers that is a factor, but for some powers of ten."""
    for one in (1.0, *_products(_usual(written))):
        decades = math.log10(factor / one)
        if abs(decades - round(decades)) < RELATIVE:
            return one
    return 1.0
