"""Which answer comes first: sheets of which an engineer knows it, from closed forms and by
scipy."""

from __future__ import annotations

import json
import math
import random
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, root

import rulesheets
import solver
from benchmarks.chains import cooling_tower, feeder
from solver.ranking.ranking import Ranking
from solver.report.sheet import result_json, result_text

SHIELD = """variables
  T1 = 800 [K]
  T2 = 293 [K]
  T3 [K]
rules
  0.1*5.67e-8*(T1^4 - T3^4) = 5.67e-8*(T3^4 - T2^4) + 25*(T3 - T2)
"""
FLASH = """variables
  z1 = 0.3
  z2 = 0.4
  z3 = 0.3
  K1 = 1.9
  K2 = 1.1
  K3 = 0.2
rules
  L + V = 1
  z1 = x1*L + y1*V
  z2 = x2*L + y2*V
  z3 = x3*L + y3*V
  y1 = K1*x1
  y2 = K2*x2
  y3 = K3*x3
  x1 + x2 + x3 = y1 + y2 + y3
"""
FLIGHT = """variables
  v0 = 30 [m/s]
  theta = 60 [deg]
  y = 0 [m]
rules
  x = v0*cosd(theta)*tf
  y = v0*sind(theta)*tf - 9.81*tf^2/2
  vy = v0*sind(theta) - 9.81*tf
"""
ORBIT = """variables
  mu = 398600
  R = 6371
  v = 7.0
  ra = 8000
rules
  h = rp - R
  a = (ra + rp)/2
  v^2 = mu*(2/rp - 1/a)
"""
SPRING = """variables
  F = 300 [N]
  D = 20 [mm]
  tau = 700
rules
  C = D/d
  Kw = (4*C - 1)/(4*C - 4) + 0.615/C
  tau = Kw*8*F*D/(pi*d^3)
"""


def first(sheet: str, name: str) -> float:
    value = solver.solve(rulesheets.loads(sheet))[name]
    assert isinstance(value, float)
    return value


def test_a_temperature_above_absolute_zero_comes_first() -> None:
    def balance(t: float) -> float:
        return 0.1 * 5.67e-8 * (800**4 - t**4) - 5.67e-8 * (t**4 - 293**4) - 25 * (t - 293)

    assert first(SHIELD, "T3") == pytest.approx(brentq(balance, 293, 800), rel=1e-12)


def placed(rule: Ranking, rows: Sequence[Sequence[float]], given: Sequence[float]) -> list[int]:
    """The places of tuples of numbers, the first one first."""
    return sorted(range(len(rows)), key=rule.keys_of_rows(rows, given).__getitem__)


@pytest.mark.parametrize(
    ("unit", "zero"),
    [
        ("degC", -273.15),
        ("degF", -459.67),
        ("K", 0.0),
        ("g", 0.0),
        ("mbar", 0.0),
        ("barg", -1.01325),
    ],
)
def test_only_what_is_below_its_least_value_counts_double(unit: str, zero: float) -> None:
    """An answer with one negative number comes before one with a temperature or a mass that there
    is not."""
    model = rulesheets.loads(
        f"variables\n  T [{unit}]\n  a\n  b\n  c\nrules\n  a + b + c + T = d\n"
    )
    rule = Ranking(model, ["d"])
    place = {name: k for k, name in enumerate(rule.read)}

    def row(**values: float) -> list[float]:
        return [values.get(name, 1.0) for name in sorted(place, key=place.__getitem__)]

    cold, one, two = row(T=zero - 1), row(a=-1.0), row(a=-1.0, b=-1.0, c=-1.0)
    assert placed(rule, [two, cold, one], [2.0]) == [2, 1, 0]


def test_a_flash_has_fractions_between_0_and_1() -> None:
    def balance(v: float) -> float:
        pairs = ((0.3, 1.9), (0.4, 1.1), (0.3, 0.2))
        return sum(z * (k - 1) / (1 + v * (k - 1)) for z, k in pairs)

    assert first(FLASH, "V") == pytest.approx(brentq(balance, 0, 1), rel=1e-10)


def test_a_flight_that_moves_comes_before_one_of_no_time() -> None:
    time = 2 * 30 * math.sin(math.radians(60)) / 9.81
    assert first(FLIGHT, "tf") == pytest.approx(time, rel=1e-12)
    result = solver.solve(rulesheets.loads(FLIGHT))
    assert [solution["tf"] for solution in result.solutions[1:]] == [0.0]


def test_an_orbit_is_above_the_ground() -> None:
    # v² = mu (2/r - 2/(ra + r)) is v² r (ra + r) = 2 mu ra
    radius = (-8000 + math.sqrt(8000**2 + 8 * 398600 * 8000 / 49)) / 2
    assert first(ORBIT, "h") == pytest.approx(radius - 6371, rel=1e-10)


