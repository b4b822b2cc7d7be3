"""Prepared calls by records of a solve, compared with full solves, closed forms and each other."""

from __future__ import annotations

import math
import random
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

import rulesheets
import solver
from solver.accuracy.rule_check import check_rule
from solver.kernel.block import kernel_of
from solver.path import SolveBlock
from solver.path.planner import planner
from solver.trace.newton import BlockNewton

MODELS = Path(__file__).parents[3] / "models"
EVERYDAY = Path(__file__).parents[2] / "everyday"

TWO = """
variables
  p = 1.2
  q = 2.5
  x in [0, 3]
  y in [0, 3]
rules
  x + y + sin(x*y) + 0.1*exp(x - y^2) = p + q
  x*exp(0.1*y) - 0.3*y*cosh(x) = p
"""

THREE = """
variables
  p = 0.3
  x in [0, 3]
  y in [0, 3]
  z in [0, 3]
rules
  x + 0.2*sin(y*z) = 1 + p
  y + 0.2*exp(-x*z) = 2 - p
  z + 0.1*x*y*cos(x + y + z) = 1.5
"""


def finders(plan: solver.Plan) -> list[object]:
    return [finder for program in plan.records.programs for finder in program.flow.finders]


@pytest.mark.parametrize(("text", "inputs"), [(TWO, ["p", "q"]), (THREE, ["p"])])
def test_blocks_of_several_tears_are_recorded(text: str, inputs: list[str]) -> None:
    model = rulesheets.loads(text)
    want = [name for name, variable in model.variables.items() if variable.value is None]
    plan = solver.prepare(model, inputs, want)
    middle = [float(model.variables[name].value) for name in inputs]
    plan(*middle)
    assert any(isinstance(finder, BlockNewton) for finder in finders(plan))
    draw = random.Random(3)
    for _ in range(10):
        point = [number * draw.uniform(0.95, 1.05) for number in middle]
        full = solver.solve(rulesheets.loads(text), dict(zip(inputs, point, strict=True)))
        found = dict(zip(want, plan(*point), strict=True))
        assert any(
            all(math.isclose(found[n], s[n], rel_tol=1e-12) for n in want) for s in full.solutions
        ), point


def test_every_answer_is_followed() -> None:
    """Both roots of a block with no formula: where x exp(-x) = c/10, y = x + sin(x)/9."""
    rules = "y = x + sin(x)/9\n 10*x*exp(x - y - x) = c"
    model = rulesheets.loads(f"variables\n c = 2\n x\n y\nrules\n {rules}\n")
    plan = solver.prepare(model, ["c"], ["x"])
    known = sorted(row[0] for row in plan.all(2.0))
    for c in np.linspace(1.9, 2.1, 9):
        rows = sorted(row[0] for row in plan.all(c))
        assert len(rows) == len(known)
        for x in rows:
            assert 10 * x * math.exp(-x - math.sin(x) / 9) == pytest.approx(c, rel=1e-12)


@pytest.mark.parametrize("swap", [("omegaQR", "PQ"), ("xm", "QR")])
def test_the_digits_do_not_depend_on_what_was_asked_before(swap: tuple[str, str]) -> None:
    model = rulesheets.load(MODELS / "four_link_chain" / "model.tk")
    given, wanted = swap
    number = solver.solve(model)[given]
    plans = [solver.prepare(model, [given], [wanted], {wanted: None}) for _ in range(2)]
    for plan, first in zip(plans, (1.0, 1.0013), strict=True):
        plan(number * first)
    for share in np.linspace(1.0002, 1.0011, 7):
        one, other = (plan(number * share)[0] for plan in plans)
        assert one == pytest.approx(other, rel=2**-51)


def test_rows_agree_with_calls() -> None:
    model = rulesheets.loads(TWO)
    plan = solver.prepare(model, ["p", "q"], ["x", "y"])
    p, q = np.linspace(1.0, 1.4, 60), np.linspace(2.3, 2.7, 60)
    table = plan.sweep(p, q)
    for row in range(0, 60, 7):
        assert (table["x"][row], table["y"][row]) == pytest.approx(plan(p[row], q[row]), rel=1e-13)


