"""Classic systems of interval analysis, every root proved and the list proved complete: counts and times.

python -m benchmarks.proof
"""

from __future__ import annotations

from time import perf_counter

import rulesheets
import solver
from benchmarks.interval_systems import SYSTEMS


def main() -> None:
    print(f"{'system':22}{'unknowns':>9}{'known':>7}{'proved':>8}  {'all':5}{'seconds':>8}")
    for system in SYSTEMS:
        model = rulesheets.loads(system.sheet)
        start = perf_counter()
        result = solver.solve(model, prove=True)
        seconds = perf_counter() - start
        proved = sum(solution.proof is not None and solution.proof.proved for solution in result.solutions)
        whole = "yes" if result.complete else "no"
        print(f"{system.name:22}{len(system.names):9}{system.roots:7}{proved:8}  {whole:5}{seconds:8.2f}")


if __name__ == "__main__":
    main()
