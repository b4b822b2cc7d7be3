"""Decimals decide where floats leave nothing but rounding: whether a limit is only approached, a
divisor is 0, an argument lies at the end of a domain."""

from __future__ import annotations

import contextlib
import math
from decimal import Decimal

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import rulesheets
import solver

decimals = st.builds(
    lambda digits, places: Decimal(digits).scaleb(-places), st.integers(1, 999), st.integers(0, 3)
)


def status(text: str, **inputs: Decimal) -> str:
    given_numbers = {name: float(number) for name, number in inputs.items()}
    return str(solver.solve(rulesheets.loads(text), given_numbers).status)


@given(rate=decimals, free=st.integers(1, 200), per=st.sampled_from([1, 12, 100, 365]))
def test_the_average_rate_of_a_tax_stays_below_its_rate(rate: Decimal, free: int, per: int) -> None:
    text = f"tax = {rate}*(income - {100 * free})\naverage = {per}*tax/income"
    assert status(text, average=per * rate) == "infeasible"


@given(most=decimals, half=decimals, share=st.sampled_from([1, 2, 4, 5, 8, 10, 25, 40]))
def test_a_saturated_rate_has_no_concentration(most: Decimal, half: Decimal, share: int) -> None:
    text = f"rate = {most}*c/({share}*c + {half})"
    assert status(text, rate=most / share) == "infeasible"


APPROACHES_ONE = (
    *("tanh(t/{k})", "erf(t/{k})", "1 - exp(-t/{k})", "t/({k} + t)", "atand(t/{k})/90"),
    *("sqrt(1 - 1/(t*{k}))", "1 - {k}/t^2", "t/sqrt(t^2 + {k})"),
)


@given(most=decimals, factor=decimals, scale=decimals, form=st.sampled_from(APPROACHES_ONE))
def test_what_is_approached_is_not_attained(
    most: Decimal, factor: Decimal, scale: Decimal, form: str
) -> None:
    text = f"v = {most}*U*({form.format(k=scale)})"
    assert status(text, v=most * factor, U=factor) == "infeasible"


@given(total=decimals, part=decimals, factor=decimals)
def test_nothing_is_left_of_decimals_that_cancel(
    total: Decimal, part: Decimal, factor: Decimal
) -> None:
    model = rulesheets.loads(f"all = {part}*{factor} + {total}*rest\nrest = share^2")
    result = solver.solve(model, {"all": float(part * factor)})
    assert [(s["rest"], s["share"]) for s in result.solutions] == [(0.0, 0.0)]


@given(most=decimals, half=decimals, factor=decimals)
def test_a_saturated_rate_that_is_computed_is_no_answer(
    most: Decimal, half: Decimal, factor: Decimal
) -> None:
    """Its last place may be off by what the numbers of the rules are."""
    text = f"rate = {most}*c/(0.7*c + {half})\n{factor * Decimal('0.7')}*rate = {factor * most}"
    assert status(text) != "solved"


@given(most=decimals, half=decimals, below=st.integers(1, 10**9))
def test_next_to_the_limit_there_is_one(most: Decimal, half: Decimal, below: int) -> None:
    rate = most * (1 - Decimal(below).scaleb(-12))
    text = f"rate = {most}*c/(c + {half})"
    result = solver.solve(rulesheets.loads(text), {"rate": float(rate)})
    assert result.complete
    (answer,) = result.solutions
    exact = half * Decimal(float(rate)) / (Decimal(float(most)) - Decimal(float(rate)))
    assert abs(Decimal(answer["c"]) / exact - 1) < Decimal("1e-3")


NOTHING = {
    "y - x - {k}*z": ("y", lambda x, z, k: x + k * z),
    "x*z - y": ("y", lambda x, z, k: x * z),
    "x^2 - y": ("y", lambda x, z, k: x * x),
    "y/{k} - x": ("y", lambda x, z, k: k * x),
    "(x + z)*{k} - y": ("y", lambda x, z, k: (x + z) * k),
    "x*(1 + z) - y": ("y", lambda x, z, k: x * (1 + z)),
    "x + {k}*y - x": ("y", lambda x, z, k: Decimal(0)),
}
"""Differences, and the number with which nothing is left of them."""


