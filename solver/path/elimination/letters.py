"""Equations as polynomials in letters: every angle is two, its cosine and its sine, and every root one."""

from __future__ import annotations

import math
from collections.abc import Collection
from fractions import Fraction

from rulesheets.construct import add, call, divide
from rulesheets.nodes import Call, Expression, Name, Negative, Number, Power, Product, Quotient, Sum, names
from solver.path.polynomial import Polynomial, constant, letter, minus, plus, reduced, scaled, times

_CIRCULAR = {"sind": "d", "cosd": "d", "sin": "", "cos": ""}
_QUARTER = {"d": 90.0, "": math.pi / 2}


class NoForm(Exception):
    """The equations are no polynomials in letters, or contradict one another."""


class Letters:
    """What the letters stand for."""

    def __init__(self, unknowns: Collection[str], turning: Collection[str]) -> None:
        self.unknowns, self.turning = frozenset(unknowns), frozenset(turning)
        self.meaning: dict[str, Expression] = {}
        self.pairs: dict[str, str] = {}
        self.angles: dict[str, tuple[str, str, str]] = {}
        self.open: set[str] = set()
        self.roots: list[str] = []
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
        raise NoForm

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
            raise NoForm
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
            raise NoForm
        base = unknown[0] if unknown else next((t for t in terms if _signed(t)), None)
        signed = None if base is None else _signed(base)
        if signed is None:
            if unknown:
                raise NoForm
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
            raise NoForm
        cosine, sine, known = self.angles.setdefault(name, (f"#c {name}", f"#s {name}", unit))
        if known != unit:
            raise NoForm
        self.pairs[sine] = cosine
        self.open.update((cosine, sine))
        self.meaning.update({cosine: Name(cosine), sine: Name(sine)})
        return cosine, sine

    def _pair(self, argument: Expression, unit: str) -> tuple[str, str]:
        cosine = self._named(call("cos" + unit, argument))
        sine = self._named(call("sin" + unit, argument))
        self.pairs[sine] = cosine
        return cosine, sine


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