def test_a_fold_is_left_to_the_full_solve() -> None:
    """Next to the fold of x exp(-x) = c floats lose digits: no record answers there with wrong
    ones."""
    text = "variables\n c = 0.3\n x\n y\nrules\n y = x*exp(-x)\n y + 0*cos(x) = c\n"
    plan = solver.prepare(rulesheets.loads(text), ["c"], ["x"])
    plan(0.3)
    for c in (0.36787, 0.3678794, 0.3678794411, 0.367879441171):
        expected = sorted(float(-mpmath.lambertw(-mpmath.mpf(c), k).real) for k in (0, -1))
        assert sorted(row[0] for row in plan.all(c)) == pytest.approx(expected, rel=1e-11)


def test_a_branch_that_ends_is_no_answer() -> None:
    """The fold of x exp(-x) = c at c = 1/e: beyond it there is nothing."""
    model = rulesheets.loads(
        "variables\n c = 0.3\n x\n y\nrules\n y = x*exp(-x)\n y + 0*cos(x) = c\n"
    )
    plan = solver.prepare(model, ["c"], ["x"])
    assert len(plan.all(0.3)) == 2
    with pytest.raises(solver.Unsolved):
        plan(0.38)
    for x in (row[0] for row in plan.all(0.36787)):
        assert x * math.exp(-x) == pytest.approx(0.36787, rel=1e-13)


def test_a_block_of_constants_is_followed_on_rows() -> None:
    model = rulesheets.loads("variables\n b = 1\n x in [0, 2]\n z\nrules\n x = cos(x)\n z = b*x\n")
    plan = solver.prepare(model, ["b"], ["z"])
    table = plan.sweep(np.linspace(1.0, 2.0, 40))
    assert table["z"] == pytest.approx(0.7390851332151607 * np.linspace(1.0, 2.0, 40), rel=1e-14)
    newton = BlockNewton(
        kernel_of(planner(model).graph, SolveBlock((0,), ("x",), ("x",))), [0.74], []
    )
    assert newton.array() == pytest.approx(np.array([[0.7390851332151607]]), rel=1e-15)


def test_a_redundant_rule_that_tells_more_digits_is_followed() -> None:
    """Next to the perihelion the distance tells little of the eccentric anomaly, the direction
    much."""
    model = rulesheets.load(MODELS / "kepler" / "model.tk")
    state = solver.solve(model)
    plan = solver.prepare(model, ["nu"], ["M"], {"M": None})
    plan(state["nu"])
    assert plan.records.programs
    for nu in (6.0, 6.1, 6.2):
        E = 2 * math.atan(math.sqrt(0.9 / 1.1) * math.tan(math.radians(nu) / 2))
        assert plan(nu)[0] == pytest.approx(math.degrees(E - 0.1 * math.sin(E)), rel=1e-13)


def test_a_small_number_that_a_formula_loses_digits_of_is_corrected() -> None:
    """Carbonate in rain is what little is left of hydrogen after bicarbonate."""
    model = rulesheets.load(EVERYDAY / "chemistry" / "rain.tk")
    state = solver.solve(model).solutions[0]
    plan = solver.prepare(model, ["pH"], None, {"pCO2": None})
    plan(state["pH"])
    assert plan.records.programs
    for pH in (5.55, 5.6, 5.65):
        found = {**state, "pH": pH, **dict(zip(plan.want, plan(pH), strict=True))}
        assert all(check_rule(rule, found).holds for rule in model.equations)


def test_a_second_answer_of_an_odd_size_is_followed() -> None:
    """The temperature at which one vapour pressure is 2.47 times another, and a root near a
    pole."""
    model = rulesheets.loads(
        "log(p1) = 6.90565 - 1211.033/(T + 220.79)\nlog(p2) = 6.95464 - 1344.8/(T + 219.482)\na = "
        "p1/p2"
    )
    plan = solver.prepare(model, ["a"], ["T", "p1"])
    plan(2.467839685576056)
    assert plan.records.programs
    for a in (2.45, 2.467, 2.48):
        expected = solver.solve(model, {"a": a})
        assert len(expected.solutions) == 2
        assert expected.solutions[1]["p1"] > 1e100
        found = plan.all(a)
        assert [row[0] for row in found] == pytest.approx(
            [s["T"] for s in expected.solutions], rel=1e-12
        )


