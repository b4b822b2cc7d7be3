"""Calls expanded into the calling sheet: names, guards, places, order."""

import pytest

from rulesheets import RuleSheetError, loads
from rulesheets.format import format_condition, format_expression
from rulesheets.model import Model, Premise
from rulesheets.syntax.nodes import Call, Number, Product
from tests.oracles.operations import growth


def equations(model: Model) -> list[str]:
    return [
        f"{format_expression(item.left)} = {format_expression(item.right)}"
        for item in model.equations
    ]


def guards(model: Model) -> list[list[tuple[str, bool]]]:
    return [
        [
            (format_condition(model.conditions[premise.condition]), premise.holds)
            for premise in item.guard
        ]
        for item in model.equations
    ]


DOUBLE = """
function double(a; b)
rules
  half = a
  b = 2*half
"""


def test_a_bare_list_of_equations_is_a_model():
    model = loads("x + y = 10\nx - y = 2")
    assert list(model.variables) == ["x", "y"]
    assert all(variable.posted for variable in model.variables.values())
    assert equations(model) == ["x + y = 10", "x - y = 2"]


def test_plain_names_are_the_callers_variables_and_other_names_are_local():
    model = loads("call double(p; q)" + DOUBLE)
    assert equations(model) == ["double.half = p", "q = 2*double.half"]
    assert list(model.variables) == ["p", "q", "double.half"]
    assert [variable.posted for variable in model.variables.values()] == [True, True, False]


def test_an_expression_as_actual_gets_a_dotted_variable_and_an_equation():
    model = loads("call double(p + 1; 3*q)" + DOUBLE)
    assert equations(model) == [
        "double.a = p + 1",
        "double.b = 3*q",
        "double.half = double.a",
        "double.b = 2*double.half",
    ]


def test_the_second_call_in_a_scope_is_numbered():
    model = loads("call double(p; q)\ncall double(q; r)\ncall double(r; s)" + DOUBLE)
    assert [name for name in model.variables if "." in name] == [
        "double.half",
        "double#2.half",
        "double#3.half",
    ]


def test_calls_nest_and_scopes_nest_with_them():
    model = loads(
        "call outer(p; q)\nfunction outer(x; y)\nrules\n  call double(x; m)\n  y = m + 1\n" + DOUBLE
    )
    assert equations(model) == [
        "outer.double.half = p",
        "outer.m = 2*outer.double.half",
        "q = outer.m + 1",
    ]
    assert [item.scope for item in model.equations] == ["outer.double.", "outer.double.", "outer."]


def test_parameters_are_shared_by_name_through_every_level():
    model = loads(
        "k = 3\ncall outer(p; q)\n"
        "function outer(x; y)\nparameters k\nrules\n  call inner(x; y)\n"
        "function inner(x; y)\nparameters k\nrules\n  y = k*x\n"
    )
    assert equations(model) == ["k = 3", "q = k*p"]


def test_a_parameter_may_be_a_local_of_the_calling_function():
    model = loads(
        "call outer(p; q)\n"
        "function outer(x; y)\nrules\n  k = x + 1\n  call inner(x; y)\n"
        "function inner(x; y)\nparameters k\nrules\n  y = k*x\n"
    )
    assert equations(model) == ["outer.k = p + 1", "q = outer.k*p"]


def test_a_call_in_an_expression_becomes_the_variable_of_its_result():
    model = loads("y = 1 + double(x)*double(z)" + DOUBLE)
    assert equations(model) == [
        "y = 1 + double.b*double#2.b",
        "double.half = x",
        "double.b = 2*double.half",
        "double#2.half = z",
        "double#2.b = 2*double#2.half",
    ]


def test_a_call_as_a_whole_side_binds_its_result_to_the_other_side():
    assert equations(loads("y = double(x)" + DOUBLE)) == equations(
        loads("call double(x; y)" + DOUBLE)
    )
    assert equations(loads("double(x) = y" + DOUBLE)) == equations(
        loads("call double(x; y)" + DOUBLE)
    )


def test_a_call_as_actual_needs_no_variable_of_its_own():
    model = loads("y = double(double(x)) + 0" + DOUBLE)
    assert sorted(name for name in model.variables if "." in name) == [
        "double#2.b",
        "double#2.half",
        "double.b",
        "double.half",
    ]


def test_several_results_fill_a_tuple():
    split = "\nfunction split(a; b, c)\nrules\n  (b, c) = (a/2, a/3)\n"
    assert equations(loads("(x, y) = split(z)" + split)) == ["x = z/2", "y = z/3"]
    assert equations(loads("call split(z; x, y)" + split)) == ["x = z/2", "y = z/3"]


def test_a_tuple_is_one_rule_of_several_equations():
    model = loads("(a, b) = (c + 1, d)")
    assert equations(model) == ["a = c + 1", "b = d"]
    assert {item.rule.text for item in model.equations} == {"(a, b) = (c + 1, d)"}


def test_an_else_arm_shares_the_condition_of_its_then_arm():
    model = loads("if x > 3 then y = 1 else y = 2")
    assert [item.guard for item in model.equations] == [(Premise(0, True),), (Premise(0, False),)]
    assert model.equations[0].rule.text == "if x > 3 then y = 1 else y = 2"
    assert list(model.variables) == ["x", "y"]


def test_premises_of_nested_ifs_accumulate():
    model = loads(
        "if x > 3 then if y > 4 then z = 1 else z = 2 else if y = 5 then z = 3 else z = 4"
    )
    assert guards(model) == [
        [("x > 3", True), ("y > 4", True)],
        [("x > 3", True), ("y > 4", False)],
        [("x > 3", False), ("y = 5", True)],
        [("x > 3", False), ("y = 5", False)],
    ]


