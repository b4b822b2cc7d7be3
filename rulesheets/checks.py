"""Checks of a parsed program, before its calls are expanded: names, calls, size, figures."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from functools import partial
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise
from typing import NamedTuple

from rulesheets.diagnosis import (
    PROPERTIES,
    WRITE_IN_PYTHON,
    Diagnosis,
    closest,
    error,
    error_at,
    labels,
    meant,
    plural,
    refuse,
    suggestion,
)
from rulesheets.functions import PLANNED, TABLE
from rulesheets.syntax import LIKE_PI, Span, nodes
from rulesheets.syntax.program import Program, bodies, components, rules_of


def check(program: Program) -> dict[str, Scope]:
    """The sheet itself, which has no name, and its functions.

    Raises RuleSheetError with every complaint about names, symbols and calls, scope by scope.
    """
    functions = {name: Scope(program, one) for name, one in program.functions.items()}
    scopes = {"": Scope(program), **functions}
    refuse(_complaints(program, scopes))
    return scopes


def _complaints(program: Program, scopes: Mapping[str, Scope]) -> Iterator[Diagnosis]:
    sheet = scopes[""]
    yield from check_rows(program)
    yield from check_ranges(sheet)
    for scope in scopes.values():
        if scope.function is not None:
            yield from check_head(scope.function)
        yield from check_names(scope)
        yield from check_shapes(scope)
        yield from check_nodes(scope)
        for call, function in scope.calls:
            if function is not None:
                yield from _check_rule_function(call, function, scope)
            else:
                yield from check_builtin(call, program.functions, scope.names)
    yield from check_nesting(scopes)


class Scope:
    """The sheet itself, or one function of it: what its rules name and call.

    ``parts`` are scalar equalities, calls, conditions … in source order, ``every`` are all their
    nodes. ``declared`` are the names in the variables section or in the head of the function,
    ``places`` those in the rules, each with the first part that contains it, and ``names`` both.

    ``size`` is the number of its rules. ``calls`` are those with results (``call f(a; x)``, ``x =
    f(a)``), then those in expressions, each with its rule function, if it calls one.
    """

    def __init__(self, program: Program, function: nodes.Function | None = None) -> None:
        self.program, self.function = program, function
        if function is None:
            self.title, self.declared = "this sheet", tuple(row.name for row in program.rows)
        else:
            self.title = function.name
            self.declared = (*function.arguments, *function.results, *function.parameters)
        rules = program.rules if function is None else rules_of(function)
        every = [body for rule in rules for body in bodies(rule.body)]
        self.size = len(every)
        self.parts = [part for body in every for part in components(body, program.functions)]
        self.every = list[nodes.Expression | nodes.Condition]()
        self.places: dict[str, nodes.RuleBody] = {}
        for part in self.parts:
            self.every += nodes.walk(*part.parts)
            for name in part.names:
                self.places.setdefault(name, part)
        self.names = dict.fromkeys((*self.declared, *self.places))
        calls: list[nodes.CallRule | nodes.Call]
        calls = [part for part in self.parts if isinstance(part, nodes.CallRule)]
        calls += [node for node in self.every if type(node) is nodes.Call]
        self.calls = [(call, program.functions.get(call.function.lower())) for call in calls]

    def place(self, name: str) -> Span | None:
        """The first place of a variable in the rules."""
        inside = nodes.walk(*self.places[name].parts)
        named = (node for node in inside if isinstance(node, nodes.Name) and node.name == name)
        return next(named).span


# --- places ---------------------------------------------------------------------


def head_of(function: nodes.Function) -> Span | None:
    """The first line of a function: its name and its arguments."""
    span = function.span
    return span and span.part(0, len(span.text.partition("\n")[0].split('"')[0].rstrip()))


def name_in(call: nodes.Call | nodes.CallRule) -> Span | None:
    """The place of the function's name in a call."""
    span = call.span
    if span is None:
        return None
    begin = len("call") if isinstance(call, nodes.CallRule) else 0
    start = span.text.lower().find(call.function.lower(), begin)
    return span if start < 0 else span.part(start, len(call.function))


# --- calls ----------------------------------------------------------------------

_ELSEWHERE = {
    "convert": "write the factor as a number; values are converted where they are given: x = 3[in]",
    "converttemp": "temperatures are converted where they are given: --set T=20degC",
    "integral": "integrals are not supported yet",
    **dict.fromkeys(("diff", "derivative"), "write the derivative out"),
    **dict.fromkeys(("pow", "power"), "write a^b"),
    **dict.fromkeys(("cot", "ctg"), "write 1/tan(x)"),
    **dict.fromkeys(("csc", "cosec"), "write 1/sin(x)"),
    "sec": "write 1/cos(x)",
    "tg": "write tan(x)",
    "cbrt": "write x^(1/3)",
    "log2": "write ln(x)/ln(2)",
    **dict.fromkeys(("fact", "factorial"), "write gamma(x + 1)"),
    **dict.fromkeys(PROPERTIES, WRITE_IN_PYTHON),
}
"""Functions known from EES and other languages, and what to use instead."""