@pytest.mark.parametrize("given, wanted", [("alphaEF", "phiF"), ("ye", "phiC")])
def test_a_record_is_made_where_unknowns_vanish_and_angles_turn(given: str, wanted: str) -> None:
    """At its own numbers the sheet has a piston at 180 degrees, and another right above the
    shaft."""
    model = rulesheets.load(MODELS / "two_cylinder_engine" / "model.tk")
    state = solver.solve(model)
    plan = solver.prepare(model, [given], [wanted], {wanted: None})
    plan(state[given])
    assert plan.records.programs
    assert any(row[0] == pytest.approx(state[wanted], rel=1e-12) for row in plan.all(state[given]))


BEAM = "variables\n w = 3\n x = 2\n L\nrules\n w*L^4/8 = R*L^3/3\n R = w*x\n"
CHANNEL = (
    "variables\n v = 2\n Q\nrules\n A = 3*y\n P = 3 + 2*y\n R = A/P\n Q = 9*A*R^(2/3)\n Q = v*A\n"
)


def depth(v: float) -> float:
    return 3.0 * (v / 9.0) ** 1.5 / (3.0 - 2.0 * (v / 9.0) ** 1.5)


@pytest.mark.parametrize(
    "text, given, wanted, root",
    [(BEAM, "x", "L", lambda x: 8.0 * x / 3.0), (CHANNEL, "v", "Q", lambda v: 3.0 * v * depth(v))],
)
def test_an_unknown_that_may_vanish_keeps_a_record(
    text: str, given: str, wanted: str, root: Any
) -> None:
    """A span of 0 is a triple root, and at a depth of 0 a slope is infinite: whatever the load or
    speed."""
    plan = solver.prepare(rulesheets.loads(text), [given], [wanted])
    for number in (2.0, 2.01, 1.9):
        assert [row[0] for row in plan.all(number)] == pytest.approx([root(number), 0.0], rel=1e-12)
    assert plan.records.programs


TAX = """if income <= 12000 then tax = 0 else tax = 0.2*(income - 12000)
average = 100*tax/income"""


def test_a_case_in_which_a_rule_divides_0_by_0_stops_no_record() -> None:
    """Without a tax the average asks for an income of 0."""
    plan = solver.prepare(rulesheets.loads(TAX), ["average"], ["income"])
    for average in (10.0, 10.1, 9.8):
        assert plan.all(average) == [(pytest.approx(2.4e5 / (20.0 - average), rel=1e-12),)]
    assert plan.records.programs


def test_a_double_root_comes_last_in_records_too() -> None:
    """The span is negative, so that the rule for sizes and signs alone would begin with 0."""
    plan = solver.prepare(rulesheets.loads(BEAM.replace("x = 2", "x = -2")), ["x"], ["L"])
    for number in (-2.0, -2.01, -1.9, -1.8, -1.7):
        assert [row[0] for row in plan.all(number)] == pytest.approx(
            [8.0 * number / 3.0, 0.0], rel=1e-12
        )
        assert plan(number)[0] == pytest.approx(8.0 * number / 3.0, rel=1e-12)
    assert plan.records.programs


def test_a_double_root_that_parts_leaves_no_record() -> None:
    """At s = 0 both roots of x^2 cosh(x) = s are 0, beside it they are not, and below it there are
    none."""
    model = rulesheets.loads("variables\n s = 0\n x\nrules\n x^2*cosh(x) = s\n")
    plan = solver.prepare(model, ["s"], ["x"])
    with pytest.raises(solver.Unsolved):
        plan(0.0)
    root = mpmath.findroot(lambda x: x * x * mpmath.cosh(x) - 0.25, 0.5)
    assert sorted(row[0] for row in plan.all(0.25)) == pytest.approx([-root, root], rel=1e-12)
    with pytest.raises(solver.Unsolved):
        plan(-0.25)