def test_a_spring_has_a_wire_thinner_than_its_coil() -> None:
    def excess(d: float) -> float:
        c = 20 / d
        return ((4 * c - 1) / (4 * c - 4) + 0.615 / c) * 8 * 300 * 20 / (math.pi * d**3) - 700

    assert first(SPRING, "d") == pytest.approx(brentq(excess, 2, 5), rel=1e-10)


def test_a_positive_root_comes_before_a_smaller_negative_one() -> None:
    assert first("D^2 + 0.013*D - 0.053 = 0", "D") > 0
    assert first("D^2 - 0.013*D - 0.053 = 0", "D") > 0


@pytest.mark.parametrize(
    ("rules", "name", "expected"),
    [
        ("920 = 1000*(1 + i/100)^4", "i", 100 * (0.92**0.25 - 1)),
        ("V = 920\nV = 1000*(1 - d)^4", "d", 1 - 0.92**0.25),
        (
            "700 = pi/4*(60^2 - (60 - 2*t)^2)",
            "t",
            30 - math.sqrt(900 - 700 / math.pi),
        ),  # a tube's wall
        ("0.97 = 1 - (1 - p)^4", "p", 1 - 0.03**0.25),
        ("50 = 4*x^2/((1 - x)*(2 - x))", "x", (150 - math.sqrt(150**2 - 4 * 46 * 100)) / 92),
        ("a = 0.5\nb = 0.8\n3 = x^2/((a - x)*(b - x))", "x", (3.9 - math.sqrt(3.9**2 - 9.6)) / 4),
        (
            "240 = 12000*i/(1 - (1 + i)^(-48))",
            "i",
            brentq(lambda i: 50 * i + (1 + i) ** -48 - 1, -0.01, -0.001),
        ),
    ],
)
def test_what_grows_or_remains_is_positive(rules: str, name: str, expected: float) -> None:
    """No share above 1, no loss of more than all; other answers follow, and plans say the same."""
    model = rulesheets.loads(rules)
    result = solver.solve(model)
    assert len(result.solutions) > 1
    assert result[name] == pytest.approx(expected, rel=1e-12)
    assert solver.prepare(model, inputs=[], want=[name])() == pytest.approx((expected,), rel=1e-12)


@pytest.mark.parametrize(
    ("rule", "name", "expected"),
    [
        # a platinum thermometer at 138.5 ohm
        ("138.5 = 100*(1 + 3.9083e-3*T - 5.775e-7*T^2)", "T", 99.985),
        # steel in a concrete beam: 250e6 = 378 As (500 - As/34)
        ("250e6 = 0.9*As*420*(500 - As*420/(1.7*28*300))", "As", 1445.7),
        # a wire of 100.4267 m sags by 4 m between its ends
        ("100.4267 = L*(1 + 8/3*(4/L)^2)", "L", 100.0),
    ],
)
def test_a_correction_is_small(rule: str, name: str, expected: float) -> None:
    """Where the terms of a factor cancel, or are more than its number, the answer comes later,
    though it is of no worse size."""
    assert first(rule, name) == pytest.approx(expected, rel=1e-4)


def test_an_epidemic_that_happens_comes_before_none() -> None:
    """All survive where nobody is infected: ``N - S`` is 0 there, and the rule says nothing
    else."""
    rules = "N = 8308\nb = 0.5834\ng = 0.2\nS = N*exp(-b/g*(N - S)/N)\n"
    expected = brentq(lambda s: s - 8308 * math.exp(-2.917 * (1 - s / 8308)), 100, 2000, xtol=1e-9)
    assert first(rules, "S") == pytest.approx(expected, rel=1e-11)


def test_phases_have_either_sign() -> None:
    """Each answer has currents below 0, if not the same: their number says nothing of a load of
    three phases.

    Of its eight answers the one of the highest voltages comes first.
    """
    result = solver.solve(rulesheets.loads(feeder(1).sheet))
    size = [math.hypot(result[f"v{phase}1"], result[f"w{phase}1"]) for phase in "abc"]
    assert min(size) > 2300.0


def test_the_difference_of_coordinates_has_either_sign() -> None:
    """Only its square counts: the circle's point that is nearer to the other numbers' sizes comes
    first."""
    left = "variables\n  a = 5\n  b = 1\n  r = 2\n  y = 2.2\nrules\n  (x - a)^2 + (y - b)^2 = r^2\n"
    found = [s["x"] for s in solver.solve(rulesheets.loads(left)).solutions]
    assert found == pytest.approx([3.4, 6.6])