def _check_rule_function(
    call: nodes.Call | nodes.CallRule, function: nodes.Function, scope: Scope
) -> Iterator[Diagnosis]:
    name, head = function.name, head_of(function)
    usage = f"{name}({', '.join(function.arguments)}; {', '.join(function.results)})"
    if len(call.arguments) != len(function.arguments):
        expected = plural(len(function.arguments), "argument")
        yield _argument_count(call, name, expected, usage, head)
    given = len(call.results) if isinstance(call, nodes.CallRule) else 1
    if given != len(function.results):
        expected = plural(len(function.results), "result")
        message = f"{name} gives {expected}, not {given or 'none'}"
        note = f"it is called as {usage}"
        if isinstance(call, nodes.Call):
            message = f"{name} has {expected}, so it has no single value in an expression"
            note = f"call it on a line of its own: call {usage}"
        places = labels((call.span, f"{plural(given, 'result')} asked for"), (head, "defined here"))
        yield error("E204", message, *places, notes=(note,))
    for parameter in function.parameters:
        if parameter in scope.names:
            continue
        cure = f"add {parameter} to the parameters of {scope.title}"
        if scope.function is None:
            cure = f"name {parameter} in the variables section or in a rule of this sheet"
        missing = f"{scope.title} has no variable {parameter}"
        message = f"{name} has the parameter {parameter}, but {missing}"
        notes = (*suggestion(parameter, scope.names), cure)
        places = labels((call.span, "called here"), (head, f"{parameter} is its parameter"))
        yield error("E205", message, *places, notes=notes)


def _argument_count(
    call: nodes.Call | nodes.CallRule, name: str, expected: str, usage: str, head: Span | None
) -> Diagnosis:
    count = len(call.arguments)
    places = labels((call.span, f"{plural(count, 'argument')} given"), (head, "defined here"))
    message = f"{name} takes {expected}, not {count or 'none'}"
    return error("E203", message, *places, notes=(f"it is called as {usage}",))


def check_builtin(
    call: nodes.Call | nodes.CallRule, own: Iterable[str] = (), variables: Iterable[str] = ()
) -> Iterator[Diagnosis]:
    """Check a call of a built-in function; ``own`` and ``variables`` may be suggested instead."""
    name = call.function.lower()
    place = None if name in TABLE else name_in(call)
    if name in PLANNED:
        message = f"{call.function} works on lists, which are not supported yet"
        note = "write the terms out, as in `a + b + c`"
        yield error_at("E202", message, place, note, label="not there yet")
    elif name not in TABLE:
        written = place.text if place is not None and place != call.span else call.function
        defined = "a function of your own is defined with `function`"
        notes = suggestion(call.function, (*own, *TABLE))
        notes = notes or (f"{defined}, or comes from a file named by `use`",)
        if name in _ELSEWHERE:
            notes = (_ELSEWHERE[name],)
        if written in variables:
            notes = (f"for a product with the variable {written} write {written}*(…)",)
        yield error_at("E201", f"there is no function {written}", place, *notes, label="not known")
    else:
        row = TABLE[name]
        if not row.accepts(len(call.arguments)):
            least, most = row.arity
            expected = f"{'' if most is not None else 'at least '}{plural(least, 'argument')}"
            usage = f"{call.function}({row.arguments})"
            yield _argument_count(call, call.function, expected, usage, None)
        if isinstance(call, nodes.CallRule) and len(call.results) != 1:
            message = f"{call.function} gives one result, not {len(call.results) or 'none'}"
            note = f"write it in a rule: y = {call.function}(…)"
            yield error_at("E204", message, call.span, note)


# --- size -----------------------------------------------------------------------

MAX_DEPTH, MAX_RULES = 100, 200_000


