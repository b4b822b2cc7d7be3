"""What a text says: nodes, their places, lines and sections."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rulesheets
from rulesheets.diagnosis import RuleSheetError
from rulesheets.files import read_source
from rulesheets.format import format_sheet
from rulesheets.parse.grammar import Grammar, Unparsed
from rulesheets.parse.layout import logical_lines
from rulesheets.parse.sections import parse
from rulesheets.syntax import Source
from rulesheets.syntax.nodes import (
    And,
    Call,
    CallRule,
    CommentLine,
    Comparison,
    Equality,
    Given,
    IfRule,
    Name,
    Negative,
    Not,
    Number,
    Or,
    Power,
    Product,
    Quotient,
    RuleSheet,
    Sum,
    Symbol,
    Use,
    VariableRow,
)
from tests.oracles.operations import operations

a, b, c, x, y = map(Name, "abcxy")


def read(text: str) -> RuleSheet:
    return parse(Source("sheet.tk", text))


def rule(text: str):
    (only,) = read(text).rules
    return only.body


def expression(text: str):
    return rule(f"x = {text}").right[0]


def row(text: str) -> VariableRow:
    (only,) = read(f"variables\n{text}\nrules\nx = y").variables
    return only


def bounds(*written: str, name: str = "x") -> tuple[Comparison, ...]:
    pairs = [text.split() for text in written]
    return tuple(Comparison(sign, Name(name), Number(float(end))) for sign, end in pairs)


def codes(text: str) -> list[str]:
    with pytest.raises(RuleSheetError) as caught:
        read(text)
    return [diagnosis.code for diagnosis in caught.value.diagnoses]


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("a - b + c", Sum((a, Negative(b), c))),
        ("a - (b + c)", Sum((a, Negative(Sum((b, c)))))),
        ("a/b*c", Product(Quotient(a, b), c)),
        ("-2^2", Negative(Power(Number(2.0), Number(2.0)))),
        ("2^-3", Power(Number(2.0), Negative(Number(3.0)))),
        ("a^b^c", Power(a, Power(b, c))),
        ("-a*b", Product(Negative(a), b)),
        ("+3", Number(3.0)),
        ("-30", Negative(Number(30.0))),
        (".5", Number(0.5)),
        ("1E-3", Number(0.001)),
        ("3.", Number(3.0)),
        ("pi", Call("pi", ())),
        ("PI()", Call("pi", ())),
        ("Pi", Call("pi", ())),
        ("e", Name("e")),
        ("e()", Call("e", ())),
        ("SinD(a)", Call("sind", (a,))),
        ("atan2d(a, b)", Call("atan2d", (a, b))),
        ("'open", Symbol("open")),
        ("given", Name("given")),
        ("in", Name("in")),
        ("iffy", Name("iffy")),
        ("θ_1", Name("θ_1")),
    ],
)
def test_expressions(text: str, tree) -> None:
    assert expression(text) == tree


EQUAL = Comparison("=", a, b)
LESS = Comparison("<", a, c)


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("a = b", EQUAL),
        ("(a = b)", EQUAL),
        ("((a) = (b))", EQUAL),
        ("(a + b)*c >= 1", Comparison(">=", Product(Sum((a, b)), c), Number(1.0))),
        ("a ≤ b", Comparison("<=", a, b)),
        ("a ≥ b", Comparison(">=", a, b)),
        ("a ≠ b", Comparison("<>", a, b)),
        ("and (a = b, a < c)", And((EQUAL, LESS))),
        ("AND(a = b, a < c)", And((EQUAL, LESS))),
        ("a = b and a < c", And((EQUAL, LESS))),
        ("or(a = b, a < c)", Or((EQUAL, LESS))),
        ("a = b or a < c and a = b", Or((EQUAL, And((LESS, EQUAL))))),
        ("(a = b or a < c) and a = b", And((Or((EQUAL, LESS)), EQUAL))),
        ("not (a = b)", Not(EQUAL)),
        ("not(a = b)", Not(EQUAL)),
        ("not a = b", Not(EQUAL)),
        ("and(a = b)", EQUAL),
        ("given('a)", Given("a")),
        ("not given ( 'a ) or a = b", Or((Not(Given("a")), EQUAL))),
        ("given = a", Comparison("=", Name("given"), a)),
    ],
)
def test_conditions(text: str, tree) -> None:
    assert rule(f"if {text} then x = 1").condition == tree


ONE = Equality((x,), (Number(1.0),))
TWO = Equality((x,), (Number(2.0),))
THREE = Equality((x,), (Number(3.0),))


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("a + b = c", Equality((Sum((a, b)),), (c,))),
        ("(a, b) = (x, y)", Equality((a, b), (x, y))),
        ("(a, b) = f(x)", Equality((a, b), (Call("f", (x,)),))),
        ("f(x) = (a, b)", Equality((a, b), (Call("f", (x,)),))),
        ("(a) = b", Equality((a,), (b,))),
        ("call f(a, b; x, y)", CallRule("f", (a, b), (x, y))),
        ("CALL F ( a )", CallRule("f", (a,), ())),
        ("call f(; x)", CallRule("f", (), (x,))),
        ("call f(a + b; x - 1)", CallRule("f", (Sum((a, b)),), (Sum((x, Negative(Number(1.0)))),))),
        ("if a = b then x = 1", IfRule(EQUAL, ONE)),
        ("if a = b then x = 1 else x = 2", IfRule(EQUAL, ONE, TWO)),
        ("if a = b then x = 1 else if a < c then x = 2 else x = 3",
         IfRule(EQUAL, ONE, IfRule(LESS, TWO, THREE))),
        ("if a = b then if a < c then x = 1 else x = 2", IfRule(EQUAL, IfRule(LESS, ONE, TWO))),
        ("if a = b then (if a < c then x = 1) else x = 2", IfRule(EQUAL, IfRule(LESS, ONE), TWO)),
        ("if a = b then call f(a; x) else (a, b) = f(x)",
         IfRule(EQUAL, CallRule("f", (a,), (x,)), Equality((a, b), (Call("f", (x,)),)))),
    ],
)  # fmt: skip
def test_rules(text: str, tree) -> None:
    assert rule(text) == tree


WIDE = (
    Comparison(">=", x, Negative(Number(1.0))),
    Comparison("<=", x, Product(Number(2.0), Number(2.0))),
)


@pytest.mark.parametrize(
    ("text", "tree"),
    [
        ("x", VariableRow("x")),
        ("x = 3", VariableRow("x", Number(3.0))),
        ("x = 'open", VariableRow("x", Symbol("open"))),
        ("x = 2*pi [rad]", VariableRow("x", Product(Number(2.0), Call("pi", ())), unit="rad")),
        ("x ~ -40", VariableRow("x", guess=Negative(Number(40.0)))),
        ("x [$/mo -> $/yr]", VariableRow("x", unit="$/mo", display_unit="$/yr")),
        ("x [-> %]", VariableRow("x", display_unit="%")),
        ("x [1/min]", VariableRow("x", unit="1/min")),
        ("x [°C]", VariableRow("x", unit="°C")),
        ("x in [0, 5]", VariableRow("x", range=bounds(">= 0", "<= 5"))),
        ("x = 3 in [-1, 2*2] [m]", VariableRow("x", Number(3.0), None, "m", range=WIDE)),
        ("x = 3 [m] in [-1, 2*2]", VariableRow("x", Number(3.0), None, "m", range=WIDE)),
        ("x > 0", VariableRow("x", range=bounds("> 0"))),
        ("x > 0, <= 5", VariableRow("x", range=bounds("> 0", "<= 5"))),
        ("x < 5, ≥ 0", VariableRow("x", range=bounds(">= 0", "< 5"))),
        ("x ~ 1 ≥ 0 < 5", VariableRow("x", guess=Number(1.0), range=bounds(">= 0", "< 5"))),
        ('x = 3 " length', VariableRow("x", Number(3.0), comment="length")),
        ("x = 3 ; length", VariableRow("x", Number(3.0), comment="length")),
        (
            "in = 3 in [1, 4]",
            VariableRow("in", Number(3.0), range=bounds(">= 1", "<= 4", name="in")),
        ),
        ("rules = 3", VariableRow("rules", Number(3.0))),
    ],
)
def test_rows(text: str, tree: VariableRow) -> None:
    assert row(text) == tree


@pytest.mark.parametrize(
    "text",
    [
        "x = a +\n b",
        "x =\n\t a + b",
        "x = (a\n + b)",
        'x = a + " first\n b " second',
        'x = a + " first\n " a line of its own\n b',
        "x = a ; comment\n",
    ],
)
def test_a_rule_goes_on(text: str) -> None:
    assert rule(text) in (
        Equality((x,), (Sum((a, b)),)),
        Equality((x,), (a,)),
    )


@pytest.mark.parametrize("gap", ["", "\n", '" a comment\n', "; one\n\n; two\n"])
def test_then_and_else_may_begin_lines(gap: str) -> None:
    text = f"if a = b\n{gap} THEN x = 1\n{gap}else if a < c\nthen x = 2\n{gap} else\n x = 3"
    assert rule(text) == IfRule(EQUAL, ONE, IfRule(LESS, TWO, THREE))


def test_a_semicolon_is_a_comment_only_outside_parentheses() -> None:
    sheet = read("call f(a; x) ; and ( b\nx = a ; c = (b)")
    assert [line.comment for line in sheet.rules] == ["and ( b", "c = (b)"]


def test_comments_of_a_rule_are_joined() -> None:
    (only,) = read('if a = b then x = 1 " first\n else x = 2 ; second').rules
    assert only.comment == "first; second"


SHEET = """" A crank
use "position.tk", "rest; of it.tk" " two files

