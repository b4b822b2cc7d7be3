"""What a closed form of simultaneous equations is: formulas in order, some of them with two values.

``elimination`` finds them; following them is the kernel's, by floats and compiled.
"""

from __future__ import annotations

from dataclasses import dataclass

from rulesheets.syntax.nodes import Expression


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
