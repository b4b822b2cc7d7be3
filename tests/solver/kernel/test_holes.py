"""Poles of a residual, and points where it is 0/0: what is proven there, and what must not be."""

from __future__ import annotations

import math

import pytest
from scipy.optimize import brentq

import rulesheets
import solver

TRIANGLES = (
    "a/sind(A) = b/sind(B)\nb/sind(B) = c/sind(C)\nA + B + C = 180",
    "d = a/sind(A)\nd = b/sind(B)\nd = c/sind(C)\nA + B + C = 180",
)


@pytest.mark.parametrize("text", TRIANGLES)
def test_a_triangle_that_its_sides_do_not_make_is_infeasible(text: str) -> None:
    found = solver.solve(rulesheets.loads(text), {"a": 1.0, "b": 2.0, "c": 4.0})
    assert str(found.status) == "infeasible"
    (note,) = found.diagnoses[0].notes
    assert note.endswith("a solution needs a > 2, b > 3 or c < 3")
    found = solver.solve(rulesheets.loads(text), {"a": 3.0, "b": 4.0, "c": 5.0})
    assert found.complete
    assert found["C"] == pytest.approx(90.0)


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("x*y = 3*x\nx + y = 5", [0.0, 2.0]),
        ("w*(x - 2) = (x - 2)*(x + 1)\nw = 9 - x", [2.0, 4.0]),
        (
            "w*(x - 2) = (x - 2)*(x + 1)\nw^2 = 9 - x",
            [-4.701562118716424, 1.7015621187164243, 2.0, 2.0],
        ),
        ("u*x = x*v\nu*v = 6 - x\nv = x + 1", [-4.192582403567252, 0.0, 1.1925824035672519]),
    ],
)
def test_a_factor_that_vanishes_leaves_an_answer(text: str, values: list[float]) -> None:
    """A rule that is a product divides by nothing: what is undone by a quotient must not be
    cancelled."""
    found = solver.solve(rulesheets.loads(text))
    assert sorted(answer["x"] for answer in found.solutions) == pytest.approx(values, rel=1e-9)


@pytest.mark.parametrize(
    ("text", "given", "unknown", "values"),
    [
        (
            "A = P*i/(1 - (1 + i)^(-n))",
            {"A": 150.0, "P": 9_000.0, "n": 71.0},
            "i",
            [0.004822449456],
        ),
        ("1/x + 1/(x - 1) = 3", {}, "x", [0.2324081207560018, 1.4342585459106648]),
        ("e = 1 - (r^1.4 - 1)/(1.4*(r - 1)*18^0.4)", {"e": 0.63}, "r", [2.033821158]),
        ("variables\n D in [0, 180]\nrules\n T = R*tand(D/2)\n pi*R*D = 180*L", {}, "D", [42.0]),
    ],
)
def test_poles_and_holes_are_no_gaps(
    text: str, given: dict[str, float], unknown: str, values: list[float]
) -> None:
    if not given and "T" in text:
        given = {"T": 300 * math.tan(math.radians(21)), "L": 300 * math.radians(42)}
    found = solver.solve(rulesheets.loads(text), given)
    assert found.complete
    assert sorted(answer[unknown] for answer in found.solutions) == pytest.approx(values, rel=1e-6)


