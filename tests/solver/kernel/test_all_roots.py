"""Answers of algebraic equations in one unknown are known to be all: as many as numpy's roots
allow."""

from __future__ import annotations

import math
import random

import numpy
import pytest
import scipy.optimize
import scipy.special

import rulesheets
import solver

ALGEBRAIC = [
    (
        "q = (Ta - T1)/((1/r1 - 1/r2)/(4*pi*k) + 1/(h*4*pi*r2^2))",
        {"q": 50.0, "Ta": 300.0, "T1": 77.0, "r1": 0.25, "k": 0.02, "h": 10.0},
        2,
    ),
    (
        "C = D/d\nKB = (4*C + 2)/(4*C - 3)\nF = pi*d^3*S/(8*KB*D)",
        {"F": 200.0, "D": 0.02, "S": 4e8},
        2,
    ),
    (
        "beta = D2/D1\nv2 = Cd*sqrt(2*dp/(rho*(1 - beta^4)))\nQ = v2*pi*D2^2/4",
        {"D1": 0.1, "Cd": 0.98, "dp": 5000.0, "rho": 1000.0, "Q": 0.01},
        2,
    ),
    ("x^2.5 + sqrt(x) = 3 + 1/x", {}, 1),
    ("sqrt(x + 1) + sqrt(x + 2) + sqrt(x + 3) = 7", {}, 1),
    ("x*abs(x) - 3*x + 1/x = 1", {}, None),
]


@pytest.mark.parametrize(("text", "inputs", "count"), ALGEBRAIC)
def test_algebraic_blocks_are_complete(
    text: str, inputs: dict[str, float], count: int | None
) -> None:
    result = solver.solve(rulesheets.loads(text), inputs)
    assert str(result.status) == "solved"
    assert result.complete
    assert count is None or len(result.solutions) == count


@pytest.mark.parametrize("seed", range(12))
def test_rational_equations_have_the_roots_of_their_numerator(seed: int) -> None:
    draw = random.Random(seed)
    a, b, c, d, e = (round(draw.uniform(-5.0, 5.0), 2) or 1.0 for _ in range(5))
    result = solver.solve(rulesheets.loads(f"{a}/(x - {abs(b)}) + {c}*x^2 + {d}*x = {e}"))
    numerator = numpy.polymul([c, d, -e], [1.0, -abs(b)])
    numerator[-1] += a
    roots = numpy.roots(numerator)
    real = sorted(root.real for root in roots if abs(root.imag) < 1e-7 * abs(root))
    if result.complete:
        found = sorted(float(solution["x"]) for solution in result.solutions)
        assert found == pytest.approx(real, rel=1e-6)
    gaps = numpy.diff(real)
    if len(gaps) == 0 or min(gaps) > 1e-3 * max(map(abs, real)):
        assert result.complete


def test_poles_and_foreign_signs_are_no_answers() -> None:
    result = solver.solve(rulesheets.loads("(x^2 - 1)/(x - 1) + sqrt(x) = 1/x^2 + 3"))
    assert all(float(solution["x"]) > 1.0 for solution in result.solutions)
    assert result.complete
    (x,) = (float(solution["x"]) for solution in result.solutions)
    assert math.isclose(x + 1.0 + math.sqrt(x), 1.0 / x**2 + 3.0)


def test_a_root_at_the_corner_of_two_ranges_is_found() -> None:
    """Beside 0 the second rule, whose terms are of size 1, says nothing of numbers below 1e-16."""
    rules = "x + sin(x) + y^3 + y = 0\ny + exp(y) + x + exp(x) = 2\n"
    result = solver.solve(rulesheets.loads(f"variables\nx in [0, 9]\ny in [0, 9]\nrules\n{rules}"))
    assert str(result.status) == "solved"
    assert [dict(answer) for answer in result.solutions] == [{"x": 0.0, "y": 0.0}]


def _biot(number: int) -> float:
    """The root of ``z*tan(z) = 0.5`` next above a multiple of π."""
    low = number * math.pi
    return float(
        scipy.optimize.brentq(lambda z: z * math.sin(z) - 0.5 * math.cos(z), low, low + math.pi / 2)
    )