def test_a_range_that_reaches_below_0_takes_its_sign_out_of_the_count() -> None:
    """With x aside, y alone counts; without the range the answers are as negative as one
    another."""
    rules = "rules\n  x + y = 1\n  x*y = -6\n  z = y^3\n"
    with_range = solver.solve(rulesheets.loads(f"variables\n  x in [-100, 100]\n{rules}"))
    assert with_range["y"] == 3.0
    assert {s["y"] for s in with_range.solutions} == {3.0, -2.0}


def test_the_crank_driven_by_its_slider_turns_on_as_in_the_paper() -> None:
    model = rulesheets.load("offset_slider_crank")
    driven = {"xB": 9.79, "thetaAO": None}
    for want in (None, ["thetaAO"], ["thetaAO", "omegaAB"]):
        result = solver.solve(model, driven, want=want)
        assert result["thetaAO"] == pytest.approx(-30, abs=0.1)
        plan = solver.prepare(model, ["xB"], want or ["thetaAO", "vB"], given={"thetaAO": None})
        assert plan(9.79)[0] == pytest.approx(float(result["thetaAO"]), rel=1e-12)
        assert plan(9.79) == pytest.approx(plan.all(9.79)[0], rel=1e-12)


def test_a_negative_difference_lets_other_amounts_be_positive() -> None:
    """A book value written down at a rate of 22 % a year; at 178 % it would change its sign each
    year."""
    rules = "B1 = C*(1 - d)^n\nS = C*(1 - d)^N\nB2 = C - (C - S)/N*n\ndiff = B1 - B2"
    given = {"C": 48000.0, "S": 48000.0 * 0.78**8, "n": 3.0, "N": 8.0}
    result = solver.solve(rulesheets.loads(rules), given)
    assert len(result.solutions) == 2
    assert result["d"] == pytest.approx(0.22, rel=1e-9)
    assert result["diff"] < 0.0


def test_a_saturation_current_suggests_no_size_of_the_others() -> None:
    """The fill factor of a cell at a photocurrent ten decades above the saturation current."""
    rules = "u = ln(IL/I0 + 1)\nFF = (u - ln(u + 0.72))/(u + 1)"
    model = rulesheets.loads(rules)
    factor = solver.solve(model, {"IL": 3.2, "I0": 1e-9})["FF"]
    assert solver.solve(model, {"FF": factor, "I0": 1e-9})["IL"] == pytest.approx(3.2, rel=1e-9)


@pytest.mark.parametrize(("guess", "first"), [(2.1, 2.0), (-1.8, -2.0)])
def test_a_guess_comes_before_what_is_likely(guess: float, first: float) -> None:
    """At z = 2 the others are a billion times larger than the rules suggest, at -2 smaller."""
    text = "k = 20\ny = exp(z*k)\nz^2 = 4\nx = 300*(1 + 0.001*x)\nw = y*x"
    result = solver.solve(rulesheets.loads(text), guesses={"z": guess})
    assert len(result.solutions) == 2 and result["z"] == first


def test_guesses_come_before_all_else() -> None:
    model = rulesheets.loads(SHIELD)
    assert solver.solve(model, guesses={"T3": -800.0})["T3"] < 0  # type: ignore[operator]
    plan = solver.prepare(model, ["T1"], ["T3"], guesses={"T3": -800.0})
    assert [plan(t)[0] < 0 for t in (800.0, 810.0, 820.0)] == [True] * 3


@pytest.mark.parametrize("sheet", [SHIELD, FLASH, FLIGHT, ORBIT, SPRING])
def test_the_order_of_rules_and_variables_makes_no_difference(sheet: str) -> None:
    before, rules = sheet.split("rules\n")
    named = before.split("\n")[1:-1]
    lines = rules.strip("\n").split("\n")
    answers = [dict(s) for s in solver.solve(rulesheets.loads(sheet)).solutions]
    for seed in range(4):
        draw = random.Random(seed)
        draw.shuffle(named)
        draw.shuffle(lines)
        text = "\n".join(["variables", *named, "rules", *lines])
        others = [dict(s) for s in solver.solve(rulesheets.loads(text)).solutions]
        assert len(others) == len(answers)
        for one, other in zip(answers, others, strict=True):
            assert other == pytest.approx(one, rel=1e-9, abs=1e-9)


def test_numbers_next_to_the_ends_of_floats_have_an_order() -> None:
    rule = Ranking(rulesheets.loads("variables\n  a [deg]\n  b\nrules\n  b = a + c\n"), ["c"])
    assert placed(rule, [(1e308, 1e308), (-1e308, 5e-324), (1.0, 2.0)], (1e-300,))[0] == 2


