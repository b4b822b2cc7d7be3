"""How much of a result rounding can have changed: running error analysis, beside the program.

Every operation adds a unit in the last place to what the errors of its operands make of it, to first
order (Higham, Accuracy and Stability of Numerical Algorithms, 2002, section 3.3). The bound is that of the
way in which a result is computed; the problem itself may be better conditioned.
"""

from __future__ import annotations

from solver.compiled.flow import NotCompilable
from solver.compiled.schedule import LEAVES, LOGICAL, operands, schedule

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Sequence

    from solver.compiled.flow import Flow

UNIT = 2.0**-52
CANCELLED = 1e-12
"""Share of its terms that a difference may be no more of than their rounding."""
RADIAN = 0.017453292519943295


def accurate(flow: Flow, results: Sequence[int], share: float) -> int:
    """The node that is true where no result can be off by more than that share of itself.

    Raises NotCompilable where an operation has no known effect on errors.
    """
    analysis = _Analysis(flow)
    every = flow.true
    for node in dict.fromkeys(results):
        limit = flow.add("mul", flow.constant(share), flow.add("abs", node))
        every = flow.add("and", every, flow.add("le", analysis.error(node), limit))
    return every


def quiet(flow: Flow, node: int, known: Iterable[int], share: float) -> int:
    """The node that is true where the rounding on the way from ``known`` nodes moves a result by no more
    than that share of itself. Raises NotCompilable as ``accurate`` does."""
    error = _Analysis(flow, known).error(node)
    return flow.add("le", error, flow.add("mul", flow.constant(share), flow.add("abs", node)))


def divisors_told_from_zero(flow: Flow, results: Sequence[int]) -> Iterator[int]:
    """A node for each sum that the way to the results divides by, true where it is more than the last places
    of its terms: what rests on less is no answer, and left to be told step by step."""
    for node in schedule(flow, results).order:
        if flow.nodes[node][0] == "div":
            divisor = operands(flow, node)[1]
            if flow.nodes[divisor][0] in ("add", "sub"):
                one, other = (flow.add("abs", part) for part in operands(flow, divisor))
                least = flow.add("mul", flow.constant(CANCELLED), flow.add("add", one, other))
                yield flow.add("lt", least, flow.add("abs", divisor))


class _Analysis:
    """The nodes of the error bounds; what is ``known`` has no errors."""

    def __init__(self, flow: Flow, known: Iterable[int] = ()) -> None:
        self.flow = flow
        self.errors: dict[int, int] = dict.fromkeys(known, flow.constant(0.0))

    def error(self, node: int) -> int:
        """The node of the error bound of a node."""
        for one in (*schedule(self.flow, [node]).order, node):
            if one not in self.errors:
                self.errors[one] = self._bound(one)
        return self.errors[node]

    def _bound(self, node: int) -> int:
        flow = self.flow
        operation, *rest = flow.nodes[node]
        zero = flow.constant(0.0)
        if operation in LEAVES or operation in LOGICAL:
            return zero
        parts = operands(flow, node)
        errors = [self.errors.get(part, zero) for part in parts]
        rounding = flow.add("mul", flow.constant(UNIT), flow.add("abs", node))
        return flow.add("add", rounding, self._carried(node, str(operation), rest, parts, errors))

    def _carried(
        self,
        node: int,
        operation: str,
        rest: list[int | float | str],
        parts: tuple[int, ...],
        errors: list[int],
    ) -> int:
        """What the errors of the operands make of the result."""
        flow, add = self.flow, self.flow.add
        if operation == "call":
            operation = str(rest[0])
        match operation:
            case "add" | "sub":
                return add("add", errors[0], errors[1])
            case "neg" | "abs":
                return errors[0]
            case "mul":
                one = add("mul", add("abs", parts[0]), errors[1])
                return add("add", one, add("mul", add("abs", parts[1]), errors[0]))
            case "div":
                above = add("add", errors[0], add("mul", add("abs", node), errors[1]))
                return add("div", above, add("abs", parts[1]))
            case "sqrt":
                return add("div", errors[0], add("mul", flow.constant(2.0), node))
            case "where":
                return add("where", parts[0], errors[1], errors[2])
            case "sind" | "cosd":
                return add("mul", flow.constant(RADIAN), errors[0])
            case "sin" | "cos":
                return errors[0]
            case "expm1":
                return add("mul", errors[0], add("add", flow.constant(1.0), add("abs", node)))
            case "log1p":
                return add("div", errors[0], add("abs", add("add", flow.constant(1.0), parts[0])))
            case "direction" | "directiond" | "atan2" | "atan2d":
                return self._turned(
                    parts, errors, 1.0 if operation in ("direction", "atan2") else 1.0 / RADIAN
                )
            case _ if all(error == flow.constant(0.0) for error in errors):
                return flow.constant(0.0)
            case _:
                raise NotCompilable

    def _turned(self, parts: tuple[int, ...], errors: list[int], scale: float) -> int:
        add = self.flow.add
        y, x = parts
        across = add("add", add("mul", add("abs", x), errors[0]), add("mul", add("abs", y), errors[1]))
        square = add("add", add("mul", x, x), add("mul", y, y))
        return add("mul", self.flow.constant(scale), add("div", across, square))