def test_the_rules_of_a_guarded_call_inherit_the_guard():
    model = loads("if x > 3 then call double(p + 1; q)" + DOUBLE)
    assert [item.guard for item in model.equations] == [(Premise(0, True),)] * 3


def test_a_call_in_a_condition_is_not_guarded_by_it():
    model = loads("if double(x) > 3 then y = 1" + DOUBLE)
    assert guards(model) == [[("double.b > 3", True)], [], []]


def test_conditions_inside_a_function_are_under_full_names():
    model = loads(
        "call f(p; q)\nfunction f(a; b)\nrules\n  t = a\n  if and(t > 1, given('a)) then b = 1 "
        "else b = 2\n"
    )
    assert format_condition(model.conditions[0]) == "f.t > 1 and given('p)"


def test_rules_keep_their_place_in_the_function():
    model = loads("call double(p + 1; q)" + DOUBLE)
    assert [item.rule.text for item in model.equations] == [
        "call double(p + 1; q)",
        "half = a",
        "b = 2*half",
    ]
    assert [item.rule.line for item in model.equations] == [1, 4, 5]


def test_function_names_are_read_in_any_case_and_locals_carry_the_defined_one():
    model = loads("y = 1 + TWICE(x)\nfunction Twice(a; b)\nrules\n  b = 2*a\n")
    assert "Twice.b" in model.variables


def test_a_built_in_function_can_be_called_too():
    assert equations(loads("call atan2d(y, x; t)")) == ["t = atan2d(y, x)"]


def test_many_rules_expand_quickly_and_without_recursion():
    model = loads("\n".join(f"x{k + 1} = x{k} + {k}" for k in range(3000)))
    assert len(model.equations) == 3000
    from rulesheets.build import build
    from rulesheets.syntax.nodes import Equality, Name, Number, Rule, RuleSheet, Sum
    from rulesheets.syntax.program import Program

    def chain(n: int):
        rules = tuple(
            Rule(Equality((Name(f"x{k + 1}"),), (Sum((Name(f"x{k}"), Number(1.0))),)))
            for k in range(n)
        )
        return lambda: build(Program(RuleSheet(rules=rules), {}), "chain")

    assert len(chain(32_000)().equations) == 32_000
    assert growth(chain, 1_000) < 1.2


def test_a_long_chain_of_else_ifs_is_no_deep_recursion():
    from rulesheets.build import build
    from rulesheets.syntax.nodes import (
        Comparison,
        Equality,
        IfRule,
        Name,
        Number,
        Rule,
        RuleBody,
        RuleSheet,
    )
    from rulesheets.syntax.program import Program

    body: RuleBody = Equality((Name("y"),), (Number(0.0),))
    for k in range(2000):
        arm = Equality((Name("y"),), (Number(float(k)),))
        body = IfRule(Comparison("=", Name("x"), Number(float(k))), arm, body)
    model = build(Program(RuleSheet(rules=(Rule(body),)), {}), "cases")
    assert len(model.conditions) == 2000
    assert len(model.equations[-1].guard) == 2000


def test_functions_that_multiply_are_stopped():
    levels = 30
    text = "y = f0(x)\n" + "".join(
        f"function f{k}(a; b)\nrules\n  b = f{k + 1}(a) + f{k + 1}(a + 1)\n" for k in range(levels)
    )
    text += f"function f{levels}(a; b)\nrules\n  b = a\n"
    with pytest.raises(RuleSheetError) as caught:
        loads(text)
    assert caught.value.diagnoses[0].code == "E216"


def test_calls_that_nest_too_deep_are_stopped():
    text = "y = f0(x)\n" + "".join(
        f"function f{k}(a; b)\nrules\n  b = f{k + 1}(a)\n" for k in range(150)
    )
    text += "function f150(a; b)\nrules\n  b = a\n"
    with pytest.raises(RuleSheetError) as caught:
        loads(text)
    assert [item.code for item in caught.value.diagnoses] == ["E216"]


def test_a_long_product_is_read_and_an_endless_one_refused():
    assert len(loads("y = " + "*".join(["x"] * 250)).equations) == 1
    assert len(loads("y = " + " + ".join(["x"] * 5000)).equations) == 1
    with pytest.raises(RuleSheetError) as caught:
        loads("y = " + "*".join(["x"] * 5000))
    assert [item.code for item in caught.value.diagnoses] == ["E217"]


@pytest.mark.parametrize(
    ("written", "number"),
    [
        ("sin(pi)", 0.0),
        ("sin(-2*pi())", 0.0),
        ("cos(pi/2)", 0.0),
        ("cos(2*pi/3)", -0.5),
        ("sin(pi - pi/6)", 0.5),
        ("cos(1/3*pi)", 0.5),
        ("tan(pi/4 + pi)", 1.0),
        ("SIN(7*pi/6)", -0.5),
    ],
)
def test_what_is_exactly_a_float_at_a_part_of_pi_is_put_in(written: str, number: float) -> None:
    (equation,) = loads(f"x = 3*{written}").equations
    assert equation.right == Product(Number(3.0), Number(number))
    assert loads(f"if x > {written} then y = 1").conditions[0].right == Number(number)


@pytest.mark.parametrize(
    "written", ["tan(pi/2)", "sin(pi/4)", "sin(3.14159)", "sin(pi*y)", "sin(pi + 1)", "sin(0*pi/0)"]
)
def test_what_no_float_is_stays_as_it_is_written(written: str) -> None:
    (equation,) = loads(f"x = {written}").equations
    assert isinstance(equation.right, Call)