def test_what_rounding_leaves_of_zero_has_no_sign() -> None:
    """The constant of a tacheometer is 0; what is left of it is of either sign with the two
    angles."""
    sheet = (
        "variables\n  a [deg]\nrules\n  D = K*i*cosd(a)^2 + C*cosd(a)\n  V = K*i*sind(2*a)/2 + "
        "C*sind(a)\n"
    )
    model = rulesheets.loads(sheet)
    given = {"K": 100.0, "i": 1.35, "C": 0.0, "a": 6.5}
    forward = solver.solve(model, given)
    asked = {"K": 100.0, "i": 1.35, "C": None, "a": None, "D": forward["D"], "V": forward["V"]}
    result = solver.solve(model, asked)
    assert result["a"] == pytest.approx(6.5, rel=1e-9)
    assert abs(float(result["C"])) < 1e-10


VAPOUR = "P = 10^(8.07 - 1730.6/(233.4 + T))\nP = 760*x\nx = 0.5 + T/400\n"


def test_an_answer_of_unlikely_size_is_last_and_marked() -> None:
    """Next to the pole at -233.4 the pressure vanishes."""
    result = solver.solve(rulesheets.loads(VAPOUR))
    assert result["T"] == pytest.approx(
        brentq(lambda t: 10 ** (8.07 - 1730.6 / (233.4 + t)) - 760 * (0.5 + t / 400), 50, 150),
        rel=1e-9,
    )
    assert [bool(s.unlikely) for s in result.solutions] == [False, False, True]
    assert "P" in result.solutions[-1].unlikely
    assert float(result.solutions[-1]["P"]) < 1e-40
    assert json.loads(result_json(result))["unlikely"] == [
        [],
        [],
        list(result.solutions[-1].unlikely),
    ]
    assert "answer 3 is of unlikely size: P, x" in result_text(result, every=True)
    assert "unlikely" not in result_text(result)


def test_of_unlikely_sizes_the_farthest_are_last() -> None:
    """The current of a diode is far from its saturation current, but not by 50 decades."""
    diode = rulesheets.loads("I = Is*(exp(V/(1.5*0.02585)) - 1)\nE = V + I*R\nPR = I^2*R\n")
    given = {"Is": 1e-12, "E": 5.0}
    forward = solver.solve(diode, {**given, "R": 220.0})
    result = solver.solve(diode, {**given, "PR": forward["PR"]})
    assert result["R"] == pytest.approx(220.0)
    assert max(float(s["I"]) for s in result.solutions) > 1e30


def test_an_only_answer_is_listed_whatever_its_size() -> None:
    small = solver.solve(rulesheets.loads("a = 3\nb = 3 + 1e-13\nc = b - a\n"))
    assert small.status is solver.Status.SOLVED
    assert small.solutions[0].unlikely == ()
    large = solver.solve(rulesheets.loads("a = 3\nb = a*c\nexp(c/50) = 1e30\n"))
    assert large["c"] == pytest.approx(50 * 30 * math.log(10), rel=1e-12)
    assert large.solutions[0].unlikely == ()


@pytest.mark.parametrize(
    ("b", "marked"), [("1 + 1e-12", ("c",)), ("1 + 1e-5", ()), ("1 - 1e-12", ("c",))]
)
def test_an_only_answer_is_marked_where_it_is_far_too_large(
    b: str, marked: tuple[str, ...]
) -> None:
    """Its size follows from a and b, which suggest 1."""
    assert (
        solver.solve(rulesheets.loads(f"a = 1\nb = {b}\nc = 1/(b - a)\n")).solutions[0].unlikely
        == marked
    )


@pytest.mark.parametrize("rest", [-5e-17, 5e-17])
def test_what_rounding_leaves_of_zero_is_trivial_with_either_sign(rest: float) -> None:
    """At x = 0 the other answer has a negative x: nothing positive is lost, whatever is left of
    0."""
    model = rulesheets.loads("x*(x + 1) = c\nx = cosd(phi)\nc = 0\n")
    rule = Ranking(model, ("c",), ("x", "phi"))
    one, other = {"c": 0.0, "phi": 180.0, "x": -1.0}, {"c": 0.0, "phi": 90.0, "x": rest}
    assert rule.order([one, other]) == rule.order([one, {**other, "x": 0.0}])


@pytest.mark.parametrize("cells", [1, 3])
def test_a_load_takes_little_current_at_a_high_voltage(cells: int) -> None:
    """Constant powers at the end of wires: U = E - R*I has a root with little loss, and one with
    little U."""
    lines = ["U0 = 12", "R = 0.1", "P = 20"]
    for k in range(1, cells + 1):
        lines += [f"U{k} = U{k - 1} - R*I{k}", f"P = U{k}*J{k}", f"loss{k} = R*I{k}^2"]
        lines.append(f"I{k} = J{k}" + (f" + I{k + 1}" if k < cells else ""))
    result = solver.solve(rulesheets.loads("\n".join(lines) + "\n"))
    assert all(float(result[f"U{k}"]) > 10.0 for k in range(1, cells + 1))


