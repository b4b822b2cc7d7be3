"""What each last resort of the chain of methods brings, on hard random blocks.

    python benchmarks/last_resorts.py [--unknowns 24] [--blocks 60] [--seed 0]

draws blocks (``hard_blocks.py``) and searches each by the chain up to damped Newton from hundreds of starts.
On those that it leaves without an answer every last resort is tried alone, from the guess and from many
starts, and counted: what it finds, and what nothing else finds. Every answer has passed the witness.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent))

import rulesheets
from benchmarks.hard_blocks import hard_block
from solver.attempts import Method
from solver.kernel.candidates import Candidates
from solver.kernel.code.block import BlockKernel
from solver.kernel.methods import last_resorts
from solver.kernel.question import Question
from solver.kernel.search.fallback import fall_back
from solver.kernel.solve_block import solve_block
from solver.path.planner import planner
from solver.path.steps import SolveBlock


def kernels(unknowns: int, seed: int) -> tuple[list[BlockKernel], dict[str, float]]:
    """The simultaneous blocks of a hard sheet, and its guesses."""
    block = hard_block(unknowns, seed)
    model = rulesheets.loads(block.sheet)
    path = planner(model).path(frozenset(), {})
    graph = planner(model).graph
    return [BlockKernel(graph, step) for step in path.steps if isinstance(step, SolveBlock)], block.guesses


def resorts(kernel: BlockKernel, guesses: dict[str, float]) -> dict[Method, tuple[bool, float]]:
    """Whether each last resort finds an answer alone, and its processor time."""
    found = {}
    for method in last_resorts(kernel):
        candidates = Candidates(Question(kernel, {}, guesses))
        began = time.process_time()
        fall_back(candidates.question, candidates, [method])
        found[method] = bool(candidates.answers), time.process_time() - began
    return found


def measure(unknowns: int, seeds: range) -> tuple[int, list[dict[Method, tuple[bool, float]]]]:
    """How many blocks the chain before the last resorts answers, and the last resorts on the others."""
    answered, left = 0, []
    for seed in seeds:
        several, guesses = kernels(unknowns, seed)
        if len(several) != 1 or several[0].known:
            continue
        (kernel,) = several
        if solve_block(kernel, {}, guesses, assumed=True).answers:
            answered += 1
        else:
            left.append(resorts(kernel, guesses))
    return answered, left


def table(left: list[dict[Method, tuple[bool, float]]]) -> str:
    lines = [f"{'last resort, alone':<56}{'finds':>7}{'only it':>9}{'median ms':>11}"]
    for method in left[0]:
        hits = [found for found in left if found[method][0]]
        alone = sum(sum(hit for hit, _ in found.values()) == 1 for found in hits)
        milliseconds = 1e3 * statistics.median(found[method][1] for found in left)
        lines.append(f"{method.told:<56}{len(hits):>7}{alone:>9}{milliseconds:>11.0f}")
    return "\n".join(lines)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--unknowns", type=int, default=24)
    parser.add_argument("--blocks", type=int, default=60)
    parser.add_argument("--seed", type=int, default=0)
    arguments = parser.parse_args()
    seeds = range(arguments.seed, arguments.seed + arguments.blocks)
    answered, left = measure(arguments.unknowns, seeds)
    some = sum(any(hit for hit, _ in found.values()) for found in left)
    print(f"blocks of {arguments.unknowns} unknowns: {answered + len(left)}")
    print(f"answered by damped Newton from the guess and many starts: {answered}")
    print(f"answered by a last resort: {some} of the other {len(left)}")
    if left:
        print(table(left))


if __name__ == "__main__":
    main()
