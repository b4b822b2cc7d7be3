"""Functions of one's own: registered from Python, named by sheets, solved in every direction."""

from __future__ import annotations

import math
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

import rulesheets
import solver
from rulesheets.diagnosis import RuleSheetError
from rulesheets.format import format_sheet
from rulesheets.functions import TABLE
from rulesheets.functions.row import slope_by_differences
from rulesheets.parse.sections import parse
from rulesheets.syntax import Source

ANTOINE = """
import rulesheets

def psat(T):
    if T <= -233.426:
        raise ValueError("colder than the equation goes")
    return 10 ** (8.07131 - 1730.63 / (233.426 + T))

rulesheets.function("psat", psat)
"""
SHEET = 'use python "properties.py"\nvariables\n  T = 80\n  p\nrules\n  p = psat(T)\n'


def psat(t: float) -> float:
    return 10 ** (8.07131 - 1730.63 / (233.426 + t))


@pytest.fixture(autouse=True)
def table() -> Iterator[None]:
    """The table is as before afterwards."""
    before = dict(TABLE)
    yield
    TABLE.clear()
    TABLE.update(before)


@pytest.fixture
def sheet(tmp_path: Path) -> Path:
    (tmp_path / "properties.py").write_text(ANTOINE, encoding="utf-8")
    (tmp_path / "steam.tk").write_text(SHEET, encoding="utf-8")
    return tmp_path / "steam.tk"


def test_a_function_called_like_an_operation_is_not_taken_for_it() -> None:
    rulesheets.function("power", lambda x, y: x * y + 1)
    result = solver.solve(rulesheets.loads("x^1.5 + power(x, y) = 10\ny^1.5 + power(y, x) + x = 8"))
    assert result.status is solver.Status.SOLVED
    x, y = float(result["x"]), float(result["y"])
    assert x**1.5 + x * y + 1 == pytest.approx(10)


def test_functions_of_ones_own_are_no_part_of_a_kept_model(tmp_path: Path) -> None:
    (tmp_path / "own.tk").write_text("y = twice_as(3)\n")
    rulesheets.function("twice_as", lambda x: 2 * x)
    assert rulesheets.load(tmp_path / "own.tk").equations
    del TABLE["twice_as"]
    with pytest.raises(RuleSheetError) as caught:
        rulesheets.load(tmp_path / "own.tk")
    assert caught.value.diagnoses[0].code == "E201"


def entropy(t: float) -> float:
    """Of air in kJ/kg K, by a cubic polynomial for the specific heat (Cengel & Boles, table
    A-2c)."""
    return (28.11 * math.log(t) + 0.1967e-2 * t + 0.2401e-5 * t**2 - 0.6553e-9 * t**3) / 28.97


@pytest.mark.parametrize("guesses", [{}, {"T2": 800.0}])
def test_a_large_value_of_a_small_slope_is_solved_for(guesses: dict[str, float]) -> None:
    """The rounding of an entropy of 7 moves the temperature by more than a rule of the language may
    miss."""
    rulesheets.function("entropy", entropy)
    model = rulesheets.loads("T1 = 1400\nr = 10\nentropy(T2) = entropy(T1) - 0.287*ln(r)\n")
    result = solver.solve(model, guesses=guesses)
    low, high = 300.0, 1400.0  # by bisection
    for _ in range(60):
        middle = (low + high) / 2
        below = entropy(middle) < entropy(1400.0) - 0.287 * math.log(10)
        low, high = (middle, high) if below else (low, middle)
    assert result["T2"] == pytest.approx(low, rel=1e-13)


def test_a_step_through_a_function_of_floats_is_not_refused_for_want_of_digits() -> None:
    """The wet bulb at 22 °C: where floats leave an answer vague, more digits have no value of
    psat."""

    def psat(t: float) -> float:
        return 0.61078 * math.exp(17.27 * t / (t + 237.3))

    def wet(t: float) -> float:
        saturated = 0.622 * psat(22) / (101.325 - psat(22))
        w = (1.005 * (22 - t) + saturated * (2501 - 2.326 * 22)) / (2501 + 1.86 * t - 4.186 * 22)
        return 1.005 * t + w * (2501 + 1.86 * t)

    rulesheets.function("psat", psat)
    sheet = """
        ws = 0.622*psat(22)/(101.325 - psat(22))
        w = (1.005*(22 - T) + ws*(2501 - 2.326*22))/(2501 + 1.86*T - 4.186*22)
        h = 1.005*T + w*(2501 + 1.86*T)
    """
    result = solver.solve(rulesheets.loads(sheet), {"h": wet(32.0)})
    assert result["T"] == pytest.approx(32.0, rel=1e-9)


def test_a_file_of_python_runs_only_if_that_is_allowed(sheet: Path) -> None:
    with pytest.raises(RuleSheetError) as caught:
        rulesheets.load(sheet)
    (diagnosis,) = caught.value.diagnoses
    assert diagnosis.code == "E313" and "psat" not in TABLE
    assert solver.solve(rulesheets.load(sheet, allow_python=True))["p"] == pytest.approx(psat(80.0))


def test_solved_backwards_by_search(sheet: Path) -> None:
    model = rulesheets.load(sheet, allow_python=True)
    result = solver.solve(model, {"T": None, "p": 355.0})
    assert str(result.status) == "solved" and not result.complete
    assert psat(float(result["T"])) == pytest.approx(355.0, rel=1e-13)


def test_sweeps_and_plans(sheet: Path) -> None:
    model = rulesheets.load(sheet, allow_python=True)
    pressures = np.linspace(100.0, 700.0, 60)
    table = solver.sweep(model, {"p": pressures}, want=["T"], given={"T": None}, jobs=2)
    assert not table.status.any()
    assert [psat(t) for t in table["T"]] == pytest.approx(pressures, rel=1e-12)
    plan = solver.prepare(model, inputs=["p"], want=["T"], given={"T": None})
    assert psat(plan(355.0)[0]) == pytest.approx(355.0, rel=1e-12)


