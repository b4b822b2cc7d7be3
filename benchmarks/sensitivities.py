"""Derivatives of every model at random states and other choices of inputs, against differences at
50 digits.

    python benchmarks/sensitivities.py [MODEL…] [--states 5]

draws the inputs of a shipped model anew (numbers within 15 %, angles within 40°), solves it, and
gives outputs back as inputs, one at a time. At each answer the derivatives by two inputs are
compared with central differences at 50 digits, for which no path, block or derivative of the solver
is used (``tests/oracles/differences.py``). It prints how many were compared, the worst relative
difference, how many were not told, and at how many answers the differences themselves did not
converge.
"""

from __future__ import annotations

import argparse
import random
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

import rulesheets
import solver
from benchmarks.pages import ROOT
from rulesheets.model import Model
from tests.oracles.differences import Differences

NAMES = sorted(path.parent.name for path in (ROOT / "models").glob("*/model.tk"))
SWAPS = 2
NOUGHT = 1e-18
"""What differences make of a derivative that is 0; smaller ones are not compared relatively."""


@dataclass(frozen=True)
class Comparison:
    """One derivative and its relative difference; None where it was not told."""

    output: str
    given: str
    difference: float | None


def states(name: str, count: int) -> Iterator[solver.Result]:
    """Solved states of a model: draws of the inputs that have one, and the same with outputs given
    back."""
    model = rulesheets.load(name)
    draw = random.Random(name)
    shipped = {n: v for n, v in solver.solve(model).inputs.items() if isinstance(v, float)}
    for _ in range(count):
        given = {n: _moved(model, n, v, draw) for n, v in shipped.items()}
        result = solver.solve(model, given)
        if result.status is not solver.Status.SOLVED:
            continue
        yield result
        values = dict(result.solutions[0])
        outputs = [
            n
            for n in model.variables
            if n not in result.inputs and isinstance(values.get(n), float)
        ]
        for _ in range(SWAPS if given and outputs else 0):
            taken, back = draw.choice(list(given)), draw.choice(outputs)
            swapped = solver.solve(
                model, {**given, taken: None, back: values[back]}, guesses={taken: given[taken]}
            )
            if swapped.status is solver.Status.SOLVED:
                yield swapped


def _moved(model: Model, name: str, value: float, draw: random.Random) -> float:
    angle = model.variables[name].unit == "deg"
    return value + draw.uniform(-40, 40) if angle else value * draw.uniform(0.85, 1.15)


def compared(result: solver.Result, draw: random.Random, most: int = 2) -> Iterator[Comparison]:
    """The derivatives of a random answer by ``most`` of its inputs. Raises AssertionError where the
    differences do not converge."""
    answer = draw.randrange(len(result.solutions))
    numbers = [n for n, v in result.inputs.items() if isinstance(v, float)]
    by = draw.sample(numbers, min(most, len(numbers)))
    found = result.sensitivity(inputs=by, answer=answer)
    oracle = Differences(result.model, result.solutions[answer], result.inputs)
    for given in by:
        right = oracle.by(given)
        for output in found.outputs:
            slope, exact = found[output, given], right.get(output, 0.0)
            difference = None if slope is None else abs(slope - exact) / max(abs(exact), NOUGHT)
            yield Comparison(output, given, difference)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("models", nargs="*", default=NAMES)
    parser.add_argument("--states", type=int, default=5)
    arguments = parser.parse_args()
    print(
        f"{'model':<32}{'states':>8}{'derivatives':>13}{'worst':>10}{'not told':>10}{'unchecked':>11}"
    )
    total, worst = 0, 0.0
    for name in arguments.models:
        draw, solved, unchecked = random.Random(name), list(states(name, arguments.states)), 0
        found: list[Comparison] = []
        for result in solved:
            try:
                found += compared(result, draw)
            except AssertionError:
                unchecked += 1
        told = [one.difference for one in found if one.difference is not None]
        total, worst = total + len(told), max([worst, *told])
        print(
            f"{name:<32}{len(solved):>8}{len(told):>13}{max(told, default=0.0):>10.1e}"
            f"{len(found) - len(told):>10}{unchecked:>11}",
            flush=True,
        )
    print(f"{total} derivatives, worst relative difference {worst:.1e}")


if __name__ == "__main__":
    main()