@pytest.mark.parametrize(
    "rule",
    ["q = 8/({d})", "q = 2 + 1/({d})^2", "q*({d}) = 3", "q = ln({d})", "w = {d}\nq = 3/w"],
)
@given(x=decimals, z=decimals, k=decimals, form=st.sampled_from(sorted(NOTHING)))
def test_nothing_is_divided_by_decimals_that_cancel(
    rule: str, x: Decimal, z: Decimal, k: Decimal, form: str
) -> None:
    name, number = NOTHING[form]
    inputs = {"x": x, "z": z, name: number(x, z, k)}
    rows = "".join(f" {name} = {value}\n" for name, value in inputs.items())
    text = f"variables\n{rows}rules\n {rule.format(d=form.format(k=k))}\n"
    result = solver.solve(rulesheets.loads(text))
    assert result.status is solver.Status.INFEASIBLE


@given(a=decimals, b=decimals, k=st.integers(2, 9))
def test_a_number_computed_on_the_way_is_as_exact(a: Decimal, b: Decimal, k: int) -> None:
    text = f"p = a*b\nq = s/{k} - b\nt = 7/(p - q)"
    assert status(text, a=a, b=b, s=k * (a * b + b)) == "infeasible"


AT_ENDS = {
    "t = acosd((a^2 + b^2 - c^2)/(2*a*b))": ({"c": lambda a, b: a + b}, 180.0),
    "t = acosd((a^2 + b^2 - c^2)/(2*b*a))": ({"c": lambda a, b: abs(a - b)}, 0.0),
    "u = (a^2 + b^2 - c^2)/(2*a*b)\nt = acosd(u)": ({"c": lambda a, b: a + b}, 180.0),
    "t = asind(c/(b*a))": ({"c": lambda a, b: a * b}, 90.0),
    "t = 2*sqrt(c - a^2)": ({"c": lambda a, b: a * a}, 0.0),
    "h = a^2 + b^2\nt = sqrt(c - h)": ({"c": lambda a, b: a * a + b * b}, 0.0),
    "D = c^2 - 4*a*d\nt = (-c + sqrt(D))/(2*a)": (
        {"c": lambda a, b: -2 * a * 3, "d": lambda a, b: 9 * a},
        3.0,
    ),
    "t = (a*b - c)^1.5 + 2": ({"c": lambda a, b: a * b}, 2.0),
    "sqrt(t) = c - a*b": ({"c": lambda a, b: a * b}, 0.0),
    "d = sqrt(2*a)\nt = acosd(d^2/(2*a))": ({}, 0.0),
    "s = (a + b + c)/2\nt = sqrt(s*(s - a)*(s - b)*(s - c))": ({"c": lambda a, b: a + b}, 0.0),
}
"""Formulas, the inputs that lead them to the end of a domain, and their values there."""


@pytest.mark.parametrize("rules", sorted(AT_ENDS))
@given(a=decimals, b=decimals)
def test_the_end_of_a_domain_belongs_to_it(rules: str, a: Decimal, b: Decimal) -> None:
    assume(a < 20 * b and b < 20 * a)
    others, value = AT_ENDS[rules]
    given_numbers = {"a": a, "b": b} | {name: number(a, b) for name, number in others.items()}
    model = rulesheets.loads(rules)
    inputs = {n: float(v) for n, v in given_numbers.items() if n in model.variables}
    result = solver.solve(model, inputs)
    assert result.status is solver.Status.SOLVED
    assert result["t"] == pytest.approx(value, abs=1e-5)


TOUCHED = {
    "cosd(t) = (a^2 + b^2 - c^2)/(2*a*b)": (lambda a, b: a + b, 180.0),
    "c^2 = a^2 + b^2 - 2*a*b*cosd(t)": (lambda a, b: abs(a - b), 0.0),
    "u = c/(a*b)\nsind(t) = u": (lambda a, b: a * b, 90.0),
    "a*sind(t) + b = c": (lambda a, b: a + b, 90.0),
}


@pytest.mark.parametrize("rules", sorted(TOUCHED))
@given(a=decimals, b=decimals)
def test_two_answers_coincide_where_decimals_touch_an_end(
    rules: str, a: Decimal, b: Decimal
) -> None:
    third, value = TOUCHED[rules]
    inputs = {"a": float(a), "b": float(b), "c": float(third(a, b))}
    result = solver.solve(rulesheets.loads(rules), inputs)
    assert (result.status, result["t"]) == (solver.Status.SINGULAR, value)


