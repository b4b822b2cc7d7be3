"""A sheet and the files that it uses to a model: checked, its values evaluated, its calls expanded.

A call of a rule function stands for the rules of that function with their names bound:

* an argument or a result whose actual is a plain variable *is* that variable;
* any other actual gets a dotted variable and an equation (``f.a = AO/2``);
* a parameter is the variable of that name in the calling scope;
* every other name is local: ``f.name``, in the second call of f ``f#2.name``,
  in a call inside a call ``f.g.name``.

Equations come rule by rule in source order, those of a call right after the rule that
calls. Bodies of calls are worked off a stack, so that only the nesting of one rule recurses.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any, NamedTuple

from rulesheets.checks import check, head_of
from rulesheets.checks.marks import check_figures
from rulesheets.diagnosis import Diagnosis, Label, RuleSheetError, Severity, error, labels, refuse, said
from rulesheets.evaluate.number import with_round_values
from rulesheets.files import confined, is_sheet, near_files, outside, parsed, read_source
from rulesheets.inputs import declared, valued
from rulesheets.library import Library
from rulesheets.model import Equation, Model, Premise, Requirement, Variable
from rulesheets.registered import run_python
from rulesheets.syntax import Source, Span, nodes
from rulesheets.syntax.forms import Form, Like, like_of
from rulesheets.syntax.nodes import Number, children, leaves, measured, names, rebuilt
from rulesheets.syntax.program import Program, bodies, components, names_of, rules_of, walk
from rulesheets.units import differences, library_of, unit_named

_MEASURE = re.compile(r"\[(?<=[\d.]\[)")  # a pattern that begins with a certain character is found fast
_PI = re.compile("P[iI]")


class File(NamedTuple):
    """A parsed file: ``key`` tells it from others, ``folder`` is what its ``use`` paths are relative to."""

    key: str
    shown: str
    folder: str
    sheet: nodes.RuleSheet


def gather(
    source: Source, folder: str, path: str | None = None, within: str | None = None, python: bool = False
) -> Program:
    """Parse a sheet and, each once, the files that it uses directly or through others.

    ``path`` is the file of the sheet itself, None for a text that is in no file; ``within`` the folder
    that used files must lie in; ``python``: files of Python may be run. Raises RuleSheetError for what
    cannot be read or parsed, circles and doubly defined functions.
    """
    key = os.path.realpath(path) if path else source.name
    found = _Gathering(File(key, source.name, folder, parsed(source, path)), within, python)
    refuse(found.complaints)
    return found.program


class _Gathering:
    """Depth-first over the uses, with a stack, so that no chain of files is too long."""

    def __init__(self, first: File, within: str | None, python: bool) -> None:
        self.program, self.within, self.python = Program(first.sheet), within, python
        self.complaints: list[Diagnosis] = []
        self.seen: set[str] = set()
        trail = [first]
        pending = [self.enter(first)]
        while trail:
            step = next(pending[-1], None)
            if step is None:
                trail.pop()
                pending.pop()
            elif (file := self.open(*step, trail)) is not None:
                trail.append(file)
                pending.append(self.enter(file))

    def enter(self, file: File) -> Iterator[tuple[str, Span | None]]:
        self.seen.add(file.key)
        self.program.units += (row for row in file.sheet.units if isinstance(row, nodes.UnitRow))
        for function in file.sheet.functions:
            earlier = self.program.functions.setdefault(function.name.lower(), function)
            if earlier is not function:
                message = f"the function {function.name} is defined twice"
                places = (head_of(function), "defined again"), (head_of(earlier), "first defined here")
                note = "give one of the two another name (capitals do not count in function names)"
                self.complaints.append(error("E206", message, *labels(*places), notes=(note,)))
        uses = [(path, place_of(path, use), use.python) for use in file.sheet.uses for path in use.paths]
        for path, place, python in uses:
            if python:
                self.run(path, place, file)
        return ((path, place) for path, place, python in uses if not python)

    def run(self, path: str, place: Span | None, file: File) -> None:
        """Run a file of Python that registers functions, if that is allowed."""
        shown = os.path.normpath(os.path.join(file.folder, path))
        if not self.python:
            message = f"the sheet needs the Python file {path}, which is not allowed to run"
            note = (
                "a Python file can do anything that you can: read it, and if you trust it, give "
                "--allow-python (allow_python=True in Python)"
            )
            self.complaints.append(said("E313", message, place, note, label="named here"))
        elif not confined(shown, self.within):
            self.complaints.append(outside(path, place))
        elif not os.path.exists(shown):
            self.complaints.append(_missing(path, shown, place))
        elif shown not in self.program.python:
            self.program.python.append(shown)
            try:
                run_python(shown)
            except RuleSheetError as wrong:
                used = labels((place, "used here"))
                self.complaints.extend(one._replace(labels=used) for one in wrong.diagnoses)

    def open(self, path: str, place: Span | None, trail: list[File]) -> File | None:
        """The file that a ``use`` names; None where it was read before or cannot be used."""
        shown = os.path.normpath(os.path.join(trail[-1].folder, path))
        key = self.program.links[shown] = os.path.realpath(shown)
        if not confined(shown, self.within):
            self.complaints.append(outside(path, place))
            return None
        circle = [file.key for file in trail]
        if key in circle:
            names = [os.path.basename(file.shown) for file in trail[circle.index(key) :]]
            message = "a file uses itself" if len(names) == 1 else "files use each other in a circle"
            ring = " → ".join((*names, names[0]))
            note = f"the way round: {ring}; move what both need into a file of its own"
            self.complaints.append(said("E307", message, place, note, label="closes the circle"))
            return None
        if key in self.seen:
            return None
        if not os.path.exists(shown):
            self.complaints.append(_missing(path, shown, place))
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
    """Where a ``use`` names the path, quotes included."""
    start = use.span.text.find(f'"{path}"') if use.span is not None else -1
    return use.span if use.span is None or start < 0 else use.span.part(start, len(path) + 2)


def _missing(path: str, shown: str, place: Span | None) -> Diagnosis:
    notes = near_files(shown) or ("paths are relative to the file that names them",)
    return said("E306", f"there is no file {path} to use", place, *notes, label=f"looked for {shown}")


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
    check(program)
    units = library_of(program.units)
    variables = declared(program.rows, units)
    refuse(_wrong_units(program, units))
    expansion = Expansion(program)
    passed = _passed(program)
    for local in (False, True):  # rows of the sheet, then names of its rules, then locals of the calls
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
        notes=tuple(_respelt(program)),
        files=(*files, *python),
        python=python,
        units=units,
    )
    if found := differences(model):  # of temperatures, which are converted as such
        rows = (row for row in program.rows if row.name in found)
        changed = {row.name: valued(replace(model.variables[row.name], difference=True), row) for row in rows}
        model = replace(model, variables={**model.variables, **changed})
    refuse(check_figures(program, model.variables))
    return model


def _rule_parts(program: Program, said: re.Pattern[str]) -> list[nodes.Expression | nodes.Condition]:
    """The expressions of all rules, where a source of the program has what the pattern matches."""
    owners: list[nodes.RuleSheet | nodes.Function] = [program.sheet, *program.functions.values()]
    sources = dict.fromkeys(owner.span.source for owner in owners if owner.span is not None)
    if not any(said.search(source.text) for source in sources):
        return []
    rules = (rule for owner in owners for rule in rules_of(owner))
    return [part for rule in rules for body in bodies(rule.body) for part in children(body)]


def _wrong_units(program: Program, units: Library) -> Iterator[Diagnosis]:
    """Numbers of rules, and figures, whose units are unknown."""
    figures = ((one.unit, one.span and one.span.part(0, len("figure"))) for one in program.sheet.figures)
    numbers = (one for part in _rule_parts(program, _MEASURE) for one in leaves(part, Number))
    for unit, place in (*figures, *((one.unit, one.span) for one in numbers)):
        try:
            unit_named(unit or "", place, units)
        except RuleSheetError as wrong:
            yield from wrong.diagnoses


def _respelt(program: Program) -> Iterator[Diagnosis]:
    """A note on the first ``Pi``, which is read as the number."""
    parts = _rule_parts(program, _PI)
    if not parts:
        return
    parts += [row.value for row in program.rows if row.value is not None]
    for node in (node for part in parts for node in walk(part)):
        if isinstance(node, nodes.Call) and node.function == "pi" and node.span is not None:
            name = node.span.text[:2]
            if name != "pi":
                message = f"{name} is read as pi, the number 3.14159…"
                yield Diagnosis("E219", Severity.NOTE, message, (Label(node.span),))
                return


def _passed(program: Program) -> set[str]:
    """Names that the sheet's own rules only pass from the results of one call to the arguments of another."""
    if not program.functions:
        return set()
    found: tuple[set[str], set[str], set[str]] = set(), set(), set()
    by_form: dict[Form, tuple[set[int], ...]] = {}
    for rule in rules_of(program.sheet):
        for body in bodies(rule.body):
            if (like := getattr(body, "like", None)) is None:
                roles: Iterable[Iterable[str]] = _roles(body, program.functions)
            else:
                if like.form not in by_form:
                    of_first = _roles(like.form.numbered(), program.functions)
                    by_form[like.form] = tuple([{int(name) for name in role} for role in of_first])
                every = [like.names[place] for place in like.pattern] if like.pattern else like.names
                roles = ([every[place] for place in role] for role in by_form[like.form])
            for known, role in zip(found, roles, strict=True):
                known.update(role)
    results, arguments, used = found
    return (results & arguments) - used