def test_a_pole_of_several_denominators_is_no_gap() -> None:
    """Backwater in a trapezoidal channel: the velocity head has A^2 below, friction A^2 R^(4/3).
    Their common denominator tells that a depth of -b/z, where the area vanishes, is no answer. One
    depth is, by Brent's method."""

    def energy(y: float, sign: float) -> float:
        area, wetted = y * (8.0 + 1.5 * y), 8.0 + 2.0 * math.sqrt(3.25) * y
        slope = (0.02 * 25.0 / area) ** 2 / (area / wetted) ** (4 / 3)
        return y + (25.0 / area) ** 2 / 19.62 + sign * 15.0 * slope

    rules = ["y0 = 2.5", "E1 = E0 - 30*(0.0006 - (S1 + S0)/2)"]
    for i in (0, 1):
        rules += [f"A{i} = y{i}*(8 + 1.5*y{i})", f"P{i} = 8 + 2*sqrt(3.25)*y{i}"]
        rules += [f"V{i} = 25/A{i}", f"R{i} = A{i}/P{i}", f"S{i} = (0.02*V{i})^2/R{i}^(4/3)"]
        rules.append(f"E{i} = y{i} + V{i}^2/19.62")
    found = solver.solve(rulesheets.loads("\n".join(rules)))
    depth = brentq(lambda y: energy(y, -1.0) - energy(2.5, 1.0) + 0.018, 2.0, 3.0, xtol=1e-14)
    assert found.complete
    assert [answer["y1"] for answer in found.solutions] == pytest.approx([depth], rel=1e-12)


def test_the_head_losses_of_three_pipes_have_one_answer() -> None:
    rules = [f"z{i} - H = {k}*Q{i}*abs(Q{i})" for i, k in enumerate((100, 200, 150), 1)]
    model = rulesheets.loads("\n".join([*rules, "Q1 + Q2 + Q3 = 0"]))
    found = solver.solve(model, {"z1": 50.0, "z2": 30.0, "z3": 10.0})
    assert found.complete
    assert len(found.solutions) == 1
    assert [found[f"Q{i}"] > 0.0 for i in (1, 2, 3)] == [True, False, False]


def test_a_factor_cancels_in_the_product_that_a_name_stands_for() -> None:
    """A throw for t seconds that ends at a height y, and a load on two ropes: where the cosine, or
    the sine of the sum, is 0, rules divide by 0, and nothing is left to search there."""
    v, y, t = 15.0, 3.0, 0.936
    rules = "y = x*tand(al) - 9.81*x^2/(2*v^2*cosd(al)^2)\nt = x/(v*cosd(al))"
    found = solver.solve(rulesheets.loads(rules), {"v": v, "y": y, "t": t})
    sine = (y + 9.81 * t**2 / 2) / (v * t)
    reach = v * t * math.sqrt(1 - sine**2)
    assert sorted(answer["x"] for answer in found.solutions) == pytest.approx([-reach, reach])
    assert found.complete

    rules = "T1 = 30*g*cosd(b)/sind(a + b)\nT2 = 30*g*cosd(a)/sind(a + b)"
    found = solver.solve(rulesheets.loads(rules), {"b": 55.0, "T1": 169.4, "T2": 226.0})
    tilt = math.degrees(math.acos(226.0 / 169.4 * math.cos(math.radians(55.0))))
    assert sorted(answer["a"] for answer in found.solutions) == pytest.approx([-tilt, tilt])
    assert found.complete


def test_a_mean_wage_with_overtime_has_one_answer() -> None:
    """0/0 at no hours; below 40 hours the mean is 18 throughout."""
    rules = "pay = 18*min(h, 40) + 27*max(h - 40, 0)\nmean = pay/h"
    found = solver.solve(rulesheets.loads(rules), {"mean": 19.17})
    assert [answer["h"] for answer in found.solutions] == pytest.approx([360 / (27 - 19.17)])
    assert found.complete


@pytest.mark.parametrize("power", [2, 3, 4, 5])
@pytest.mark.parametrize("factor", [1.0, 2.5, -3.0])
@pytest.mark.parametrize("reverse", [False, True])
def test_a_divisor_multiplied_out_adds_no_answer(power: int, factor: float, reverse: bool) -> None:
    """At 0 the step ``t = v*s/10`` has a value, and the rule that it comes from has none."""
    rules = [f"s = {factor}*t^{power}", "v = 10*t/s"]
    found = solver.solve(rulesheets.loads("\n".join(rules[::-1] if reverse else rules)), {"v": 9.0})
    size = abs(10 / (9 * factor)) ** (1 / (power - 1))
    signs = (1.0, -1.0) if (power - 1) % 2 == 0 else (math.copysign(1.0, factor),)
    expected = [] if power % 2 and factor < 0.0 else sorted(sign * size for sign in signs)
    assert found.complete
    assert sorted(answer["t"] for answer in found.solutions) == pytest.approx(expected)


