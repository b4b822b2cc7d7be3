"""The equations that are left at a stage of elimination, and the formulas found so far."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import TypeAlias

from rulesheets.construct import add, call, divide
from rulesheets.model import Equation
from rulesheets.nodes import Expression, Name, Number
from solver.path.closed_form import Coefficient, Formula, Let
from solver.path.elimination.letters import Letters, NoForm
from solver.path.polynomial import (
    Monomial,
    Polynomial,
    coefficients,
    expression,
    letters,
    minus,
    reduced,
    scaled,
)

Line: TypeAlias = tuple[Polynomial, Polynomial, Polynomial]
"""``a x + b y = k`` as a, b and k."""


class System:
    """Equations in the ``open`` letters.

    ``forward`` are formulas in the order in which they are followed; each group of ``backward`` needs
    letters that are found later, so that the groups are followed last, in reverse.
    """

    def __init__(self, equations: Sequence[Equation], letters: Letters) -> None:
        self.letters = letters
        forms = [minus(letters.polynomial(e.left), letters.polynomial(e.right)) for e in equations]
        self.equations = [reduced(form, letters.pairs) for form in (*forms, *letters.extra)]
        self.open = letters.open
        self.forward: list[Formula] = []
        self.backward: list[list[Formula]] = []

    def formulas(self) -> list[Formula]:
        """All of them, in the order in which they are followed."""
        return [*self.forward, *(formula for group in reversed(self.backward) for formula in group)]

    def tidy(self) -> None:
        """Drop the equations that have come to 0 = 0. Raises NoForm where one holds no unknown."""
        self.equations = [e for e in (reduced(p, self.letters.pairs) for p in self.equations) if e]
        if any(not self.unknown(e) for e in self.equations):
            raise NoForm

    def drop(self, *places: int) -> None:
        self.equations = [e for place, e in enumerate(self.equations) if place not in places]

    def found(self, *names: str) -> None:
        """From here on these letters are known. What stood before them stays before them."""
        self.open.difference_update(names)

    # --- what a polynomial is in the open letters ---

    def unknown(self, polynomial: Polynomial) -> set[str]:
        return letters(polynomial) & self.open

    def plain(self, name: str) -> bool:
        """Neither a cosine nor a sine of an unknown angle."""
        return not name.startswith(("#c ", "#s "))

    def linear(self, equation: Polynomial) -> bool:
        return all(self._degree(monomial) <= 1 for monomial in equation)

    def curved(self, equation: Polynomial) -> Polynomial:
        """What is not linear of it."""
        return {m: c for m, c in equation.items() if self._degree(m) > 1}

    def _degree(self, monomial: Monomial) -> int:
        return sum(exponent for name, exponent in monomial if name in self.open)

    def sides(self, equation: Polynomial, x: str, y: str) -> Line:
        """``a x + b y = k``."""
        by_x = coefficients(equation, x)
        by_y = coefficients(by_x.get(0, {}), y)
        return by_x.get(1, {}), by_y.get(1, {}), scaled(by_y.get(0, {}), Fraction(-1))

    # --- the same as formulas ---

    def expression(self, polynomial: Polynomial) -> Expression:
        return expression(polynomial, self.letters.meaning)

    def size(self, polynomial: Polynomial) -> Expression:
        """The sum of the sizes of the terms."""
        terms = [expression({m: c}, self.letters.meaning) for m, c in polynomial.items()]
        return add(*(call("abs", term) for term in terms))

    def coefficient(self, polynomial: Polynomial) -> Coefficient:
        return Coefficient(self.expression(polynomial), self.size(polynomial))

    def line(self, equation: Polynomial, x: str, y: str) -> tuple[Coefficient, Coefficient, Coefficient]:
        a, b, k = self.sides(equation, x, y)
        return self.coefficient(a), self.coefficient(b), self.coefficient(k)

    def reciprocal(self, divisor: Polynomial) -> str:
        """A letter for the reciprocal of something known, which must not vanish."""
        count = len(self.letters.meaning)
        name, inverse = f"#d{count}", f"#i{count}"
        self.forward.append(Let(name, self.expression(divisor), divisor=True, size=self.size(divisor)))
        self.forward.append(Let(inverse, divide(Number(1.0), Name(name))))
        self.letters.meaning.update({name: Name(name), inverse: Name(inverse)})
        return inverse