@given(a=decimals, b=decimals, beyond=st.integers(10, 10**6))
def test_what_lies_beyond_an_end_has_no_value(a: Decimal, b: Decimal, beyond: int) -> None:
    third = (a + b) * (1 + Decimal(beyond).scaleb(-13))
    rule = "t = acosd((a^2 + b^2 - c^2)/(2*a*b))"
    assume(a < 20 * b and b < 20 * a)
    assert status(rule, a=a, b=b, c=third) == "infeasible"


BESIDE_JUMPS = {
    "x = int(y/b)": (lambda b, k: b * k, lambda b, k: k),
    "x = -int(-y/b)": (lambda b, k: b * k, lambda b, k: k),
    "u = y/b\nx = int(u) + sgn(frac(u))": (lambda b, k: b * k, lambda b, k: k),
    "x = y - b*int(y/b)": (lambda b, k: b * k, lambda b, k: 0),
    "x = mod(y, b)": (lambda b, k: b * k, lambda b, k: 0),
    "x = frac(y/b)": (lambda b, k: b * k, lambda b, k: 0),
    "u = 100*y\nx = int(u)": (lambda b, k: Decimal(k) / 100, lambda b, k: k),
    "x = round(y*b/b)": (lambda b, k: k + Decimal("0.5"), lambda b, k: k + 1),
    "x = step(y/b, 2)": (lambda b, k: 2 * b, lambda b, k: 1),
    "x = sgn(y - 1.1*b)": (lambda b, k: b * Decimal("1.1"), lambda b, k: 0),
}
"""Rules that jump where decimals lead, the number ``y`` that leads there, and ``x``."""


@pytest.mark.parametrize("rules", sorted(BESIDE_JUMPS))
@given(b=decimals, k=st.integers(1, 30))
def test_decimals_decide_beside_a_jump(rules: str, b: Decimal, k: int) -> None:
    number, value = BESIDE_JUMPS[rules]
    model, inputs = rulesheets.loads(rules), {"y": float(number(b, k)), "b": float(b)}
    inputs = {name: number for name, number in inputs.items() if name in model.variables}
    result = solver.solve(model, inputs)
    assert (result.status, result["x"]) == (solver.Status.SOLVED, float(value(b, k)))
    plan = solver.prepare(model, ["y"], ["x"], inputs)
    with contextlib.suppress(solver.Unsolved):
        plan(1.037 * inputs["y"])
    assert plan(inputs["y"]) == (float(value(b, k)),)


AT_THRESHOLDS = {
    "if a*b {} c then x = 1 else x = 2": lambda a, b: a * b,
    "p = a*b\nif p {} c and a > 0 then x = 1 else x = 2": lambda a, b: a * b,
    "if a + b {} c then x = 1 else x = 2": lambda a, b: a + b,
    "n = c/a\nif n {} b then x = 1 else x = 2": lambda a, b: a * b,
    "p = 100*a\nif p {} c then x = b/b else x = 2*b/b": lambda a, b: 100 * a,
}
"""Rules that compare what is equal in decimals, with ``c``."""


@pytest.mark.parametrize("rules", sorted(AT_THRESHOLDS))
@given(a=decimals, b=decimals, operator=st.sampled_from([">=", "<=", ">", "<"]))
def test_numbers_that_are_equal_in_decimals_are_neither_less_nor_more(
    rules: str, a: Decimal, b: Decimal, operator: str
) -> None:
    case = 1.0 if operator in (">=", "<=") else 2.0
    model = rulesheets.loads(rules.format(operator))
    inputs = {"a": float(a), "b": float(b), "c": float(AT_THRESHOLDS[rules](a, b))}
    result = solver.solve(model, inputs)
    assert (result.status, result["x"]) == (solver.Status.SOLVED, case)
    plan = solver.prepare(model, ["a"], ["x"], inputs)
    plan(1.037 * inputs["a"])
    assert plan(inputs["a"]) == (case,)


