"""Blocks that lead to one polynomial: every answer, and none where exact counting says so."""

from __future__ import annotations

import itertools
import math
import random
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import rulesheets
import solver
from solver.facts import Method


def solved(sheet: str, **inputs: float) -> solver.Result:
    return solver.solve(rulesheets.loads(sheet), inputs)


def methods(result: solver.Result) -> list[Method]:
    return [attempt.method for attempts in result.attempts.values() for attempt in attempts]


CUBIC = "y = x^3 - 6*x^2\ny + 11*x = k"


@pytest.mark.parametrize(("k", "roots"), [(6.0, [1, 2, 3]), (0.0, [0]), (5.0, None), (1e6, None)])
def test_roots_of_a_cubic(k: float, roots: list[float] | None) -> None:
    result = solved(CUBIC, k=k)
    assert str(result.status) == "solved"
    assert result.complete
    assert k == 1e6 or methods(result) == [Method.POLYNOMIAL]
    for solution in result.solutions:
        x = solution["x"]
        assert x**3 - 6 * x**2 + 11 * x == pytest.approx(k, rel=1e-13, abs=1e-13)
    if roots is not None:
        assert sorted(s["x"] for s in result.solutions) == pytest.approx(roots, abs=1e-15)


def test_planted_roots_of_random_blocks() -> None:
    draw = random.Random(3)
    for _ in range(20):
        roots = sorted(draw.sample(range(-9, 10), 4))
        a, b, c, d = roots
        sheet = f"u = (x - ({a}))*(x - ({b}))\nw = (x - ({c}))*(x - ({d}))\nu*w = v\nv = 0*x"
        result = solved(sheet)
        assert result.complete
        assert sorted(s["x"] for s in result.solutions) == pytest.approx(roots, abs=1e-12)


def test_planted_roots_beside_poles() -> None:
    draw = random.Random(4)
    for _ in range(20):
        *roots, p, q = draw.sample(range(-9, 10), 4)
        a, b = roots
        sheet = f"u = (x - ({a}))/(x - ({p}))^2\nw = (x - ({b}))*(x - ({q}))^-1\nu*w = v\nv = 0*x"
        result = solved(sheet)
        assert result.complete
        assert sorted(s["x"] for s in result.solutions) == pytest.approx(sorted(roots), abs=1e-12)


def test_a_root_where_a_divisor_is_0_is_no_answer() -> None:
    """x + 1 = 2x but for x = 1, where the quotient is 0/0."""
    hole = solved("y = x - 1\nz = (x^2 - 1)/y\nz = 2*x")
    assert str(hole.status) == "singular"
    assert not any("x" in solution for solution in hole.solutions)
    result = solved("y = x - 1\nz = (x^2 + 1)/y\nz + x = 2/y")  # 2x^2 - x - 1 = 0
    assert [s["x"] for s in result.solutions] == pytest.approx([-0.5], rel=1e-15)
    assert result.complete


@pytest.mark.parametrize("target", [1.9999999999999996, 2.0, 2.0000000000000004])
def test_what_rounding_leaves_of_an_equation_proves_nothing(target: float) -> None:
    """Of each positive x it is x (|x| + 2/x - x) = 2."""
    result = solved("u = abs(x) + 2/x\nw = abs(u - x)\nk = x*w", k=target)
    assert result.status is not solver.Status.INFEASIBLE


def test_quotients_that_say_the_same_leave_an_unknown_free() -> None:
    result = solved("y = 6/x\nz = 2/x\ny + z = 8/x")
    assert str(result.status) == "partial"


def test_no_real_root_is_proven() -> None:
    result = solved("y = x^4 + x\ny + 2*x^2 = -k", k=3.0)
    assert str(result.status) == "infeasible"


