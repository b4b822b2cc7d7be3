"""Double roots: exactly there, or not proved where only rounding makes them."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path

import pytest

pytest.importorskip("flint")

import rulesheets
import solver
from rulesheets.evaluate.exact import Inexact, Rationals
from solver.__main__ import main

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
    exact = Rationals({"x": Fraction(9, 25)}, None).of(equation.right)
    assert exact == Fraction(625, 486) - Fraction(3, 10) - Fraction(9, 25)
    for text in ("y = sqrt(2)", "y = sind(20)", "y = 1/(x - x)", "y = x^0.5", "y = x + z"):
        with pytest.raises(Inexact):
            Rationals({"x": Fraction(2)}, None).of(rulesheets.loads(text).equations[0].right)


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
