"""One answer of a large block, the sensible one, by sparse Newton steps without tearing."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.model import Equation
from rulesheets.syntax.nodes import Expression, Name, Negative, Product, Quotient, Sum, calls, walk
from solver.accuracy.rule_sides import MANY
from solver.kernel.block import FEW
from solver.kernel.candidates import Answer, Candidates
from solver.kernel.problem import BlockProblem
from solver.kernel.root_check import sharp_root
from solver.numerics.linear_algebra import Array, Map
from solver.numerics.sparse_newton import itself, sparse_least_squares, sparse_newton
from solver.numerics.tolerances import LEAST
from solver.ranking.sizes import added, nearly_balanced

LIMIT = 0.2
"""The share of its size by which an unknown may move in a limited step."""
BALANCED = 1e-9
"""Share of the factors of a sum that these may add up to in a difference."""
BELOW, LARGE = 0.5, 8.0
"""The shares of their sizes at which unknowns begin again: at these themselves differences may be
0; and where one answer is that all is 0, Newton's method is drawn to it from below the other."""


def search_sparsely(problem: BlockProblem, candidates: Candidates, every: bool) -> None:
    """Try starts in turn until an answer is found that none is preferred to, or ``every`` one.

    An answer without negative numbers ends the search; one with some is kept, and a positive one is
    searched for. The same holds for an answer in which a rule holds trivially.
    """
    free = {
        v.name for v in problem.variables if v.low == -math.inf and problem.turn(v.name) is None
    }
    sought = problem.guesses or candidates.nearest[0]
    for start in _sparse_starts(problem, sought):
        if candidates.answers and not (start.positive or every):
            continue
        root = sparse_newton(
            *problem.sparse,
            start.x,
            start.sizes,
            start.positive,
            explicit=start.explicit,
            limit=start.limit,
        )
        if not np.isfinite(root.x).all():
            continue
        point = problem.named(root.x.tolist())
        if root.converged and len(point) <= MANY:
            candidates.refine(root.x.tolist())
        elif root.converged and (polished := _polished(problem, root.x)) is not None:
            candidates.keep(polished, alone=root.alone)
        else:
            candidates.note(point)
        fitting = [answer for answer in candidates.answers if problem.fits(answer.values)]
        signs = [_least(problem, answer, free) for answer in fitting]
        if signs and not every and (problem.guesses or max(signs) >= 0.0):
            candidates.answers.sort(key=fitting[signs.index(max(signs))].__ne__)
            return


def _least(problem: BlockProblem, answer: Answer, free: Collection[str]) -> float:
    """The least of the ``free`` numbers of an answer; that of a trivial one is a tiny negative
    number."""
    least = min((v for name, v in answer.values.items() if name in free), default=0.0)
    return least or (-LEAST if _is_trivial(problem, answer) else 0.0)


def _is_trivial(problem: BlockProblem, answer: Answer) -> bool:
    """Whether some rule is 0 = 0 there, for any values of its unknowns that are not 0: a population
    that has died out, an infection that nobody has."""
    x = np.array([answer.values[name] for name in problem.unknowns])
    slopes, rows, columns = problem.sparse[1](x)
    counts = partial(np.bincount, rows, minlength=len(x))
    others = counts(weights=(slopes != 0.0) & (x[columns] != 0.0))
    own = counts(weights=(slopes != 0.0) & (x[columns] == 0.0))
    return bool(((others == 0) & (own > 0) & (counts(weights=slopes == 0.0) > 0)).any())


def _polished(problem: BlockProblem, x: Array) -> dict[str, float] | None:
    """The point next to a root at which every rule holds. If rounding has left traces (the flow
    through a closed valve, the last of many complexes), explicit rules correct it; if rounding in
    the evaluation of a rule prevents it (``exp(x) - 1`` at a small x), residuals in many digits do.
    None otherwise."""

    def near() -> Iterator[Sequence[float] | None]:
        yield x.tolist()
        yield problem.kernel.sparse.with_explicit(x, problem.known).tolist()
        yield sharp_root(problem, x.tolist(), problem.sizes_at(x.tolist()))

    points = (problem.named(point) for point in near() if point is not None)
    return next(filter(problem.holds, points), None)


