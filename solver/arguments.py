"""The numbers that a plan is called with: by position in the order of its inputs, or by name."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rulesheets.diagnosis import meant, plural
from rulesheets.inputs import is_symbol, quantities

if TYPE_CHECKING:
    from collections.abc import Mapping
    from typing import Any

    from rulesheets.model import Model, Value


def arguments(
    model: Model, inputs: tuple[str, ...], given: tuple[Any, ...], named: Mapping[str, Any]
) -> tuple[Value, ...]:
    """The value of every input, floats and names of symbols.

    Raises TypeError that names the input: for one that is missing, given twice or not prepared for, and for
    a value that is neither a number nor a symbol.
    """
    asked = ", ".join(inputs) or "nothing"
    if len(given) > len(inputs):
        raise TypeError(
            f"this plan takes {plural(len(inputs), 'input')} ({asked}), and {len(given)} were given; "
            "what is fixed is said to prepare, by given"
        )
    values = dict(zip(inputs, given, strict=False))
    for name, value in named.items():
        if name not in inputs:
            notes = meant(name, inputs)
            if not notes and name in model.variables:
                notes = (f"to vary it, prepare with inputs=[…, '{name}']",)
            tail = f"; {notes[0]}" if notes else ""
            raise TypeError(f"{name} is no input of this plan, which takes {asked}{tail}")
        if name in values:
            raise TypeError(f"{name} is given twice, by its place and by its name")
        values[name] = value
    missing = [name for name in inputs if name not in values]
    if missing:
        raise TypeError(
            f"no value is given for {', '.join(missing)}; this plan takes {asked}, in this order "
            "(give nan to have it solved)"
        )
    return tuple(_value(model, name, values[name]) for name in inputs)


def _value(model: Model, name: str, given: Any) -> Value:
    if isinstance(given, str):
        if not is_symbol(given):
            hint = f"; give the number {given}, not a text" if _is_number(given) else ""
            raise TypeError(
                f"{given!r} is no value for {name}: a text is read as a symbol, and this is none{hint}"
            )
        if name in quantities(model):
            raise TypeError(f"{name} is a number, and {given!r} a symbol")
        return given.removeprefix("'")
    if not getattr(given, "ndim", 0) and _is_number(given):
        return float(given)
    kind = type(given).__name__
    hint = "; for columns of values call sweep" if hasattr(given, "__len__") else ""
    hint = "; to have it solved give nan" if given is None else hint
    raise TypeError(f"{name} takes a number (or a symbol), not {kind}{hint}")


def _is_number(given: Any) -> bool:
    if (
        isinstance(given, complex | bytes | bytearray)
        or getattr(getattr(given, "dtype", None), "kind", "") == "c"
    ):
        return False
    try:
        float(given)
    except (TypeError, ValueError, OverflowError):
        return False
    return True
