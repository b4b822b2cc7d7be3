"""Random rule sheets in canonical form, as hypothesis strategies."""

from __future__ import annotations

import string

from hypothesis import strategies as st

from rulesheets.checks import KINDS, Kind
from rulesheets.syntax.nodes import (
    And,
    Call,
    CallRule,
    CommentLine,
    Comparison,
    Equality,
    Figure,
    Function,
    Given,
    IfRule,
    Mark,
    Name,
    Negative,
    Not,
    Number,
    Or,
    Power,
    Product,
    Quotient,
    Rule,
    RuleSheet,
    Sum,
    Symbol,
    Tolerance,
    Use,
    VariableRow,
)

RESERVED = {"if", "then", "else", "call", "and", "or", "not", "pi"}
HEADS = {"use", "function", "parameters", "variables", "rules", "list", "procedure", "figure", "in"}

identifiers = st.from_regex(r"[A-Za-zθéЖ_][A-Za-z0-9_θ]{0,6}", fullmatch=True).filter(
    lambda word: (
        word.lower()
        not in RESERVED
        | HEADS
        | {"rule", "variable", "equation", "equations", "formula", "formulas"}
    )
)
numbers = st.one_of(
    st.integers(0, 400).map(float),
    st.floats(0, allow_nan=False, allow_infinity=False, allow_subnormal=True),
).map(Number)
atoms = st.one_of(
    numbers,
    identifiers.map(Name),
    st.just(Call("pi", ())),
)


def tuples(items, least=1, most=3):
    return st.lists(items, min_size=least, max_size=most).map(tuple)


def _larger(parts):
    return st.one_of(
        parts.map(Negative),
        tuples(parts, 2).map(Sum),
        st.builds(Product, parts, parts),
        st.builds(Quotient, parts, parts),
        st.builds(Power, parts, parts),
        st.builds(
            Call, identifiers.map(str.lower).filter(lambda word: word != "given"), tuples(parts, 0)
        ),
    )


expressions = st.recursive(atoms, _larger, max_leaves=8)
values = expressions | identifiers.map(Symbol)
comparisons = st.builds(
    Comparison, st.sampled_from(["=", "<>", "<", "<=", ">", ">="]), values, values
)
conditions = st.recursive(
    comparisons | identifiers.map(Given),
    lambda parts: tuples(parts, 2).map(And) | tuples(parts, 2).map(Or) | parts.map(Not),
    max_leaves=4,
)

# A single call on the left of a tuple would be turned round, a rule without a variable refused.
equalities = st.one_of(
    st.builds(lambda name, right: Equality((Name(name),), (right,)), identifiers, values),
    st.builds(lambda left, name: Equality((left,), (Name(name),)), expressions, identifiers),
    st.builds(
        lambda n, a, b: Equality((Name(n), *a), b),
        identifiers,
        tuples(expressions),
        tuples(expressions),
    ),
)
calls = st.builds(CallRule, identifiers.map(str.lower), tuples(values, 0), tuples(expressions, 0))
bodies = st.recursive(
    equalities | calls,
    lambda parts: st.builds(IfRule, conditions, parts, st.none() | parts),
    max_leaves=4,
)

comments = st.text(string.printable + "θ≤°", max_size=12).map(lambda text: " ".join(text.split()))
comment_lines = comments.map(CommentLine)
rules = st.builds(Rule, bodies, comments)


def with_a_rule(lines):
    return any(isinstance(line, Rule) for line in lines)


rule_lists = tuples(rules | comment_lines, 1, 4)

units = st.from_regex(r"[a-z%$][a-z0-9/^*²·]{0,5}", fullmatch=True)
limits = st.floats(allow_nan=False, allow_infinity=False).map(
    lambda number: Number(number) if number >= 0.0 else Negative(Number(-number))
)
lower, upper = (st.none() | st.tuples(st.sampled_from([sign, f"{sign}="]), limits) for sign in "><")
rows = st.builds(
    lambda name, value, guess, is_input, tolerance, range, **cells: VariableRow(
        name,
        value if is_input else None,
        None if is_input else guess,
        tolerance=tolerance if is_input and value is not None else None,
        range=tuple(Comparison(sign, Name(name), end) for sign, end in filter(None, range)),
        **cells,
    ),
    identifiers,
    st.none() | values,
    st.none() | expressions,
    st.booleans(),
    st.none() | st.builds(Tolerance, expressions, st.booleans()),
    unit=st.none() | units,
    display_unit=st.none() | units,
    range=st.tuples(lower, upper),
    comment=comments,
)
functions = st.builds(
    lambda parameters, remark, **parts: Function(
        parameters=parameters, parameters_comment=remark if parameters else "", **parts
    ),
    tuples(identifiers, 0),
    comments,
    name=identifiers,
    arguments=tuples(identifiers, 0),
    results=tuples(identifiers, 0),
    rules=rule_lists.filter(with_a_rule),
    comment=comments,
    above=tuples(comment_lines, 0, 2),
)
full_names = st.builds(
    lambda calls, name: Name(".".join((*calls, name))),
    tuples(st.builds(lambda f, n: f + n, identifiers, st.sampled_from(["", "#2", "#13"])), 0, 2),
    identifiers,
)
coordinates = st.one_of(
    expressions, full_names, st.builds(Sum, tuples(expressions | full_names, 2))
)


def marks_of_kind(kind: str, row: Kind):
    points = identifiers.map(Name)
    arguments = {
        0: st.tuples(coordinates, coordinates),
        1: st.tuples(points, coordinates),
        None: tuples(points, row.least, row.most or row.least + 2),
    }[row.points]
    unnamed = st.none() if not row.named else st.nothing()
    named = identifiers if row.points != 1 else st.nothing()
    return st.builds(Mark, st.just(kind), unnamed | named, arguments, comments)


marks = st.one_of([marks_of_kind(kind, row) for kind, row in KINDS.items()])
figures = st.builds(
    Figure,
    identifiers,
    st.none() | units,
    tuples(marks | comment_lines, 1, 4).filter(
        lambda lines: any(isinstance(line, Mark) for line in lines)
    ),
    comments,
    above=tuples(comment_lines, 0, 2),
)
paths = st.from_regex(r"[a-zü./ ;,-]{1,8}\.tk", fullmatch=True)
uses = st.builds(Use, tuples(paths), comments)
sheets = st.builds(
    RuleSheet,
    tuples(uses, 0, 2),
    st.none() | tuples(rows | comment_lines, 0, 4),
    rule_lists | st.just(()),
    tuples(functions, 0, 2),
    tuples(comment_lines, 0, 2),
    figures=tuples(figures, 0, 2),
).filter(lambda sheet: sheet.functions or with_a_rule(sheet.rules))