@pytest.mark.parametrize(("guess", "numbers"), [(None, range(20)), (100.0, range(26, 38))])
def test_of_endless_roots_the_nearest_are_listed(guess: float | None, numbers: range) -> None:
    guesses = {} if guess is None else {"z": guess}
    result = solver.solve(rulesheets.loads("z*tan(z) = 0.5\nw = 3*z"), guesses=guesses)
    found = [answer["z"] for answer in result.solutions]
    assert found[0] == pytest.approx(_biot(0 if guess is None else 32), rel=1e-11)
    for root in map(_biot, numbers):
        assert min(abs(z - root) for z in found) <= 1e-11 * root
    (note,) = (d for d in result.diagnoses if d.code == "S593")
    assert "give z a range" in note.notes[0]


def test_a_range_lists_all_of_its_roots() -> None:
    result = solver.solve(
        rulesheets.loads("variables\nz in [0, 300]\nrules\nz*tan(z) = 0.5\nw = 3*z")
    )
    assert result.complete
    expected = [_biot(number) for number in range(96)]
    assert sorted(answer["z"] for answer in result.solutions) == pytest.approx(expected, rel=1e-11)


def test_amounts_in_equilibrium_are_positive() -> None:
    """Nickel and its complexes with ammonia: one root in free ammonia, of a polynomial of degree
    five, is positive, and most starts lead to others."""
    stages = [10**2.81, 10**2.27, 10**1.77, 10**1.27]
    rules = [f"Ni{k + 1}/(Ni{k}*A) = {stage!r}" for k, stage in enumerate(stages)]
    rules += ["Ni0 + Ni1 + Ni2 + Ni3 + Ni4 = 0.01", "A + Ni1 + 2*Ni2 + 3*Ni3 + 4*Ni4 = 0.03"]
    first = solver.solve(rulesheets.loads("\n".join(rules))).solutions[0]
    beta = [1.0, *map(math.prod, (stages[: k + 1] for k in range(4)))]
    bound, whole = [k * b for k, b in enumerate(beta)], beta
    balance = numpy.polyadd(
        numpy.polymul(whole[::-1], [1.0, -0.03]), [0.01 * share for share in bound[::-1]]
    )
    free = [
        root.real for root in numpy.roots(balance) if abs(root.imag) < 1e-12 and root.real > 0.0
    ]
    assert [first["A"]] == pytest.approx(free, rel=1e-9)
    assert all(float(value) > 0.0 for value in first.values())


@pytest.mark.parametrize(("reach", "count"), [(1.8, 1), (1.5, 2), (1.9, 0)])
def test_an_arm_of_two_links_reaches_in_two_ways_or_stretched(reach: float, count: int) -> None:
    """The second angle is measured from the first link: by the law of cosines, where they are not
    in line."""
    text = "x = cos(a) + 0.8*cos(a + b)\ny = sin(a) + 0.8*sin(a + b)"
    result = solver.solve(rulesheets.loads(text), {"x": reach, "y": 0.0})
    bend = math.acos(min((reach**2 - 1.64) / 1.6, 1.0))
    found = sorted(float(solution["b"]) for solution in result.solutions)
    assert str(result.status) == ("infeasible", "singular", "solved")[count]
    assert result.complete is (count != 1)
    assert found == pytest.approx([-bend, bend][2 - count :], rel=1e-12, abs=0.0)


def test_a_root_at_0_is_0() -> None:
    """P. T. Boggs, SIAM J. Numer. Anal. 8 (1971) 767-785: roots (0, 1), (-√½, 3/2) and (-1, 2)."""
    result = solver.solve(rulesheets.loads("x1^2 - x2 + 1 = 0\nx1 - cos(pi/2*x2) = 0"))
    assert result.complete
    roots = sorted((float(found["x1"]), float(found["x2"])) for found in result.solutions)
    assert roots == [(-1.0, 2.0), (pytest.approx(-math.sqrt(0.5)), pytest.approx(1.5)), (0.0, 1.0)]


def test_the_first_zeros_of_a_bessel_function_are_listed() -> None:
    """The circular modes of a drum: as for a sine, without gaps."""
    result = solver.solve(rulesheets.loads("j0(k*a) = 0\nf = k*c/(2*pi)"), {"a": 0.2, "c": 100.0})
    found = [answer["k"] for answer in result.solutions]
    zeros = scipy.special.jn_zeros(0, 10) / 0.2
    assert found[0] == pytest.approx(zeros[0], rel=1e-12)
    assert all(min(abs(k - zero) for k in found) <= 1e-11 * zero for zero in zeros)
    assert len(found) < 60
