"""Do the units of a model fit its rules? Dimensions first, then factors such as 1000.

A rule computes with readings in the units of its variables. With N, m and kg it needs no factor; if
one of them is in kN, it needs a factor of 1000. The check therefore compares the sizes of the units
of both sides, and accepts a difference that the numbers written in the rule explain. An empirical
formula, which holds only in its own units, is left out by a comment that begins with ``unchecked``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from rulesheets.checks import PLACES, marks_of
from rulesheets.diagnosis import Diagnosis, Label, Severity
from rulesheets.functions import TABLE
from rulesheets.library import library
from rulesheets.model import Model
from rulesheets.syntax import Span
from rulesheets.syntax.nodes import (
    Call,
    Comparison,
    Condition,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
)
from rulesheets.syntax.program import walk
from rulesheets.units import SYSTEMS
from rulesheets.units.dimensions import (
    RELATIVE,
    SIZE,
    Dimensions,
    Exponents,
    Mismatch,
    Powers,
    Statement,
    exponents,
    in_other_unit,
)

NUMBER = "1 (a number)"
DERIVED = ("N", "J", "W", "Pa", "V", "ohm", "F", "C", "Hz", "m^2", "m^3", "m/s")


def check_units(model: Model, sure: bool = False) -> tuple[Diagnosis, ...]:
    """Warnings about rules whose sides differ in dimension or by a factor.

    ``sure`` leaves out what may be right: a mismatch that the unit of a written constant would
    cure, and a common logarithm of a quantity, which is that of its reading (pH, decibels).
    """
    dimensions = inference(model)
    if dimensions is None:
        return ()
    said: dict[tuple[str, int, int], Diagnosis | None] = {}
    for found in dimensions.mismatches:
        statement = dimensions.statements[found.statement]
        place = statement.place.file, statement.place.start, statement.place.end
        curable = sure and found.factor is None and _curable(found, statement)
        said.setdefault(place, None if curable else _diagnosis(model, dimensions, found))
    warm = any((unit := variable.measure) and unit.offset for variable in model.variables.values())
    if warm:
        from rulesheets.units.temperatures import Weights

        for equation, warning in Weights(model).warnings(sure):
            rule = equation.rule
            if not _unchecked(rule):
                said.setdefault((rule.file, rule.start, rule.end), warning)
    ordered = map(said.get, sorted(said))
    return tuple(one for one in ordered if one is not None)


def inferred(model: Model) -> dict[str, str]:
    """The units that rules imply for variables of the sheet without a written unit."""
    dimensions = inference(model)
    if dimensions is None:
        return {}
    units = {}
    for name, variable in model.variables.items():
        form = None if variable.unit or not variable.posted else dimensions.known(name)
        if form is not None:
            # numbers in a rule may be factors between units: then only the kind is known
            blurred = math.isnan(form.sure.get(SIZE, 0.0)) and len(form.sure) > 1
            text = unit_text(form.sure)
            units[name] = "-" if text == NUMBER else f"{text}{' or a multiple' if blurred else ''}"
    return units


def inference(model: Model) -> Dimensions | None:
    """The dimensions that the rules of a model imply; None if it has no units."""
    units = {name: v.measure for name, v in model.variables.items() if v.measure is not None}
    if not units:
        return None
    values = {n: v.value for n, v in model.variables.items() if isinstance(v.value, float)}
    dimensions = Dimensions(units, values, model.units)
    statements = [Statement(one.rule, one.left, one.right) for one in model.equations]
    compared: list[tuple[Condition, Span | None]] = []
    compared += ((one.comparison, one.rule) for one in model.requirements)
    compared += ((condition, None) for condition in model.conditions)
    for condition, place in compared:
        for node in walk(condition):
            span = place or node.span
            if isinstance(node, Comparison) and span is not None:
                statements.append(Statement(span, node.left, node.right))
    for figure in model.figures:
        for mark in marks_of(figure):  # coordinates
            if figure.unit and mark.kind in PLACES and mark.span is not None:
                unit = Number(1.0, unit=figure.unit)
                statements += [Statement(mark.span, part, unit) for part in mark.arguments]
    dimensions.infer([statement for statement in statements if not _unchecked(statement.place)])
    return dimensions


def _unchecked(place: Span) -> bool:
    """Whether the comment after a rule excludes it."""
    text, end = place.source.text, place.end
    if '"' not in text[end : end + 80]:
        return False
    line = text[end : (text + "\n").index("\n", end)]
    return line.strip().lower().startswith(('"unchecked', '" unchecked'))


# --- what may be right ------------------------------------------------------------------


def _constants(statement: Statement) -> list[float]:
    """Written numbers that may have a unit: 9.81, 8.314 and 3600, but not 2, 1/2 or exponents."""
    nodes = [*walk(statement.left, statement.right)]
    exponents = {id(node.exponent) for node in nodes if isinstance(node, Power)}
    numbers = (n for n in nodes if isinstance(n, Number) and id(n) not in exponents)
    found = dict.fromkeys(n.value for n in numbers if n.unit is None)
    usual = (0.5, 0.25, *map(float, range(-10, 11)))
    return [number for number in found if number not in usual]


def _curable(found: Mismatch, statement: Statement) -> bool:
    """Whether a unit of a constant would resolve a mismatch, or it is a logarithm of a quantity."""
    logarithms = [Call(name, (found.left,)) for name in ("log", "log10") if found.right is None]
    nodes = walk(statement.left, statement.right)
    return bool(_constants(statement)) or any(node in logarithms for node in nodes)


# --- messages ---------------------------------------------------------------------------


def _diagnosis(model: Model, dimensions: Dimensions, found: Mismatch) -> Diagnosis:
    statement = dimensions.statements[found.statement]
    chain = dict.fromkeys(dimensions.statements[index].place.text for index in sorted(found.why))
    rules = [" ".join(rule.split()) for rule in chain if rule != statement.place.text]
    nodes = (found.left,) if found.right is None else (found.left, found.right)
    texts, units = [_shown(node, statement.place) for node in nodes], []
    for node, form in zip(nodes, found.forms, strict=False):
        units.append(_written(node, model) or unit_text(form.known if found.factor else form.sure))
    code, place = "W601", statement.place
    if found.factor is None:
        if found.right is not None:
            message = f"the units do not fit: {texts[0]} is in {units[0]}, {texts[1]} in {units[1]}"
        elif found.call is not None:
            message = f"{found.call.function} takes a number, and {texts[0]} is in {units[0]}"
        else:
            message = f"{texts[0]} must be a number, and its unit is {units[0]}"
        excluded = '" unchecked behind it excludes a formula that holds in its own units'
        cures = [*_constant(found, statement), f"correct the rule or a unit; {excluded}"]
    elif found.call is not None:
        code, place = "W602", found.call.span or place
        message, cures = _of_angle(found.call, found.factor, texts[0], units[0])
    else:
        large, small = (0, 1) if found.factor > 1 else (1, 0)
        share = f"{max(found.factor, 1 / found.factor):.6g}"
        each = f"{texts[large]} is in {units[large]}, {texts[small]} in {units[small]}"
        message = f"{each}: a factor of {share} is missing"
        shown = texts[large] if isinstance(nodes[large], Name) else f"({texts[large]})"
        cures = [f"write {share}*{shown}, or change a unit"]
        for side in nodes:
            if isinstance(side, Call) and (twin := in_other_unit(side.function)):
                cures = [f"write {twin} instead of {side.function}"]
    notes = [f"from {rule}" for rule in rules[:4]]
    return Diagnosis(code, Severity.WARNING, message, (Label(place),), (*cures, *notes))


def _of_angle(call: Call, factor: float, argument: str, unit: str) -> tuple[str, list[str]]:
    wanted = "deg" if TABLE[call.function].in_degrees else "rad"
    message = f"{call.function} takes an angle in {wanted}, and {argument} is in {unit}"
    cure = f"multiply it by {factor:.6g}"
    if math.isclose(max(factor, 1 / factor), 180 / math.pi, rel_tol=1e-9):
        cure = f"write {in_other_unit(call.function)}({argument})"
    return message, [f"{cure}, or give it in {wanted}"]


def _constant(found: Mismatch, statement: Statement) -> list[str]:
    """The unit of a constant of the rule that would resolve the mismatch."""
    if found.right is None:
        return []
    one, other = (Powers(form.dimension) for form in found.forms)
    for side, missing in ((found.left, other.plus(one, -1)), (found.right, one.plus(other, -1))):
        for number, power in _factors_of(side):
            if number.unit is None and number.value in _constants(statement):
                shown = _shown(number, statement.place)
                unit = unit_text(missing.times(1 / power).known)
                return [f"if {shown} is a constant with a unit, write it: {shown}[{unit}]"]
    return []


def _written(node: Expression, model: Model) -> str | None:
    """The unit of an expression, written with the units of its variables if that is short."""
    match node:
        case Name(name):
            return model.variables[name].unit
        case Number(unit=str(unit)):
            return unit
        case (
            Product(Number(unit=None), inner) | Quotient(inner, Number(unit=None)) | Negative(inner)
        ):
            return _written(inner, model)
        case Product(left, right):
            parts = _written(left, model), _written(right, model)
            plain = all(part is not None and "/" not in part for part in parts)
            return f"{parts[0]}·{parts[1]}" if plain and parts[0] != parts[1] else None
        case _:
            return None


def _factors_of(
    node: Expression, power: Fraction = Fraction(1)
) -> Iterator[tuple[Number, Fraction]]:
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


def _shown(node: Expression, place: Span) -> str:
    """An expression of the rule at a place, as written there."""
    if node.span is None:
        return "the figure"
    from rulesheets.format import format_expression  # a message alone needs it

    return format_expression(node) if node.span == place else " ".join(node.span.text.split())


# --- the text of a unit -----------------------------------------------------------------


def unit_text(known: Exponents) -> str:
    """``kg·m/s²`` for exponents of base units, with their size; a usual unit where one fits."""
    size = float(known.get(SIZE, 0.0))
    dimension = {base: e for base, e in known.items() if base not in (SIZE, "dB")}
    if not dimension:
        return NUMBER if math.isnan(size) or abs(size) < 1e-9 else f"{math.exp(size):.6g}"
    names = (*DERIVED, "deg", "rpm", "h", "min", *SYSTEMS["si"].split())
    for name in names:
        unit = exponents(library().unit(name))
        apart = float(unit.pop(SIZE, 0.0)) - (0.0 if math.isnan(size) else size)
        if unit == dimension and abs(apart) < RELATIVE * 1e-6 and not library().unit(name).offset:
            return name
    above = [_power(base, e) for base, e in dimension.items() if e > 0]
    below = [_power(base, -e) for base, e in dimension.items() if e < 0]
    under = "·".join(below) if len(below) < 2 else f"({'·'.join(below)})"
    text = ("·".join(above) or "1") + (f"/{under}" if below else "")
    return text if math.isnan(size) or abs(size) < 1e-9 else f"{math.exp(size):.6g} {text}"


def _power(base: str, exponent: Fraction | int) -> str:
    if isinstance(exponent, Fraction) and exponent.denominator > 1:
        return f"{base}^({exponent})"
    return base if exponent == 1 else f"{base}^{exponent}"