def test_a_point_without_a_limit_is_no_further_answer() -> None:
    """At n = 0 and C = S the yearly loss is 0/0, and other in every direction."""
    rules = "S = C*(1 - d)^n\nloss = (C - S)/n"
    found = solver.solve(rulesheets.loads(rules), {"S": 5000.0, "loss": 7500.0, "d": 0.32})
    assert len(found.solutions) == 1
    assert found.complete
    assert not found.diagnoses


@pytest.mark.parametrize(("p", "q"), [(0.5, 1.25), (0.5, 0.75), (1.5, 2.5)])
@pytest.mark.parametrize("flow", [0.4, 2.2, 5.0])
def test_a_power_of_a_product_cancels_one_of_its_factor(p: float, q: float, flow: float) -> None:
    """The specific speed of a turbine grows without bound where friction leaves no head."""
    rules = f"hf = 0.6*Q^2\nH = 96 - hf\nP = 9.81*Q*H*0.88\nn = 750*P^{p}/H^{q}"
    head = 96 - 0.6 * flow**2
    speed = 750 * (9.81 * flow * head * 0.88) ** p / head**q
    found = solver.solve(rulesheets.loads(rules), {"n": speed})
    assert [answer["Q"] for answer in found.solutions] == pytest.approx([flow])
    assert found.complete


@pytest.mark.parametrize("p", [0.05, 0.35, 0.8])
def test_a_quotient_within_a_root_is_reduced(p: float) -> None:
    """The standard error of a share in a sample of a finite population: 0/0 for a share of 1."""
    rules = "n0 = 4*p*(1 - p)/0.0009\nn = n0/(1 + (n0 - 1)/8000)\nlow = p - 2*sqrt(p*(1 - p)/n)"
    low = solver.solve(rulesheets.loads(rules), {"p": p})["low"]
    found = solver.solve(rulesheets.loads(rules), {"low": low})
    assert [answer["p"] for answer in found.solutions] == pytest.approx([p])
    assert found.complete


@pytest.mark.parametrize("n", [6.0, 48.0, 120.0])
def test_a_rate_that_0_divides_is_no_gap(n: float) -> None:
    """What n payments make, with a rest to pay at the end: none would have to be infinite."""
    rules = "pay = (26000 - 9000*1.004^(-n))*0.004/(1 - 1.004^(-n))\ntotal = n*pay + 9000"
    total = n * (26000 - 9000 * 1.004**-n) * 0.004 / (1 - 1.004**-n) + 9000
    found = solver.solve(rulesheets.loads(rules), {"total": total})
    assert [answer["n"] for answer in found.solutions] == pytest.approx([n])
    assert found.complete


@pytest.mark.parametrize("function", ["ln", "log10"])
@pytest.mark.parametrize("share", [0.3, 2.0, 7.0])
def test_a_logarithm_has_no_value_at_0(function: str, share: float) -> None:
    """ln(r/a) = s*ln(r/b) is linear in ln(r)."""
    rules = f"K = {function}(r/15)/20\n{function}(r/0.2) = {share}*20*K"
    found = solver.solve(rulesheets.loads(rules))
    radius = math.exp((math.log(0.2) - share * math.log(15)) / (1 - share))
    assert [answer["r"] for answer in found.solutions] == pytest.approx([radius])
    assert found.complete