def test_a_double_root_is_found_in_exact_numbers() -> None:
    """At k = 4 an extremum touches: x^3 - 3x - 2 = (x + 1)^2 (x - 2)."""
    result = solved("y = x^3 - 3*x\ny + 2 = k", k=4.0)
    assert methods(result) == [Method.POLYNOMIAL]
    assert [s["x"] for s in result.solutions] == [2.0, -1.0]
    assert result.complete
    above, below = (solved("y = x^3 - 3*x\ny + 2 = k", k=k) for k in (4.001, 3.999))
    assert [len(r.solutions) for r in (above, below)] == [1, 3]


def test_a_range_leaves_out_roots() -> None:
    sheet = "variables\nx in [1.5, 10]\ny\nk = 6\nrules\ny = x^3 - 6*x^2\ny + 11*x = k"
    result = solved(sheet)
    assert sorted(s["x"] for s in result.solutions) == pytest.approx([2, 3])
    assert result.complete


def test_a_range_of_another_unknown_leaves_out_roots() -> None:
    sheet = "variables\nx\ny in [-20, -10]\nk = 6\nrules\ny = x^3 - 6*x^2\ny + 11*x = k"
    result = solved(sheet)
    assert sorted(s["x"] for s in result.solutions) == pytest.approx([2])


# --- the tear is an angle -----------------------------------------------------------

WAVES = "u = p*cosd(t)\nv = q*sind(t)\nu^2 + u*v + r*v = k"


def waves(t: float, p: float, q: float, r: float) -> float:
    u, v = p * math.cos(math.radians(t)), q * math.sin(math.radians(t))
    return u * u + u * v + r * v


@given(*(st.integers(-5, 5).filter(bool) for _ in range(3)), st.integers(-170, 170))
def test_every_angle_of_a_planted_one(p: int, q: int, r: int, planted: int) -> None:
    """As many angles as there are changes of sign on a fine grid, the planted one among them."""
    k = waves(planted, p, q, r)
    result = solved(WAVES, p=float(p), q=float(q), r=float(r), k=k)
    found = sorted(s["t"] for s in result.solutions)
    for t in found:
        assert waves(t, p, q, r) == pytest.approx(k, abs=1e-11)
    grid = [waves(-180 + 0.25 * i + 0.1, p, q, r) - k for i in range(1441)]
    if min(map(abs, grid)) > 1e-3 or result.complete:
        assert len(found) >= sum(a * b < 0 for a, b in itertools.pairwise(grid))
    assert any(abs(t - planted) < 1e-4 for t in found)


def test_angles_that_are_multiple_are_told_and_are_all() -> None:
    """A crank of 3 and a rod of 5 in line: one angle, twice."""
    sheet = "x = 3*cosd(t)\ny = 3*sind(t)\n8 - x = sqrt(25 - y^2)"
    result = solved(sheet)
    assert str(result.status) == "singular"
    assert [s["t"] for s in result.solutions] == [0.0]


@pytest.mark.parametrize(("sheet", "angle"), [("x = 3*cosd(t)\ny = sind(t)\nx + y^2 = -3", 180.0)])
def test_the_half_turn_is_not_lost(sheet: str, angle: float) -> None:
    result = solved(sheet)
    assert angle in [s["t"] for s in result.solutions]


QUARTERS = "x = 2*cosd(t + 90)\ny = 3*sind(180 - t)\nx*y + y = k"


def test_quarter_turns_are_exact() -> None:
    """3 s - 6 s² = k for the sine s."""
    result = solved(QUARTERS, k=0.25)
    assert result.complete
    assert len(result.solutions) == 4
    sines = {round(math.sin(math.radians(s["t"])), 12) for s in result.solutions}
    assert sorted(sines) == pytest.approx(
        [(3 - math.sqrt(3)) / 12, (3 + math.sqrt(3)) / 12], abs=1e-11
    )
    assert str(solved(QUARTERS, k=1.0).status) == "infeasible"


