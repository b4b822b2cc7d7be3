"""Active rules linearized: against closed forms, with redundant, singular and guarded rules."""

import math

import pytest

import rulesheets
import solver
from solver.derivatives.linearization import active_equations, linearize
from solver.numerics.elimination import independent_rows


def linearized(text: str, values: dict, inputs: set[str], **more):
    return linearize(rulesheets.loads(text), values, inputs, **more)


def test_rows_are_the_slopes_of_left_minus_right() -> None:
    found = linearized("y = x^2*z", {"x": 3.0, "z": 2.0, "y": 18.0}, {"x", "z"})
    assert found.rows[0] == {"y": 1.0, "x": -12.0, "z": -9.0}
    assert found.unknowns == ("y",)


def test_blocks_come_in_the_order_in_which_they_need_one_another() -> None:
    found = linearized(
        "c = a*b\na + b = s\na - b = d",
        {"s": 5.0, "d": 1.0, "a": 3.0, "b": 2.0, "c": 6.0},
        {"s", "d"},
    )
    assert [set(block.unknowns) for block in found.blocks] == [{"a", "b"}, {"c"}]
    assert [set(block.equations) for block in found.blocks] == [{1, 2}, {0}]


def test_redundant_rules_are_left_over_and_preferred_ones_taken() -> None:
    text, values = "x + y = 26\n2*x + 2*y = 52\nx = 4", {"x": 4.0, "y": 22.0}
    assert linearized(text, values, set()).redundant == (1,)
    assert linearized(text, values, set(), prefer=(1,)).redundant == (0,)


def test_rows_that_the_pattern_takes_for_independent_give_way_to_one_that_is() -> None:
    text, values = "x + y = 3\n2*x + 2*y = 6\nx - y = d", {"x": 2.0, "y": 1.0, "d": 1.0}
    found = linearized(text, values, {"d"})
    assert 2 in found.equations
    assert len(found.redundant) == 1
    assert found.free == ()


def test_a_double_root_leaves_its_unknown_free_and_the_rest_is_kept() -> None:
    found = linearized("x^2 = a\ny = 3*b", {"x": 0.0, "a": 0.0, "y": 6.0, "b": 2.0}, {"a", "b"})
    assert found.free == ("x",)
    assert found.unknowns == ("y",)


def test_a_singular_block_frees_what_moves_and_keeps_what_does_not() -> None:
    text = "x + y + z = 3\n2*x + 2*y + z = 5\n3*x + 3*y + 2*z = 8"
    found = linearized(text, {"x": 1.0, "y": 1.0, "z": 1.0}, set())
    assert set(found.free) == {"x", "y"}
    assert {"x", "y"} - {*found.unknowns} in ({"x"}, {"y"})  # one of them is held
    assert "z" in found.unknowns


def test_a_rule_without_a_slope_is_rough() -> None:
    assert linearized("y = sqrt(x)", {"x": 0.0, "y": 0.0}, {"x"}).rough == (0,)


def test_only_active_rules_of_numbers_take_part() -> None:
    model = rulesheets.loads("if b = 'up then y = x else y = -x\nb = 'up")
    values = {"b": "up", "x": 2.0, "y": 2.0}
    assert [e.index for e in active_equations(model, values, {"x"})] == [0]


@pytest.mark.parametrize("theta", [-30.0, 17.0, 100.0, 200.0, 300.0])
def test_the_slider_crank_has_a_rule_for_every_unknown(theta: float) -> None:
    model = rulesheets.load("offset_slider_crank")
    answer = solver.solve(model, {"thetaAO": theta}).solutions[0]
    given = {"thetaAO", "AO", "AB", "offset", "omegaAO", "alphaAO", "branch"}
    found = linearize(model, answer, given)
    numbers = {name for name, value in answer.items() if isinstance(value, float)}
    assert set(found.unknowns) == numbers - given
    assert found.free == found.redundant == found.rough == ()


def test_independent_rows_do_not_depend_on_units() -> None:
    rows = [[1.0, 1e9], [1e-9, 1.0], [1.0, -1e9]]
    for scale in ([1.0, 1e-9], [1e6, 1e-3]):
        found = independent_rows(rows, scale)
        assert len(found.rows) == 2
        assert 2 in found.rows
        assert found.free == ()


def test_the_columns_of_a_null_vector_are_free() -> None:
    assert independent_rows([[1.0, 1.0, 0.0], [0.0, 0.0, math.pi]], [1.0, 1.0, 1.0]).free == (0, 1)