def check_nesting(scopes: Mapping[str, Scope]) -> Iterator[Diagnosis]:
    """A diagnosis for a circle of calls, if there is one, else for calls nested too deeply."""
    calls: dict[str, dict[str, Span | None]] = {name: {} for name in scopes}
    for name, scope in scopes.items():
        for call, function in scope.calls:
            if function is not None:
                calls[name].setdefault(function.name.lower(), call.span)
    try:
        inner_first = tuple(TopologicalSorter(calls).static_order())
    except CycleError as found:
        ring = found.args[1][:0:-1]  # each is called by the one before it
        order = list(scopes)
        first = min(range(len(ring)), key=lambda k: order.index(ring[k]))
        ring = [*ring[first:], *ring[: first + 1]]
        names = [scopes[name].title for name in ring]
        steps = zip(pairwise(ring), pairwise(names), strict=True)
        places = [(calls[a][b], f"{caller} calls {target}") for (a, b), (caller, target) in steps]
        message = f"{names[0]} calls itself" + (" through others" if len(names) > 2 else "")
        note = f"the calls form a circle: {' → '.join(names)}; a function cannot call itself"
        yield error("E208", message, *labels(*places), notes=(note,))
        return
    depths, sizes = dict[str, int](), dict[str, int]()
    for name in inner_first:
        called = [one.name.lower() for _, one in scopes[name].calls if one is not None]
        depths[name] = max((1 + depths[one] for one in called), default=0)
        sizes[name] = scopes[name].size + sum(sizes[one] for one in called)
    reason = f"calls nest {depths['']} deep; {MAX_DEPTH} is the limit"
    if depths[""] <= MAX_DEPTH:
        if sizes[""] <= MAX_RULES or not calls[""]:
            return
        reason = f"with calls expanded the model has more than {MAX_RULES:,} rules"
    place = next(iter(calls[""].values()))
    yield error_at("E216", reason, place, "nest fewer calls", label="called here")


def check_shapes(scope: Scope) -> Iterator[Diagnosis]:
    """Tuples of different lengths."""
    for part in scope.parts:
        if isinstance(part, nodes.Equality) and len(part.left) != len(part.right):
            left, right = len(part.left), len(part.right)
            message = f"the two sides differ in length: {left} on the left, {right} on the right"
            note = "write the same number on both sides, as in (a, b) = (c, d)"
            yield error_at("E213", message, part.span, note, label="one equation for each pair")


# --- names ----------------------------------------------------------------------

FREE = PLANNED | {"e", "gamma", "beta", "step", "j0", "j1", "jn", "y0", "y1", "yn", "i0", "k0"}
"""Functions whose names may also be variables, because sheets about angles, places and currents
need them: a function is always followed by a parenthesis, so nothing is ambiguous."""


def check_names(scope: Scope) -> Iterator[Diagnosis]:
    """Functions that are used as variables, in the section or the head and then in rules."""
    if scope.function is None:
        rows = scope.program.rows
        declared = [(row.name, row.span and row.span.part(0, len(row.name))) for row in rows]
    else:
        declared = [(name, head_of(scope.function)) for name in scope.declared]
    own = {function.name: function for function in scope.program.functions.values()}
    found: list[tuple[str, Span | None, nodes.Function | None]]
    found = [(name, place, None) for name, place in declared if _reserved(name)]
    others = (name for name in scope.places if name not in scope.declared)
    found += [(n, scope.place(n), own.get(n)) for n in others if _reserved(n) or n in own]
    for name, place, function in found:
        use = f"{function.name}({', '.join(function.arguments)})" if function else f"{name}(x)"
        note = f"call it as {use}, or give the variable another name"
        message = f"{name} is a function, not a variable"
        yield error_at("E210", message, place, note, label="the name of a function")


def _reserved(name: str) -> bool:
    return name.lower() in TABLE and name.lower() not in FREE and not LIKE_PI.fullmatch(name)


def check_rows(program: Program) -> Iterator[Diagnosis]:
    first: dict[str, Span | None] = {}
    for row in program.rows:
        place = row.span and row.span.part(0, len(row.name))
        if row.name in first:
            places = labels((place, "again"), (first[row.name], "first here"))
            message = f"{row.name} has two rows in the variables section"
            yield error("E215", message, *places, notes=("keep one of the two rows",))
        first.setdefault(row.name, place)


def check_ranges(scope: Scope) -> Iterator[Diagnosis]:
    """Ends of ranges that name variables: the variables must exist, the functions be built in."""
    for end in (bound.right for row in scope.program.rows for bound in row.range):
        yield from check_constant(end)
        for node in nodes.walk(end):
            if isinstance(node, nodes.Name) and node.name not in scope.names:
                message = f"the end of a range names {node.name}, not a variable of this sheet"
                note = f"no rule and no other row names {node.name}"
                notes = suggestion(node.name, scope.names) or (note,)
                yield error_at("E218", message, node.span, *notes)