@pytest.mark.parametrize(
    "angle", ["90 - t", "-t + 90", "270 - t", "-90 - t", "t - 90", "90 + t", "180 - t"]
)
def test_quarter_turns_stand_anywhere_beside_the_angle(angle: str) -> None:
    sheet = (
        f"x = 2*cosd(t) + cosd({angle})\ny = 3*sind({angle}) + sind(t)\nz = x*y + x^2\nz*x + y*x "
        "= k"
    )
    result = solved(sheet, k=float(solved(sheet, t=20.0)["k"]))
    assert result.complete
    assert any(solution["t"] == pytest.approx(20.0, abs=1e-9) for solution in result.solutions)


@given(st.floats(5.0, 90.0), st.floats(5.0, 90.0))
@settings(max_examples=30, deadline=None)
def test_a_pole_that_rounding_has_made_is_no_root(one: float, other: float) -> None:
    """The slope of a chord of a parabola is linear in each end, though rounding leaves 1e-13 of the
    rise where both are one point."""
    assume(abs(one - other) > 0.01)
    sheet = "q1 = k1*v1\nv1 = a*(1 - k1/b)\nq2 = k2*v2\nv2 = a*(1 - k2/b)\nw = (q2 - q1)/(k2 - k1)"
    slope = 97.0 * (1 - (one + other) / 119.0)
    result = solved(sheet, a=97.0, b=119.0, k2=other, w=slope)
    assert result.complete
    assert [s["k1"] for s in result.solutions] == pytest.approx([one], rel=1e-9)


@pytest.mark.parametrize("rate", [1.0, 2.5, 12.0])
@pytest.mark.parametrize("asked", ["D", "Q"])
def test_a_form_that_is_0_over_0_where_nothing_holds_hides_no_root(asked: str, rate: float) -> None:
    """The mean term D of payments, and the sum of their squares Q, both by the price, which is 0
    where a discount factor of 0 leaves D free."""
    sheet = """P = c*(v + v^2 + v^3) + 100*v^n
    D*P = c*(v + 2*v^2 + 3*v^3) + 100*n*v^n
    Q = (c*(v + 4*v^2 + 9*v^3) + 100*n^2*v^n)/P
    y = D*P/100"""
    v, c, weights = 1 / (1 + rate / 100), 4.0, {"D": (1, 2, 3), "Q": (1, 4, 9)}[asked]
    price = np.array([100 + c, c, c, 0.0])
    top = np.array([weights[2] * (100 + c), weights[1] * c, weights[0] * c, 0.0])
    if asked == "D":
        y = np.polyval(top, v) / 100
        roots = np.roots(top - np.array([0, 0, 0, 100 * y]))
        result = solved(sheet, c=c, n=3.0, y=y)
    else:
        q = np.polyval(top, v) / np.polyval(price, v)
        roots = np.roots((top - q * price)[:-1])
        result = solved(sheet, c=c, n=3.0, Q=q)
    real = sorted(float(root.real) for root in roots if abs(root.imag) < 1e-9)
    assert result.complete
    assert sorted(s["v"] for s in result.solutions) == pytest.approx(real, rel=1e-9)


@pytest.mark.parametrize("n", [2.0, 3.0, 5.0])
def test_a_named_whole_exponent_of_a_negative_base(n: float) -> None:
    """Its slope by the exponent has no value, and is not needed."""
    at = -1.7
    y = at * (at**n + at)
    roots = np.roots([1.0, *([0.0] * int(n - 2)), 1.0, 0.0, -y])
    real = sorted(float(root.real) for root in roots if abs(root.imag) < 1e-9)
    result = solved("z = x^n + x\ny = x*z", n=n, y=y)
    assert result.complete
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(real, rel=1e-9)