BLOCKS = {
    "p = {a}*x + {b}*y\nq = x - {b}*y": lambda x, y, a, b: (a * x + b * y, x - b * y),
    "p = x + y^2\nq = x + {a}*y": lambda x, y, a, b: (x + y * y, x + a * y),
    "p = x*y\nq = x + y": lambda x, y, a, b: (x * y, x + y),
    "p = {a}*(x + y)^3 - x\nq = x*y + {b}": lambda x, y, a, b: (a * (x + y) ** 3 - x, x * y + b),
}
"""Rules that are solved together, and the numbers that two decimals lead to."""
AFTER = {
    "u = sqrt({k}*(x - T))": 0.0,
    "z = {k}*x\nu = 3 - 2*sqrt({k}*T - z)": 3.0,
    "u = (x/T - 1)^1.5": 0.0,
    "u = asind(x/T)": 90.0,
    "z = {k}*x\nif z >= {k}*T then u = 1 else u = 2": 1.0,
    "if x > T then u = 1 else u = 2": 2.0,
    "u = int(x/T)": 1.0,
}


@pytest.mark.parametrize("block", sorted(BLOCKS))
@given(
    x=decimals, y=decimals, a=decimals, b=decimals, k=decimals, then=st.sampled_from(sorted(AFTER))
)
def test_decimals_that_a_block_leads_to_decide(
    block: str, x: Decimal, y: Decimal, a: Decimal, b: Decimal, k: Decimal, then: str
) -> None:
    assume(x < 100 * y and y < 100 * x and abs(x - y) * 10 > x)  # no double root
    model = rulesheets.loads(f"{block}\n{then}".format(a=a, b=b, k=k))
    p, q = BLOCKS[block](x, y, a, b)
    result = solver.solve(model, {"p": float(p), "q": float(q), "T": float(x)})
    answers = [(s["x"], s["u"]) for s in result.solutions]
    assert any(s == pytest.approx((float(x), AFTER[then]), rel=1e-12) for s in answers), answers


@given(a=decimals, b=decimals, c=decimals, d=decimals, y=decimals, k=st.integers(1, 9))
def test_nothing_is_left_of_an_unknown_that_is_0(
    a: Decimal, b: Decimal, c: Decimal, d: Decimal, y: Decimal, k: int
) -> None:
    """Neither of decimals, nor of numbers with all the digits of floats."""
    assume(abs(a * d - b * c) * 1000 > max(a * d, b * c))
    text = f"{a}*x + {b}*y = p\n{c}*x + {d}*y = q\nu = sqrt(x)\nif x >= 0 then v = 1 else v = 2"
    for n in (1, math.exp(1.0 / k)):
        inputs = {"p": float(b * y) * n, "q": float(d * y) * n}
        result = solver.solve(rulesheets.loads(text), inputs)
        assert [(s["x"], s["u"], s["v"]) for s in result.solutions] == [(0.0, 0.0, 1.0)]


@pytest.mark.parametrize("length", [4, 40])
def test_a_chain_that_leads_to_no_decimals_is_followed_once(length: int) -> None:
    """Each of its rules reads the one before: a comparison at its end asks them all."""
    rules = [f"x{k} = 1.1*x{k - 1} - 0.3" for k in range(1, length)]
    text = "\n".join(["x0 = sin(a)", *rules, f"if x{length - 1} >= b then v = 1 else v = 2"])
    model = rulesheets.loads(text)
    end = solver.solve(model, {"a": 0.3}, want=[f"x{length - 1}"])[f"x{length - 1}"]
    assert isinstance(end, float)
    above = math.nextafter(end, math.inf)
    assert [solver.solve(model, {"a": 0.3, "b": b})["v"] for b in (end, above)] == [1.0, 2.0]


@given(k=st.integers(10, 99), y=st.integers(1, 9), a=st.integers(2, 9))
def test_a_small_number_that_has_digits_stays(k: int, y: int, a: int) -> None:
    x = Decimal(k).scaleb(-14)
    inputs = {"p": float(a * x + y), "q": float(x + y / Decimal(10))}
    text = f"{a}*x + y = p\nx + y/10 = q\nu = ln(x)"
    (answer,) = solver.solve(rulesheets.loads(text), inputs).solutions
    assert answer["x"] == pytest.approx(float(x), rel=0.05)


@pytest.mark.parametrize(
    "rule", ["x = exp(int(a))", "x = exp(a) + frac(b)", "if exp(a) > b then x = 1"]
)
def test_what_is_beyond_floats_has_no_decimals(rule: str) -> None:
    result = solver.solve(
        rulesheets.loads(rule), {"a": 1e4, "b": 0.3} if "b" in rule else {"a": 1e4}
    )
    assert result.status is not solver.Status.SOLVED
    assert result.diagnoses