def test_neighbours_of_a_network_are_nearly_alike() -> None:
    """A ring of four nodes with loads of constant power, fed at one node."""
    loads = [
        f"(U{k - 1} - U{k})/r + (U{(k + 1) % 4} - U{k})/r = I{k}\nU{k}*I{k} = 2000\n"
        for k in (1, 2, 3)
    ]
    result = solver.solve(rulesheets.loads("U0 = 400\nr = 0.05\n" + "".join(loads)))
    assert all(float(result[f"U{k}"]) > 399.0 for k in (1, 2, 3))


def test_the_last_step_of_a_series_goes_on_like_those_before() -> None:
    """Water in a tower warms evenly by short steps of its equations, and does not jump to 84 °C in
    the last of five steps, whose other root that is."""
    steps = cooling_tower(600)
    fine = steps.by_hand()[steps.names.index("t600")]
    result = solver.solve(rulesheets.loads(cooling_tower(5).sheet))
    assert result["t5"] == pytest.approx(fine, rel=1e-2)
    assert result.complete


def field(count: int, rule: str, left: float, right: float, **known: float) -> str:
    """A rule about each node of a line and its neighbours."""
    lines = [f"{name} = {value}" for name, value in {**known, "h": 1 / (count + 1)}.items()]
    names = [left, *(f"u{k}" for k in range(1, count + 1)), right]
    around = zip(names, names[1:], names[2:], strict=False)
    return "\n".join([*lines, *(rule.format(a=a, b=b, c=c) for a, b, c in around)]) + "\n"


@pytest.mark.parametrize(("count", "strength"), [(3, 2.0), (4, 3.0)])
def test_a_field_is_the_one_that_grows_from_rest(count: int, strength: float) -> None:
    """Bratu's equation, u'' + k exp(u) = 0, and a membrane that is drawn down, u'' = k/(1 - u)^2:
    of their answers the one that k leads to from 0, where u is 0 everywhere."""
    for rule, source, k in [
        ("({a} - 2*{b} + {c})/h^2 + k*exp({b}) = 0", np.exp, strength),
        ("({a} - 2*{b} + {c})/h^2 + k/(1 - {b})^2 = 0", lambda u: (1 - u) ** -2, 0.4 * strength),
    ]:

        def missed(u: np.ndarray, k: float, source: Any = source) -> np.ndarray:
            return np.diff([0.0, *u, 0.0], 2) * (count + 1) ** 2 + k * source(u)

        u = np.zeros(count)
        for share in np.linspace(0.05, 1.0, 20):
            u = root(missed, u, args=(share * k,)).x
        model = rulesheets.loads(field(count, rule, 0, 0, k=k))
        names = [f"u{i}" for i in range(1, count + 1)]
        found = solver.solve(model)
        assert [found[name] for name in names] == pytest.approx(u, rel=1e-6)
        plan = solver.prepare(model, ["k"], names)
        assert plan(k) == pytest.approx(u, rel=1e-6)
        assert plan.sweep([0.9 * k, k])[names[0]][1] == pytest.approx(u[0], rel=1e-6)


def test_a_flow_goes_evenly_from_end_to_end() -> None:
    """Burgers' equation between 1 and -1: u falls all along and is odd about the middle."""
    rule = "{b}*({c} - {a})/(2*h) = nu*({a} - 2*{b} + {c})/h^2"
    result = solver.solve(rulesheets.loads(field(4, rule, 1, -1, nu=0.3)))
    u = [1.0, *(float(result[f"u{k}"]) for k in range(1, 5)), -1.0]
    assert sorted(u, reverse=True) == u
    assert u[1] == pytest.approx(-u[4], rel=1e-12)


def test_a_square_tells_no_sign() -> None:
    """Water has the refractive index 1.333 by the angle of its rainbow (Descartes), and not
    -1.333."""
    model = rulesheets.loads("cosd(i)^2 = (n^2 - 1)/3\nsind(i) = n*sind(r)\nD = 180 + 2*i - 4*r")
    angle = solver.solve(model, {"n": 1.333}, guesses={"i": 59, "r": 40})["D"]
    for inputs in ({"D": angle}, {"i": 59.4}, {"r": 40.2}):
        assert float(solver.solve(model, inputs)["n"]) == pytest.approx(1.333, abs=2e-3)


def test_water_flows_slowly_beyond_the_critical_depth() -> None:
    """Of the two depths of one specific energy the one near to it."""
    model = rulesheets.loads("q = 2.5\ng = 9.81\nv = q/y\nE = y + v^2/(2*g)\nyc = (q^2/g)^(1/3)\n")
    energy = 1.8 + (2.5 / 1.8) ** 2 / (2 * 9.81)
    assert solver.solve(model, {"E": energy})["y"] == pytest.approx(1.8, rel=1e-12)