def test_a_divisor_in_which_the_unknown_cancels() -> None:
    """rp + ra is 2a whatever rp is: the divisor is a number, its terms are not."""
    result = solved(
        "a = (rp + ra)/2\ne = (ra - rp)/(ra + rp)\nT = 2*pi*sqrt(a^3/mu)\n"
        "vp = sqrt(mu*(2/rp - 1/a))\nE = -mu/(2*a)",
        E=-2.4e7,
        T=7593.0,
        e=0.2,
    )
    assert str(result.status) == "solved"
    a = math.sqrt(4.8e7) * 7593.0 / (2 * math.pi)  # mu = 2 a |E| and mu T^2 = 4 pi^2 a^3
    assert result["rp"] == pytest.approx(0.8 * a)
    assert result["ra"] == pytest.approx(1.2 * a)


@pytest.mark.parametrize("anomaly", [17.0, 40.0, 100.0, 163.0])
def test_functions_of_known_numbers_are_coefficients(anomaly: float) -> None:
    """An orbit by its perigee and one radius: r + r e cos ν = a (1 - e²) is linear in 1/a = (1 -
    e)/rp."""
    perigee, apogee, wave = 6778.0, 24000.0, math.cos(math.radians(anomaly))
    sheet = "a = (rp + ra)/2\ne = (ra - rp)/(ra + rp)\np = a*(1 - e^2)\nr = p/(1 + e*cosd(nu))"
    radius = 2 * perigee * apogee / (perigee + apogee + (apogee - perigee) * wave)
    result = solver.solve(
        rulesheets.loads(sheet), {"rp": perigee, "r": 0.999 * radius, "nu": anomaly}
    )
    e = (0.999 * radius - perigee) / (perigee - 0.999 * radius * wave)
    assert result.complete
    assert [s["ra"] for s in result.solutions] == pytest.approx(
        [perigee * (1 + e) / (1 - e)], rel=1e-10
    )


@pytest.mark.parametrize("rate", [0.3, 1.7, -2.0])
def test_powers_of_known_numbers_are_coefficients(rate: float) -> None:
    """x³ e^(2 k) + x² e^k = c, which has one positive root."""
    factor = math.exp(rate)
    result = solver.solve(
        rulesheets.loads("u = x*exp(k)\nv = u^2 + u\nv*x = c"), {"k": rate, "c": 5.0}
    )
    roots = np.roots([factor**2, factor, 0.0, -5.0])
    real = sorted(float(root.real) for root in roots if abs(root.imag) < 1e-9)
    assert result.complete
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(real, rel=1e-9)


FEE = "fee = p*min(x, a) + q*max(0, x - b)\nnet = x - fee\nshare = abs(net - c)/d + fee"


def test_the_bottom_of_a_kink_is_an_answer() -> None:
    """The share is -x below 0 and 3 x above: only at 0 it is none. Slopes took it for a miss."""
    given_ = {"p": 0.0, "q": 2.0, "a": 0.0, "b": 0.0, "c": 0.0, "d": 1.0, "share": 0.0}
    result = solver.solve(rulesheets.loads(FEE), given_)
    assert str(result.status) in ("solved", "singular")
    assert [solution["x"] for solution in result.solutions] == [0.0]


