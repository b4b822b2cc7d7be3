"""Double roots: exactly there, or two answers, or none, a hair on either side; each told for what
it is."""

from __future__ import annotations

import json
import math
from fractions import Fraction
from pathlib import Path

import mpmath
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("flint")

import rulesheets
import solver
from rulesheets.evaluate import differentiate
from rulesheets.evaluate.balls import ball, precision
from rulesheets.evaluate.exact import Inexact, exactly
from rulesheets.syntax.nodes import Name, Negative, Number, Power, Product, Sum
from solver.__main__ import main
from solver.solution.proof import Square, unfolded

MODELS = Path(__file__).parent.parent.parent / "models"
CRANK = rulesheets.load(MODELS / "offset_slider_crank" / "model.tk")


def circles(a: float, b: float, first: float, second: float) -> solver.Result:
    """Circles around the origin and around (a, b)."""
    rules = f"x^2 + y^2 = {first!r}^2\n(x - {a!r})^2 + (y - {b!r})^2 = {second!r}^2"
    return solver.solve(rulesheets.loads(rules), prove=True)


@pytest.mark.parametrize("hair", [-1, 0, 1])
@pytest.mark.parametrize(
    ("triple", "radius", "within"),
    [((3, 4, 5), 2, False), ((5, 12, 13), 20, False), ((8, 15, 17), 3, True)],
    ids=["side by side", "the second within", "the first within"],
)
def test_touching_circles(
    triple: tuple[int, int, int], radius: int, within: bool, hair: int
) -> None:
    """Whole numbers: the distance of the middles is exactly the sum of the radii, or their
    difference.

    One unit in the last place of a radius makes two answers, or none.
    """
    a, b, distance = triple
    other = float(radius + distance if within else abs(distance - radius))
    changed = other if not hair else math.nextafter(other, math.inf if hair > 0 else 0.0)
    result = circles(float(a), float(b), float(radius), changed)
    if hair:
        overlap = (hair > 0) is not within
        assert str(result.status) == ("solved" if overlap else "infeasible")
        assert len(result.solutions) == (2 if overlap else 0)
        assert all(
            solution.proof is not None and solution.proof.proved for solution in result.solutions
        )
        return
    assert str(result.status) == "singular"
    (solution,) = result.solutions
    assert solution.proof is not None
    assert set(solution.proof.double) == {"x", "y"}
    sign = -1 if within else 1
    assert solution["x"] == float(Fraction(sign * a * radius, distance))
    assert solution["y"] == float(Fraction(sign * b * radius, distance))


@pytest.mark.parametrize(("x", "branch"), [(11.0, "open"), (-5.0, "crossed")])
def test_dead_centre_in_line(x: float, branch: str) -> None:
    inputs = {"xB": x, "offset": 0.0, "thetaAO": None, "branch": branch}
    result = solver.solve(CRANK, inputs, prove=True)
    assert str(result.status) == "singular"
    assert any(
        "thetaAO" in solution.proof.double for solution in result.solutions if solution.proof
    )


def test_a_dead_centre_that_no_float_hits_is_not_proved() -> None:
    result = solver.solve(CRANK, {"xB": math.sqrt(117.0), "thetaAO": None}, prove=True)
    assert str(result.status) == "singular"
    assert all(solution.proof and not solution.proof.double for solution in result.solutions)


@pytest.mark.parametrize(
    ("AO", "AB", "offset", "outer", "branch"),
    [
        (3.0, 8.0, 2.0, True, "open"),
        (1.0, 8.0, -2.0, True, "crossed"),
        (1.3, 7.3, 0.0, False, "open"),
        (3.3, 6.4, 0.0, True, "crossed"),
        (2.170181616307929, 7.016429468983409, -1.9311992131070599, False, "open"),
    ],
)
def test_a_dead_centre_that_no_float_hits_is_two_answers_or_none(
    AO: float, AB: float, offset: float, outer: bool, branch: str
) -> None:
    """In rational numbers the slider of these doubles is within reach, or it is not."""
    limit = (Fraction(AB) + (1 if outer else -1) * Fraction(AO)) ** 2 - Fraction(offset) ** 2
    x = math.sqrt(limit)
    reached = (Fraction(x) ** 2 < limit) is outer
    inputs = {"AO": AO, "AB": AB, "offset": offset, "branch": branch, "thetaAO": None}
    result = solver.solve(
        CRANK, {**inputs, "xB": math.copysign(x, 1 if branch == "open" else -1)}, prove=True
    )
    assert str(result.status) == "singular"
    (solution,) = result.solutions
    assert solution.proof is not None
    assert not solution.proof.proved
    beside = solution.proof.beside
    assert beside is not None
    assert "thetaAO" in beside.unknowns
    assert beside.roots == (2 if reached else 0)
    assert bool(beside.apart) is reached