@pytest.mark.parametrize("ratio", [0.2, 0.97, 1.9, 7.0])
@pytest.mark.parametrize("angle", [25.0, 62.0])
def test_a_common_factor_that_is_not_0_leaves_answers(ratio: float, angle: float) -> None:
    """The tension of a rope that holds a boom of length x: x is 0, or is no factor."""
    text = "T*x*sind(a - g) = x*cosd(a)\ntand(g) = (x*sind(a) - 5)/(x*cosd(a) + 3)"
    found = solver.solve(rulesheets.loads(text), {"a": angle, "T": ratio})
    sine, cosine = math.sin(math.radians(angle)), math.cos(math.radians(angle))
    between = math.asin(min(1.0, cosine / ratio))
    slopes = [math.tan(math.radians(angle) - b) for b in (between, math.pi - between)]
    lengths = [(5 + 3 * slope) / (sine - slope * cosine) for slope in slopes]
    if ratio >= cosine:
        for length in lengths:
            assert any(answer["x"] == pytest.approx(length) for answer in found.solutions)
    else:
        assert all(answer["x"] == 0.0 for answer in found.solutions)


@pytest.mark.parametrize("log", ["ln", "log"])
@pytest.mark.parametrize("time", [0.01, 0.9, 5.0, 30.0])
def test_logarithms_end_at_poles_of_their_quotients(time: float, log: str) -> None:
    """The period of a trigger, which rises from 0 without end as a share k of its supply grows."""
    text = f"h = k*v\nl = 0.3*k*v\nt = {log}((v + h)/(v - h)) + {log}((v + l)/(v - l))"
    found = solver.solve(rulesheets.loads(text), {"v": 10.8, "t": time})
    unit = 1.0 if log == "ln" else math.log(10.0)

    def miss(k: float) -> float:
        return 2 * (math.atanh(k) + math.atanh(0.3 * k)) / unit - time

    top = math.nextafter(1.0, 0.0)
    roots = [brentq(miss, 0.0, top, xtol=1e-15)] if miss(top) > 0.0 else []
    assert found.complete or not roots
    assert [answer["k"] for answer in found.solutions] == pytest.approx(roots, rel=1e-9)


@pytest.mark.parametrize("shift", [0.0, 2.0, 2.3])
@pytest.mark.parametrize("power", [0.2, 0.33, 0.5, 0.9])
def test_a_root_where_a_slope_is_infinite_is_counted(power: float, shift: float) -> None:
    """Growth that ends where decay is as large as it, and at nothing."""
    text = "y = s*(k - a)^p\ny = c*(k - a)"
    found = solver.solve(rulesheets.loads(text), {"s": 0.22, "c": 0.08, "p": power, "a": shift})
    ends = [shift, shift + (0.22 / 0.08) ** (1 / (1 - power))]
    assert found.complete
    assert sorted(answer["k"] for answer in found.solutions) == pytest.approx(ends, rel=1e-9)


@pytest.mark.parametrize("rule", ["tand(x)*cosd(x) = 1", "tand(x - 30)*cosd(x - 30) = 1"])
def test_a_point_where_a_rule_is_undefined_is_no_double_root(rule: str) -> None:
    """The sine of an angle is 1 at one where it is no quotient: only a limit."""
    found = solver.solve(rulesheets.loads(f"rules\n  {rule}\n"))
    assert str(found.status) == "singular"
    assert not any("x" in answer for answer in found.solutions)


@pytest.mark.parametrize("share", [0.0882, 0.1, 0.15])
def test_a_reciprocal_of_0_refutes_no_answer(share: float) -> None:
    """Methanol from a feed of exactly the proportions in which it reacts: with nothing fed and
    nothing purged every rule holds, and the purge times its content is 0 = 0."""
    text = """
        F + Rr = 100
        xH*F + yH*Rr = yH1*100
        xI*F + yI*Rr = yI1*100
        yH1 + yC1 + yI1 = 1
        yH + yC + yI = 1
        yC1*100 = M + yC*(Rr + Pu)
        yH1*100 = 2*M + yH*(Rr + Pu)
        yI1*100 = yI*(Rr + Pu)
        M = sp*yC1*100"""
    given = {"xH": 0.673, "xI": 0.002, "yI": 0.08, "sp": share}
    found = solver.solve(rulesheets.loads(text), given)
    assert found.status is solver.Status.SINGULAR
    assert not found.complete