def check_nodes(scope: Scope) -> Iterator[Diagnosis]:
    """Symbols in arithmetic (unless a call passes them on) or in order, and names in ``given``."""
    own, every = scope.program.functions, scope.every
    kinds = set(map(type, every))
    for node in () if kinds.isdisjoint((nodes.Symbol, nodes.Given)) else every:
        if isinstance(node, nodes.Call) and node.function.lower() in own:
            continue
        if isinstance(node, nodes.Given):
            if node.name not in scope.names:
                message = f"given('{node.name}) asks for an unknown variable"
                note = f"no rule and no row names {node.name}"
                notes = suggestion(node.name, scope.names) or (note,)
                yield error_at("E214", message, node.span, *notes)
        elif not isinstance(node, nodes.Comparison):
            yield from _symbols_in(node)
        elif node.operator not in ("=", "<>"):
            sides = node.left, node.right
            symbols = [side.name for side in sides if isinstance(side, nodes.Symbol)]
            if symbols:
                message = f"the symbol '{symbols[0]} is neither greater nor smaller than anything"
                note = "symbols are compared by = and <> only"
                label = f"compared by {node.operator}"
                yield error_at("E212", message, node.span, note, label=label)


def _symbols_in(node: nodes.Expression | nodes.Condition) -> Iterator[Diagnosis]:
    for part in node.parts:
        if isinstance(part, nodes.Symbol):
            message = f"the symbol '{part.name} is not a number, so there is no arithmetic with it"
            given = f"a symbol can be given to a variable (x = '{part.name})"
            note = f"{given} or be compared by = and <>"
            also = f"if the variable {part.name} is meant, leave out the apostrophe"
            yield error_at("E211", message, part.span, note, also, label="a symbol")


def check_constant(expression: nodes.Expression) -> Iterator[Diagnosis]:
    """An input as written: numbers and built-in functions, without arithmetic on symbols."""
    for node in nodes.walk(expression):
        if isinstance(node, nodes.Call):
            yield from check_builtin(node)
        yield from _symbols_in(node)


def check_head(function: nodes.Function) -> Iterator[Diagnosis]:
    place = head_of(function)
    if function.name.lower() in TABLE or function.name.lower() in PLANNED:
        message = f"{function.name} is a built-in function and cannot be redefined"
        note = f"give it a name of its own, such as my_{function.name}"
        yield error_at("E207", message, place, note)
    roles: dict[str, list[str]] = {}
    for role in ("argument", "result", "parameter"):
        for name in getattr(function, f"{role}s"):
            roles.setdefault(name, []).append(f"{'an' if role == 'argument' else 'a'} {role}")
    for name, held in roles.items():
        if len(held) > 1:
            distinct = list(dict.fromkeys(held))
            role = " and ".join(distinct) if len(distinct) > 1 else f"twice {held[0]}"
            note = "a name is either an argument, a result or a parameter, and is listed once"
            label = f"{name} has more than one role"
            yield error_at("E209", f"{name} is {role} of {function.name}", place, note, label=label)


# --- lines of figures: their kinds, the shape of each, and the names in them ------------


class Kind(NamedTuple):
    """A kind of line of a figure, with an example and ``least`` and ``most`` arguments.

    The first ``points`` of them, or all, are points of the figure; ``takes`` says what they are
    otherwise. ``named``: a name before the parentheses is required, else it is an optional label.
    """

    example: str
    least: int = 2
    most: int | None = 2
    points: int | None = None
    takes: str = ""
    named: bool = False


_place = partial(Kind, points=0, takes="two coordinates", named=True)
_link = partial(Kind, most=None)
_joint = partial(Kind, points=1, takes="a point of the figure and a direction in degrees")

KINDS: dict[str, Kind] = {
    "point": _place("point A = (xA, yA)"),
    "pin": _place("pin O = (0, 0)"),  # to the ground
    "pole": _place("pole o = (0, 0)"),  # of a velocity or acceleration diagram
    "line": _link("line (O, A)"),  # a link, or a line through several points
    "slot": Kind("slot (C, D)"),  # a link with a slot along it
    "body": _link("body (U, T, W)", 3),  # a rigid link with three corners or more
    "slider": _joint("slider (B, 0)"),  # on a fixed straight guide
    "block": _joint("block (B, thetaCD)"),  # a slider on a moving link
    "trunnion": _joint("trunnion (E, thetaCD)"),  # a guide that turns about a fixed point
    "vector": Kind("vector vB = (o, b)"),
    "normal": Kind("normal aAn = (o1, a11)"),  # along a link: a normal acceleration
    "tangential": Kind("tangential vAB = (a, b)"),  # across a link: a velocity or an acceleration
    "sliding": Kind("sliding vS = (s, b)"),  # along a link or a guide
    "coriolis": Kind("coriolis (s1, k1)"),
}
"""A table, so that a new kind needs no new grammar."""

