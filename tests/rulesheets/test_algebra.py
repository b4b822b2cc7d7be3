"""Rules as sympy equations: agreement with the evaluator, guards, and what is printed."""

import math

import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from rulesheets import loads
from rulesheets.algebra import MATHEMATICS, listing, mathematics, sympy_equations
from rulesheets.evaluate import Undefined, value
from rulesheets.format import latex_name
from rulesheets.functions import TABLE
from rulesheets.syntax.nodes import Call, Name

x, y, z = sympy.symbols("x y z")


def test_every_built_in_function_has_its_sympy_form():
    assert set(TABLE) <= set(MATHEMATICS)


@pytest.mark.parametrize("name", sorted(TABLE))
@settings(deadline=None, max_examples=12)
@given(numbers=st.lists(st.integers(-64, 64).map(lambda k: k / 16), min_size=2, max_size=2))
def test_sympy_and_the_evaluator_agree(name, numbers):
    _, most = TABLE[name].arity
    count = 2 if most is None else most
    if name in ("jn", "yn"):
        numbers = [float(round(numbers[0])), numbers[1]]
    names = ("x", "y")[:count]
    expression = Call(name, tuple(Name(item) for item in names))
    values = dict(zip(names, numbers, strict=False))
    try:
        expected = value(expression, values)
    except Undefined:
        return
    exact = {sympy.Symbol(item): sympy.Rational(number) for item, number in values.items()}
    computed = complex(mathematics(expression).subs(exact).evalf(30))
    assert computed.imag == pytest.approx(0.0, abs=1e-20)
    assert computed.real == pytest.approx(expected, rel=1e-11, abs=1e-300)


def test_an_equation_is_an_eq_of_plain_symbols():
    (found,) = sympy_equations(loads("y = 2*x^2 + sind(x)"))
    assert found.equation == sympy.Eq(y, 2 * x**2 + sympy.sin(sympy.pi * x / 180))


def test_a_guard_stands_beside_its_equation():
    then, otherwise = sympy_equations(loads("if x > 3 then y = 1 else y = 2"))
    assert (then.guard, then.equation) == (x > 3, sympy.Eq(y, 1))
    assert otherwise.guard == sympy.Not(x > 3, evaluate=False)
    assert otherwise.equation == sympy.Eq(y, 2)


def test_every_rule_has_its_equation_guard_and_place():
    model = loads("y = x\nif and(x > 3, z = 'open) then y = z^2")
    plain, guarded = sympy_equations(model)
    assert plain.guard is sympy.true
    assert guarded.equation == sympy.Eq(y, z**2)
    assert guarded.guard == sympy.And(x > 3, sympy.Eq(z, sympy.Symbol("'open")))
    assert (plain.place.line, guarded.place.line) == (1, 2)


def test_sides_that_say_the_same_stay_an_equation():
    assert isinstance(sympy_equations(loads("x - x = 0"))[0].equation, sympy.Eq)


def test_a_long_product_converts_without_deep_recursion():
    model = loads("y = " + "*".join(["x"] * 300))
    assert sympy_equations(model)[0].equation.rhs == x**300


@pytest.mark.parametrize(
    ("rule", "text"),
    [
        ("xB - xA = +sqrt(AB^2 - (yB - yA)^2)", "xB - xA = sqrt(AB^2 - (yB - yA)^2)"),
        ("m2*m1 = -1", "m2*m1 = -1"),
        ("y = ln(x)/log(x)", "y = ln(x)/log(x)"),
        ("y = 0.1*x", "y = 0.1*x"),
        ("y = 2*cosd(theta + 90)*exp(-x)", "y = 2*cosd(theta + 90)*exp(-x)"),
        ("y = -a*b/c", "y = -a*b/c"),
        ("y = -(a + b)*c", "y = -(a + b)*c"),
        ("y = a - -3", "y = a - -3"),
        ("if branch <> 'open then y = 1", "y = 1   if branch <> 'open"),
        (
            "if and (z >= 1, a > 0, given('z)) then y = 1",
            "y = 1   if z >= 1 and a > 0 and given('z)",
        ),
        ("if or (a = 1, and(b > 2, c < 3)) then y = 1", "y = 1   if a = 1 or b > 2 and c < 3"),
    ],
)
def test_the_listing_reads_like_the_sheet(rule, text):
    place, _, rest = listing(loads(rule, name="sheet.tk")).partition("  ")
    assert place == "sheet.tk:1"
    assert rest == text


def test_a_guard_that_must_fail_is_listed_as_not():
    model = loads("if x > 3 then y = 1 else if z = 1 then y = 2 else y = b", name="s")
    assert listing(model).splitlines() == [
        "s:1  y = 1   if x > 3",
        "s:1  y = 2   if not (x > 3) and z = 1",
        "s:1  y = b   if not (x > 3) and z <> 1",
    ]


def test_latex_lists_every_equation():
    model = loads("omegaAB = vAB/AB\nif thetaAO = 'open then xa = cosd(thetaAO)^2", name="s.tk")
    assert listing(model, latex=True) == (
        "\\begin{align*}\n"
        "  % s.tk:1\n"
        "  \\omega_{AB} &= \\frac{v_{AB}}{\\mathit{AB}} \\\\\n"
        "  % s.tk:2\n"
        "  x_{a} &= \\operatorname{cosd}^{2}\\left(\\theta_{AO}\\right)"
        " && \\text{if } \\theta_{AO} = \\text{'open}\n"
        "\\end{align*}"
    )


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("omegaAB", r"\omega_{AB}"),
        ("theta", r"\theta"),
        ("theta_1", r"\theta_{1}"),
        ("xB", "x_{B}"),
        ("xb11", "x_{b11}"),
        ("m2", "m_{2}"),
        ("aBAn", "a_{BAn}"),
        ("AO", r"\mathit{AO}"),
        ("offset", r"\mathrm{offset}"),
        ("offset_left", r"\mathrm{offset\_left}"),
        ("position.yB", r"\text{position.}y_{B}"),
        ("position#2.yB", r"\text{position\#2.}y_{B}"),
        ("piston", r"\mathrm{piston}"),
        ("etas", r"\mathrm{etas}"),
        ("vx", "v_{x}"),
        ("Fy2", "F_{y2}"),
        ("dx", r"\mathrm{dx}"),
        ("Delta", r"\Delta"),
    ],
)
def test_names_in_latex(name, latex):
    assert latex_name(name) == latex


def test_numbers_keep_their_digits():
    assert math.isclose(float(mathematics(Call("pi", ()))), math.pi)
    assert listing(loads("y = 0.30000000000000004", name="s")).endswith("0.30000000000000004")