_EXPONENTIALS = frozenset({"exp", "sinh", "cosh"})


class Start(NamedTuple):
    """A point (n,) to start from, the ``sizes`` (n,) of the unknowns, and options of
    ``sparse_newton``."""

    x: Array
    sizes: Array | None
    positive: bool = False
    explicit: Map = itself
    limit: float | None = None


def _sparse_starts(problem: BlockProblem, guesses: Mapping[str, float]) -> Iterator[Start]:
    """Points to start from in turn, with options.

    The guesses (or the nearest miss so far) if there are any, else 0, from which the first step
    solves the linearised rules; positive numbers of the sizes that balance the rules; and 1.
    Unknowns that a rule gives explicitly start at its value, and in the last starts they also
    follow it after each step: then auxiliary unknowns, such as friction factors, do not hold back
    the others.
    """
    names, system = problem.unknowns, problem.kernel.sparse
    low, high = np.array([(v.low, v.high) for v in problem.variables]).T

    def explicit(x: Array) -> Array:
        return np.clip(system.with_explicit(x, problem.known), low, high)

    nothing = np.zeros(len(names))
    level = _smooth(problem, nothing)
    nothing = np.clip(nothing if level is None else level, low, high)
    zero = explicit(nothing)
    if not guesses:
        yield Start(zero, None)
    known = {name: v for name in problem.kernel.known if isinstance(v := problem.here[name], float)}
    turns = np.array([problem.turn(name) or math.nan for name in names])
    guessed, turning = np.abs([guesses.get(name, 0.0) for name in names]), ~np.isnan(turns)

    def positive(sharing: bool) -> tuple[Array, Array]:
        """Positive numbers, but 0 for angles, that nearly balance the rules, and their sizes."""
        balanced = nearly_balanced(problem.kernel.alike, names, known, sharing)
        sizes = np.where(guessed > 0.0, guessed, np.where(turning, turns / 4, balanced))
        return np.clip(np.where(turning, 0.0, sizes), low, high), sizes

    inside, sizes = positive(sharing=True)
    if guesses:
        guess = np.array([guesses.get(n, v) for n, v in zip(names, inside, strict=True)])
        yield Start(guess, sizes)
        yield Start(zero, sizes)
    ones = np.clip(np.where(turning, 0.0, 1.0), low, high)
    yield Start(inside, sizes, positive=True)
    yield Start(ones, sizes, positive=True)
    if len(names) > FEW:
        yield Start(np.clip(BELOW * inside, low, high), sizes, positive=True)
        whole, alike = positive(sharing=False)
        yield Start(whole, alike, positive=True)
        yield Start(whole, alike)
        yield Start(np.clip(LARGE * inside, low, high), sizes, positive=True)
    yield Start(ones, sizes)
    yield Start(inside, sizes)
    utilities = _exponents(problem)
    if utilities.any():
        yield Start(np.clip(np.where(utilities, 0.0, inside), low, high), sizes)
    flat = _smooth(problem, inside)
    if flat is not None:
        yield Start(explicit(flat), sizes)
    if len(names) > FEW:
        beside = [inside] if flat is None else [inside, flat]
        yield from (Start(start, sizes, explicit=explicit) for start in (zero, *beside))
        if not turning.any():  # a mechanism has several answers, which starts at random find
            yield from (Start(start, sizes, limit=LIMIT) for start in beside)


_Term: TypeAlias = tuple[float, str | None, str]
"""A term of a sum: its sign, the name of the number that is its factor, if there is one, and its
own."""