variables
  AO = 3
  " a line

  xB
rules " all
  call position(AO; xB)

" above it
function position(AO; xB) ; head
parameters AB,
  offset
parameters branch " last
rules
  xB = AO + AB
"""


def test_sections() -> None:
    sheet = read(SHEET)
    assert sheet.comments == (CommentLine("A crank"),)
    assert sheet.uses == (Use(("position.tk", "rest; of it.tk"), "two files"),)
    assert sheet.variables == (
        VariableRow("AO", Number(3.0)),
        CommentLine("a line"),
        VariableRow("xB"),
    )
    assert [row.gap for row in sheet.variables] == [False, False, True]
    assert sheet.rules[0] == CommentLine("all")
    assert sheet.rules[1].body == CallRule("position", (Name("AO"),), (Name("xB"),))
    (function,) = sheet.functions
    assert (function.name, function.arguments, function.results) == ("position", ("AO",), ("xB",))
    assert function.parameters == ("AB", "offset", "branch")
    assert (function.comment, function.parameters_comment) == ("head", "last")
    assert function.above == (CommentLine("above it"),)
    assert len(function.rules) == 1


def test_a_bare_list_of_equations_is_a_sheet() -> None:
    sheet = read("V = I*R\nP = V*I")
    assert sheet.variables is None
    assert len(sheet.rules) == 2


def test_a_variables_section_ends_a_function() -> None:
    sheet = read("function f(a; x)\n x = a\nvariables\n a = 3\nrules\n call f(a; x)")
    assert [len(sheet.variables), len(sheet.rules), len(sheet.functions)] == [1, 1, 1]


@pytest.mark.parametrize(
    "word", ["used", "functional", "parameters_1", "rules_2", "variables_x", "user", "listing"]
)
def test_names_may_begin_like_section_heads(word: str) -> None:
    assert read(f"{word} = 3").rules[0].body == Equality((Name(word),), (Number(3.0),))


@pytest.mark.parametrize("word", ["use", "function", "parameters", "rules", "variables"])
def test_section_words_may_be_variables(word: str) -> None:
    assert read(f"{word} = 3").rules[0].body == Equality((Name(word),), (Number(3.0),))


# --- places -------------------------------------------------------------------------


def every_node(sheet: RuleSheet):
    stack = [line.body for line in sheet.rules]
    while stack:
        node = stack.pop()
        yield node
        match node:
            case Equality(left, right):
                stack += [*left, *right]
            case CallRule(_, arguments, results):
                stack += [*arguments, *results]
            case IfRule(condition, then, otherwise):
                stack += [condition, then, *([otherwise] if otherwise else [])]
            case _:
                stack += node.parts


@pytest.mark.parametrize(
    ("text", "spans"),
    [
        ("x = (a + b)*c", ["x = (a + b)*c", "x", "(a + b)*c", "(a + b)", "a", "b", "c"]),
        ("(a, b) = f(x)", ["(a, b) = f(x)", "a", "b", "f(x)", "x"]),
        (
            "x = -sqrt( a )^2",
            ["x = -sqrt( a )^2", "x", "-sqrt( a )^2", "sqrt( a )^2", "sqrt( a )", "a", "2"],
        ),
        ("x = a - b", ["x = a - b", "x", "a - b", "a", "- b", "b"]),
        ("call f(a; x)", ["call f(a; x)", "a", "x"]),
        (
            "if not given('a) then x = 'open",
            [
                "if not given('a) then x = 'open",
                "not given('a)",
                "given('a)",
                "x = 'open",
                "x",
                "'open",
            ],
        ),
    ],
)
def test_every_node_knows_its_place(text: str, spans: list[str]) -> None:
    sheet = read(f'\n\n  {text}  " c')
    assert sorted(node.span.text for node in every_node(sheet)) == sorted(spans)
    assert (sheet.rules[0].span.line, sheet.rules[0].span.column) == (3, 3)
    assert sheet.rules[0].span.text == text


def test_places_after_comments_inside_a_rule() -> None:
    sheet = read('x = a + " b + c (\n  b')
    assert [node.span.line for node in every_node(sheet) if node == b] == [2]


# --- refusals -----------------------------------------------------------------------


def test_several_mistakes_are_reported_at_once() -> None:
    assert codes("x = 2y\ny = 3\n3 < 4\nz = (3") == ["E105", "E114", "E102"]


def test_a_flood_of_mistakes_is_cut() -> None:
    assert len(codes("x = = 3\n" * 1000)) == 50


def test_an_unclosed_parenthesis_does_not_swallow_the_next_section() -> None:
    assert codes("variables\n a = (3\nrules\n x = 2y") == ["E102", "E105"]


def nested(depth: int, kind: str) -> str:
    return {
        "parentheses": "x = " + "(" * depth + "y" + ")" * depth,
        "calls": "x = " + "f(" * depth + "y" + ")" * depth,
        "signs": "x = " + "-" * depth + "y",
        "powers": "x = " + "2^" * depth + "y",
        "products": "x = " + "y*(" * depth + "y" + ")" * depth,
        "not": "if " + "not " * depth + "a = b then x = 1",
        "if": "if a = b then " * depth + "x = 1",
        "else if": "if a = b then x = 1" + " else if a = b then x = 1" * depth,
        "row": "variables\n x = " + "-" * depth + "3\nrules\nx = y",
    }[kind]


KINDS = ["calls", "signs", "powers", "products", "not", "if", "else if", "row"]


@pytest.mark.parametrize("kind", KINDS)
def test_deep_nesting_is_refused(kind: str) -> None:
    assert codes(nested(3_000, kind)) == ["E124"]


@pytest.mark.parametrize("kind", KINDS)
def test_nesting_within_the_limit_is_read(kind: str) -> None:
    sheet = read(nested(90, kind))
    assert read(format_sheet(sheet)) == sheet


def test_parentheses_alone_are_no_level() -> None:
    assert read(nested(3_000, "parentheses")) == read("x = y")


@pytest.mark.parametrize(
    "text", ["x = " + "1+" * 5_000_000 + "1", "x" * 10_000_000, "x = " + "(" * 10_000_000]
)
def test_a_line_of_ten_megabytes_is_refused_quickly(text: str) -> None:
    assert operations(lambda: codes(text)) < len(text)
    assert codes(text) == ["E125"]


def test_a_comment_may_be_of_any_length() -> None:
    assert len(read('x = y "' + "c" * 1_000_000).rules[0].comment) == 1_000_000


def test_a_sum_of_many_terms_is_one_node() -> None:
    terms = expression(" - ".join(f"a{k}" for k in range(5000))).terms
    assert len(terms) == 5000
    assert terms[-1] == Negative(Name("a4999"))


def test_a_long_chain_of_products_is_read_and_printed() -> None:
    text = "x = y" + "*y/z" * 149
    assert format_sheet(read(text)) == f"rules\n  {text}\n"


@pytest.mark.parametrize("row", ["x = {}", "x ~ {}", "x = 3 ± {}", "x in [0, {}]", "x < a*{}"])
@pytest.mark.parametrize(
    ("code", "deep"), [("E124", "-" * 5000 + "1"), ("E217", "1" + "*1" * 5000)]
)
def test_no_number_of_a_row_is_too_deep(row: str, code: str, deep: str) -> None:
    assert codes("variables\n" + row.format(deep) + "\nrules\ny = x*a") == [code]


WORDS = "x y sqrt 2 1.5 1e . ( ) ( ) = = + - * / ^ < >= <> , ; [m] [ ] ~ ± { − : π given to"
PIECES = [
    *WORDS.split(),
    *("if ", "then ", "else ", "and ", "or ", "not ", "call ", "in ", "use ", "list function"),
    *('"', "'open", "'", "\n", "\n", " ", "\t", "\0"),
    *("variables\n", "rules\n", "function f(a; x)\n", "parameters p\n", 'use "a.tk"\n'),
]


@settings(max_examples=400, deadline=None)
@given(st.lists(st.sampled_from(PIECES), max_size=25).map("".join))
def test_any_text_is_read_or_explained(text: str) -> None:
    try:
        sheet = read(text)
    except RuleSheetError as refused:
        assert all(diagnosis.labels and diagnosis.message for diagnosis in refused.diagnoses)
    else:
        assert read(format_sheet(sheet)) == sheet


# --- files --------------------------------------------------------------------------


def test_byte_order_mark_and_line_ends_are_dropped(tmp_path: Path) -> None:
    path = tmp_path / "sheet.tk"
    path.write_bytes("\ufeffx = y\r\ny = 3\r".encode())
    assert read_source(path).text == "x = y\ny = 3\n"


@pytest.mark.parametrize(
    ("content", "code"),
    [(b"x = 3\0", "E303"), (b"\xff\xfe", "E303"), (b"\x89PNG\r\n\x1a\n\0", "E303")],
)
def test_what_is_no_text_is_refused(tmp_path: Path, content: bytes, code: str) -> None:
    path = tmp_path / "sheet.tk"
    path.write_bytes(content)
    with pytest.raises(RuleSheetError) as caught:
        read_source(path)
    assert caught.value.diagnoses[0].code == code


def test_missing_files_and_folders_are_refused(tmp_path: Path) -> None:
    for path, code in (
        (tmp_path / "none.tk", "E301"),
        (tmp_path, "E302"),
        (tmp_path / "a\0b", "E304"),
    ):
        with pytest.raises(RuleSheetError) as caught:
            read_source(path)
        assert caught.value.diagnoses[0].code == code


def test_tables_that_were_kept_read_and_explain_alike(monkeypatch, tmp_path):
    monkeypatch.setenv("BACKSOLVE_CACHE", str(tmp_path / "store"))
    source = Source("<text>", "a + = 2")
    (line,) = logical_lines(source.text)
    for _ in range(2):
        grammar = Grammar()
        with pytest.raises(Unparsed) as stop:
            grammar.read(source, line, "rule")
        assert stop.value.place == 4
    assert len(list((tmp_path / "store").iterdir())) == 2


@pytest.mark.parametrize(
    ("line", "hidden"),
    [
        ("x = 3 ; y = 4", "y = 4"),
        ("x = 3; y = 2*x; z = 5", "y = 2*x"),
        ("x = V ; V = volume", None),
        ("x = 3 ; D = 3 mm pipe", None),
        ("x = 3 ; as given", None),
    ],
)
def test_a_rule_behind_a_semicolon_is_noted(line: str, hidden: str | None) -> None:
    told = [note.message for note in rulesheets.loads(line).notes]
    assert told == ([f"`{hidden}` is read as a comment: it follows a `;`"] if hidden else [])
