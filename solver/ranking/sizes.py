"""The sizes of unknowns that the rules and the known numbers suggest.

This is dimensional analysis with numbers. Every rule is a linear equation between logarithms: terms
of a sum balance, factors multiply, sines and the arguments of exponentials are of size 1. Where
these equations disagree, their squared residuals are least. The scalings that leave the rules
unchanged tell which quantities are of one kind (E. Buckingham, *On physically similar systems*,
1914): ``v = omega*r`` stays true if r and v are doubled, or omega and v.
"""

from __future__ import annotations

import math
from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from math import log10, pi
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from rulesheets.functions import LOGARITHMS, TABLE, named
from rulesheets.model import Equation, Model
from rulesheets.syntax.nodes import (
    Call,
    Expression,
    Name,
    Negative,
    Number,
    Power,
    Product,
    Quotient,
    Sum,
    is_number,
    names,
    walk,
)
from solver.numerics.linear_algebra import Array
from solver.numerics.sparse_newton import sparse_least_squares
from solver.numerics.tolerances import NULL
from solver.path.graph import shape_of
from solver.path.shapes import Alike, same_columns

Places = NDArray[np.intp]

EXACT = 100.0
"""Weight of a rule without sums, relative to one whose terms only balance."""
DROP = 0.1
"""Weight of a product having the size of names that balance without it: in V = E - R*I it may be
small, with a name or without."""
SINE = 3.0
"""Weight of a sine being of size 1: small angles are ordinary."""
CANCELLING = 0.01
"""Weight of a difference being of the size of its terms, in a network, where neighbours are nearly
alike."""
MANY = 200
"""Unknowns of a model beyond which no sizes are suggested."""
UNDECIDED = 1e-6
"""Share of an unknown that may move without any rule, below which it is determined."""

_ALIKE = frozenset({"abs", "min", "max", "round", "int", "frac", "mod", "hypot"})
_DIRECTIONS = named(lambda row: row.direction)
_UNBOUNDED = frozenset({"exp", "sinh", "cosh"})


Slopes: TypeAlias = list[tuple[int, float]]
"""Those that are not 0 of one unknown, each with the place of its known number."""


def suggested(
    model: Model, known: Sequence[str], names: Sequence[str], zero: Sequence[bool]
) -> tuple[list[Slopes], list[float], list[bool]]:
    """The decades of unknowns, by ``names``, as slopes times those of the ``known`` numbers plus
    constants, and which are determined; others are as near to 1 as the rules allow. For too large a
    model nothing is suggested.

    Known numbers that are ``zero`` vanish, and with them the terms that they are factors of, and
    the values that a rule then gives as 0.
    """
    unknowns = sorted(set(model.variables).difference(known))
    if len(unknowns) > MANY or not names:
        return [[]] * len(names), [0.0] * len(names), [False] * len(names)
    vanishing = {name for name, none in zip(known, zero, strict=True) if none}
    given = (rule.sides for rule in model.equations)
    vanishing |= {
        left.name for left, right in given if isinstance(left, Name) and is_number(right, 0.0)
    }
    pairs = [pair for rule in model.equations for pair in rule.definitions]
    products = {name for name, side in pairs if isinstance(side, Product | Quotient | Power)}
    sums = [(name, side.terms) for name, side in pairs if isinstance(side, Sum)]
    products |= {name for name, some in sums if all(_is_product(term, products) for term in some)}
    nodes = _nodes(model.equations)
    rows = _Balances((*unknowns, *known), vanishing, nodes=nodes, products=products)
    for equation in model.equations:
        rows.read(equation)
    a, k, c = rows.parts(len(unknowns))
    places = [unknowns.index(name) for name in names]
    inverse = np.linalg.pinv(a, rcond=NULL)
    determined = np.einsum("ij,ji->i", inverse[places], a[:, places]) > 1.0 - UNDECIDED
    weights = (-(inverse[places] @ k)).tolist()
    slopes = [[(place, slope) for place, slope in enumerate(row) if slope] for row in weights]
    return slopes, (-(inverse[places] @ c)).tolist(), determined.tolist()


def _is_product(term: Expression, products: Collection[str]) -> bool:
    named = isinstance(term, Name) and term.name in products
    return named or isinstance(term, Product | Quotient | Power)