def test_the_brief_form_says_the_first_of_all_answers() -> None:
    model = rulesheets.loads(
        "variables\n s\n p\n x\n y\nrules\n x + y = s\n x*y = p\n x^3 + y = z\n"
    )
    plan = solver.prepare(model, ["s", "p"], ["x", "y", "z"])
    plan(5.0, 3.0)
    assert plan.records.programs[0].brief is not None
    draw = random.Random(1)
    for _ in range(100):
        numbers = draw.uniform(2.0, 9.0), draw.uniform(-3.0, 0.9)
        assert plan(*numbers) == pytest.approx(plan.all(*numbers)[0], rel=1e-12)


def test_answers_next_to_a_fold_are_not_lost_to_a_record_beyond_it() -> None:
    """Both answers end at an acceleration of -709.09."""
    model = rulesheets.load(MODELS / "offset_slider_crank" / "model.tk")
    plan = solver.prepare(model, ["aB"], ["offset"], {"offset": None})
    for aB in (-709.1, -707.0, -714.02616824541, -700.0):
        if aB < -709.09:
            assert len(plan.all(aB)) == 2
        else:
            with pytest.raises(solver.Unsolved):
                plan.all(aB)


def test_a_row_on_the_boundary_of_a_case_teaches_nothing_about_others() -> None:
    """-2 is no answer where z = -4, as x > -2 there; beside it there are two."""
    plan = solver.prepare(
        rulesheets.loads("if x > -2 then y = x^2 else y = -3.8\nz = -y"), ["z"], ["x"]
    )
    for z, expected in ((-4.0, [2.0]), (-3.0, [-(3.0**0.5), 3.0**0.5]), (-9.0, [3.0])):
        assert sorted(x for (x,) in plan.all(z)) == pytest.approx(expected)


def test_angles_beyond_half_a_turn_stay_in_the_turn_that_the_answer_has_them_in() -> None:
    rules = "variables\nb = 7\nc = 9\nC = 80\nrules\na^2 = b^2 + c^2 - 2*b*c*cosd(A)\n"
    model: Any = solver.loads(rules + "b/sind(B) = a/sind(A)\nA + B + C = 180\n")
    plan: Any = solver.prepare(model, ["b", "c", "C"], ["A"])
    for number in (80.0, 80.1, 79.7):
        found = plan.all(7.0, 9.0, number)
        wanted = solver.solve(model, {"C": number}).solutions
        assert [row[0] for row in found] == pytest.approx([answer["A"] for answer in wanted])
    assert len(plan.records.programs) == 1


def test_a_root_with_a_negative_base_keeps_a_record_of_the_other_one() -> None:
    """Savings: for an even number of years there is a second rate, below -200 %."""
    plan: Any = solver.prepare(
        solver.loads("S = S0*(1 + r)^n + a*((1 + r)^n - 1)/r\n"), ["S0", "n", "a", "S"], ["r"]
    )
    for total in (684000.0, 684700.0, 683000.0):
        rows = plan.all(20000.0, 30.0, 7200.0, total)
        for (r,) in rows:
            growth = mpmath.mpf(1 + mpmath.mpf(r)) ** 30
            assert 20000 * growth + 7200 * (growth - 1) / r == pytest.approx(total, rel=1e-12)
        assert [r < -2.0 for (r,) in rows] == [False, True]
    assert len(plan.records.programs) == 1


SINES = """
variables
  a = 5 > 0
  b = 7 > 0
  C = 50         [deg]
  c > 0
  A in [0, 180]  [deg]
  B in [0, 180]  [deg]
  R
  p
rules
  c^2 = a^2 + b^2 - 2*a*b*cosd(C)
  a/sind(A) = 2*R
  b/sind(B) = 2*R
  c/sind(C) = 2*R
  A + B + C = 180
  p = a + b + c
"""


