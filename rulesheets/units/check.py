"""Do the units of a model fit its rules? Dimensions first, then factors such as 1000.

A rule computes with readings in the units of its variables. Where these are N, m and kg it needs no factor;
where one is kN, a factor of 1000 must stand in it. The check therefore compares the scales of both sides and
excuses a difference that the numbers written in the rule explain. An empirical formula, which is right in its
own units alone, is left out by a comment that begins with ``unchecked``.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction

from rulesheets.diagnosis import Diagnosis, Label, Severity
from rulesheets.model import Equation, Model
from rulesheets.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Product,
    Quotient,
    bare,
    children,
    numbers,
)
from rulesheets.units.dimensions import Dimensions, Exponents, Form, Mismatch
from rulesheets.units.library import library
from rulesheets.units.scales import alike, explained, scale
from rulesheets.units.unit import Unit

DEGREES = {"sind": "sin", "cosd": "cos", "tand": "tan"}
LARGEST_COUNT = 10
"""Integers up to this are counts and factors of formulas (`m*v^2/2`), not constants that have a unit."""
RADIANS = {radian: degree for degree, radian in DEGREES.items()}


def check_units(model: Model, sure: bool = False) -> tuple[Diagnosis, ...]:
    """Warnings about rules whose sides differ in dimension or by a factor; none for a model without units.

    ``sure`` leaves out what may be right: a mismatch that the unit of a written constant would cure, and a
    common logarithm of a quantity, which is that of its reading (pH, decibels).
    """
    units = {n: library().unit(v.unit) for n, v in model.variables.items() if v.unit}
    if not units:
        return ()
    checked = [e for e in model.equations if not _unchecked(e)]
    given = {n: v.value for n, v in model.variables.items() if isinstance(v.value, float)}
    dimensions = Dimensions({name: unit.dimension for name, unit in units.items()}, given)
    dimensions.infer((e.index, e.left, e.right) for e in checked)
    said: dict[tuple[int, int], Diagnosis] = {}
    skipped: set[tuple[int, int]] = set()
    for mismatch in dimensions.mismatches:
        equation = model.equations[mismatch.equation]
        if sure and _curable(mismatch, equation):
            skipped.add((equation.rule.start, equation.rule.end))
            continue
        said.setdefault((equation.rule.start, equation.rule.end), _mismatch(mismatch, model))
    for equation in checked:
        place = (equation.rule.start, equation.rule.end)
        found = next(_factors(equation, units), None) if place not in said and place not in skipped else None
        if found is not None:
            said[place] = found
    return tuple(said[place] for place in sorted(said))


def _unchecked(equation: Equation) -> bool:
    """Whether the comment behind a rule says so."""
    text, end = equation.rule.source.text, equation.rule.end
    return (
        text[end : (text + "\n").index("\n", end)].strip().lower().startswith(('"unchecked', '" unchecked'))
    )


# --- dimensions -------------------------------------------------------------------------


def _constants(equation: Equation) -> list[float]:
    """Written numbers that may well have a unit: 9.81, 8.314 and 3600, but not 2 or 1/2."""
    written = dict.fromkeys(
        n.value for side in (equation.left, equation.right) for n in numbers(side) if n.unit is None
    )
    return [n for n in written if not (n.is_integer() and abs(n) <= LARGEST_COUNT) and n not in (0.5, 0.25)]


def _curable(found: Mismatch, equation: Equation) -> bool:
    """Whether the unit of a constant would cure a mismatch, or it is a common logarithm of a quantity."""
    if _constants(equation):
        return True
    return found.right is None and any(
        call.function in ("log", "log10") and call.arguments == (found.left,) for call in _calls(equation)
    )


def _mismatch(found: Mismatch, model: Model) -> Diagnosis:
    equation = model.equations[found.equation]
    left = unit_text(found.left_exponents)
    if found.right is None:
        message = f"{_shown(found.left)} must be a number, and its unit is {left}"
    else:
        right = unit_text(found.right_exponents)
        message = f"the units do not fit: {_shown(found.left)} is in {left}, {_shown(found.right)} in {right}"
    chain = sorted(index for index in found.why if index != found.equation)
    notes = tuple(f"from {model.equations[index].rule.text}" for index in chain[:4])
    cure = 'correct the rule or a unit; write " unchecked behind a formula that holds in its own units alone'
    return _warning(equation, message, (*notes, *_units_of_constants(found, equation), cure))


def _units_of_constants(found: Mismatch, equation: Equation) -> tuple[str, ...]:
    """The unit that would make the mismatch go away, if a constant of the rule had it."""
    if found.right is None:
        return ()
    for side, wanted, given in (
        (found.left, found.right_exponents, found.left_exponents),
        (found.right, found.left_exponents, found.right_exponents),
    ):
        for number, power in _factors_of(side):
            if number.unit is None and number.value in _constants(equation):
                missing = Form(wanted).plus(Form(given), Fraction(-1)).times(1 / power).known
                shown = _shown(number)
                return (f"if {shown} is a constant with a unit, write it: {shown}[{unit_text(missing)}]",)
    return ()


def _factors_of(node: Expression, power: Fraction = Fraction(1)) -> Iterator[tuple[Number, Fraction]]:
    """Numbers that multiply or divide an expression, each with its exponent."""
    match node:
        case Number():
            yield node, power
        case Negative(operand):
            yield from _factors_of(operand, power)
        case Product(left, right):
            yield from (*_factors_of(left, power), *_factors_of(right, power))
        case Quotient(left, right):
            yield from (*_factors_of(left, power), *_factors_of(right, -power))
        case Call("sqrt", (argument,)):
            yield from _factors_of(argument, power / 2)


def _warning(equation: Equation, message: str, notes: tuple[str, ...]) -> Diagnosis:
    return Diagnosis("W601", Severity.WARNING, message, (Label(equation.rule),), notes)


def _shown(node: Expression) -> str:
    span = node.span
    return "this" if span is None else " ".join(span.text.split())


def unit_text(exponents: Exponents) -> str:
    """``kg·m/s²`` for exponents of base units; the name of a derived unit where one fits."""
    if not exponents:
        return "1 (a number)"
    for name in ("N", "J", "W", "Pa", "V", "ohm", "F", "C", "Hz"):
        if library().unit(name).dimension == exponents:
            return name
    above = [_power(base, e) for base, e in exponents.items() if e > 0]
    below = [_power(base, -e) for base, e in exponents.items() if e < 0]
    under = "·".join(below) if len(below) < 2 else f"({'·'.join(below)})"
    return ("·".join(above) or "1") + (f"/{under}" if below else "")


def _power(base: str, exponent: Fraction) -> str:
    if exponent.denominator > 1:
        return f"{base}^({exponent})"
    return base if exponent == 1 else f"{base}^{exponent}"


# --- factors ------------------------------------------------------------------------------


def _factors(equation: Equation, units: Mapping[str, Unit]) -> Iterator[Diagnosis]:
    """The first place of a rule where scales differ, and no number in the rule explains by how much."""
    written = sorted(
        {abs(n.value) for side in (equation.left, equation.right) for n in numbers(side) if n.unit is None}
    )
    for one, other in (*alike(equation.left), *alike(equation.right), (equation.left, equation.right)):
        first, second = scale(one, units), scale(other, units)
        if bare(one) or bare(other) or first is None or second is None or explained(first / second, written):
            continue
        share = first / second if first > second else second / first
        message = f"{_shown(one)} and {_shown(other)} differ by a factor of {share:.6g} in their units"
        yield _warning(equation, message, (f"multiply by {share:.6g} where it is missing, or change a unit",))
    for call in _calls(equation):
        yield from _angle(equation, call, units)


# --- angles -------------------------------------------------------------------------------


def _calls(equation: Equation) -> Iterator[Call]:
    stack: list[Expression] = [equation.left, equation.right]
    while stack:
        node = stack.pop()
        if isinstance(node, Call):
            yield node
        stack.extend(children(node))  # type: ignore[arg-type]


def _angle(equation: Equation, call: Call, units: Mapping[str, Unit]) -> Iterator[Diagnosis]:
    """``sin`` of a variable in degrees, ``sind`` of one in radians."""
    other = DEGREES.get(call.function) or RADIANS.get(call.function)
    argument = call.arguments[0] if call.arguments else None
    if other is None or not isinstance(argument, Name):
        return
    unit = units.get(argument.name)
    wanted = "deg" if call.function in DEGREES else "rad"
    if unit is None or unit.bases != {"rad": 1} or unit == library().unit(wanted):
        return
    message = f"{call.function} takes an angle in {wanted}, and {argument.name} is in another unit"
    place = call.span or equation.rule
    notes = (f"write {other}({argument.name}), or give it in {wanted}",)
    yield Diagnosis("W602", Severity.WARNING, message, (Label(place),), notes)
