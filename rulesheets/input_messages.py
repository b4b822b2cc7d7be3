"""What is said about values, inputs and variable sheets: the wording of their diagnoses, side by side."""

from __future__ import annotations

import math
import os

from rulesheets.diagnosis import Diagnosis, RuleSheetError, error, meant, said
from rulesheets.model import Model, Variable
from rulesheets.syntax import Span


def not_finite(reason: str, place: Span | None) -> Diagnosis:
    note = "give a finite number, or leave the value out to have it solved"
    return said("E402", f"this input has no finite value: {reason}", place, note)


def not_finite_number(number: float, variable: Variable) -> Diagnosis:
    return said("E402", f"{variable.name} = {number} is not finite", None, "give a finite number")


def outside_range(number: float, variable: Variable, place: Span | None) -> Diagnosis:
    message = f"{variable.name} = {number:.10g} lies outside its range {range_text(variable)}"
    return said("E403", message, place, "change the value, or the range in the variables section")


def symbol_for_number(symbol: str, variable: Variable, model: Model, place: Span | None = None) -> Diagnosis:
    ranged = math.isfinite(variable.low) or math.isfinite(variable.high)
    kind = f"that is {range_text(variable)}" if ranged else "that rules compute with"
    kind = f"in [{variable.unit}]" if variable.unit else kind
    message = f"{variable.name} is a number {kind}, and '{symbol} is a symbol"
    tied = ("to tie two variables together write a rule",) if symbol in model.variables else ()
    return said("E406", message, place, "give a number, or clear the input to have it solved", *tied)


def symbol_as_guess(symbol: str, place: Span | None) -> Diagnosis:
    message, note = f"a guess is a number, and '{symbol} is a symbol", "to give the symbol as an input write"
    return said("E404", message, place, f"{note} = '{symbol}")


def no_tolerance(symbol: bool, place: Span | None) -> Diagnosis:
    """A tolerance of a symbol, or one that is not a number from 0 on."""
    message = "a symbol has no tolerance" if symbol else "a tolerance is a number that is not negative"
    return said("E405", message, place, "write it as in = 3 ± 0.01, or = 3 ± 1%")


def guess_with_tolerance(place: Span | None) -> Diagnosis:
    note = "write the guess alone, or clear the G to make it an input"
    return said("E405", "a guess has no tolerance", place, note)


def range_text(variable: Variable) -> str:
    """``> 0``, ``<= 5`` or ``[0, 5]``, with round brackets at open ends."""
    low, high = f"{variable.low:.10g}", f"{variable.high:.10g}"
    if math.isinf(variable.low):
        return f"{'<' if variable.high_open else '<='} {high}"
    if math.isinf(variable.high):
        return f"{'>' if variable.low_open else '>='} {low}"
    return f"{'(' if variable.low_open else '['}{low}, {high}{')' if variable.high_open else ']'}"


def not_a_value(text: str, place: Span, reason: str = "") -> Diagnosis:
    message = f"{text or 'nothing'} is not a value" + (f": {reason}" if reason else "")
    note = "a value is a number (3, 1e-3), an expression of numbers (2*3), or a symbol ('open)"
    return said("E406", message, place, note)


def unknown_variable(name: str, model: Model, place: Span | None = None) -> Diagnosis:
    """The complaint about a name that the model does not have, with the name that may be meant."""
    return said("E407", f"{model.name} has no variable {name}", place, *meant(name, model.variables))


def unwritable(path: str, failure: OSError) -> Diagnosis:
    return error("E416", f"{path} cannot be written: {failure.strerror}", notes=("choose another place",))


def expect_regular(name: str) -> None:
    """Raise RuleSheetError (E304) for a pipe or a device: reading it may never end."""
    if os.path.exists(name) and not (os.path.isfile(name) or os.path.isdir(name)):
        message = f"{name} cannot be read: it is a pipe or a device, not a file"
        note = "a dash in place of the sheet reads it from standard input"
        raise RuleSheetError(said("E304", message, None, note))
