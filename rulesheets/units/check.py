"""Do the units of a model fit its rules? Dimensions first, then factors such as 1000.

A rule computes with readings in the units of its variables. With N, m and kg it needs no factor; if
one of them is in kN, it needs a factor of 1000. The check therefore compares the sizes of the units
of both sides, and accepts a difference that the numbers written in the rule explain. An empirical
formula, which holds only in its own units, is left out by a comment that begins with ``unchecked``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import chain, combinations, islice, product
from typing import NamedTuple

from rulesheets.checks import PLACES, marks_of
from rulesheets.diagnosis import Diagnosis, Label, Severity, listed
from rulesheets.evaluate import Undefined, derivatives
from rulesheets.format import format_expression
from rulesheets.functions import TABLE
from rulesheets.library import ANGLE, Unit, library
from rulesheets.model import Equation, Model, Variable
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
    Sum,
    calls,
    degree,
    exchange,
    names,
    walk,
)
from rulesheets.units import SYSTEMS
from rulesheets.units.dimensions import (
    RELATIVE,
    SIZE,
    Dimensions,
    Exponents,
    Mismatch,
    Statement,
    exponents,
    in_other_unit,
)

MOST, TRIED = 3, 8
"""Variables that a cure names at most, and how many are looked at."""
USUAL = (*SYSTEMS["si"].split(), "N-mm", "s", "min", "h", *SYSTEMS["us"].split())
"""Units that a cure proposes."""
NUMBER = "1 (a number)"
DERIVED = ("N", "J", "W", "Pa", "V", "ohm", "F", "C", "H", "T", "Hz", "m^2", "m^3", "m/s")


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
        chain = (statement, *(dimensions.statements[index] for index in found.why))
        curable = sure and found.factor is None and any(_curable(found, one) for one in chain)
        said.setdefault(place, None if curable else _diagnosis(model, dimensions, found))
    for unit, name in (("C", "coulomb"), ("F", "farad")):
        if hot := [v for v in model.variables.values() if v.unit == unit and _is_warm(v)]:
            said["", 0, len(said)] = _coulombs(hot, unit, name)
    warm = any((own := variable.measure) and own.offset for variable in model.variables.values())
    if warm:
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
    scales = [v.unit for v in model.variables.values() if v.measure and v.measure.offset]
    for name, variable in model.variables.items():
        form = None if variable.unit or not variable.posted else dimensions.known(name)
        if form is not None:
            # numbers in a rule may be factors between units: then only the kind is known
            blurred = math.isnan(form.sure.get(SIZE, 0.0)) and len(form.sure) > 1
            text = unit_text(form.sure)
            units[name] = "-" if text == NUMBER else f"{text}{' or a multiple' if blurred else ''}"
            if text == "K" and scales and not _DIFFERENCE.match(name.rpartition(".")[2]):
                units[name] = f"{scales[0]}, or K of a difference"
    return units


def inference(model: Model) -> Dimensions | None:
    """The dimensions that the rules of a model imply; None if it has no units."""
    units = {name: v.measure for name, v in model.variables.items() if v.measure is not None}
    if not units:
        return None
    values = {n: v.value for n, v in model.variables.items() if isinstance(v.value, float)}
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
    checked = [statement for statement in statements if not _unchecked(statement.place)]
    # an output of the kind of a variable in % may be in %, too
    parts = [size for unit in units.values() if (size := _part(exponents(unit)))]
    while True:
        dimensions = Dimensions(units, values, model.units)
        dimensions.infer(checked)
        free = ((n, dimensions.known(n)) for n in model.variables if n not in units)
        sizes = {name: _part(form.sure) for name, form in free if form is not None}
        numbers = [
            name
            for name, size in sizes.items()
            if size and (name in values or not any(abs(size - part) < RELATIVE for part in parts))
        ]
        if not numbers:
            return dimensions
        units |= dict.fromkeys(numbers, Unit())


def _part(known: Exponents) -> float | None:
    """The logarithm of a pure number other than 1: for it, a number without a unit would have to
    make up."""
    size = float(known[SIZE]) if known.keys() == {SIZE} else 0.0
    return size if abs(size) > RELATIVE else None


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
    nodes = walk(statement.left, statement.right)
    exponents = {id(node.exponent) for node in nodes if isinstance(node, Power)}
    numbers = (n for n in nodes if isinstance(n, Number) and id(n) not in exponents)
    found = dict.fromkeys(n.value for n in numbers if n.unit is None)
    usual = (0.5, 0.25, *map(float, range(-10, 11)))
    return [number for number in found if number not in usual]


def _curable(found: Mismatch, statement: Statement) -> bool:
    """Whether a unit of a constant of the rule, or of one that its units follow from, would resolve
    a mismatch, or it is a logarithm of a quantity."""
    logarithms = [Call(name, (found.left,)) for name in ("log", "log10") if found.right is None]
    nodes = walk(statement.left, statement.right)
    return bool(_constants(statement)) or any(node in logarithms for node in nodes)


# --- messages ---------------------------------------------------------------------------


def _is_warm(variable: Variable) -> bool:
    """Whether a variable has the name of a temperature."""
    return variable.span is not None and _WARM.fullmatch(variable.name) is not None


def _coulombs(hot: Sequence[Variable], unit: str, name: str) -> Diagnosis:
    """The warning about temperatures in a unit of electricity."""
    are = "are" if len(hot) > 1 else "is"
    message = f"{listed([v.name for v in hot])} {are} in {unit}, which is the {name}"
    labels = tuple(Label(v.span) for v in hot[:1] if v.span)
    return Diagnosis("W604", Severity.WARNING, message, labels, (f"write deg{unit}",))


def _diagnosis(model: Model, dimensions: Dimensions, found: Mismatch) -> Diagnosis:
    statement = dimensions.statements[found.statement]
    chain = dict.fromkeys(dimensions.statements[index].place.text for index in sorted(found.why))
    rules = [" ".join(rule.split()) for rule in chain if rule != statement.place.text]
    nodes = (found.left,) if found.right is None else (found.left, found.right)
    texts, units = [_shown(node, statement.place) for node in nodes], []
    for node, form in zip(nodes, found.forms, strict=False):
        units.append(_written(node, model) or unit_text(form.known if found.factor else form.sure))
    if found.counted != 1.0:  # numbers of the rule turn the unit of a side into another
        at = 0 if isinstance(found.right, Name) else 1
        known = found.forms[at].known
        size = float(known.get(SIZE, 0.0)) + (2 * at - 1) * math.log(found.counted)
        units[at] = unit_text({**known, SIZE: size})
    code, place = "W601", statement.place
    if found.factor is None:
        if found.right is not None:
            message = f"the units do not fit: {texts[0]} is in {units[0]}, {texts[1]} in {units[1]}"
        elif found.call is not None:
            message = f"{found.call.function} takes a number, and {texts[0]} is in {units[0]}"
        else:
            message = f"{texts[0]} must be a number, and its unit is {units[0]}"
        excluded = '" unchecked behind it excludes a formula that holds in its own units'
        cures = [*_constant(dimensions, found), f"correct the rule or a unit; {excluded}"]
        cures = [*_millikelvin(model, statement), *cures]
    elif found.call is not None and found.forms[1].known:
        code, place = "W602", found.call.span or place
        message, cures = _of_angle(found.call, found.factor, texts[0], units[0])
    else:
        change = _other_units(dimensions, found)
        message, cures = _of_factor(found, nodes, texts, units, change)
        shifted = {n for n, unit in dimensions.declared.items() if unit.offset}
        if found.forms[0].dimension == {"K": 1} and any(shifted & {*names(n)} for n in nodes):
            cures = ["give these temperatures in the same unit"]
    notes = [f"from {rule}" for rule in rules[:4]]
    return Diagnosis(code, Severity.WARNING, message, (Label(place),), (*cures, *notes))


def _of_factor(
    found: Mismatch,
    nodes: Sequence[Expression],
    texts: Sequence[str],
    units: Sequence[str],
    change: str | None,
) -> tuple[str, list[str]]:
    """``nodes``: the two sides, or what must be a number, as ``texts``; ``change`` of a unit."""
    factor = found.factor or 1.0
    if found.right is None:
        whose = f"{found.call.function} takes" if found.call else "an exponent is"
        return f"{whose} a number, and {texts[0]} is in {units[0]}", [change or "change a unit"]
    large, small = (0, 1) if factor > 1 else (1, 0)
    share = f"{max(factor, 1 / factor):.6g}"
    shown = list(units)
    for own, other, size in ((large, small, share), (small, large, f"{1 / float(share):.6g}")):
        if units[own][0].isdigit() and not units[other][0].isdigit():  # 1e+12 kg/(m·s^2)
            shown[own] = f"{size} {units[other]}"
    each = f"{texts[large]} is in {shown[large]}, {texts[small]} in {shown[small]}"
    factored = texts[large] if isinstance(nodes[large], Name) else f"({texts[large]})"
    written = f"write {share}*{factored}"
    cures = [f"{change}, or {written}" if change else f"{written}, or change a unit"]
    if any(
        _beside_number(node) for node in walk(*nodes) if isinstance(node, Sum)
    ):  # it counts in the other's unit
        cures = [change or "change a unit"]
    for side in nodes:
        if isinstance(side, Call) and (twin := in_other_unit(side.function)):
            cures = [f"write {twin} instead of {side.function}"]
    return f"{each}: a factor of {share} is missing", cures


def _of_angle(call: Call, factor: float, argument: str, unit: str) -> tuple[str, list[str]]:
    wanted = "deg" if TABLE[call.function].in_degrees else "rad"
    message = f"{call.function} takes an angle in {wanted}, and {argument} is in {unit}"
    cure = f"multiply it by {factor:.6g}"
    if math.isclose(max(factor, 1 / factor), 180 / math.pi, rel_tol=1e-9):
        cure = f"write {in_other_unit(call.function)}({argument})"
    return message, [f"{cure}, or give it in {wanted}"]


def _constant(dimensions: Dimensions, found: Mismatch) -> list[str]:
    """The unit of a constant of the rule that would resolve the mismatch, one that is no power of
    ten first."""
    statement, asked = dimensions.statements[found.statement], []
    sides, constants = (statement.left, statement.right), _constants(statement)
    others = [dimensions.statements[place] for place in sorted(found.why - {found.statement})]
    for leaf in dict.fromkeys(walk(*sides)):
        if isinstance(leaf, Number) and leaf.value in constants:
            open_ = Statement(statement.place, *(exchange(side, leaf, Name("#")) for side in sides))
            trial = dimensions.again([*others, open_])
            if trial.mismatches or (form := trial.known("#")) is None:
                continue
            plain = {base: e for base, e in form.known.items() if base != SIZE}
            texts = (unit_text(exponents) for exponents in (form.known, plain))
            asked.append((leaf, next((t for t in texts if not t[0].isdigit()), unit_text(plain))))
    asked.sort(key=lambda pair: math.log10(abs(pair[0].value)).is_integer())
    shown = [(_shown(leaf, statement.place), unit) for leaf, unit in asked[:1]]
    return [f"if {one} is a constant with a unit, write it: {one}[{unit}]" for one, unit in shown]


def _millikelvin(model: Model, statement: Statement) -> list[str]:
    """What to write for metre and kelvin, where a unit of the rule has ``mK``."""
    for leaf in walk(statement.left, statement.right):
        unit = leaf.unit if isinstance(leaf, Number) else None
        unit = model.variables[leaf.name].unit if isinstance(leaf, Name) else unit
        if unit and (apart := re.sub(r"\bmK\b", "m-K", unit)) != unit:
            return [f"mK is a millikelvin in {unit}; for metre times kelvin write {apart}"]
    return []


def _other_units(dimensions: Dimensions, found: Mismatch) -> str | None:
    """The variable of the rule, or of those that its units follow from, with a unit in which no
    factor is missing: a base unit, a usual one, or several variables in base units."""
    rules = [dimensions.statements[place] for place in sorted({*found.why, found.statement})]
    read = dict.fromkeys(n for s in rules for n in names(s.left, s.right))
    declared = {name: dimensions.declared.get(name) for name in islice(read, TRIED)}
    own = {name: unit for name, unit in declared.items() if unit and not unit.offset}
    bases = {name: _base(unit) for name, unit in own.items() if exponents(unit).get(SIZE)}
    usual = [(text, library().unit(text)) for text in USUAL]
    others = [
        {name: (text, unit)}
        for name, old in own.items()
        for text, unit in usual
        if unit.bases == old.bases and not unit.offset
    ]
    several = (combinations(bases.items(), count) for count in range(2, MOST + 1))
    for changed in chain(
        ({name: base} for name, base in bases.items()),
        others,
        map(dict, chain.from_iterable(several)),
    ):
        units = {name: unit for name, (_, unit) in changed.items()}
        if not dimensions.again(rules, units).mismatches:
            texts = (f"{name} {_given_in(text)}" for name, (text, _) in changed.items())
            return f"give {listed([*texts])}"
    return None


def _base(unit: Unit) -> tuple[str, Unit]:
    base = Unit(bases=unit.bases)
    return unit_text(exponents(base)), base


def _given_in(text: str) -> str:
    return "as a plain number" if text == NUMBER else f"in {text}"


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


def _beside_number(node: Sum) -> Expression | None:
    """The other term of a sum with a number: ``tax`` of ``1 - tax``."""
    match node.terms:
        case (Number(unit=None), other) | (other, Number(unit=None)):
            return other
    return None


def _shown(node: Expression, place: Span) -> str:
    """An expression of the rule at a place, as written there."""
    if node.span is None:
        return "the figure"
    return format_expression(node) if node.span == place else " ".join(node.span.text.split())


# --- the text of a unit -----------------------------------------------------------------


def unit_text(known: Exponents) -> str:
    """``kg·m/s²`` for exponents of base units, with their size; a usual unit where one fits."""
    size = float(known.get(SIZE, 0.0))
    aside = {SIZE, "dB"}
    if known.keys() - {*aside, ANGLE, "s"}:  # N·m·rad/s is W, and not W·rad
        aside.add(ANGLE)
    dimension = {base: e for base, e in known.items() if base not in aside}
    if not dimension:
        return NUMBER if math.isnan(size) or abs(size) < 1e-9 else f"{math.exp(size):.6g}"
    names = (*DERIVED, "deg", "rpm", "h", "min", *SYSTEMS["si"].split())
    for name in names:
        unit = exponents(library().unit(name))
        apart = float(unit.pop(SIZE, 0.0)) - (0.0 if math.isnan(size) else size)
        if unit == dimension and abs(apart) < RELATIVE * 1e-6 and not library().unit(name).offset:
            return name
    text = _shortest(dimension)
    return text if math.isnan(size) or abs(size) < 1e-9 else f"{math.exp(size):.6g} {text}"


def _shortest(dimension: Exponents) -> str:
    """Base units; of heat and electricity one derived unit or its reciprocal by base units, if
    these are fewer: ``K/W`` for ``s^3·K/(kg·m^2)``."""
    forms: list[Exponents] = [dimension]
    usual = not dimension.keys().isdisjoint({"K", "mol"}) or abs(dimension.get("s", 0)) == 3
    for name, power in product(("W", "J", "V", "ohm") if usual else (), (1, -1)):
        form = dict(dimension)
        for base, exponent in exponents(library().unit(name)).items():
            form[base] = form.get(base, 0) - power * exponent
        forms.append({name: power} | {base: e for base, e in form.items() if e})
    shortest = min(forms, key=lambda form: sum(map(abs, form.values())))
    above = [_power(base, e) for base, e in shortest.items() if e > 0]
    below = [_power(base, -e) for base, e in shortest.items() if e < 0]
    under = "·".join(below) if len(below) < 2 else f"({'·'.join(below)})"
    return ("·".join(above) or "1") + (f"/{under}" if below else "")


def _power(base: str, exponent: Fraction | int) -> str:
    if isinstance(exponent, Fraction) and exponent.denominator > 1:
        return f"{base}^({exponent})"
    return base if exponent == 1 else f"{base}^{exponent}"


_WARM = re.compile(r"[dD]?_?[tT](?:\d|_|[a-z]{0,3}\d*$|emp).*|LMTD|\w*[tT]emp\w*")
"""Names of temperatures."""
_DIFFERENCE = re.compile(r"(?:[dD]_?[Tt]|[dD]elta|Δ|LMTD|lmtd)")
"""The beginnings of names of differences, which decide if the rules do not."""
POINTS, TRIES = 3, 8
NOISE = 1e-9
"""Share of the slopes that may be left of their sum by rounding."""


class TemperatureRule(NamedTuple):
    """A rule with its slopes by temperatures, each by a kelvin, at some places."""

    equation: Equation
    slopes: tuple[dict[str, float], ...]

    def holds(self, differences: set[str]) -> bool:
        """Whether it still holds if all points shift together."""
        for row in self.slopes:
            moved = sum(slope for name, slope in row.items() if name not in differences)
            if abs(moved) > NOISE * sum(map(abs, row.values())):
                return False
        return True

    def points(self, differences: set[str]) -> list[str]:
        varied = {name for row in self.slopes for name, slope in row.items() if slope}
        return [name for name in self.slopes[0] if name in varied - differences]


class Weights:
    """``differences`` are the temperatures of a model that are differences of points of a scale.

    A law of nature does not depend on the zero of a scale: if all points in a rule shift by one
    kelvin and the differences stay, it still holds. ``dT = T1 - T2`` and ``Q = m*c*(T1 - T2)`` do
    so if dT is a difference; ``p*v = R*T`` does not, and needs an absolute temperature. This is
    decided by the slopes of a rule by its temperatures at a few places.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        measures = ((name, variable.measure) for name, variable in model.variables.items())
        self.units = {name: unit for name, unit in measures if unit and unit.bases == {"K": 1}}
        self.rules = [rule for rule in map(self._rule, model.equations) if rule is not None]
        marked = {n: model.variables[n].unit or "" for n in self.units}
        self.differences = {n for n, unit in marked.items() if "delta" in unit or "Δ" in unit}
        self.differences |= {n for n in marked if _DIFFERENCE.match(n.rpartition(".")[2])}
        denied: set[str] = set()  # some are called points by a rule: dTm = (T1 + T2)/2
        for rule in [rule for rule in self.rules if not rule.holds(self.differences)]:
            sides = [model.variables[s.name] for s in rule.equation.sides if isinstance(s, Name)]
            if any(side.measure is None for side in sides):  # it may be a temperature itself
                continue
            named = self.differences & rule.slopes[0].keys()
            denied.update(name for name in named if rule.holds(self.differences - {name}))
        self.differences -= denied
        for settle in (self._only_one, self._alone_on_a_side, self._of_differences, self._only_one):
            while sum(settle(rule) for rule in self.rules if not rule.holds(self.differences)):
                pass

    def _rule(self, equation: Equation) -> TemperatureRule | None:
        """The slopes of a rule; None if it has no temperature or no slopes."""
        here = [name for name in equation.names if name in self.units]
        rows = [TABLE.get(call.function) for call in calls(*equation.sides)]
        # a file's own Python is not run
        if not here or any(row is None or row.source for row in rows):
            return None
        found: list[dict[str, float]] = []
        for attempt in range(1, TRIES + 1):
            values = {n: 1 + 0.618 * attempt * k % 1 for k, n in enumerate(equation.names, 1)}
            try:
                _, left = derivatives(equation.left, values)
                _, right = derivatives(equation.right, values)
            except (Undefined, KeyError, ValueError, OverflowError):
                continue
            apart = {n: left.get(n, 0.0) - right.get(n, 0.0) for n in here}
            row = {n: slope / float(self.units[n].factor) for n, slope in apart.items()}
            if all(slope == slope for slope in row.values()):
                found.append(row)
            if len(found) == POINTS:
                break
        return TemperatureRule(equation, tuple(found)) if len(found) > 1 else None

    # --- differences ---

    def _candidates(self, rule: TemperatureRule) -> list[str]:
        """The points of which one is a difference, if the others are points."""
        points = rule.points(self.differences)
        held = (name for name in points if rule.holds(self.differences | {name}))
        return list(held) if len(points) > 2 else []

    def _only_one(self, rule: TemperatureRule) -> bool:
        found = self._candidates(rule)
        self.differences.update(found if len(found) == 1 else ())
        return len(found) == 1

    def _alone_on_a_side(self, rule: TemperatureRule) -> bool:
        """``dT = T1 - T2`` is taken as the definition of dT, though T2 might be the difference."""
        sides = rule.equation.sides
        found = [name for name in self._candidates(rule) if Name(name) in sides]
        self.differences.update(found[:1])
        return bool(found)

    def _of_differences(self, rule: TemperatureRule) -> bool:
        """``LMTD = (a - b)/ln(a/b)``: a value computed only from differences is one."""
        left, right = rule.equation.sides
        for side, other in ((left, right), (right, left)):
            rest = set(names(other)) & self.units.keys()
            plain = isinstance(side, Name) and rule.points(self.differences) == [side.name]
            if plain and rest and rest <= self.differences and not isinstance(other, Sum):
                self.differences.add(side.name)  # type: ignore[union-attr]
                return True
        return False

    # --- mistakes ---

    def warnings(self, sure: bool) -> Iterator[tuple[Equation, Diagnosis]]:
        """Points of °C and °F in rules that need absolute temperatures, and scales that differ."""
        for rule in self.rules:
            points = rule.points(self.differences)
            scaled = [name for name in points if self.units[name].offset]
            if not scaled or self._open(rule.equation):
                continue
            if rule.holds(self.differences):
                offset = self.units[scaled[0]].offset
                other = next((n for n in points if self.units[n].offset != offset), None)
                if other is None:
                    continue
                one, two = (self.model.variables[name].unit for name in (scaled[0], other))
                apart = abs(float(offset - self.units[other].offset))
                where = f"{scaled[0]} is in {one}, {other} in {two}"
                message = f"{where}: their zeros are {apart:.6g} K apart"
                note = "give both in one unit, or write the number between them"
            elif self._candidates(rule) or self._may_mean(rule, sure):
                continue
            else:
                unit, measure = self.model.variables[scaled[0]].unit, self.units[scaled[0]]
                # below that of the scale, in its degrees
                zero = float(measure.offset / measure.factor)
                needed = "an absolute temperature or a difference"
                message = f"{scaled[0]} is in {unit}, and this rule needs {needed}"
                advice = f"write {scaled[0]} + {zero:.6g}, or give it in K"
                note = f"{advice}; a difference of temperatures is in K, too"
            label = Label(rule.equation.rule)
            yield rule.equation, Diagnosis("W603", Severity.WARNING, message, (label,), (note,))

    def _open(self, equation: Equation) -> bool:
        """Whether something is added to a temperature: ``T + 273.15`` may be absolute."""
        sums = [part.terms for part in walk(*equation.sides) if isinstance(part, Sum)]
        for side, other in (equation.sides, (equation.right, equation.left)):
            sums += [(side, other)] if isinstance(side, Name) and side.name in self.units else []
        return any({0.0, 1.0} <= {degree(term, self.units) for term in terms} for terms in sums)

    def _may_mean(self, rule: TemperatureRule, sure: bool) -> bool:
        """Whether its points may cancel by another rule, as in ``m1*c*T1 + m2*c*T2 = m*c*T``, or it
        counts an energy from the zero of the scale, as in ``h = c*T``, which it may mean to (where
        ``sure``)."""
        sides = rule.equation.sides
        if max(degree(side, self.units) for side in sides) != 1.0:
            return False
        alone = (self.model.variables[side.name] for side in sides if isinstance(side, Name))
        units = [variable.measure for variable in alone]
        energy = any(unit is None or unit.bases.get("m") == 2 for unit in units)
        signs = {slope > 0.0 for slope in rule.slopes[0].values() if slope}
        return len(signs) == 2 or (sure and energy)
