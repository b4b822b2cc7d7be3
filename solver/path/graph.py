"""A model as a graph of integers, and the algebra behind its edges, looked up when asked for."""

from __future__ import annotations

from collections.abc import Iterable

from rulesheets import nodes
from rulesheets.model import Equation, Model
from rulesheets.nodes import Call, Name, Negative, Number, Product, Sum
from solver.path.isolate import Isolation, isolate
from solver.path.linearity import plainly_resolvable

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any

TURN = {
    **dict.fromkeys(("sind", "cosd", "tand"), 360.0),
    **dict.fromkeys(("sin", "cos", "tan"), 6.283185307179586),
}
"""Period that functions of an angle have in common, by function."""

_DIRECTIONS = {
    **dict.fromkeys(("asind", "acosd", "atand", "atan2d"), 360.0),
    **dict.fromkeys(("asin", "acos", "atan", "atan2"), 6.283185307179586),
}


class ModelGraph:
    """Variables and equations by number; isolations are found once and kept."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.names = tuple(model.variables)
        self.number = {name: i for i, name in enumerate(self.names)}
        self.occurs = tuple(self._numbers(equation.names) for equation in model.equations)
        self.condition_occurs = tuple(
            self._numbers(dict.fromkeys(nodes.names(condition))) for condition in model.conditions
        )
        self._users: dict[str, tuple[int, ...]] = {}
        self._isolations: dict[tuple[int, int], Isolation | None] = {}
        self._plain: dict[int, frozenset[str]] = {}
        self._turns: dict[str, float | None] | None = None
        self.kernels: dict[Any, Any] = {}

    def _numbers(self, names: Iterable[str]) -> tuple[int, ...]:
        return tuple(self.number[name] for name in names)

    def users(self, name: str) -> tuple[int, ...]:
        """Equations that read a variable, in their body or their guard."""
        if not self._users:
            users: dict[str, list[int]] = {name: [] for name in self.names}
            for equation, occurs in zip(self.model.equations, self.occurs, strict=True):
                guards = (v for p in equation.guard for v in self.condition_occurs[p.condition])
                for variable in dict.fromkeys((*occurs, *guards)):
                    users[self.names[variable]].append(equation.index)
            self._users = {name: tuple(equations) for name, equations in users.items()}
        return self._users[name]

    def isolation(self, equation: int, variable: int) -> Isolation | None:
        key = (equation, variable)
        if key not in self._isolations:
            body = self.model.equations[equation]
            self._isolations[key] = isolate(body.left, body.right, self.names[variable])
        return self._isolations[key]

    def cost(self, equation: int, variable: int) -> int | None:
        """The cost of an isolation, told without isolating where that is plain; None where there is none."""
        if equation not in self._plain:
            body = self.model.equations[equation]
            self._plain[equation] = plainly_resolvable(body.left, body.right)
        if self.names[variable] in self._plain[equation]:
            return 0
        isolation = self.isolation(equation, variable)
        return None if isolation is None else isolation.cost

    def turn(self, name: str) -> float | None:
        """The period of a variable that is nothing but an angle: 360, 2π, or None."""
        if self._turns is None:
            self._turns = _turns(self.model.equations)
        return self._turns.get(name)


def _turns(equations: Iterable[Equation]) -> dict[str, float | None]:
    """Variables that occur only where whole turns make no difference."""
    turns: dict[str, float | None] = {}
    plain: set[str] = set()
    for equation in equations:
        if not _angle_relation(equation, turns):
            for side in (equation.left, equation.right):
                _collect(side, turns, plain)
    return {name: turn for name, turn in turns.items() if name not in plain}


def _angle_relation(equation: Equation, turns: dict[str, float | None]) -> bool:
    """``thetaAB = atan2d(…)`` and ``beta = alpha + 90`` relate angles as such."""
    left, right = equation.left, equation.right
    for one, other in ((left, right), (right, left)):
        if isinstance(one, Name) and isinstance(other, Call) and other.function in _DIRECTIONS:
            turns.setdefault(one.name, _DIRECTIONS[other.function])
            return not any(True for _ in nodes.names(other)) or _collect_into(other, turns)
    return is_angle_sum(left) and is_angle_sum(right)


def _collect_into(call: Call, turns: dict[str, float | None]) -> bool:
    plain: set[str] = set()
    for argument in call.arguments:
        _collect(argument, turns, plain)
    turns.update(dict.fromkeys(plain, None))
    return True


def is_angle_sum(side: nodes.Expression) -> bool:
    """Names and numbers added up: harmless for angles, and no evidence that they are any."""
    match side:
        case Name() | Number():
            return True
        case Negative(operand):
            return is_angle_sum(operand)
        case Sum(terms):
            return all(isinstance(t, Name | Number | Negative) and is_angle_sum(t) for t in terms)
        case _:
            return False


def _whole_turns(argument: nodes.Expression) -> bool:
    """Whole multiples of angles added up: a turn of any of them is a whole number of turns."""
    match argument:
        case Name() | Number():
            return True
        case Negative(operand):
            return _whole_turns(operand)
        case Product(Number(factor), Name()) | Product(Name(), Number(factor)):
            return factor == round(factor)
        case Sum(terms):
            return all(map(_whole_turns, terms))
        case _:
            return False


def _collect(side: nodes.Expression, turns: dict[str, float | None], plain: set[str]) -> None:
    stack: list[nodes.Expression] = [side]
    while stack:
        node = stack.pop()
        if isinstance(node, Name):
            plain.add(node.name)
        elif isinstance(node, Call) and node.function in TURN and _whole_turns(node.arguments[0]):
            for name in nodes.names(node.arguments[0]):
                turn = TURN[node.function]
                if turns.setdefault(name, turn) != turn:
                    plain.add(name)
        else:
            stack.extend(nodes.children(node))  # type: ignore[arg-type]