def test_what_follows_from_angles_is_positive_where_nothing_else_tells() -> None:
    """The day is 15.1 hours long (FAO Irrigation and Drainage Paper 56, equations 21, 23, 24, 25,
    34, 35)."""
    text = """
    cos(ws) = -tan(phi)*tan(delta)
    delta = 0.409*sin(2*pi()/365*J - 1.39)
    dr = 1 + 0.033*cos(2*pi()/365*J)
    Ra = 24*60/pi()*0.082*dr*(ws*sin(phi)*sin(delta) + cos(phi)*cos(delta)*sin(ws))
    N = 24/pi()*ws
    Rs = (0.25 + 0.5*n/N)*Ra
    """
    result = solver.solve(rulesheets.loads(text), {"J": 180, "phi": 0.75, "n": 9})
    assert result["N"] == pytest.approx(15.140, abs=1e-3)
    assert result["Ra"] == pytest.approx(41.758, abs=1e-3)


@pytest.mark.parametrize(
    ("angle", "rule", "right"),
    [
        ("a [deg]", "b = 2*c", 90.0),
        ("a [rad]", "b = 2*c", math.pi / 2),
        ("a", "b = c*cosd(a)", 90.0),
        ("a", "b = c*cos(a)", math.pi / 2),
    ],
)
def test_an_angle_beyond_a_right_one_comes_later_in_its_own_unit(
    angle: str, rule: str, right: float
) -> None:
    """Although the number beside it has the size that the rules suggest."""
    ranking = Ranking(rulesheets.loads(f"variables\n  {angle}\n  b\nrules\n  {rule}\n"), ["c"])
    assert ranking.read == ("a", "b")
    assert placed(ranking, [(1.1 * right, 1.0), (0.9 * right, 50.0)], [1.0]) == [1, 0]
    assert placed(ranking, [(0.8 * right, 1.0), (0.7 * right, 50.0)], [1.0]) == [0, 1]


def test_a_sine_may_be_small() -> None:
    """A glider sinks at two degrees and a half: the coefficient of lift is 0.6, not 90."""
    text = """
    CL = CL0 + slope*alpha
    CD = CD0 + CL^2/(pi()*e*AR)
    L = 0.5*rho*v^2*S*CL
    L = W*cosd(gamma)
    D = 0.5*rho*v^2*S*CD
    D = W*sind(gamma)
    sink = v*sind(gamma)
    """
    model = rulesheets.loads(text)
    given = {
        "slope": 0.09,
        "alpha": 4,
        "CD0": 0.018,
        "e": 0.85,
        "AR": 14,
        "rho": 1.1,
        "S": 12,
        "W": 3600,
    }
    known = solver.solve(model, {**given, "CL0": 0.25})
    back = solver.solve(model, {**given, "sink": known["sink"]})
    assert back["CL0"] == pytest.approx(0.25)
    assert back["gamma"] == pytest.approx(2.6237, abs=1e-4)


@pytest.mark.parametrize(
    ("link", "length", "given"),
    [("AO", 3.0, "aB"), ("AO", 3.0, "xB"), ("AO", 3.0, "vB"), ("AB", 8.0, "thetaAB")],
)
def test_the_length_of_a_link_is_positive(link: str, length: float, given: str) -> None:
    """Whatever signs coordinates and accelerations have: the other link has a length, too."""
    model = rulesheets.load(
        Path(__file__).parents[3] / "models" / "offset_slider_crank" / "model.tk"
    )
    state = solver.solve(model).solutions[0]
    found = solver.solve(model, {link: None, given: state[given]})
    assert found.solutions[0][link] == pytest.approx(length, rel=1e-9)


def test_a_difference_that_all_but_cancels_has_either_sign() -> None:
    """Three buses: the voltages are those next to 1, although bus 2 draws a little reactive power
    there."""
    text = """
    P2 = V2*V1*b12*sind(d2) + V2*V3*b23*sind(d2 - d3)
    -P3 = V3*V1*b13*sind(d3) + V3*V2*b23*sind(d3 - d2)
    -Q3 = V3^2*(b13 + b23) - V3*V1*b13*cosd(d3) - V3*V2*b23*cosd(d3 - d2)
    Q2 = V2^2*(b12 + b23) - V2*V1*b12*cosd(d2) - V2*V3*b23*cosd(d2 - d3)
    """
    given = {
        "V1": 1.04,
        "V2": 1.02,
        "P2": 0.6,
        "P3": 1.1,
        "Q3": 0.4,
        "b12": 10,
        "b13": 8,
        "b23": 12,
    }
    result = solver.solve(rulesheets.loads(text), given)
    flat = solver.solve(rulesheets.loads(text), given, guesses={"V3": 1.0, "d2": 0.0, "d3": 0.0})
    assert result["Q2"] == pytest.approx(-0.024382, abs=1e-6)
    assert [result[n] for n in ("V3", "d2", "d3")] == pytest.approx(
        [flat[n] for n in ("V3", "d2", "d3")]
    )


