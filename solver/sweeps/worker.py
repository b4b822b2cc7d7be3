"""The other end of ``workers``: a process that solves pieces of one sweep until its input ends.

Work and pieces come on standard input, solved pieces or exceptions go to what was standard output,
all of them pickled. What anything prints goes to standard error.
"""

from __future__ import annotations

import os
import pickle
import sys

from solver.interruption import Interrupted
from solver.sweeps.interrupts import Interrupts
from solver.sweeps.work import Solver, unpacked


def serve() -> None:
    """Solve pieces until there are no more. An interrupt ends the piece at hand: what there is of it is sent
    as a tuple."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    questions = sys.stdin.buffer
    with Interrupts() as interrupts:
        solve = Solver(unpacked(pickle.load(questions)))
        while True:
            try:
                columns = pickle.load(questions)
            except EOFError:
                return
            try:
                with interrupts.open():
                    answer: object = solve(columns)
            except Interrupted as reached:
                answer = reached.kept
            except KeyboardInterrupt:
                answer = ()
            except Exception as failure:
                answer = failure
            pickle.dump(answer, answers, protocol=5)
            answers.flush()