def nearly_balanced(
    rules: Alike, unknowns: Sequence[str], known: Mapping[str, float], sharing: bool = True
) -> Array:
    """Sizes (n,) of the unknowns of a large block that approximately balance its rules.

    The terms of a sum are ``sharing`` it, or one may make up most of it, as along a chain of
    branches.

    Rules of one shape, with zeros at the same places, give the same equations for other unknowns.
    """
    n = len(unknowns)
    place = {name: i for i, name in enumerate(unknowns)}
    columns = np.array([place.get(name, -1) for name in rules.names], dtype=np.intp)
    numbers = np.array([known.get(name, np.nan) for name in rules.names])
    entries, rhs = list[tuple[Array, Places, Places]](), list[Array]()
    rows = 0, n
    for family in rules.families:
        mine, given = columns[family.columns], numbers[family.columns]
        every = np.concatenate([np.where(mine < 0, given, np.nan), family.numbers])
        for zero, chosen in same_columns(every == 0.0):
            matrix, constants = _balance_of_shape(family.first, len(mine), zero, sharing)
            count, (height, width) = len(chosen), rows
            # the column of each name and number; -1 where known
            at = np.full((matrix.shape[1], count), -1)
            at[: len(mine)] = mine[:, chosen]
            free = at[len(every) :]
            free[:] = width + np.arange(free.size).reshape(free.shape)
            decades = np.zeros(at.shape)
            with np.errstate(all="ignore"):
                decades[: len(every)] = np.nan_to_num(
                    np.log10(np.abs(every[:, chosen])), nan=0.0, neginf=0.0
                )
            rhs.append((-constants[:, None] - matrix @ np.where(at < 0, decades, 0.0)).ravel())
            row, column = np.nonzero(matrix)
            asked = at[column] >= 0
            shares = np.broadcast_to(matrix[row, column][:, None], asked.shape)
            lines = height + row[:, None] * count + np.arange(count)
            entries.append((shares[asked], lines[asked], at[column][asked]))
            rows = height + len(matrix) * count, width + free.size
    if not rows[0]:
        return np.ones(n)
    data, lines, mine = (np.concatenate(parts) for parts in zip(*entries, strict=True))
    found = sparse_least_squares((data, lines, mine), rows, np.concatenate(rhs))[:n]
    return np.asarray(10.0 ** np.clip(found, -50.0, 50.0))


def _balance_of_shape(
    rule: Equation, names: int, zero: NDArray[np.bool_], sharing: bool
) -> tuple[Array, Array]:
    """The equations between decades of rules of one shape: their matrix, with a column for each of
    their ``names``, each number in their text, and each number of free size, and constants. Some
    are ``zero``."""
    every = [f"#{k}" if k < names else f"#.{k - names}" for k in range(len(zero))]
    read = _Balances(
        every,
        {name for name, none in zip(every, zero, strict=True) if none},
        cancelling=True,
        sharing=sharing,
    )
    shape, _ = shape_of(rule)
    read.read(rule.but(shape.left, shape.right))
    matrix, _, constants = read.parts(len(every))
    return matrix, constants


@dataclass(slots=True, eq=False)
class _Term:
    """The decade of an expression: a linear function of those of its variables."""

    factors: Mapping[str | int, float]
    constant: float = 0.0
    exact: bool = True

    def plus(self, other: _Term, share: float) -> _Term:
        factors = dict(self.factors)
        for name, factor in other.factors.items():
            factors[name] = factors.get(name, 0.0) + share * factor
        return _Term(factors, self.constant + share * other.constant, self.exact and other.exact)


_ONE = _Term({})