def test_a_rule_that_follows_from_others_is_checked_in_a_record() -> None:
    """With b and C known, (p - b - a)^2 = a^2 + b^2 - 2 a b cos C is linear in a."""
    plan: Any = solver.prepare(solver.loads(SINES), ["p"], ["a"], {"a": None})
    for p in (17.385, 17.4, 17.2, 18.0):
        q = p - 7.0
        expected = (q * q - 49.0) / (2.0 * (q - 7.0 * math.cos(math.radians(50.0))))
        assert plan(p) == (pytest.approx(expected, rel=1e-12),)
    assert len(plan.records.programs) == 1


def test_a_rule_that_follows_from_others_here_refuses_numbers_elsewhere() -> None:
    """At k = 2 the second rule is twice the first one; at another k it says that x is 0."""
    plan: Any = solver.prepare(
        solver.loads("x + y = 3\nk*x + 2*y = 6\nw = x - y\n"), ["k", "w"], ["x", "y"]
    )
    assert plan(2.0, 1.0) == (2.0, 1.0)
    assert plan(2.0, 1.5) == (2.25, 0.75)
    assert plan(3.0, -3.0) == (0.0, 3.0)
    for row in ((3.0, 1.0), (2.001, 1.0), (2.0, 1.0), (1.0, 1.0)):
        if row[0] == 2.0:
            assert plan(*row) == (2.0, 1.0)
            continue
        with pytest.raises(solver.Unsolved) as refused:
            plan(*row)
        assert str(refused.value.status) == "inconsistent"


def test_a_block_that_comes_to_nothing_leaves_no_record_and_no_error() -> None:
    """Heron's rule for a side, where the sines of unknown angles say nothing of it."""
    rules = """
    variables
      a = 5 > 0
      b = 7 > 0
      c = 6 > 0
      A in [0, 180]  [deg]
      B in [0, 180]  [deg]
      C in [0, 180]  [deg]
      S
      p
      R
    rules
      a^2 = b^2 + c^2 - 2*b*c*cosd(A)
      b^2 = a^2 + c^2 - 2*a*c*cosd(B)
      c^2 = a^2 + b^2 - 2*a*b*cosd(C)
      a/sind(A) = 2*R
      b/sind(B) = 2*R
      c/sind(C) = 2*R
      A + B + C = 180
      p = a + b + c
      S = sqrt(p/2*(p/2 - a)*(p/2 - b)*(p/2 - c))
    """
    plan: Any = solver.prepare(solver.loads(rules), ["S"], ["a"], {"a": None})
    for area in (14.69, 14.7):
        square = [
            85.0 + sign * math.sqrt(4.0 * 49.0 * 36.0 - 16.0 * area**2) for sign in (-1.0, 1.0)
        ]
        assert [a for (a,) in plan.all(area)] == pytest.approx(
            [math.sqrt(s) for s in square], rel=1e-12
        )


def test_answers_born_beside_a_record_are_not_missed() -> None:
    """A moment determines a span by cubics, one for each sign of a force: two of its roots begin at
    28.5."""
    rules = "R = 6*x + M/x\n8*M*(x + 5) = -(12*x^3 + 2500)\nP = R^2/24\n"
    model = rulesheets.loads(f"variables\n P = 28\n x\nrules\n{rules}")
    plan = solver.prepare(model, ["P"], ["x"])
    moments = np.linspace(28.1, 32.0, 41)
    found = plan.sweep(moments)
    for moment, count in zip(moments.tolist(), np.asarray(found["answers"]).tolist(), strict=True):
        forces = (math.sqrt(24.0 * moment), -math.sqrt(24.0 * moment))
        cubics = ([-36.0, 8.0 * force - 240.0, 40.0 * force, 2500.0] for force in forces)
        roots = np.concatenate([np.roots(cubic) for cubic in cubics])
        assert count == np.count_nonzero(np.abs(roots.imag) < 1e-9)


