"""The shipped models: their published answers, and every well-posed swap of inputs and outputs."""

from __future__ import annotations

import random
from functools import cache, partial
from pathlib import Path
from typing import Any

import mpmath
import pytest

import rulesheets
import solver
from docs import generate
from tests.oracles import library
from tests.oracles.library import REFERENCES, Reference, Swap

ROOT = Path(__file__).parent.parent
MODELS = ROOT / "models"
NAMES = sorted(path.parent.name for path in MODELS.glob("*/model.tk"))
SWAPS_TRIED = 12
"""At most so many of each model's swaps, drawn evenly; the small models are tried in full."""


@cache
def model(name: str) -> Any:
    return rulesheets.load(MODELS / name / "model.tk")


def solve_from(name: str, state: dict[str, Any], inputs: tuple[str, ...]) -> Any:
    """Solve the sheet with these inputs of the state and no others."""
    cleared = {
        key: None for key, variable in model(name).variables.items() if variable.value is not None
    }
    return solver.solve(model(name), {**cleared, **{key: float(state[key]) for key in inputs}})


def matches(solution: Any, state: dict[str, Any], rel: float) -> bool:
    return all(
        key in solution and solution[key] == pytest.approx(float(state[key]), rel=rel)
        for key in state
    )


def well_posed_swaps(reference: Reference) -> list[Swap]:
    """All of them, or an even draw of those that there are too many of."""
    found = [swap for swap in library.swaps(reference) if swap.well_posed]
    return random.Random(reference.model).sample(found, min(SWAPS_TRIED, len(found)))


SWAPS = [(reference, swap) for reference in REFERENCES for swap in well_posed_swaps(reference)]


@pytest.mark.parametrize("name", NAMES)
def test_every_model_states_its_source_and_answers(name: str) -> None:
    page = (MODELS / name / "README.md").read_text(encoding="utf-8")
    assert "nswer" in page


@pytest.mark.parametrize("name", NAMES)
def test_shipped_inputs_solve(name: str) -> None:
    result = solver.solve(model(name))
    assert str(result.status) == "solved", result.diagnoses


@pytest.mark.parametrize("row", generate.published(), ids=lambda row: f"{row.model}-{row.quantity}")
def test_published_answers(row: generate.Row) -> None:
    assert row.agrees, row.answers()


@pytest.mark.parametrize("name", generate.PAGES)
def test_a_generated_page_is_up_to_date(name: str) -> None:
    """``python docs/generate.py`` writes it."""
    assert (ROOT / name).read_text(encoding="utf-8") == generate.text(name)


@pytest.mark.parametrize("reference", REFERENCES, ids=lambda reference: reference.model)
def test_forward(reference: Reference) -> None:
    state = reference.exact
    result = solve_from(reference.model, state, tuple(reference.parameters))
    assert str(result.status) == "solved"
    assert any(matches(solution, state, 1e-12) for solution in result.solutions)


@pytest.mark.parametrize(
    ("reference", "swap"), SWAPS, ids=[f"{r.model}-{'-'.join(s.inputs)}" for r, s in SWAPS]
)
def test_swap(reference: Reference, swap: Swap) -> None:
    """Outputs given back as inputs lead to the state that they came from."""
    state = reference.exact
    result = solve_from(reference.model, state, swap.inputs)
    assert str(result.status) == "solved"
    assert any(
        matches(solution, state, 1e-14 / swap.determinant + 1e-11) for solution in result.solutions
    )


@pytest.mark.parametrize("reference", REFERENCES, ids=lambda reference: reference.model)
def test_singular_choices_are_never_solved(reference: Reference) -> None:
    """As many inputs as it takes, of which one says what the others say already."""
    state = reference.exact
    singular = [swap for swap in library.swaps(reference) if swap.singular]
    for swap in random.Random(1).sample(singular, min(6, len(singular))):
        result = solve_from(reference.model, state, swap.inputs)
        assert str(result.status) != "solved", swap


@pytest.mark.slow
@pytest.mark.parametrize("reference", REFERENCES, ids=lambda reference: reference.model)
def test_no_singular_choice_is_solved_or_called_impossible(reference: Reference) -> None:
    """All, at most a thousand, at the reference and at a random state."""
    draw = random.Random(reference.model)
    for at in (reference, library.elsewhere(reference, draw)):
        singular = [swap for swap in library.swaps(at) if swap.singular]
        for swap in draw.sample(singular, min(1000, len(singular))):
            result = solve_from(at.model, at.exact, swap.inputs)
            assert str(result.status) in {"partial", "singular"}, (dict(at.parameters), swap)
            assert result.undetermined, (dict(at.parameters), swap)
            assert any(diagnosis.variables for diagnosis in result.diagnoses), (
                dict(at.parameters),
                swap,
            )


