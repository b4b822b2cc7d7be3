"""Operations that have no value, and how numbers are written in what is said of them."""

from __future__ import annotations

from rulesheets.functions import TABLE
from rulesheets.syntax.nodes import Expression


def number_text(x: float) -> str:
    """Six digits of x, or all where six would pass it off as a whole number."""
    text = f"{x:.6g}"
    return repr(x) if float(text) != x and float(text).is_integer() else text


class Undefined(ArithmeticError):
    """An operation that has no value at its arguments; the text reads ``sqrt of -3.2``.

    ``operation`` is the name of a function, or ``/``, ``^``, ``overflow``, ``symbol``;
    ``expression`` is the part of the tree that it stands for. ``overflow``: there is a value, that no float
    holds.
    """

    def __init__(
        self, operation: str, arguments: tuple[float, ...], expression: Expression, overflow: bool = False
    ) -> None:
        super().__init__(_reading(operation, arguments))
        self.overflow = overflow or operation == "overflow"
        self.operation = operation
        self.arguments = arguments
        self.expression = expression

    @property
    def argument(self) -> float:
        """The argument to blame: the divisor, the base, the first of a function's."""
        return self.arguments[0]

    @property
    def hole(self) -> bool:
        """Whether it divides by 0, be it by a power, or asks for the direction of the origin: a point without
        a value among points that have one.
        """
        return (
            self.operation == "/"
            or (self.operation == "^" and self.arguments[0] == 0.0)
            or (self.operation in TABLE and TABLE[self.operation].direction)
        )


def _reading(operation: str, arguments: tuple[float, ...]) -> str:
    texts = [number_text(argument) for argument in arguments]
    match operation:
        case "/":
            return f"division by {texts[0]}"
        case "^":
            base = f"({texts[0]})" if arguments[0] < 0.0 and arguments[1] != int(arguments[1]) else texts[0]
            return f"{base}^{texts[1]}"
        case "overflow":
            return "a number too large to hold"
        case "symbol":
            return "arithmetic with a symbol"
        case _:
            return f"{operation} of {texts[0]}" if len(texts) == 1 else f"{operation} of ({', '.join(texts)})"