@settings(max_examples=40, deadline=None)
@given(*[st.integers(-4, 4)] * 2, *[st.integers(0, 6)] * 4, st.integers(1, 3), st.integers(-8, 8))
def test_every_piece_of_a_rule_with_kinks_is_counted(
    p: int, q: int, a: int, b: int, c: int, at: int, d: int, beyond: int
) -> None:
    """Between neighbouring kinks the share is a line, by exact fractions."""

    def share(x: Fraction) -> Fraction:
        fee = p * min(x, Fraction(a)) + q * max(Fraction(0), x - b)
        return abs(x - fee - c) / d + fee

    target = share(Fraction(at)) + Fraction(beyond, 8)
    kinks = {Fraction(a), Fraction(b)}
    pieces = [*sorted(kinks), max(kinks) + 1000]
    ends = [min(kinks) - 1000, *pieces]
    for low, high in itertools.pairwise(ends):  # where x - fee = c
        (first, last) = (
            x - (p * min(x, Fraction(a)) + q * max(Fraction(0), x - b)) - c for x in (low, high)
        )
        if first * last < 0:
            kinks.add(low + (high - low) * first / (first - last))
    ends = [min(kinks) - 1000, *sorted(kinks), max(kinks) + 1000]
    heights = [share(x) - target for x in ends]
    lines = list(zip(itertools.pairwise(ends), itertools.pairwise(heights), strict=True))
    assume(all(one != other for _, (one, other) in lines))
    roots = {
        low + (high - low) * one / (one - other)
        for (low, high), (one, other) in lines
        if one * other <= 0
    }
    roots = {x for x in roots if ends[0] < x < ends[-1]}
    given_ = {"p": p, "q": q, "a": a, "b": b, "c": c, "d": d, "share": float(target)}
    result = solver.solve(
        rulesheets.loads(FEE), {name: float(number) for name, number in given_.items()}
    )
    found = [s["x"] for s in result.solutions if abs(s["x"]) < 900]
    assert sorted(found) == pytest.approx(sorted(map(float, roots)), rel=1e-9, abs=1e-9)
    assert result.complete or str(result.status) == "singular"


@pytest.mark.parametrize("rest", ["", "*exp(x)", "*cosd(3)"])
@pytest.mark.parametrize("n", [1.5, 2.0, 3.0, 4.0])
def test_a_base_with_a_named_positive_exponent_divides_nothing(n: float, rest: str) -> None:
    """x = 0 is an answer, as with the exponent written as a number."""
    rules = f"z = x^n{rest}\nz = 0.4*x"
    named = solved(rules, n=n)
    written = solved(rules.replace("^n", f"^{n}"))
    assert named.complete
    assert sorted(s["x"] for s in named.solutions) == pytest.approx(
        sorted(s["x"] for s in written.solutions), abs=1e-12
    )
    assert any(s["x"] == 0.0 for s in named.solutions)


@pytest.mark.parametrize(("n", "roots"), [(-1.0, [0.5, 2.0]), (-2.0, [])])
def test_a_base_with_a_named_negative_exponent_divides(n: float, roots: list[float]) -> None:
    result = solved("z = x^n\ny = z + x", n=n, y=2.5)
    if not roots:
        real = [root.real for root in np.roots([1.0, -2.5, 0.0, 1.0]) if abs(root.imag) < 1e-9]
        roots = sorted(map(float, real))
    assert result.complete
    assert sorted(s["x"] for s in result.solutions) == pytest.approx(roots)


COIL = """p1 = rh*0.61094*exp(17.625*t1/(t1 + 243.04))
pa = 0.61094*exp(17.625*ta/(ta + 243.04))
w1 = 0.622*p1/(101.325 - p1)
wa = 0.622*pa/(101.325 - pa)
t2 = ta + f*(t1 - ta)
w2 = wa + f*(w1 - wa)
h1 = 1.006*t1 + w1*(2501 + 1.86*t1)
h2 = 1.006*t2 + w2*(2501 + 1.86*t2)
m = 2.4/(0.287*(t1 + 273.15)*(1 + 1.608*w1)/101.325)
drop = m*(h1 - h2 - (w1 - w2)*4.19*t2)
share = m*(1.006 + 1.86*w1)*(t1 - t2)/drop"""


@pytest.mark.parametrize("f", [0.1, 0.15, 0.3, 0.75])
@pytest.mark.parametrize("rh", [0.6, 0.55, 0.7])
def test_a_coil_that_all_air_passes_by_has_no_share(rh: float, f: float) -> None:
    """At f = 1 the share is 0/0, but for the rounding of what is computed before."""
    given = {"t1": 32.0, "ta": 8.0, "rh": rh}
    share = solved(COIL, f=f, **given)["share"]
    result = solved(COIL, share=share, **given)
    assert result.complete
    assert [s["f"] for s in result.solutions] == pytest.approx([f], rel=1e-10)