PLACES = frozenset(kind for kind, row in KINDS.items() if row.points == 0)
ARROWS = ("vector", "normal", "tangential", "sliding", "coriolis")


MARK_SHAPE = "a line of a figure reads point A = (x, y), line (O, A) or slider (B, 0)"


def marks_of(figure: nodes.Figure) -> tuple[nodes.Mark, ...]:
    """The lines of a figure without comment lines."""
    return tuple(mark for mark in figure.marks if isinstance(mark, nodes.Mark))


def parts(mark: nodes.Mark) -> tuple[tuple[nodes.Name, ...], tuple[nodes.Expression, ...]]:
    """The points that a line names, and the expressions that it evaluates."""
    named = mark.arguments[: KINDS[mark.kind].points]
    points = tuple(node for node in named if isinstance(node, nodes.Name))
    return points, mark.arguments[len(named) :]


def check_figures(program: Program, variables: Collection[str]) -> Iterator[Diagnosis]:
    """Check that names in figures are variables, or points of the figure.

    ``variables`` are all variables of the model by their full names, locals of calls included.
    """
    first: dict[str, nodes.Figure] = {}
    for figure in program.sheet.figures:
        earlier = first.setdefault(figure.name, figure)
        if earlier is not figure:
            places = (one.span and one.span.part(0, len("figure")) for one in (figure, earlier))
            yield _twice("figure", figure.name, *places)
        points: dict[str, nodes.Mark] = {}
        for mark in marks_of(figure):
            if mark.kind in PLACES and mark.name is not None:
                before = points.setdefault(mark.name, mark)
                if before is not mark:
                    yield _twice("point", mark.name, mark.span, before.span)
        for mark in marks_of(figure):
            named, reckoned = parts(mark)
            for name in named:
                if name.name not in points:
                    notes = suggestion(name.name, points) or (f"add point {name.name} = (x, y)",)
                    message = f"the figure {figure.name} has no point {name.name}"
                    yield error_at("E231", message, name.span, *notes)
            for expression in reckoned:
                yield from _check_expression(expression, variables, program.functions)


def _check_expression(
    expression: nodes.Expression, variables: Collection[str], functions: Collection[str]
) -> Iterator[Diagnosis]:
    for node in nodes.walk(expression):
        if isinstance(node, nodes.Name) and node.name not in variables:
            notes = meant(node.name, variables) or ("a figure names variables of the rules",)
            yield error_at("E230", f"there is no variable {node.name}", node.span, *notes)
        elif isinstance(node, nodes.Call) and node.function in functions:
            message = f"a figure cannot call {node.function}, which is a function of rules"
            note = "call it in a rule, and name its results here"
            yield error_at("E201", message, name_in(node), note)
        elif isinstance(node, nodes.Call):
            yield from check_builtin(node, (), variables)
        elif isinstance(node, nodes.Symbol):
            message = f"the symbol '{node.name} is not a coordinate"
            yield error_at("E233", message, node.span, "a figure is drawn from numbers")


def _twice(what: str, name: str, again: Span | None, first: Span | None) -> Diagnosis:
    places = labels((again, "again"), (first, "first here"))
    note = "give one of the two another name"
    return error("E232", f"the {what} {name} is defined twice", *places, notes=(note,))


def wrong_mark(mark: nodes.Mark) -> Diagnosis | None:
    """The mistake in a line of a figure that the grammar accepts: its kind, or a missing part."""
    kind = KINDS.get(mark.kind)
    if kind is None:
        near = closest(mark.kind, KINDS)
        note = f"did you mean {near}?" if near else f"the kinds are {', '.join(KINDS)}"
        place = mark.span and mark.span.part(0, len(mark.kind))
        return error_at("E130", f"a figure has no `{mark.kind}`", place, note)
    count, message = len(mark.arguments), ""
    if kind.named and mark.name is None:
        message = f"this {mark.kind} has no name"
    elif kind.points == 1 and mark.name is not None:
        message = f"a {mark.kind} has no name of its own"
    elif count < kind.least or (kind.most is not None and count > kind.most):
        expected = kind.takes or plural(kind.least, "point") + ("" if kind.most else " or more")
        message = f"a {mark.kind} takes {expected}, not {count or 'none'}"
    if message:
        return error_at("E131", message, mark.span, f"write {kind.example}")
    for argument in mark.arguments[: kind.points]:
        if not isinstance(argument, nodes.Name) or "." in argument.name:
            note = f"name a point of the figure, as in {kind.example}"
            return error_at("E131", "this is not the name of a point", argument.span, note)
    return None