SWING = """x = A*exp(-d*t)*cos(w*t)
v = -A*exp(-d*t)*(d*cos(w*t) + w*sin(w*t))
"""


@pytest.mark.parametrize("seed", range(10))
def test_the_first_time_of_a_swing_comes_first(seed: int) -> None:
    rng = random.Random(seed)
    A, w, d = rng.uniform(0.5, 3.0), 10.0 ** rng.uniform(-2.0, 3.0), 0.0
    if seed % 2:
        d = rng.uniform(0.02, 0.1) * w
    x = rng.uniform(0.1, 0.9) * A
    result = solver.solve(rulesheets.loads(SWING), {"A": A, "w": w, "d": d, "x": x})
    first = brentq(
        lambda t: A * math.exp(-d * t) * math.cos(w * t) - x, 0.0, math.pi / w, xtol=1e-300
    )
    assert result["t"] == pytest.approx(first, rel=1e-9)


def test_the_slowest_frequency_comes_first() -> None:
    text = "x = A*cos(w*t)\nv = -A*w*sin(w*t)"
    result = solver.solve(rulesheets.loads(text), {"A": 2.0, "t": 0.7, "x": 1.3})
    assert result["w"] == pytest.approx(math.acos(0.65) / 0.7, rel=1e-12)


def test_a_vapour_is_lighter_than_its_liquid_by_more_than_a_rest() -> None:
    """The heat flux at which boiling water burns out (N. Zuber, 1959): also at 957.8996 of 957.9
    kg/m^3."""
    model = rulesheets.loads("q = 0.149*h*rv*(s*9.81*(rl - rv)/rv^2)^0.25")
    given = {"h": 2257000.0, "rl": 957.9, "s": 0.0589}
    vapour = solver.solve(model, {**given, "q": 1.26e6})["rv"]
    assert vapour == pytest.approx(0.59688, rel=1e-5)  # brentq between 0.1 and 10


@pytest.mark.parametrize(("n1", "n2", "angle"), [(1.0, 1.5, 40.0165), (1.5, 1.0, 25.3833)])
def test_of_mirrored_angles_the_positive_comes_first(n1: float, n2: float, angle: float) -> None:
    """Light that is reflected by the same share at either side of the normal."""
    rules = "n1*sind(t1) = n2*sind(t2)\nd = t1 - t2\n"
    rules += "R = ((n1*cosd(t1) - n2*cosd(t2))/(n1*cosd(t1) + n2*cosd(t2)))^2"
    result = solver.solve(rulesheets.loads(rules), {"n1": n1, "n2": n2, "R": 0.0772})
    assert result["t1"] == pytest.approx(angle, abs=1e-4)  # brentq between 0 and 80, or 41


@pytest.mark.parametrize(
    ("rule", "name", "first", "step"),
    [
        ("6 = mod(day + 45, 7)", "day", 3.0, 7.0),
        ("4.25 = mod(22.5 + hours, 24)", "hours", 5.75, 24.0),
        ("3 = 8*int((need + 7)/8) - need", "need", 5.0, 8.0),
        ("7 = wait - 12*int(wait/12)", "wait", 7.0, 12.0),
        ("0.25 = frac(x/3)", "x", 0.75, 3.0),
    ],
)
def test_the_first_of_what_a_remainder_repeats_comes_first(
    rule: str, name: str, first: float, step: float
) -> None:
    result = solver.solve(rulesheets.loads(rule))
    found = [answer[name] for answer in result.solutions]
    assert found[0] == pytest.approx(first)
    others = [math.remainder(value - first, step) for value in found if value > 0.0]
    assert others == pytest.approx([0.0] * len(others), abs=1e-9)
    assert (len(found) <= 48, result.complete) == (True, False)


@pytest.mark.parametrize("pf", [0.8, 0.95, -0.3])
def test_a_known_cosine_means_its_arccosine(pf: float) -> None:
    """Whatever follows from the angle: the leading current needs a reactive power of twice the
    usual size."""
    sheet = "cosd(phi) = pf\nQ = P*(tand(50) - tand(phi))"
    result = solver.solve(rulesheets.loads(sheet), {"pf": pf, "P": 80.0})
    assert result["phi"] == pytest.approx(math.degrees(math.acos(pf)), rel=1e-12)


