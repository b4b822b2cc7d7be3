"""What a message says to give, beside the numeric rank of random rules of the same structure."""

import random
import re
import time
from itertools import combinations

import numpy as np
import pytest

import rulesheets
import solver

NAMES = "abcdefghuv"


def random_rules(draw: random.Random) -> list[tuple[str, ...]]:
    count = draw.randint(2, 6)
    return [
        tuple(sorted(draw.sample(NAMES[: count + 3], draw.randint(2, 3)))) for _ in range(count)
    ]


def undetermined(matrix: np.ndarray, given: tuple[int, ...]) -> set[int]:
    """The unknowns that can still vary with some given: those where the null space is not 0."""
    fixed = np.zeros((len(given), matrix.shape[1]))
    fixed[range(len(given)), given] = 1.0
    _, sizes, rows = np.linalg.svd(np.vstack([matrix, fixed]))
    null = rows[int((sizes > 1e-9).sum()) :]
    return {u for u in range(matrix.shape[1]) if np.abs(null[:, u]).max(initial=0.0) > 1e-9}


def smallest(matrix: np.ndarray, missing: set[int], useful: list[int]) -> set[tuple[int, ...]]:
    for size in range(1, 5):
        sets = {
            s for s in combinations(useful, size) if undetermined(matrix, s).isdisjoint(missing)
        }
        if sets:
            return sets
    return set()


def advised(note: str) -> set[tuple[str, ...]]:
    single = " and " not in note
    sets = re.split(", or | or |, " if single else ", or ", note.removeprefix("give "))
    return {tuple(sorted(re.split(", | and ", one))) for one in sets}


@pytest.mark.parametrize("seed", range(40))
def test_the_smallest_sets_of_missing_inputs(seed: int) -> None:
    draw = random.Random(seed)
    rules = random_rules(draw)
    names = sorted({name for rule in rules for name in rule})
    matrix = np.zeros((len(rules), len(names)))
    for row, rule in zip(matrix, rules, strict=True):
        row[[names.index(name) for name in rule]] = [draw.uniform(0.5, 2.0) for _ in rule]
    if np.linalg.matrix_rank(matrix) < len(rules) or len(rules) >= len(names):
        return
    text = "\n".join(f"{rule[0]} = exp({'*'.join(rule[1:])})" for rule in rules)
    want = None if seed % 2 else [draw.choice(names)]
    result = solver.solve(rulesheets.loads(text), want=want)
    missing = undetermined(matrix, ()) & {names.index(name) for name in want or names}
    if not missing:
        return
    assert set(result.undetermined) == {names[u] for u in missing}
    useful = [u for u, name in enumerate(names) if name not in (want or ())]
    sets = {tuple(names[u] for u in one) for one in smallest(matrix, missing, useful)}
    sets -= {tuple(sorted(result.undetermined))}
    (note,) = next(d for d in result.diagnoses if d.code == "S510").notes
    if not sets:
        assert note.startswith(("more than one", "no other"))
    else:
        assert len(advised(note)) == min(len(sets), 8) and advised(note) <= sets


def test_alternatives_count_as_one_rule() -> None:
    rates = (
        "if income < 1000 then tax = 0.1*income",
        "if income >= 1000 then tax = 0.2*income - 100",
    )
    result = solver.solve(
        rulesheets.loads("\n".join((*rates, "net = income - tax"))), want=["income"]
    )
    assert result.diagnoses[0].notes == ("give tax or net",)


def test_what_guards_read_does_not_follow_from_their_rules() -> None:
    pick = "if kind = 'long then y = x*k else y = x\nz = y + k"
    result = solver.solve(rulesheets.loads(pick), {"x": 1.0, "k": 2.0})
    assert result.diagnoses[0].notes == ("give kind",)


def test_no_other_variable_helps() -> None:
    result = solver.solve(rulesheets.loads("variables\n  t\nrules\n  a = 2*b"), want=["t"])
    assert result.diagnoses[0].notes[0].startswith("no other variable determines t")


def test_a_missing_input_of_thousands_of_rules_is_told_at_once() -> None:
    text = "\n".join(f"x{i + 1} = 0.7*x{i} + {i % 7}" for i in range(4_000))
    model = rulesheets.loads(text)
    started = time.process_time()
    (diagnosis,) = solver.solve(model).diagnoses
    assert time.process_time() - started < 5.0
    assert diagnosis.notes[0].startswith("give ") and diagnosis.notes[0].endswith(
        " or one of 3993 more"
    )


@pytest.mark.parametrize("last_places", range(-8, 9, 4))
def test_a_value_of_a_plateau_up_to_rounding_leaves_its_unknown_free(last_places: int) -> None:
    """The income of which nothing more is insured, asked by what the insurance leaves."""
    text = "ss = 0.0765*min(5200, cap)\ntaxable = max(0, 5200 - 1100 - ss)"
    taxable = 3702.2 + last_places * 2.0**-41
    result = solver.solve(rulesheets.loads(text), {"taxable": taxable})
    assert result.undetermined == ("cap",)
    assert "cap can take any value above 5200" in result.diagnoses[0].message


def test_a_stretch_up_to_a_jump_is_no_double_root() -> None:
    """The hours of a car park, charged by every hour that has begun."""
    text = "started = int(hours) + step(hours - int(hours), 1e-9)"
    result = solver.solve(rulesheets.loads(text), {"started": 4})
    assert "hours can take any value between 3 and 4" in result.diagnoses[0].message