def test_a_root_next_to_the_pole_of_a_logarithm_is_followed() -> None:
    """Of a pipe by its loss of head: the rule of Colebrook leaves 2e-17 of two numbers of 1e-4."""
    rules = "1/sqrt(f) = -2*log10(1.35e-4 + 2.51e-5/(V*sqrt(f)))\nhf = (2500*f + 12)*V^2/19.62\n"
    model = rulesheets.loads(rules)
    kernel = kernel_of(planner(model).graph, SolveBlock((0, 1), ("V", "f"), ("f",)))

    def root(hf: float) -> list[float]:
        def miss(f: Any) -> Any:
            return (
                1.35e-4
                - 2.51e-5 / (mpmath.sqrt(hf * 19.62 / (2500 * f + 12) * f))
                - 10 ** (-0.5 / mpmath.sqrt(f))
            )

        f = mpmath.findroot(miss, 9e-4)
        return [-float(mpmath.sqrt(hf * 19.62 / (2500 * f + 12))), float(f)]

    with mpmath.workdps(50):
        newton = BlockNewton(kernel, root(28.0), [28.0])
        for hf in (28.0, 28.01, 27.5):
            assert newton.scalar(hf) == pytest.approx(root(hf), rel=1e-12)
            assert newton.array(hf)[:, 0] == pytest.approx(root(hf), rel=1e-12)


def test_a_rule_next_to_the_pole_of_its_logarithm_is_checked_without_it() -> None:
    """The diameter of a pipe: for one that is negative the argument of a logarithm is lost in
    rounding."""
    rules = (
        "V = Q/(pi/4*D^2)",
        "Re = V*D/1e-6",
        "1/sqrt(f) = -2*log10(eps/(3.7*D) + 2.51/(Re*sqrt(f)))",
        "hf = (f*250/D + 12)*V^2/19.62",
        "15 + hf = 45 - 12000*Q^2",
    )
    plan = solver.prepare(rulesheets.loads("\n".join(rules)), ["hf"], ["D"], {"eps": 5e-5})
    first = plan.all(23.966)
    assert len(first) == 4 and len(plan.records.programs) == 1
    for loss in (23.96, 23.97, 23.98):
        fresh = solver.solve(plan.model, {"hf": loss, "eps": 5e-5}, want=["D"])
        found = sorted(row[0] for row in plan.all(loss))
        assert found == pytest.approx(sorted(answer["D"] for answer in fresh.solutions), rel=1e-9)
    assert len(plan.records.programs) == 1


def test_a_branch_that_ends_at_the_root_of_a_negative_number_is_watched() -> None:
    """The roughness of a channel by its speed: a negative depth has a negative radius, and no 2/3
    power."""
    rules = (
        "A = (3 + 1.5*y)*y",
        "R = A/(3 + 2*y*sqrt(3.25))",
        "V = R^(2/3)*sqrt(0.001)/n",
        "8 = V*A",
    )
    plan = solver.prepare(rulesheets.loads("\n".join(rules)), ["V"], ["n"])
    for speed in (1.6, 1.7, 1.5):
        area = 8.0 / speed
        depth = (math.sqrt(9.0 + 6.0 * area) - 3.0) / 3.0
        radius = area / (3.0 + 2.0 * depth * math.sqrt(3.25))
        ((found,),) = plan.all(speed)
        assert found == pytest.approx(radius ** (2 / 3) * math.sqrt(0.001) / speed, rel=1e-12)
    assert len(plan.records.programs) == 1


def test_a_range_that_a_block_leaves_is_watched_though_its_first_rule_lacks_the_name() -> None:
    model = rulesheets.load(MODELS / "slotted_link" / "model.tk")
    state = solver.solve(model)
    plan = solver.prepare(model, ["xD"], ["thetaOB"], {"thetaOB": None})
    answers = solver.solve(model, {"xD": state["xD"], "thetaOB": None}, want=["thetaOB"])
    angles = sorted({answer["thetaOB"] for answer in answers.solutions})
    for _ in range(2):
        assert sorted(angle for (angle,) in plan.all(state["xD"])) == pytest.approx(
            angles, rel=1e-9
        )
