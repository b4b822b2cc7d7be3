"""Classic systems of interval analysis, every root proved and the list proved complete: counts and
times.

    python -m benchmarks.proof [--hard] [NAME…]

``--hard`` adds larger ones. Times are of the processor.
"""

from __future__ import annotations

import argparse
from time import process_time

import rulesheets
import solver
from benchmarks.interval_systems import HARD, SYSTEMS


def main() -> None:
    parser = argparse.ArgumentParser(description="Proofs of every root of classic systems.")
    parser.add_argument("--hard", action="store_true", help="larger ones, too")
    parser.add_argument("names", nargs="*", metavar="NAME", help="those whose name contains it")
    arguments = parser.parse_args()
    systems = [*SYSTEMS, *(HARD if arguments.hard else ())]
    print(f"{'system':22}{'unknowns':>9}{'known':>7}{'proved':>8}  {'all':5}{'seconds':>8}")
    for system in systems:
        if arguments.names and not any(name in system.name for name in arguments.names):
            continue
        model = rulesheets.loads(system.sheet)
        start = process_time()
        result = solver.solve(model, prove=True)
        seconds = process_time() - start
        proved = sum(
            solution.proof is not None and solution.proof.proved for solution in result.solutions
        )
        whole = "yes" if result.complete else "no"
        print(
            f"{system.name:22}{len(system.names):9}{system.roots:7}{proved:8}  "
            f"{whole:5}{seconds:8.2f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