def _roles(
    body: nodes.RuleBody, functions: Mapping[str, nodes.Function]
) -> tuple[set[str], set[str], set[str]]:
    """The names that a rule has as results of calls, as arguments, and otherwise than in rule functions."""
    results, arguments, used = set[str](), set[str](), set[str]()
    for part in components(body, functions):
        is_call = isinstance(part, nodes.CallRule) and part.function.lower() in functions
        if isinstance(part, nodes.CallRule):
            results.update(n.name for n in part.results if isinstance(n, nodes.Name))
            arguments.update(n.name for n in part.arguments if isinstance(n, nodes.Name))
        rest = (n for n in children(part) if not (is_call and isinstance(n, nodes.Name)))
        used.update(name for node in rest for name in names(node))
    return results, arguments, used


# --- calls expanded ------------------------------------------------------------

_NOWHERE = Span(Source("<tree>", ""), 0, 0)


class Scope(NamedTuple):
    """Names of one body of rules on their way to full names.

    ``bound`` maps arguments, results and parameters to full names; what is not in it is
    local and gets ``prefix``. ``counts`` numbers the calls of each function.
    """

    prefix: str
    bound: Mapping[str, str]
    counts: dict[str, int]

    def full_name(self, name: str) -> str:
        return self.bound.get(name) or self.prefix + name


