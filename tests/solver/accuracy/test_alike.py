"""Rules of one shape at once: what the check of single rules finds, slope for slope."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

import rulesheets
from rulesheets.evaluate import Undefined
from solver.accuracy.alike import FEWEST, accepted, evaluated
from solver.accuracy.rule_check import check_rule
from solver.accuracy.rule_sides import gross, sides, size
from solver.numerics.tolerances import BACKWARD
from solver.path.shapes import shapes

COUNT = 40
SHAPES: list[tuple[str, Callable[[int], float]]] = [
    ("y{k} = {k}*x{k}^2 + {k}", lambda k: k * x(k) ** 2 + k),
    ("y{k} - sqrt(x{k})*{k}.5 = 0", lambda k: math.sqrt(x(k)) * (k + 0.5)),
    (
        "sind(y{k}) = x{k}/200 - 0.{k}",
        lambda k: math.degrees(math.asin(x(k) / 200 - float(f"0.{k}"))),
    ),
    ("0 = exp(-y{k}) - x{k}", lambda k: -math.log(x(k))),
    ("x{k}*abs(x{k}) = y{k}^3", lambda k: (x(k) * abs(x(k))) ** (1 / 3)),
    ("x{k}^y{k} = {k}.5/7", lambda k: math.log((k + 0.5) / 7) / math.log(x(k))),
    ("y{k} = max(x{k}, {k})", lambda k: max(x(k), k)),
    ("y{k} = int(x{k}) + 0.25", lambda k: int(x(k)) + 0.25),
    ("y{k} = x{k} - x{k}", lambda k: 0.0),
]


def x(k: int) -> float:
    return 0.3 + 1.7 * k


@pytest.mark.parametrize("shape,answer", SHAPES)
@pytest.mark.parametrize("off", [0.0, 1e-15, 1e-12, 0.5])
def test_rows_are_what_single_rules_are(
    shape: str, answer: Callable[[int], float], off: float
) -> None:
    model = rulesheets.loads("\n".join(shape.format(k=k) for k in range(1, COUNT + 1)) + "\n")
    values: dict[str, float | str] = {}
    for k in range(1, COUNT + 1):
        values[f"x{k}"], values[f"y{k}"] = x(k), answer(k) * (1 + off)
    found = evaluated(model, model.equations, values)
    assert [len(f.places) for f in shapes(model).of(model.equations).families] == [COUNT]
    told = [dict[str, float]() for _ in model.equations]
    for slope, row, column in zip(found.slopes, found.rows, found.columns, strict=True):
        told[row][found.names[column]] = slope
    for place, equation in enumerate(model.equations):
        left, right, slopes, noise = sides(equation, values)
        assert found.miss[place] == left - right
        assert found.noise[place] == pytest.approx(noise, rel=1e-12)
        assert found.gross[place] == pytest.approx(gross(equation, values), rel=1e-12)
        assert found.moves[place] == pytest.approx(size(equation, values), rel=1e-12)
        assert told[place] == pytest.approx(slopes, rel=1e-12)
        assert check_rule(equation, values).holds or not found.holds[place]
    plain = not any(word in shape for word in ("max", "int", "x{k} - x{k}"))
    assert found.holds.all() == (off <= 1e-15) if plain else not found.holds.any()


LOSSY: list[tuple[str, Callable[[int], float]]] = [
    ("y{k} = (x{k} + {k}e3) - {k}e3", x),
    ("y{k} = sqrt((x{k} + 1e4)^2) - 1e4", x),
    ("y{k} = (exp(x{k}/1e4) - 1)*1e4", lambda k: 1e4 * math.expm1(x(k) / 1e4)),
    ("y{k}*(1 - cos(x{k}/1e2)) = 1", lambda k: 0.5 / math.sin(x(k) / 200) ** 2),
]
"""Rules that lose two to five digits as floats evaluate them."""


@pytest.mark.parametrize("shape,answer", LOSSY)
@pytest.mark.parametrize("off", [0.0, 1e-15, 8e-15, 1e-13, 1e-9])
def test_what_long_floats_accept_holds_in_many_digits(
    shape: str, answer: Callable[[int], float], off: float
) -> None:
    model = rulesheets.loads("\n".join(shape.format(k=k) for k in range(1, COUNT + 1)) + "\n")
    values: dict[str, float | str] = {f"x{k}": x(k) for k in range(1, COUNT + 1)}
    values |= {f"y{k}": answer(k) * (1 + off) for k in range(1, COUNT + 1)}
    found = evaluated(model, model.equations, values)
    hold = [check_rule(equation, values).holds for equation in model.equations]
    assert all(hold[place] for place in np.flatnonzero(found.holds))
    in_floats = np.abs(found.miss) + found.noise <= BACKWARD * found.moves
    assert (found.holds & ~in_floats).any() == (off < 1e-14)


def test_what_does_not_hold_is_left_to_single_rules() -> None:
    model = rulesheets.loads("\n".join(f"y{k} = {k}*x{k}^2" for k in range(1, COUNT + 1)) + "\n")
    values = {name: 2.0 if name[0] == "x" else 4.0 * int(name[1:]) for name in model.variables}
    values["y7"] = 29.0
    worst, left = accepted(model, model.equations, values)
    assert worst == 0.0 and [equation.index + 1 for equation in left] == [7]
    assert check_rule(left[0], values).miss == 1.0


def test_parts_of_a_model_have_the_shapes_of_the_whole() -> None:
    rules = [f"y{k} = {k}*x{k}^2" for k in range(COUNT)] + [
        f"z{k} = y{k} + {k}*x{k}" for k in range(COUNT)
    ]
    model = rulesheets.loads("\n".join(rules) + "\n")
    chosen = [model.equations[place] for place in (3, 50, 41, 7, 9)]
    part = shapes(model).of(chosen)
    assert set(part.names) == {name for rule in chosen for name in rule.names}
    assert sorted(place for family in part.families for place in family.places) == [0, 1, 2, 3, 4]
    for family in part.families:
        for member, place in enumerate(family.places):
            names = tuple(part.names[column] for column in family.columns[:, member])
            assert names == chosen[place].names
            assert family.numbers[:, member].tolist()[0] == chosen[place].index % COUNT


@pytest.mark.parametrize("number", [1e-320, 0.0, math.inf, math.nan, 1e-250])
def test_out_of_the_ordinary_is_left_to_single_rules(number: float) -> None:
    model = rulesheets.loads("\n".join(f"y{k} = x{k}^2/3" for k in range(FEWEST + 1)) + "\n")
    values = dict.fromkeys(model.variables, 3.0)
    values["x3"], values["y3"] = number, number * number / 3
    found = evaluated(model, model.equations, values)
    assert found.holds.sum() == FEWEST and not found.holds[3]
    try:
        sides(model.equations[3], values)
    except Undefined:
        assert np.isnan(found.miss[3])


def test_a_symbol_is_no_number() -> None:
    model = rulesheets.loads("\n".join(f"y{k} = x{k}" for k in range(FEWEST + 1)) + "\n")
    values: dict[str, float | str] = dict.fromkeys(model.variables, 3.0)
    values["x3"] = values["y3"] = "nan"
    assert evaluated(model, model.equations, values).holds.sum() == FEWEST