class _Balances:
    """Linear equations between decades; variables by name, numbers of free size by an integer.

    ``exact`` ones hold for scalings that leave the rules unchanged: functions of numbers do not
    scale.
    """

    def __init__(
        self,
        names: Sequence[str],
        vanishing: Collection[str],
        exact: bool = False,
        cancelling: bool = False,
        nodes: frozenset[str] = frozenset(),
        sharing: bool = False,
        products: Collection[str] = (),
    ) -> None:
        self.vanishing, self.nodes, self.products = vanishing, nodes, frozenset(products)
        self.exact, self.cancelling, self.sharing = exact, cancelling, sharing
        self.places = {name: i for i, name in enumerate(names)}
        self.rows: list[tuple[_Term, float]] = []
        self.free = 0

    def read(self, equation: Equation) -> None:
        sides = equation.sides
        if self.cancelling and any(
            isinstance(side, Sum) and _has_difference(side) for side in sides
        ):
            self._balance([term for side in sides if (term := self._term(side)) is not None])
            return
        found = self._shared(added(sides[0]) + added(Negative(sides[1])))
        exact = len(found) == 2 and all(term.exact for *_, term in found)
        levels = [(part, sign) for part, sign, _ in found if _is_level(part)]
        plain = [pair for pair in levels if self.products.isdisjoint(names(pair[0]))]
        balance = next((some for some in (plain, levels) if _is_balance(some)), found)
        kept = {id(part) for part, *_ in balance}
        shares = [1.0 if id(part) in kept else DROP for part, *_ in found]
        self._balance([term for *_, term in found], EXACT if exact else 1.0, shares)

    def _shared(
        self, parts: Sequence[tuple[Expression, bool]]
    ) -> list[tuple[Expression, bool, _Term]]:
        """The terms of a balance that are not 0, and whether each is subtracted; if they are
        ``sharing`` it, each times the number of those of its sign: each of n equal ones is the n-th
        part of the balance."""
        found = [
            (part, sign, term) for part, sign in parts if (term := self._term(part)) is not None
        ]
        if not self.sharing:
            return found
        count = Counter(sign for _, sign, _ in found)
        return [
            (part, sign, term.plus(_Term({}, log10(count[sign])), 1.0))
            for part, sign, term in found
        ]

    def parts(self, unknowns: int) -> tuple[Array, Array, Array]:
        """The matrix of the unknowns (and of free numbers), that of known numbers, and the
        constants."""
        width = len(self.places)
        matrix = np.zeros((len(self.rows), width + self.free))
        constants = np.zeros(len(self.rows))
        for row, (term, weight) in enumerate(self.rows):
            constants[row] = weight * term.constant
            for name, factor in term.factors.items():
                place = self.places[name] if isinstance(name, str) else width + name
                matrix[row, place] += weight * factor
        own = np.concatenate([matrix[:, :unknowns], matrix[:, width:]], axis=1)
        return own, matrix[:, unknowns:width], constants

    def _balance(
        self, terms: Sequence[_Term], weight: float = 1.0, shares: Sequence[float] = ()
    ) -> _Term | None:
        """The mean of terms, which should have one size, each with its share."""
        if not terms:
            return None
        mean, shares = _Term({}, exact=False), shares or [1.0] * len(terms)
        total = sum(share * share for share in shares)
        for term, share in zip(terms, shares, strict=True):
            mean = mean.plus(term, share * share / total)
        if len(terms) > 1:
            rows = zip(terms, shares, strict=True)
            self.rows += [(term.plus(mean, -1.0), weight * share) for term, share in rows]
            return mean
        return terms[0]

    def _sum(self, node: Expression, numbers: bool = True) -> _Term | None:
        """The size of terms of one size, or nearly so if differences may cancel.

        ``numbers`` are left out if the others may be much larger: next to exponentials, in
        logarithms.
        """
        signed = added(node)
        parts = [part for part, _ in signed]
        unbounded = (isinstance(part, Call) and part.function in _UNBOUNDED for part in parts)
        if not self.exact and (not numbers or any(unbounded)):
            parts = [part for part in parts if not isinstance(part, Number)]
        whole = self._balance([term for part in parts if (term := self._term(part)) is not None])
        if self.sharing and whole is not None and len({sign for _, sign in signed}) == 1:
            whole = whole.plus(_Term({}, log10(len(parts))), 1.0)
        between_nodes = _is_balance(signed) and not self.nodes.isdisjoint(names(node))
        cancels = _has_difference(node) if self.cancelling else between_nodes
        if whole is None or not cancels:
            return whole
        if all(isinstance(name, str) and name.startswith("#.") for name in whole.factors):
            return whole  # no variable of a shape is a factor, its numbers alone
        left = self._any()
        self.rows.append((left.plus(whole, -1.0), CANCELLING))
        return left

    def _any(self) -> _Term:
        """A number of unknown size."""
        if self.exact:
            return _ONE
        self.free += 1
        return _Term({self.free - 1: 1.0}, exact=False)

    def _term(self, node: Expression) -> _Term | None:
        match node:
            case Number(value):
                return _Term({}, log10(abs(value))) if value else None
            case Name(name):
                if name in self.vanishing:
                    return None
                return _Term({name: 1.0}) if name in self.places else _ONE
            case Negative(operand):
                return self._term(operand)
            case Sum():
                return self._sum(node)
            case Product(left, right) | Quotient(left, right):
                one, other = self._term(left), self._term(right)
                divides = isinstance(node, Quotient)
                if other is None and divides:
                    return self._any()
                return (
                    None
                    if one is None or other is None
                    else one.plus(other, -1.0 if divides else 1.0)
                )
            case Power(base, Number(exponent)):
                inner = self._term(base)
                return None if inner is None else _ONE.plus(inner, exponent)
            case Power(base, exponent):  # it should have size 1, and for a scaling the base as well
                terms = self._term(exponent), self._term(base)
                asked = terms if self.exact else terms[:1]
                self.rows += [(term, 1.0) for term in asked if term is not None]
                return self._any()
            case Call(function, arguments):
                return self._call(function, arguments)
            case _:
                return _ONE

    def _call(self, function: str, arguments: Sequence[Expression]) -> _Term | None:
        of_sum = function in LOGARITHMS and isinstance(arguments[0], Sum)
        terms = [self._sum(a, numbers=False) if of_sum else self._term(a) for a in arguments]
        there = [term for term in terms if term is not None]
        if function == "sqrt":
            return _ONE.plus(there[0], 0.5) if there else None
        if function in _ALIKE:
            return self._balance(there)
        if function in _DIRECTIONS:
            self._balance(there)
            return _ONE
        if not arguments:
            return _Term({}, log10(pi)) if function == "pi" else _ONE
        if self.exact or function not in LOGARITHMS:
            self.rows += [(term, 1.0) for term in there]
        if self.exact or not (function in _UNBOUNDED or TABLE[function].turn):
            return _ONE
        free = self._any()
        if function not in _UNBOUNDED:
            self.rows.append((free, SINE))
        return free


