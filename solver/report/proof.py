"""What was proved of a result, where a proof was asked for."""

from __future__ import annotations

from collections.abc import Iterator

from rulesheets.spelling import plural
from solver.proof import Beside, Proof
from solver.result import Result, Status


def proof_lines(result: Result) -> Iterator[str]:
    """Whether each answer is proved, how far the numbers may be off at most, and whether these are all."""
    proofs = [solution.proof for solution in result.solutions if solution.proof is not None]
    if proofs and result.status is Status.SINGULAR:
        yield from _singular(proofs)
    if not proofs or result.status is not Status.SOLVED:
        return
    proved = [proof for proof in proofs if proof.proved]
    if len(proved) < len(proofs):
        yield f"not proved: {next(p.obstacle for p in proofs if not p.proved)}"
    if proved:
        worst = max(max(proof.radius.values(), default=0.0) for proof in proved)
        nearest = "every number the float nearest to the exact one" if all(p.nearest for p in proved) else ""
        radius = nearest or f"every number within {worst:.0e}"
        yield f"proved: {plural(len(proved), 'answer')}, {radius}"
    if result.complete and len(proved) == len(proofs):
        yield "proved: there is no other answer" if len(proofs) == 1 else "proved: there are no others"


def _singular(proofs: list[Proof]) -> Iterator[str]:
    """Whether a double root is exactly there, or a hair decides: which way, where that is proved."""
    for proof in proofs:
        if proof.double:
            names = ", ".join(proof.double)
            yield f"proved: the rules of {names} hold exactly, with a singular Jacobian: a double root"
        elif proof.beside is not None:
            yield f"proved: for the numbers exactly as they are {_beside(proof.beside)}"
    if not any(proof.double or proof.beside for proof in proofs):
        yield "not proved: a hair decides whether there are two answers, one or none"


def _beside(found: Beside) -> str:
    """What is next to a double root that is not there."""
    if not found.roots:
        return f"there is no answer here for {', '.join(found.unknowns)}, by a hair"
    far = ", ".join(f"{name} {distance:.2g}" for name, distance in found.apart.items() if distance)
    return f"there are two answers, this far apart: {far}"
