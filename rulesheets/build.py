"""A sheet and its used files as a model: parsed, checked, values evaluated, calls expanded."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias

from rulesheets.checks import Scope, check, check_figures, head_of
from rulesheets.diagnosis import (
    MAX_NAMED,
    Diagnosis,
    Label,
    RuleSheetError,
    Severity,
    closest,
    error,
    error_at,
    labels,
    refuse,
    side_by_side,
)
from rulesheets.evaluate.exact import with_round_values
from rulesheets.files import confined, is_sheet, near_files, outside, parsed, read_source
from rulesheets.inputs import declared, valued
from rulesheets.library import Library
from rulesheets.model import Equation, Model, Premise, Requirement, Variable
from rulesheets.registered import run_python
from rulesheets.syntax import Source, Span, nodes
from rulesheets.syntax.nodes import Number, names, rebuilt, walk
from rulesheets.syntax.program import Program, components, rules_of
from rulesheets.units import differences, library_of, unit_named


class File(NamedTuple):
    """A parsed file: ``key`` identifies it, ``folder`` is the base of its ``use`` paths."""

    key: str
    shown: str
    folder: str
    sheet: nodes.RuleSheet


def gather(
    source: Source,
    folder: str,
    path: str | None = None,
    within: str | None = None,
    python: bool = False,
) -> Program:
    """Parse a sheet and, each once, the files that it uses directly or through others.

    ``path`` is the file of the sheet itself, None for a text that is in no file; ``within`` the
    folder that used files must lie in; ``python``: files of Python may be run. Raises
    RuleSheetError for what cannot be read or parsed, circles and doubly defined functions.
    """
    key = os.path.realpath(path) if path else source.name
    found = _Gathering(File(key, source.name, folder, parsed(source, path)), within, python)
    refuse(found.complaints)
    return found.program


class _Gathering:
    """Depth-first search over the ``use`` lines."""

    def __init__(self, first: File, within: str | None, python: bool) -> None:
        self.program, self.within, self.python = Program(first.sheet), within, python
        self.complaints: list[Diagnosis] = []
        self.seen: set[str] = set()
        self.enter([first])

    def enter(self, trail: list[File]) -> None:
        """Add the last of these files, each of which uses the next, and the files it uses."""
        file = trail[-1]
        self.seen.add(file.key)
        self.program.units += (row for row in file.sheet.units if isinstance(row, nodes.UnitRow))
        for function in file.sheet.functions:
            earlier = self.program.functions.setdefault(function.name.lower(), function)
            if earlier is not function:
                message = f"the function {function.name} is defined twice"
                again = labels((head_of(function), "defined again"))
                first = labels((head_of(earlier), "first defined here"))
                note = "give one of the two another name (capitals do not count in function names)"
                self.complaints.append(error("E206", message, *again, *first, notes=(note,)))
        for use in file.sheet.uses:
            for path in use.paths:
                if use.python:
                    self.run(path, place_of(path, use), file)
                elif (used := self.open(path, place_of(path, use), trail)) is not None:
                    self.enter([*trail, used])

    def allows(self, path: str, shown: str, place: Span | None) -> bool:
        """Whether there is a file, in the folder that files must lie in; else a complaint."""
        if not confined(shown, self.within):
            self.complaints.append(outside(path, place))
        elif not os.path.exists(shown):
            message, label = f"there is no file {path} to use", f"looked for {shown}"
            notes = near_files(shown) or ("paths are relative to the file that names them",)
            self.complaints.append(error_at("E306", message, place, *notes, label=label))
        else:
            return True
        return False

    def run(self, path: str, place: Span | None, file: File) -> None:
        """Run a Python file that registers functions, if that is allowed."""
        shown = os.path.normpath(os.path.join(file.folder, path))
        if not self.python:
            message = f"the sheet needs the Python file {path}, which is not allowed to run"
            option = "--allow-python (allow_python=True in Python)"
            note = "a Python file can do anything that you can: read it, and if you trust it, give "
            note += option
            self.complaints.append(error_at("E313", message, place, note, label="named here"))
        elif self.allows(path, shown, place) and shown not in self.program.python:
            self.program.python.append(shown)
            try:
                run_python(shown)
            except RuleSheetError as wrong:
                used = labels((place, "used here"))
                self.complaints.extend(one._replace(labels=used) for one in wrong.diagnoses)

    def open(self, path: str, place: Span | None, trail: list[File]) -> File | None:
        """The file that a ``use`` names; None if it was read before or cannot be used."""
        shown = os.path.normpath(os.path.join(trail[-1].folder, path))
        key = self.program.links[shown] = os.path.realpath(shown)
        if not self.allows(path, shown, place):
            return None
        circle = [file.key for file in trail]
        if key in circle:
            names = [os.path.basename(file.shown) for file in trail[circle.index(key) :]]
            message = "files use each other in a circle" if names[1:] else "a file uses itself"
            ring = " → ".join((*names, names[0]))
            note = f"the circle is {ring}; move what both need into a file of its own"
            wrong = error_at("E307", message, place, note, label="closes the circle")
            self.complaints.append(wrong)
            return None
        if key in self.seen:
            return None
        try:
            source = read_source(shown)
        except RuleSheetError as wrong:
            used = labels((place, "used here"))
            told = (one._replace(labels=(*one.labels, *used)) for one in wrong.diagnoses)
            raise RuleSheetError(*told) from None
        self.program.texts.append(source)
        file = File(key, shown, os.path.dirname(shown), parsed(source, shown))
        self.complaints.extend(_only_functions(file, path, place))
        return file


def place_of(path: str, use: nodes.Use) -> Span | None:
    """The place of the path in a ``use`` line, quotes included."""
    start = use.span.text.find(f'"{path}"') if use.span is not None else -1
    return use.span if use.span is None or start < 0 else use.span.part(start, len(path) + 2)


def _only_functions(file: File, path: str, place: Span | None) -> Iterator[Diagnosis]:
    if (rule := next(rules_of(file.sheet), None)) is not None:
        found, where, label = "rules", rule.span, "a rule outside any function"
    elif file.sheet.figures:
        found, where, label = "figures", file.sheet.figures[0].span, "a figure"
    elif file.sheet.variables is not None:
        found, where, label = "a variables section", None, ""
    else:
        return
    places = labels((place, "used here"), (where if is_sheet(file.key) else None, label))
    note = "a used file may hold functions and units only; move them into a file of their own"
    yield error("E308", f"{path} cannot be used: it has {found} of its own", *places, notes=(note,))


def build(program: Program, name: str, files: tuple[str, ...] = ()) -> Model:
    """Check a program and expand it. Raises RuleSheetError with every complaint found."""
    scopes = check(program)
    inside = [node for scope in scopes.values() for node in scope.every]
    units = library_of(program.units)
    variables = declared(program.rows, units)
    refuse(_wrong_units(program, inside, units))
    expansion = Expansion(program)
    passed = _passed(scopes[""])
    # rows of the sheet, then names of its rules, then locals of the calls
    for local in (False, True):
        for full in expansion.names:
            if ("." in full) is local and full not in variables:
                variables[full] = Variable(full, posted=not local, passed=full in passed)
    python = tuple(map(os.path.abspath, program.python))
    model = Model(
        name=name,
        variables=variables,
        equations=tuple(expansion.equations),
        conditions=tuple(expansion.conditions),
        figures=program.sheet.figures,
        requirements=tuple(expansion.requirements),
        limits=program.limits,
        notes=(*_respelt(program, inside), *_misspelt(scopes, expansion.names), *_hidden(program)),
        files=(*files, *python),
        python=python,
        units=units,
    )
    if found := differences(model):  # of temperatures, which are converted as such
        for row in (row for row in program.rows if row.name in found):
            bare = replace(variables[row.name], difference=True)
            variables[row.name] = valued(bare, row)
        model = replace(model, variables=variables)
    refuse(check_figures(program, model.variables))
    return model


Nodes: TypeAlias = list[nodes.Expression | nodes.Condition]
"""All nodes of rules."""


def _wrong_units(program: Program, inside: Nodes, units: Library) -> Iterator[Diagnosis]:
    """Numbers of rules, and figures, whose units are unknown."""
    figures, word = program.sheet.figures, len("figure")
    written = [(one.unit, one.span and one.span.part(0, word)) for one in figures]
    written += ((one.unit, one.span) for one in inside if type(one) is Number and one.unit)
    for unit, place in written:
        try:
            unit_named(unit or "", place, units)
        except RuleSheetError as wrong:
            yield from wrong.diagnoses


def _respelt(program: Program, inside: Nodes) -> Iterator[Diagnosis]:
    """A note on the first ``Pi`` that is read as the number."""
    values = walk(*(row.value for row in program.rows if row.value is not None))
    for node in (*inside, *values):
        if type(node) is nodes.Call and node.function == "pi" and node.span is not None:
            name = node.span.text[:2]
            if name != "pi":
                message = f"{name} is read as pi, the number 3.14159…"
                yield Diagnosis("E219", Severity.NOTE, message, (Label(node.span),))
                return


def _misspelt(scopes: Mapping[str, Scope], read: Collection[str]) -> Iterator[Diagnosis]:
    """Notes on names without a row that are like a row: like one that no rule reads; or like any,
    where all other names have rows and this one stands in one rule only. In a function, notes on
    locals that are like an argument or a result that no rule of it reads."""
    for scope in scopes.values():
        rows, own = scope.declared, read
        told = "has no row under `variables`, where {} has one"
        if (function := scope.function) is not None:
            rows = (*function.arguments, *function.results)
            own = [name for name in scope.places if name not in function.parameters]
            told = f"is a local of {function.name}, where no rule reads {{}}"
        if function is None or not scope.places.keys() >= {*rows}:
            yield from _unlike(rows, own, scope, told)


def _unlike(
    rows: Sequence[str], read: Collection[str], scope: Scope, told: str
) -> Iterator[Diagnosis]:
    unread = [row for row in rows if row not in read]
    others = [name for name in read if name not in rows and "." not in name]
    for name in others if len(others) <= MAX_NAMED else ():
        alike = [row for row in rows if len(row) > 1 or len(name) == 1] if len(others) == 1 else ()
        sure = closest(name, unread)
        near = sure or closest(name, alike)
        if near and len({*side_by_side(name, {*rows, *read} - {name})}) < 2:
            uses = {part.span for part in scope.parts if name in part.names}
            if uses and (sure or len(uses) == 1):
                message, notes = f"{name} {told.format(near)}", (f"is {near} meant?",)
                place = labels((scope.place(name), ""))
                yield Diagnosis("E221", Severity.NOTE, message, place, notes)


def _hidden(program: Program) -> Iterator[Diagnosis]:
    """A note on the first comment behind ``;`` that reads as a rule."""
    spans = [row.span for row in program.rows]
    spans += [rule.span for rule in program.rules]
    for span in filter(None, spans):
        if found := _HIDDEN.match(span.source.text, span.end):
            message = f"`{found[1].strip()}` is read as a comment: it follows a `;`"
            place = Span(span.source, *found.span(1))
            note = "write it on a line of its own if it is a rule"
            yield Diagnosis("E220", Severity.NOTE, message, (Label(place),), (note,))
            return


_HIDDEN = re.compile(
    r"""[^\n;"]*;[ \t]*
    ([^\W\d]\w*[ \t]*=(?![^\n;"]*\w[ \t]+\w)[ \t]*(?:[\d.]|[^\n;"=]*[*/^+(])[^\n;"]*)""",
    re.VERBOSE,
)
"""An equation behind ``;``, whose right side is more than a name: ``; V = volume`` explains one."""


def _passed(sheet: Scope) -> set[str]:
    """Names that the sheet's own rules only pass from results of calls to arguments of others."""
    results, arguments, used = set[str](), set[str](), set[str]()
    functions = sheet.program.functions
    for part in sheet.parts if functions else ():
        if not isinstance(part, nodes.CallRule) or part.function.lower() not in functions:
            used.update(part.names)
            continue
        for passed, side in ((results, part.results), (arguments, part.arguments)):
            passed.update(node.name for node in side if isinstance(node, nodes.Name))
            others = (node for node in side if not isinstance(node, nodes.Name))
            used.update(names(*others))
    return (results & arguments) - used


# --- calls expanded -------------------------------------------------------------

_NOWHERE = Span(Source("<tree>", ""), 0, 0)


class FullNames(NamedTuple):
    """The names of one body of rules and their full names.

    ``bound`` maps arguments, results and parameters to full names; other names are local and get
    ``prefix``. ``counts`` numbers the calls of each function.
    """

    prefix: str
    bound: Mapping[str, str]
    counts: dict[str, int]

    def full_name(self, name: str) -> str:
        return self.bound.get(name) or self.prefix + name


class Context(NamedTuple):
    """The context of an expression: its scope, its premises, and the rule for messages."""

    scope: FullNames
    guard: tuple[Premise, ...]
    rule: Span


class Expansion:
    """The equations of a program that passed its checks: rules under full names, calls expanded.

    A call of a rule function stands for the rules of that function with their names bound:

    * an argument or a result whose actual is a plain variable *is* that variable;
    * any other actual gets a dotted variable and an equation (``f.a = AO/2``);
    * a parameter is the variable of that name in the calling scope;
    * every other name is local: ``f.name``, in the second call of f ``f#2.name``,
      in a call inside a call ``f.g.name``.

    Equations come rule by rule in source order, those of a call right after its rule.

    ``names`` are all variables that occur, in order of appearance, conditions included.
    """

    def __init__(self, program: Program) -> None:
        self.functions = program.functions
        self.equations: list[Equation] = []
        self.conditions: list[nodes.Condition] = []
        self.requirements: list[Requirement] = []
        self.names: dict[str, None] = {}
        self._called: list[tuple[nodes.Function, FullNames, tuple[Premise, ...]]] = []
        self._body(program.rules, FullNames("", {}, {}), ())
        for row in program.rows:  # the ends of ranges that name variables
            for bound in row.range:
                if any(names(bound.right)):
                    self.requirements.append(Requirement(bound, (), bound.span or _NOWHERE))

    def _body(
        self, rules: Iterable[nodes.Rule], scope: FullNames, guard: tuple[Premise, ...]
    ) -> None:
        """The rules of a sheet or a function, each followed by those of its calls."""
        for rule in rules:
            place = rule.span or rule.body.span or _NOWHERE
            self._expand(rule.body, Context(scope, guard, place))
            called, self._called = self._called, []
            for function, inside, premises in called:
                self._body(rules_of(function), inside, premises)

    def _expand(self, body: nodes.RuleBody, context: Context) -> None:
        """Expand one rule. A stack holds the remaining arms: ``else if`` chains do not recurse."""
        stack = [(body, context)]
        while stack:
            body, context = stack.pop()
            scope, guard, rule = context
            if self.functions or not (isinstance(body, nodes.Equality) and len(body.parts) == 2):
                # in the order of the text, whatever the order of the calls
                self.names |= dict.fromkeys(map(scope.full_name, body.names))
            for part in components(body, self.functions):
                match part:
                    case nodes.Equality((left, *_), (right, *_)):
                        one, other = self._bind(left, context), self._bind(right, context)
                        same = one is left and other is right
                        self._equate(one, other, context, part.names if same else None)
                    case nodes.CallRule(called, arguments, results, span):
                        function = self.functions.get(called.lower())
                        if function is not None:
                            self._call(function, arguments, results, context)
                        else:
                            sides = results[0], nodes.Call(called.lower(), arguments, span)
                            left, right = (self._bind(side, context) for side in sides)
                            self._equate(left, right, context)
                    case nodes.Inequality(comparisons):
                        for comparison in comparisons:
                            (bound,) = _exact(rule, self._bind(comparison, context))
                            self.requirements.append(Requirement(bound, guard, rule, scope.prefix))
                    case nodes.IfRule(condition, then, otherwise):
                        index = len(self.conditions)
                        self.conditions += _exact(rule, self._bind(condition, context))
                        for arm, holds in ((otherwise, False), (then, True)):
                            premises = (*guard, Premise(index, holds))
                            if arm is not None:
                                stack.append((arm, Context(scope, premises, rule)))

    def _call(
        self,
        function: nodes.Function,
        arguments: tuple[nodes.Expression, ...],
        results: tuple[nodes.Expression, ...] | None,
        context: Context,
    ) -> str:
        """Bind a call and record its body; return the full name of its first result.

        With ``results`` None (a call in an expression) the results are locals of the call.
        """
        caller, name = context.scope, function.name
        number = caller.counts[name] = caller.counts.get(name, 0) + 1
        prefix = f"{caller.prefix}{name}." if number == 1 else f"{caller.prefix}{name}#{number}."
        bound = {parameter: caller.full_name(parameter) for parameter in function.parameters}
        pairs = [*zip(function.arguments, arguments, strict=True)]
        if results is not None:
            pairs += zip(function.results, results, strict=True)
        for formal, actual in pairs:
            value = self._bind(actual, context)
            if isinstance(value, nodes.Name):
                bound[formal] = value.name
            else:
                bound[formal] = full = prefix + formal
                self.names.setdefault(full)
                self._equate(nodes.Name(full, actual.span), value, context)
        scope = FullNames(prefix, bound, {})
        self._called.append((function, scope, context.guard))
        return scope.full_name(function.results[0]) if function.results else ""

    def _equate(
        self,
        left: nodes.Expression,
        right: nodes.Expression,
        context: Context,
        read: tuple[str, ...] | None = None,
    ) -> None:
        """Add an equation; ``read`` are its names, if they are known."""
        scope, guard, rule = context
        left, right = _exact(rule, left, right)
        equation = Equation(len(self.equations), left, right, guard, rule, scope.prefix)
        if read is not None:
            equation.names = read
        self.equations.append(equation)
        self.names |= dict.fromkeys(equation.names)

    def _bind(self, node: Any, context: Context) -> Any:
        """A node with full names, and with calls of rule functions replaced by their results."""
        if not self.functions:
            return node
        if isinstance(node, nodes.Name | nodes.Given):
            full = context.scope.full_name(node.name)
            return node if full == node.name else type(node)(full, node.span)
        if isinstance(node, nodes.Call) and node.function in self.functions:
            result = self._call(self.functions[node.function], node.arguments, None, context)
            self.names.setdefault(result)
            return nodes.Name(result, node.span)
        parts = node.parts
        bound = []
        for part in parts:  # a loop, for one frame a level: trees may be hundreds of levels deep
            bound.append(self._bind(part, context))
        if all(new is old for new, old in zip(bound, parts, strict=True)):
            return node
        return rebuilt(node, tuple(bound))


def _exact(rule: Span, *parts: Any) -> Any:
    """Parts of a rule with exact values of its constants, if its text may have any."""
    text = (rule.text or "sin pi").lower()
    if "pi" not in text or not any(function in text for function in ("sin", "cos", "tan")):
        return parts
    return map(with_round_values, parts)