def _nodes(equations: Sequence[Equation]) -> frozenset[str]:
    """The names of which differences with several others are taken: the potentials of a network."""
    neighbours = defaultdict[str, set[str]](set)
    for node in walk(*(side for equation in equations for side in equation.sides)):
        if isinstance(node, Sum) and _is_balance(added(node)):
            met = set(names(node))
            for name in met:
                neighbours[name] |= met - {name}
    return frozenset(name for name, others in neighbours.items() if len(others) > 1)


def _is_balance(signed: Sequence[tuple[Expression, bool]]) -> bool:
    """Whether names are subtracted from names."""
    return {negative for part, negative in signed if _is_level(part)} == {False, True}


def _is_level(part: Expression) -> bool:
    """Whether a term of a sum is a name or a number, or their product."""
    match part:
        case Name() | Number() | Product(Number(), Name()) | Product(Name(), Number()):
            return True
        case _:
            return False


def _has_difference(node: Expression) -> bool:
    """Whether something in a sum, a product or a quotient is subtracted."""
    match node:
        case Negative():
            return True
        case Sum() | Product() | Quotient():
            return any(map(_has_difference, node.parts))
        case _:
            return False


def added(node: Expression) -> list[tuple[Expression, bool]]:
    """The terms of nested sums, and whether each is subtracted."""
    found: list[tuple[Expression, bool]] = []
    waiting = [(node, False)]
    while waiting:
        node, negative = waiting.pop()
        if isinstance(node, Sum):
            waiting += [(term, negative) for term in reversed(node.terms)]
        elif isinstance(node, Negative):
            waiting.append((node.operand, not negative))
        else:
            found.append((node, negative))
    return found


class Scalings:
    """``exponents`` (names, k): how each variable changes under k independent scalings of the
    rules."""

    def __init__(self, equations: Sequence[Equation], names: Sequence[str]) -> None:
        rows = _Balances(names, (), exact=True)
        for equation in equations:
            rows.read(equation)
        self.places = rows.places
        matrix = rows.parts(len(names))[0]
        if len(matrix) > matrix.shape[1]:
            matrix = np.asarray(np.linalg.qr(matrix, mode="r"))
        self.exponents = np.eye(matrix.shape[1])  # an orthonormal basis of the null space
        if len(matrix):
            _, singular, right = np.linalg.svd(matrix)
            rank = int((singular > NULL * max(singular[0], 1.0)).sum())
            self.exponents = np.asarray(right[rank:].T, dtype=float)

    def sizes(self, known: Mapping[str, float]) -> Mapping[str, float]:
        """The size of every variable that fits the ``known`` numbers best (in the mean of
        logarithms)."""
        given = {name: math.log(abs(v)) for name, v in known.items() if v}
        rows = self.exponents[[self.places[name] for name in given]]
        scaling = np.linalg.lstsq(rows, np.array(list(given.values())), rcond=NULL)[0]
        exponents = np.clip(self.exponents @ scaling, -200.0, 200.0)
        return dict(zip(self.places, np.exp(exponents).tolist(), strict=True))