def test_of_two_elevations_the_lower_comes_first() -> None:
    sheet = "R = v^2*sind(2*th)/g\nh = v^2*sind(th)^2/(2*g)\nt = 2*v*sind(th)/g"
    result = solver.solve(rulesheets.loads(sheet), {"R": 190.0, "v": 67.0, "g": 9.81})
    expected = math.degrees(math.asin(190.0 * 9.81 / 67.0**2)) / 2
    assert result["th"] == pytest.approx(expected, rel=1e-12)


def test_the_sign_of_a_component_says_nothing() -> None:
    """A lagging current has a negative imaginary part, and raises the voltage at the other end."""
    sheet = """cosd(phi) = pf
    (Ix, Iy) = (I*cosd(phi), -I*sind(phi))
    (Vx, Vy) = (V + R*Ix - X*Iy, R*Iy + X*Ix)
    E = sqrt(Vx^2 + Vy^2)"""
    given = {"pf": 0.9, "I": 0.29, "V": 127.0, "R": 12.0, "X": 80.0}
    result = solver.solve(rulesheets.loads(sheet), given)
    assert (len(result.solutions), result["phi"]) == (2, pytest.approx(25.8419, abs=1e-4))


@pytest.mark.parametrize(("near", "far"), [(0, 1), (1, 0), (-1, 1), (1, -1), (0, -2), (3, 2)])
def test_the_number_of_a_class_says_nothing(near: int, far: int) -> None:
    """Even where the number of one class is 0, or negative."""
    sheet = f"L = 90 - 20*log10(abs(r))\nif r < 2 then field = {near} else field = {far}"
    result = solver.solve(rulesheets.loads(sheet), {"L": 78.0})
    assert [answer["r"] > 0.0 for answer in result.solutions] == [True, False]


@pytest.mark.parametrize("flow", [0.9, 2.2, 4.0])
@pytest.mark.parametrize(
    "sheet",
    [
        "H = G - 1.1*Q^2",
        "H = G - hf\nhf = 1.1*Q^2",
        "H = G - hf\nhf = 0.8*Q^2 + 0.3*Q^2",
        "H = G - hf\nhf = pipe + bend\npipe = 0.8*Q^2\nbend = 0.3*Q^2",
        "H = G - hf\nhf = pipe + 2*bend\npipe = 0.8*v^2\nbend = 0.15*v^2\nv = Q/1",
    ],
)
def test_a_loss_is_small_with_a_name_or_without(sheet: str, flow: float) -> None:
    power = 8.6 * flow * (96 - 1.1 * flow**2)
    result = solver.solve(rulesheets.loads(f"{sheet}\nP = 8.6*Q*H"), {"P": power, "G": 96.0})
    assert result["Q"] == pytest.approx(flow)


@pytest.mark.parametrize("x", [3.0, -3.0])
@pytest.mark.parametrize("y", [4.0, -4.0])
def test_an_unknown_has_the_sign_of_its_value_in_the_sheet(x: float, y: float) -> None:
    """The squares leave signs open, and of u, v and w some are negative whatever is chosen."""
    sheet = f"variables\n  x = {x}\n  y = {y}\nrules\n"
    rules = "q = x^2 + y^2\np = x^2 - y^2\nu = -x*(y + 9)\nv = -3*y - 2*x\nw = x*y"
    model = rulesheets.loads(sheet + rules)
    asked = {"q": 25.0, "p": -7.0, "x": None, "y": None}
    result = solver.solve(model, asked)
    assert len(result.solutions) == 4 and result.complete
    assert (result["x"], result["y"]) == pytest.approx((x, y))
    plan = solver.prepare(model, ["q"], ["x", "y"], asked)
    for scale in (1.0, 1.1, 1.7):
        first = solver.solve(model, {**asked, "q": 25.0 * scale}, ["x", "y"])
        assert plan(25.0 * scale) == pytest.approx((first["x"], first["y"]))
        assert (first["x"] > 0.0, first["y"] > 0.0) == (x > 0.0, y > 0.0)


@pytest.mark.parametrize("one", ["1", "one"])
@pytest.mark.parametrize(("P", "T", "V"), [(10.0, 473.15, 3487.74), (1.0, 473.15, 38945.1)])
def test_a_term_beside_a_number_is_a_correction(one: str, P: float, T: float, V: float) -> None:
    """The virial equation for the vapour of isopropanol (J. M. Smith and H. C. Van Ness): the
    number counts for as much as a given name."""
    sheet = f"P*V = Z*R*T\nZ = {one} + B/V + C/V^2"
    given = {"P": P, "T": T, "R": 83.14, "B": -388.0, "C": -26000.0}
    given |= {"one": 1.0} if one == "one" else {}
    found = solver.solve(rulesheets.loads(sheet), given)
    assert found["V"] == pytest.approx(V, rel=1e-5)