def _smooth(problem: BlockProblem, start: Array) -> Array | None:
    """The start (n,) with the smallest possible differences between unknowns that rules subtract
    from one another or from numbers: flat voltages, heads between reservoirs, straight ropes. None
    if rules have no differences."""
    system, parts, height = problem.kernel.sparse, list[tuple[Any, ...]](), 0
    everything = np.concatenate([start, problem.known])
    for shape in system.shapes:
        given = {f"#.{k}": (np.full(len(v), -1), v) for k, v in enumerate(shape.numbers)}
        given |= {
            f"#{k}": (np.where(at < system.n, at, -1), everything[at])
            for k, at in enumerate(shape.places)
        }
        for terms, turn in _differences(shape.form):
            ones, found = np.ones(len(shape.rows)), [given[name] for *_, name in terms]
            factors = np.array([sign * (given[by][1] if by else ones) for sign, by, _ in terms])
            columns = np.array([places for places, _ in found])
            values = np.array([v for _, v in found]) * np.where(columns < 0, turn, 1.0)
            total = np.abs(factors).sum(axis=0)
            balanced = np.abs(factors.sum(axis=0)) <= BALANCED * total
            chosen = np.flatnonzero(balanced & (total > 0.0) & (columns >= 0).any(axis=0))
            shares = (factors / np.where(total > 0.0, total, 1.0))[:, chosen]
            rows = np.broadcast_to(height + np.arange(len(chosen)), shares.shape)
            moving, height = columns[:, chosen] >= 0, height + len(chosen)
            entries = shares[moving], rows[moving], columns[:, chosen][moving]
            parts.append((*entries, -(shares * values[:, chosen]).sum(axis=0)))
    if not height:
        return None
    data, rows, columns, off = (np.concatenate(each) for each in zip(*parts, strict=True))
    return start + sparse_least_squares((data, rows, columns), (height, len(start)), off)


def _differences(form: Expression) -> Iterator[tuple[list[_Term], float]]:
    """The sums in a form that are differences of names, with or without factors, or of a name and a
    number, and its sign: in ``-0.5 - V`` V is subtracted from a negative number."""
    for node in walk(form):
        terms = list[_Term]()
        for part, taken in added(node) if isinstance(node, Sum) else ():
            match part:
                case Name(name):
                    terms.append((-1.0 if taken else 1.0, None, name))
                case Product(Name(by), Name(name)) if by.startswith("#."):
                    terms.append((-1.0 if taken else 1.0, by, name))
        terms.sort(key=lambda term: term[2][1] == ".")
        count = sum(name[1] != "." for *_, name in terms)
        if count > 1 and len({sign for sign, _, _ in terms[:count]}) > 1:
            yield terms[:count], 1.0  # numbers between names are offsets
        elif count == 1 and len(terms) == 2 and (min(terms[0][0], terms[1][0]) < 0.0):
            one, (sign, _, number) = terms
            yield [one, (-one[0], None, number)], -one[0] * sign


def _exponents(problem: BlockProblem) -> NDArray[np.bool_]:
    """Which unknowns (n,) occur in sums that are exponents of e: utilities, potentials. These may
    have either sign, and only the size 1."""
    place = {name: i for i, name in enumerate(problem.unknowns)}
    rules, found = problem.kernel.alike, np.zeros(len(place), dtype=bool)
    columns = np.array([place.get(name, -1) for name in rules.names], dtype=np.intp)
    for family in rules.families:
        for name in dict.fromkeys(_terms_of_exponents(family.first)):
            mine = columns[family.columns[family.first.names.index(name)]]
            found[mine[mine >= 0]] = True
    return found


def _terms_of_exponents(rule: Equation) -> Iterator[str]:
    found = (call for call in calls(*rule.sides) if call.function in _EXPONENTIALS)
    waiting = [call.arguments[0] for call in found]
    while waiting:
        match waiting.pop():
            case Name(name):
                yield name
            case Sum(terms):
                waiting += terms
            case Negative(one) | Quotient(one, _):
                waiting.append(one)
            case Product(one, other):
                waiting += (one, other)