def test_curve_of_cones_that_have_the_same_mantles_is_named() -> None:
    """Mantles of a frustum and both its cones: one follows from the others, and a curve of cones
    has them."""
    reference = next(r for r in REFERENCES if r.model == "cone_frustum")
    result = solve_from("cone_frustum", reference.exact, ("AC1", "AC2", "AC"))
    assert str(result.status) in {"partial", "singular"}
    assert {"th", "h", "r1", "r2", "V"} <= set(result.undetermined)
    assert any("th" in diagnosis.variables for diagnosis in result.diagnoses)


@pytest.mark.parametrize("seed", range(4))
def test_flash_whose_vapour_drops_out_to_rounding(seed: int) -> None:
    """At random states, twelve choices each: 1 minus the sum of x is rounding, whatever x is
    computed."""
    draw = random.Random(seed)
    reference = library.elsewhere(next(r for r in REFERENCES if r.model == "rachford_rice"), draw)
    pairs = [("K1", "x1", "y1"), ("K2", "x2", "y2"), ("K3", "x3", "y3"), ("K4", "x4", "y4")]
    for _ in range(12):
        alone = draw.randrange(4)
        inputs = tuple(
            n for i, pair in enumerate(pairs) for n in draw.sample(pair, 1 if i == alone else 2)
        )
        result = solve_from(reference.model, reference.exact, inputs)
        assert str(result.status) in {"partial", "singular"}, (dict(reference.parameters), inputs)
        assert "V" in result.undetermined


def test_unknown_that_drops_out_to_rounding_is_never_solved() -> None:
    """Liquid and vapour both add up to 1 here, so that the balances hold for every V."""
    reference = next(r for r in REFERENCES if r.model == "rachford_rice")
    result = solve_from(
        "rachford_rice", reference.exact, ("K1", "x1", "K2", "y2", "y3", "K4", "y4")
    )
    assert str(result.status) in {"partial", "singular"}


# --- what is particular to a model ---------------------------------------------------


def test_published_reverse_answers_of_the_loan() -> None:
    payment = solver.solve(model("loan"), {"payment": None, "rate": 0.1 / 12})
    assert payment["payment"] == pytest.approx(387.206246, abs=5e-7)
    term = solver.solve(model("loan"), {"term": None, "rate": 0.1 / 12})
    assert term["term"] == pytest.approx(40.5446718, abs=5e-8)


def _overpaid(price: float, payment: float, term: int, rate: Any) -> Any:
    return payment * (1 - (1 + rate) ** -term) - price * rate


def test_rate_of_a_loan_is_one_simple_answer() -> None:
    """At random loans: none next to 0, where rounding alone makes payment and price agree, and none
    twice."""
    draw = random.Random(3)
    for _ in range(12):
        price, term = draw.uniform(1e3, 1e6), draw.choice([12, 36, 240, 360])
        with mpmath.workdps(40):
            rate = mpmath.mpf(10) ** draw.uniform(-4, -1)
            payment = float(price * rate / (1 - (1 + rate) ** -term))
            exact = mpmath.findroot(partial(_overpaid, price, payment, term), rate)
        inputs = {
            "price": price,
            "downpay": 0.0,
            "payment": payment,
            "term": float(term),
            "rate": None,
        }
        result = solver.solve(model("loan"), inputs)
        assert str(result.status) == "solved", inputs
        assert [solution["rate"] for solution in result.solutions] == pytest.approx(
            [float(exact)], rel=1e-12
        )


def test_frustum_turned_inside_out_is_excluded_by_its_range() -> None:
    volume = float(library.cone_frustum(*(mpmath.mpf(x) for x in (1.4673846836, 2.4, 50.0)))["V"])
    result = solver.solve(model("cone_frustum"), {"r2": None, "V": volume})
    assert [solution["r2"] for solution in result.solutions] == pytest.approx([2.4], rel=1e-9)


def test_two_points_of_two_circles() -> None:
    points = sorted(
        (solution["x"], solution["y"]) for solution in solver.solve(model("two_circles")).solutions
    )
    half = mpmath.sqrt(mpmath.mpf("0.54"))
    exact = [(4.2 - half, 1.4 + 3 * half), (4.2 + half, 1.4 - 3 * half)]
    assert points == [pytest.approx([float(x), float(y)], rel=1e-14) for x, y in exact]