@given(st.floats(0.1, 9.0), st.integers(-4, 4))
def test_the_double_root_of_a_quadratic_is_two_or_none(a: float, hairs: int) -> None:
    """x² − 2ax + b, b some hairs from the float next to a²: its discriminant is a rational
    number."""
    b = a * a
    for _ in range(abs(hairs)):
        b = math.nextafter(b, math.inf if hairs > 0 else 0.0)
    room = Fraction(a) ** 2 - Fraction(b)
    x, square = Name("x"), Power(Name("x"), Number(2.0))
    form = Sum((square, Negative(Product(Number(2.0 * a), x)), Number(b)))
    with precision(400):
        found = unfolded(Square([form], [differentiate(form, "x")], ("x",)), {}, [ball(a)])
        if not room:
            assert found is None
            return
        assert found is not None
        assert len(found) == (2 if room > 0 else 0)
        places = sorted(float(root["x"].mid()) for root in found)
    far = float(room) ** 0.5 if room > 0 else 0.0
    assert places == pytest.approx([a - far, a + far] if far else [], rel=1e-14)


def test_two_answers_a_hair_apart_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    words = ["solve", "offset_slider_crank", "--clear", "thetaAO", "--want", "thetaAO", "--prove"]
    assert main([*words, "--set", "xB=sqrt(117)"]) == 1
    assert (
        "proved: for the numbers exactly as they are there is no answer here"
        in capsys.readouterr().out
    )
    crank = [*words, "--set", "AO=1.3", "--set", "AB=7.3", "--set", "offset=0"]
    assert main([*crank, "--set", "xB=6", "--json"]) == 1
    (proof,) = json.loads(capsys.readouterr().out)["proofs"]
    assert proof["proved"] is False
    assert proof["beside"]["roots"] == 2
    assert proof["beside"]["apart"]["thetaAO"] == pytest.approx(
        apart_of_two(1.3, 7.3, 6.0), rel=1e-9
    )


def apart_of_two(crank: float, rod: float, x: float) -> float:
    """Degrees between the two angles of an in-line crank, by the law of cosines to 60 digits."""
    with mpmath.workdps(60):
        a, b, d = map(mpmath.mpf, (crank, rod, x))
        return float(360 - 2 * mpmath.degrees(mpmath.acos((a * a + d * d - b * b) / (2 * a * d))))


def test_the_command_tells_of_a_double_root(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("touching.tk").write_text("x^2 + y^2 = 4\n(x - 3)^2 + (y - 4)^2 = 9\n")
    assert main(["solve", "touching.tk", "--prove"]) == 1
    told = "proved: the rules of x, y hold exactly, with a singular Jacobian: a double root"
    assert told in capsys.readouterr().out


def test_exact_values() -> None:
    equation = rulesheets.loads("y = sind(90)*x^-2/6 - sqrt(x/4) + abs(-x)*cosd(180)").equations[0]
    assert exactly(equation.right, {"x": Fraction(9, 25)}) == Fraction(625, 486) - Fraction(
        3, 10
    ) - Fraction(9, 25)
    for text in ("y = sqrt(2)", "y = sind(20)", "y = 1/(x - x)", "y = x^0.5", "y = x + z"):
        with pytest.raises(Inexact):
            exactly(rulesheets.loads(text).equations[0].right, {"x": Fraction(2)})


def test_an_angle_at_a_double_root_is_turned_like_others() -> None:
    """The chain PQRS stretched at 180 degrees, up to one unit in the last place of a link."""
    model = rulesheets.load(MODELS / "four_link_chain" / "model.tk")
    links = {"PQ": 2.234905040932233, "PS": 3.3800976976508093, "QR": 3.005324586607604, "QM": 0.5}
    result = solver.solve(model, {**links, "RS": 2.6096781519754373, "thetaPQ": 180.0})
    assert str(result.status) == "singular"


@pytest.mark.parametrize("rule", ["x^2 - abs(x)/8 = c", "max(x, -2*x) = c", "abs(x)*(1 + x) = c"])
def test_a_kink_is_no_double_root(rule: str) -> None:
    """Each crosses or meets 0 at x = 0 with a slope on either side."""
    result = solver.solve(rulesheets.loads(rule), {"c": 0.0}, prove=True)
    at = [answer for answer in result.solutions if answer["x"] == 0.0]
    assert at and not any(answer.proof.double for answer in at if answer.proof)