class Context(NamedTuple):
    """Where an expression stands: its scope, its premises and the rule that complaints and places name."""

    scope: Scope
    guard: tuple[Premise, ...]
    rule: Span


class Piece(NamedTuple):
    """An equation of rules of one form: which of their names, of their numbers and what calls it reads."""

    form: Form
    reads: tuple[int | Called, ...]
    numbers: tuple[int, ...]


class Called(NamedTuple):
    """A call in rules of one form, with what stands for the arguments, and for the results beside it."""

    function: nodes.Function
    actuals: tuple[tuple[str, int | Called | Piece], ...]


class Said(NamedTuple):
    """A rule that is like others: its full ``names`` in the order of the text, and where it stands."""

    names: list[str]
    like: Like
    context: Context


class Expansion:
    """The equations of a program that passed its checks.

    ``names`` are all variables that occur, in order of appearance, conditions included.
    """

    def __init__(self, program: Program) -> None:
        self.functions = program.functions
        self.equations: list[Equation] = []
        self.conditions: list[nodes.Condition] = []
        self.requirements: list[Requirement] = []
        self.names: dict[str, None] = {}
        self._called: list[Iterator[tuple[nodes.RuleBody, Context]]] = []
        self._rules: dict[int, list[tuple[nodes.RuleBody, Span]]] = {}
        self._expanded: set[int] = set()
        self._likes: dict[int, Like | None] = {}
        self._outlines: dict[Form, list[Piece | Called]] = {}
        # calls found in a rule are pushed and come before the next rule
        stack = [self._bodies(program.sheet, Scope("", {}, {}), ())]
        while stack:
            step = next(stack[-1], None)
            if step is None:
                stack.pop()
                continue
            self._expand(*step)
            stack.extend(reversed(self._called))
            self._called.clear()
        for row in program.rows:  # the ends of ranges that name variables
            limits = row.range
            if limits is None or limits.span is None:
                continue
            low, high = ">" if limits.low_open else ">=", "<" if limits.high_open else "<="
            for operator, end in ((low, limits.lower), (high, limits.upper)):
                if end is not None and measured(end) is None:
                    comparison = nodes.Comparison(operator, nodes.Name(row.name), end, limits.span)
                    self.requirements.append(Requirement(comparison, (), limits.span))

    def _bodies(
        self, owner: nodes.RuleSheet | nodes.Function, scope: Scope, guard: tuple[Premise, ...]
    ) -> Iterator[tuple[nodes.RuleBody, Context]]:
        """The rules of a sheet or a function with where each stands."""
        if id(owner) not in self._rules:
            self._rules[id(owner)] = [
                (rule.body, rule.span or rule.body.span or _NOWHERE) for rule in rules_of(owner)
            ]
        return ((body, Context(scope, guard, rule)) for body, rule in self._rules[id(owner)])

    def _expand(self, body: nodes.RuleBody, context: Context) -> None:
        """One rule; a stack holds the arms to come, so that long ``else if`` chains don't recurse."""
        stack = [(body, context)]
        while stack:
            body, context = stack.pop()
            scope, guard, rule = context
            if (like := self._like(body, scope)) is not None:
                self._repeat(body, like, context)
                continue
            read = names_of(body)  # in the order of the text, whatever the order of the calls
            self.names.update(dict.fromkeys(map(scope.full_name, read) if scope.prefix else read))
            for part in components(body, self.functions):
                match part:
                    case nodes.Equality((left, *_), (right, *_)):
                        self._equate(self._bind(left, context), self._bind(right, context), context)
                    case nodes.CallRule(called, arguments, results, span):
                        function = self.functions.get(called.lower())
                        if function is not None:
                            self._call(function, arguments, results, context)
                        else:
                            result, value = results[0], nodes.Call(called.lower(), arguments, span)
                            self._equate(self._bind(result, context), self._bind(value, context), context)
                    case nodes.Inequality(comparisons):
                        bound = (self._bind_condition(comparison, context) for comparison in comparisons)
                        self.requirements += (Requirement(one, guard, rule, scope.prefix) for one in bound)
                    case nodes.IfRule(condition, then, otherwise):
                        index = len(self.conditions)
                        self.conditions.append(self._bind_condition(condition, context))
                        for arm, holds in ((otherwise, False), (then, True)):
                            if arm is not None:
                                stack.append((arm, Context(scope, (*guard, Premise(index, holds)), rule)))

    # --- rules that are like others ---

    def _like(self, body: nodes.RuleBody, scope: Scope) -> Like | None:
        """What a rule shares with others; a rule of a function shares it with itself in other calls."""
        if isinstance(body, nodes.CallRule) and body.function not in self.functions:
            return None
        like: Like | None = getattr(body, "like", None)
        if like is not None or not scope.prefix:
            return like
        if id(body) not in self._expanded:  # what is expanded once is expanded as it stands
            self._expanded.add(id(body))
            return None
        if id(body) not in self._likes:
            self._likes[id(body)] = like_of(body)
        return self._likes[id(body)]

    def _repeat(self, body: nodes.RuleBody, like: Like, context: Context) -> None:
        """The equations and calls of a rule that is like others."""
        names = [*map(context.scope.full_name, like.names)]
        self.names.update(dict.fromkeys(names))
        if not context.scope.prefix and like.form.called.isdisjoint(self.functions):
            self.equations.append(Equation.of(len(self.equations), body, context.guard, context.rule))
            return
        if like.form not in self._outlines:
            parts = components(like.form.numbered(), self.functions)
            self._outlines[like.form] = [*map(self._outline, parts)]
        every = [names[place] for place in like.pattern] if like.pattern else names
        said = Said(every, like, context)
        for part in self._outlines[like.form]:
            if isinstance(part, Piece):
                self._write(part, [self._name(read, said) for read in part.reads], said)
            else:
                self._call_like(part, said)

    def _outline(self, part: nodes.RuleBody) -> Piece | Called:
        """What becomes of a part of rules of one form, whose names and numbers are told by their places."""
        if isinstance(part, nodes.CallRule):
            return self._outlined(self.functions[part.function], (*part.arguments, *part.results))
        assert isinstance(part, nodes.Equality)
        return self._piece(part.left[0], part.right[0])

    def _outlined(self, function: nodes.Function, actuals: tuple[nodes.Expression, ...]) -> Called:
        pairs = zip((*function.arguments, *function.results), actuals, strict=False)
        return Called(function, tuple([(formal, self._actual(actual)) for formal, actual in pairs]))

    def _actual(self, actual: nodes.Expression) -> int | Called | Piece:
        if isinstance(actual, nodes.Name):
            return int(actual.name)
        if isinstance(actual, nodes.Call) and actual.function in self.functions:
            return self._outlined(self.functions[actual.function], actual.arguments)
        return self._piece(None, actual)

    def _piece(self, left: nodes.Expression | None, right: nodes.Expression) -> Piece:
        """That of an equation; ``left`` is None for the variable of an argument."""
        reads: list[int | Called] = []
        numbers: list[int] = []

        def blank(node: nodes.Expression) -> nodes.Expression:
            if isinstance(node, nodes.Number):
                numbers.append(int(node.value))
                return node
            if isinstance(node, nodes.Name) or (
                isinstance(node, nodes.Call) and node.function in self.functions
            ):
                read = self._actual(node)
                assert not isinstance(read, Piece)
                reads.append(read)
                return nodes.Name("", node.span)
            return rebuilt(node, tuple([blank(part) for part in children(node)]))

        first = nodes.Name("", right.span) if left is None else blank(left)
        return Piece(Form(((first,), (blank(right),))), tuple(reads), tuple(numbers))

    def _name(self, read: int | Called, said: Said) -> str:
        """The full name of a variable of a rule, or of the result of a call in it."""
        if isinstance(read, int):
            return said.names[read]
        self.names.setdefault(result := self._call_like(read, said))
        return result

    def _call_like(self, called: Called, said: Said) -> str:
        """As :meth:`_call`, of a call in a rule that is like others."""
        prefix, bound = self._scope(called.function, said.context)
        for formal, actual in called.actuals:
            if isinstance(actual, Piece):
                reads = [self._name(read, said) for read in actual.reads]
                bound[formal] = full = prefix + formal
                self.names.setdefault(full)
                self._write(actual, [full, *reads], said)
            else:
                bound[formal] = self._name(actual, said)
        return self._enter(called.function, Scope(prefix, bound, {}), said.context)

    def _write(self, piece: Piece, names: list[str], said: Said) -> None:
        """An equation of a rule that is like others."""
        like, (scope, guard, rule) = said.like, said.context
        numbers = tuple([like.numbers[place] for place in piece.numbers])
        body = Like.of(piece.form, names, numbers, like.start, like.code).rule(rule)
        self.equations.append(Equation.of(len(self.equations), body, guard, rule, scope.prefix))

    # --- rules as they stand ---

    def _call(
        self,
        function: nodes.Function,
        arguments: tuple[nodes.Expression, ...],
        results: tuple[nodes.Expression, ...] | None,
        context: Context,
    ) -> str:
        """Bind a call and put its body on the stack; the full name of its first result.

        With ``results`` None (a call in an expression) the results are locals of the call.
        """
        prefix, bound = self._scope(function, context)
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
        return self._enter(function, Scope(prefix, bound, {}), context)

    def _scope(self, function: nodes.Function, context: Context) -> tuple[str, dict[str, str]]:
        """The prefix of the next call of a function, and what its parameters stand for."""
        caller, name = context.scope, function.name
        number = caller.counts[name] = caller.counts.get(name, 0) + 1
        prefix = f"{caller.prefix}{name}." if number == 1 else f"{caller.prefix}{name}#{number}."
        return prefix, {parameter: caller.full_name(parameter) for parameter in function.parameters}

    def _enter(self, function: nodes.Function, scope: Scope, context: Context) -> str:
        """Put the body of a call on the stack; the full name of its first result."""
        self._called.append(self._bodies(function, scope, context.guard))
        return scope.full_name(function.results[0]) if function.results else ""

    def _equate(self, left: nodes.Expression, right: nodes.Expression, context: Context) -> None:
        scope, guard, rule = context
        left, right = (_exact(side, rule) for side in (left, right))
        self.equations.append(Equation(len(self.equations), left, right, guard, rule, scope.prefix))

    def _bind(self, node: nodes.Expression, context: Context) -> nodes.Expression:
        """The expression under full names, calls of rule functions replaced by their results."""
        if not self.functions:
            return node
        if isinstance(node, nodes.Name):
            full = context.scope.full_name(node.name)
            return node if full == node.name else nodes.Name(full, node.span)
        if isinstance(node, nodes.Call) and node.function in self.functions:
            result = self._call(self.functions[node.function], node.arguments, None, context)
            self.names.setdefault(result)
            return nodes.Name(result, node.span)
        parts = children(node)
        bound: list[nodes.Expression] = []
        for part in parts:  # a loop, for one frame a level: trees may be hundreds of levels deep
            bound.append(self._bind(part, context))
        if all(new is old for new, old in zip(bound, parts, strict=True)):
            return node
        return rebuilt(node, tuple(bound))

    def _bind_condition(self, node: nodes.Condition, context: Context) -> Any:
        match node:
            case nodes.Comparison(operator, left, right, span):
                left, right = (_exact(self._bind(side, context), context.rule) for side in (left, right))
                return nodes.Comparison(operator, left, right, span)
            case nodes.And(terms, span) | nodes.Or(terms, span):
                return type(node)(tuple(self._bind_condition(term, context) for term in terms), span)
            case nodes.Not(term, span):
                return nodes.Not(self._bind_condition(term, context), span)
            case nodes.Given(name, span):
                return nodes.Given(context.scope.full_name(name), span)


def _exact(side: nodes.Expression, rule: Span) -> nodes.Expression:
    """A side of a rule with what its constants are exactly put in: the text tells where there may be any."""
    text = (rule.text or "sin pi").lower()
    return with_round_values(side) if "pi" in text and any(f in text for f in ("sin", "cos", "tan")) else side