def test_the_command_asks_to_be_allowed(sheet: Path) -> None:
    command = [sys.executable, "-m", "solver", "solve", str(sheet), "--csv"]
    refused = subprocess.run(command, capture_output=True, text=True, check=False)
    assert refused.returncode == 2 and "--allow-python" in refused.stderr
    allowed = subprocess.run(
        [*command, "--allow-python"], capture_output=True, text=True, check=False
    )
    assert allowed.returncode == 0 and "354.53" in allowed.stdout


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("1/0", "ZeroDivisionError"),
        ("import rulesheets\nrulesheets.function('sin', abs)", "of the language"),
    ],
)
def test_a_file_that_fails_is_named(sheet: Path, text: str, said: str) -> None:
    (sheet.parent / "properties.py").write_text(text, encoding="utf-8")
    with pytest.raises(RuleSheetError) as caught:
        rulesheets.load(sheet, allow_python=True)
    (diagnosis,) = caught.value.diagnoses
    assert diagnosis.code == "E314" and diagnosis.labels and said in " ".join(diagnosis.notes)


def test_a_file_outside_the_folder_does_not_run(sheet: Path) -> None:
    text = SHEET.replace("properties.py", "../properties.py")
    with pytest.raises(RuleSheetError) as caught:
        rulesheets.loads(text, base=sheet.parent, within=sheet.parent, allow_python=True)
    assert caught.value.diagnoses[0].code == "E311"


def test_use_python_is_formatted() -> None:
    assert 'use python "properties.py"' in format_sheet(parse(Source("sheet", SHEET)))


def answers(text: str, name: str) -> list[float]:
    result = solver.solve(rulesheets.loads(text))
    assert str(result.status) == "solved" and not result.complete
    return sorted(float(solution[name]) for solution in result.solutions)


def test_inverses_are_every_answer_but_never_known_to_be() -> None:
    rulesheets.function("twice", lambda x: x * x, inverse=(math.sqrt, lambda t: -math.sqrt(t)))
    assert answers("twice(x) = 4", "x") == [-2.0, 2.0]
    refused = solver.solve(rulesheets.loads("twice(x) = -4"))
    assert str(refused.status) == "failed"  # its author alone says that there is none


def test_a_rough_inverse_is_polished_and_a_wrong_one_refused() -> None:
    rulesheets.function("rough", math.exp, inverse=lambda t: math.log(t) + 1e-7)
    assert answers("rough(x) = 2", "x") == pytest.approx([math.log(2.0)], rel=1e-15)
    rulesheets.function("rough", math.exp, inverse=lambda t: math.nan)
    assert str(solver.solve(rulesheets.loads("rough(x) = 2")).status) == "failed"


def test_several_arguments_in_a_block() -> None:
    rulesheets.function("length", math.hypot, array=np.hypot)
    with pytest.raises(ValueError, match="one parameter"):
        rulesheets.function("length2", lambda x, y: math.hypot(x, y), inverse=abs)
    rulesheets.function("length", lambda x, y: math.hypot(x, y), array=np.hypot)
    assert answers("x + y = 7\nlength(x, y) = 5", "x") == pytest.approx([3.0, 4.0])


def test_sensitivities_are_those_of_the_slope() -> None:
    rulesheets.function("cube", lambda x: x**3)
    result = solver.solve(rulesheets.loads("variables\n  y = 8\nrules\n  y = cube(x)"))
    assert result["x"] == pytest.approx(2.0)
    assert result.sensitivity()["x", "y"] == pytest.approx(1.0 / 12.0, rel=1e-9)


@pytest.mark.parametrize(
    ("value", "x", "slope"),
    [
        (math.exp, 1.0, math.e),
        (math.sin, 0.0, 1.0),
        (math.log, 1e-3, 1e3),
        (lambda x: x**3, 1e6, 3e12),
    ],
)
def test_slopes_by_differences_know_their_error(
    value: Callable[[float], float], x: float, slope: float
) -> None:
    found, error = slope_by_differences(value, 0, (x,))
    assert abs(found - slope) <= error < 1e-5 * abs(slope)


def test_slopes_at_the_end_of_a_domain_are_one_sided() -> None:
    found, error = slope_by_differences(lambda x: math.exp(x + 0.0 * math.sqrt(x)), 0, (0.0,))
    assert found == pytest.approx(1.0, abs=error) and error < 1e-5


def test_a_function_that_breaks_says_where() -> None:
    rulesheets.function("broken", lambda x: {}[x])
    with pytest.raises(RuleSheetError) as caught:
        solver.solve(rulesheets.loads("y = broken(x)\nx = 2"))
    (diagnosis,) = caught.value.diagnoses
    assert diagnosis.code == "E315" and "KeyError" in diagnosis.notes[0]


@pytest.mark.parametrize("name", ["sin", "sum", "a b", "2x"])
def test_names_that_are_refused(name: str) -> None:
    with pytest.raises(ValueError, match="function"):
        rulesheets.function(name, abs)


def test_its_units_are_its_own() -> None:
    """A sum with its result still has one unit."""
    rulesheets.function("psat", psat)
    text = "variables\n  T = 80 [degC]\n  p [kPa]\n  q [Pa]\nrules\n  p = psat(T)\n"
    assert rulesheets.loads(text).unit_warnings == ()
    assert rulesheets.loads(f"{text}  q = 2*psat(T)\n").unit_warnings == ()
    (warning,) = rulesheets.loads(f"{text}  q = psat(T) + p\n").unit_warnings
    assert "a factor of 1000 is missing" in warning.message