@pytest.mark.parametrize("r2", [0.5, 12.0])
def test_circles_that_do_not_meet(r2: float) -> None:
    assert str(solver.solve(model("two_circles"), {"r2": r2}).status) == "infeasible"


def test_two_elevations_of_the_projectile() -> None:
    elevations = sorted(
        solution["theta"] for solution in solver.solve(model("projectile")).solutions
    )
    with mpmath.workdps(30):
        low = mpmath.asin(mpmath.mpf(9.8) * 560 / 82**2) * 90 / mpmath.pi
    assert elevations == pytest.approx([float(low), float(90 - low)], rel=1e-13)


def test_target_beyond_the_greatest_range() -> None:
    assert str(solver.solve(model("projectile"), {"R": 700.0}).status) == "infeasible"


@pytest.mark.parametrize(
    ("P", "T", "count"), [(100.0, 500.0, 1), (45.0, 280.0, 3), (50.0, 280.0, 3)]
)
def test_volumes_of_the_gas(P: float, T: float, count: int) -> None:
    exact = library.van_der_waals_volumes(P, T, 3.592, 0.04267, 0.0820573661)
    assert len(exact) == count
    result = solver.solve(model("van_der_waals"), {"P": P, "T": T})
    volumes = sorted(solution["Vm"] for solution in result.solutions)
    assert volumes == pytest.approx([float(volume) for volume in exact], rel=1e-12)


def test_only_real_root_of_the_cubic() -> None:
    result = solver.solve(model("ees_cubic"))
    assert [solution["x"] for solution in result.solutions] == pytest.approx(
        [float(root) for root in library.cubic_roots()], rel=1e-14
    )


def test_side_side_angle_can_have_two_triangles() -> None:
    given = {"a": 6.0, "b": 8.0, "A": 40.0, "c": None}
    result = solver.solve(model("triangle"), given)
    with mpmath.workdps(30):
        B = mpmath.asin(8 * mpmath.sinpi(mpmath.mpf(40) / 180) / 6) * 180 / mpmath.pi
    angles = sorted(solution["B"] for solution in result.solutions)
    assert angles == pytest.approx([float(B), float(180 - B)], rel=1e-12)


def test_triangle_inequality() -> None:
    assert (
        str(solver.solve(model("triangle"), {"a": 1.0, "b": 2.0, "c": 4.0}).status) == "infeasible"
    )


def test_three_angles_leave_the_size_free() -> None:
    given = {"a": None, "b": None, "c": None, "A": 50.0, "B": 60.0, "C": 70.0}
    result = solver.solve(model("triangle"), given)
    assert str(result.status) in {"partial", "singular"}
    assert set(result.undetermined) == {"a", "b", "c"}


BRACKET_TAXES = {
    11000: 1100,
    44725: 5147,
    95375: 16290,
    182100: 37104,
    231250: 52832,
    578125: 174238.25,
}


@pytest.mark.parametrize(("income", "tax"), BRACKET_TAXES.items())
def test_published_taxes_both_ways(income: float, tax: float) -> None:
    assert solver.solve(model("tax_brackets"), {"income": income})["tax"] == pytest.approx(
        tax, rel=1e-14
    )
    back = solver.solve(model("tax_brackets"), {"income": None, "tax": tax + 0.01})
    assert len(back.solutions) == 1
    assert income < back["income"] < income + 0.1


def test_marginal_rate_alone_determines_no_income() -> None:
    result = solver.solve(model("tax_brackets"), {"income": None, "rate": 22.0})
    assert str(result.status) == "partial"
    assert "income" in result.undetermined


@pytest.mark.parametrize(("e", "M"), [(0.1, 5.0), (0.99, 2.0), (0.5, -170.0), (0.999, 0.001)])
def test_kepler_has_one_root(e: float, M: float) -> None:
    result = solver.solve(model("kepler"), {"e": e, "M": M})
    assert len(result.solutions) == 1
    with mpmath.workdps(30):
        residual = (
            result["E"]
            - mpmath.mpf(e) * mpmath.sinpi(mpmath.mpf(result["E"]) / 180) * 180 / mpmath.pi
        )
    assert float(residual) == pytest.approx(M, rel=1e-11)


def test_ohm_with_the_voltage_alone_names_what_is_missing() -> None:
    result = solver.solve(model("ohms_law"), {"R": None})
    assert str(result.status) in {"partial", "singular"}
    assert set(result.undetermined) == {"R", "I", "P"}
