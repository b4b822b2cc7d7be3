"""What the rules imply about dimensions: linear algebra over the exponents of base units.

A product adds exponents, a quotient subtracts, a constant power scales, and what is added or equated has
the same. Each rule therefore gives linear equations between the exponents of its variables (A. J. Kennedy,
*Programming Languages and Dimensions*, 1996; here over the rationals, since every call of a function is
instantiated). Rules with one variable left open are taken first; elimination does the rest. Each result
carries the rules that it follows from, so that a conflict names its chain.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from rulesheets.evaluate import Undefined, value
from rulesheets.nodes import (
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
    bare,
    names,
)
from rulesheets.units.library import library

Exponents = dict[str, Fraction]

SAME = frozenset({"min", "max", "abs", "mod", "hypot", "step"})
"""Functions whose result has the unit that their arguments share."""
ROOTS = {"sqrt": Fraction(1, 2)}
FREE = frozenset({"sgn", "pi", "e", "atan2", "atan2d"})
"""Functions that take any unit, the same for all arguments, and give a number."""


LONGEST_CHAIN = 16
"""Rules after which no more are noted that a unit follows from: a message names fewer."""


@dataclass
class Form:
    """Exponents of an expression: known ones, and multiples of those of variables that are open.

    ``any``: 0, or a bare number in a sum, fits whatever stands beside it.
    """

    known: Exponents = field(default_factory=dict)
    open: dict[str, Fraction] = field(default_factory=dict)
    why: frozenset[int] = frozenset()
    any: bool = False

    def plus(self, other: Form, times: Fraction = Fraction(1)) -> Form:
        known, free = dict(self.known), dict(self.open)
        for into, part in ((known, other.known), (free, other.open)):
            for key, exponent in part.items():
                into[key] = into.get(key, Fraction(0)) + times * exponent
        return Form(
            {base: e for base, e in known.items() if e},
            {name: e for name, e in free.items() if e},
            self.why if len(self.why) > LONGEST_CHAIN else self.why | other.why,
        )

    def times(self, exponent: Fraction) -> Form:
        return Form().plus(self, exponent)


@dataclass(frozen=True)
class Mismatch:
    """Two expressions of the rule ``equation`` that must have one unit, and do not.

    ``right`` is None where an argument must be a number. ``why`` are the rules that the units follow from.
    """

    equation: int
    left: Expression
    right: Expression | None
    left_exponents: Exponents
    right_exponents: Exponents
    why: frozenset[int]


class Dimensions:
    """Exponents of every variable that has a unit, and of those that the rules give one."""

    def __init__(self, declared: Mapping[str, Exponents], numbers: Mapping[str, float]) -> None:
        self.numbers = numbers
        self.forms: dict[str, Form] = {name: Form(dict(exponents)) for name, exponents in declared.items()}
        self.mismatches: list[Mismatch] = []

    def infer(self, equations: Iterable[tuple[int, Expression, Expression]]) -> None:
        """Take in the rules, those that leave one variable open first."""
        rules = list(equations)
        named = [frozenset((*names(left), *names(right))) for _, left, right in rules]
        free = [{name for name in some if name not in self.forms} for some in named]
        users: dict[str, list[int]] = {}
        for place, some in enumerate(free):
            for name in some:
                users.setdefault(name, []).append(place)
        ready = deque(place for place, some in enumerate(free) if len(some) < 2)
        taken = [False] * len(rules)
        for first in range(len(rules)):
            while ready or not taken[first]:
                place = ready.popleft() if ready else first
                if taken[place]:
                    continue
                taken[place] = True
                self._take(*rules[place])
                for name in (n for n in named[place] if n in users and self.known(n) is not None):
                    for user in users.pop(name):
                        free[user].discard(name)
                        if len(free[user]) < 2:
                            ready.append(user)

    def known(self, name: str) -> Exponents | None:
        """The exponents of a variable, None while they are open."""
        found = self._resolved(self.forms[name]) if name in self.forms else None
        return None if found is None or found.open else found.known

    def _take(self, index: int, left: Expression, right: Expression) -> None:
        self._equate(index, left, right, self.form(left, index), self.form(right, index))

    # --- expressions ---

    def form(self, node: Expression, index: int) -> Form:
        """The exponents of an expression of the rule ``index``; what is in it must fit together."""
        match node:
            case Number(unit=str(unit)):
                return Form(library().unit(unit).dimension)
            case Number():
                return Form(any=True)
            case Symbol():
                return Form(any=True)
            case Name(name):
                return self._resolved(self.forms.setdefault(name, Form(open={name: Fraction(1)})))
            case Negative(operand):
                return self.form(operand, index)
            case Sum(terms):
                return self._alike(terms, index)
            case Product(left, right) | Quotient(left, right):
                one, other = self.form(left, index), self.form(right, index)
                if one.any and other.any:
                    return one
                return one.plus(other, Fraction(1 if isinstance(node, Product) else -1))
            case Power(base, exponent):
                return self._power(base, exponent, index)
            case Call(function, arguments):
                return self._call(function, arguments, index)

    def _alike(self, terms: Iterable[Expression], index: int) -> Form:
        """Terms of one unit: numbers adopt that of the others."""
        first: tuple[Expression, Form] | None = None
        for term in terms:
            form = self.form(term, index)
            if form.any:
                continue
            if first is not None:
                self._equate(index, first[0], term, first[1], form)
            first = first or (term, form)
        return Form(any=True) if first is None else self._resolved(first[1])

    def _power(self, base: Expression, exponent: Expression, index: int) -> Form:
        below = self.form(base, index)
        if below.any or not (below.known or below.open):
            self._count(exponent, index)
            return Form(any=below.any and bare(exponent))
        self._number(exponent, index)
        try:
            constant = Fraction(float(value(exponent, self.numbers))).limit_denominator(60)
        except (Undefined, KeyError, ValueError, OverflowError):
            self._number(base, index)
            return Form()
        return below.times(constant)

    def _call(self, function: str, arguments: tuple[Expression, ...], index: int) -> Form:
        if function in ROOTS:
            return self.form(arguments[0], index).times(ROOTS[function])
        if function in SAME:
            return self._alike(arguments, index)
        if function in FREE:
            self._alike(arguments, index)
            return Form()
        for argument in arguments:
            self._number(argument, index)
        return Form()

    def _count(self, node: Expression, index: int) -> None:
        """An exponent of a number: it has no unit, or counts periods of time, as in ``(1 + i)^n``."""
        form = self.form(node, index)
        if form.known.keys() != {"s"} or form.open:
            self._number(node, index)

    def _number(self, node: Expression, index: int) -> None:
        """An expression that has no unit: an exponent, an argument of a logarithm."""
        form = self.form(node, index)
        if not form.any:
            self._meet(index, node, None, form)

    # --- equations between exponents ---

    def _equate(self, index: int, left: Expression, right: Expression, one: Form, other: Form) -> None:
        if not (one.any or other.any):
            self._meet(index, left, right, one.plus(other, Fraction(-1)))

    def _meet(self, index: int, left: Expression, right: Expression | None, form: Form) -> None:
        """``form`` is 0: that settles one of its open variables, or contradicts what is known."""
        form = self._resolved(form)
        if form.open:
            name = min(form.open)
            rest = Form(form.known, {n: e for n, e in form.open.items() if n != name}, form.why | {index})
            self.forms[name] = rest.times(-1 / form.open[name])
        elif form.known:
            sides = [self._resolved(self.form(side, index)) for side in (left, right) if side is not None]
            exponents = [side.known for side in (*sides, Form())]
            self.mismatches.append(Mismatch(index, left, right, exponents[0], exponents[1], form.why))

    def _resolved(self, form: Form) -> Form:
        """The form with variables that were open when it was made, and are not any more, filled in."""
        if form.any:
            return form
        while ready := [n for n in form.open if self._answered(n)]:
            found = Form(form.known, {n: e for n, e in form.open.items() if n not in ready}, form.why)
            for name in ready:
                found = found.plus(self.forms[name], form.open[name])
            form = found
        return form

    def _answered(self, name: str) -> bool:
        return name in self.forms and self.forms[name].open != {name: Fraction(1)}


def variables_of(equations: Iterable[tuple[int, Expression, Expression]]) -> Iterator[str]:
    """Names of the variables in rules, each once."""
    return iter(dict.fromkeys(n for _, a, b in equations for n in (*names(a), *names(b))))
