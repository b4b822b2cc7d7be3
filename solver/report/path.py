"""A solution path as text: what is solved from which rule, in order."""

from __future__ import annotations

from collections.abc import Iterator

from rulesheets.format import format_condition
from rulesheets.model import Equation, Model
from solver.attempts import Method
from solver.kernel.code.block import BlockKernel
from solver.kernel.methods import first_methods
from solver.path.planner import planner
from solver.path.steps import Assume, Check, Decide, Evaluate, Path, Select, SolveBlock, Step
from solver.report.places import Places
from solver.report.table import table
from solver.result import Result

Row = tuple[str, str, str, str, str]


def path_text(result: Result) -> str:
    """A table of the steps, then the number of branches and the wanted variables that no step reaches."""
    lines = [path_table(result.model, result.path), branches_line(result.path)]
    missing = unreached(result)
    if missing:
        lines.append(f"Not reached: {', '.join(missing)}.")
    return "\n".join(lines)


def unreached(result: Result) -> tuple[str, ...]:
    """The wanted variables that the path does not lead to."""
    beyond = set(result.path.undetermined)
    return tuple(name for name in result.wanted if name in beyond)


def path_table(model: Model, path: Path, first: int = 1) -> str:
    """One line a step: number (from ``first``), what is found, in how many ways, the rule and its place."""
    places = Places(model)
    rows = [
        row for number, step in enumerate(told(path), first) for row in _rows(model, places, number, step)
    ]
    return table(("Step", "Finds", "Ways", "Place", "By the rule"), rows)


def told(path: Path) -> tuple[Step, ...]:
    """The steps worth telling: each once, and no check of an equation that was solved with."""
    steps = tuple(dict.fromkeys(path.steps))
    solved = {equation for step in steps for equation in _solves(step)}
    return tuple(step for step in steps if not (isinstance(step, Check) and step.equation in solved))


def _solves(step: Step) -> tuple[int, ...]:
    match step:
        case Evaluate(equation):
            return (equation,)
        case Select(equations) | SolveBlock(equations):
            return equations
        case _:
            return ()


def branches_line(path: Path) -> str:
    """How many answers the path can have; only a block leaves that open."""
    if any(isinstance(step, SolveBlock) for step in path.steps):
        return "Blocks can have any number of answers."
    return "One answer at most." if path.branches == 1 else f"At most {path.branches} answers."


def _rows(model: Model, places: Places, number: int, step: Step) -> Iterator[Row]:
    match step:
        case Evaluate(equation, unknown, branches):
            yield (str(number), unknown, _ways(branches), *_rule(places, model.equations[equation]))
        case Select(equations, unknown, branches):
            first, *others = dict.fromkeys(_rule(places, model.equations[index]) for index in equations)
            yield (str(number), unknown, _ways(branches), *first)
            yield from (("", "  or by", "", *other) for other in others)
        case SolveBlock():
            yield from _block_rows(model, places, number, step)
        case Decide(conditions):
            for place, index in enumerate(conditions):
                condition = format_condition(model.conditions[index])
                yield ("" if place else str(number), "(decides)", "", "", f"whether {condition}")
        case Assume(index):
            condition = format_condition(model.conditions[index])
            yield (str(number), "(case by case)", "", "", f"assuming {condition}, and not")
        case Check(equation):
            yield (str(number), "(checks)", "", *_rule(places, model.equations[equation]))


def _block_rows(model: Model, places: Places, number: int, block: SolveBlock) -> Iterator[Row]:
    heading = f"{', '.join(block.unknowns)}, iterating on {', '.join(block.tears or block.unknowns)}"
    yield (str(number), f"block of {len(block.unknowns)}", "", "", heading)
    for step in block.order:
        yield ("", f"  {step.unknown}", _ways(step.branches), *_rule(places, model.equations[step.equation]))
    for index in block.residuals or block.equations:
        yield ("", "  (closes)", "", *_rule(places, model.equations[index]))
    yield ("", "  (tries)", "", "", _methods(model, block))


def _methods(model: Model, block: SolveBlock) -> str:
    """The methods that the structure of a block admits, in the order in which they are tried."""
    kernel = BlockKernel(planner(model).graph, block)
    methods = [Method.LINEAR] if kernel.linear else [*first_methods(kernel), Method.TRUST_REGION]
    names = dict.fromkeys(method.short.format(tear=", ".join(block.tears)) for method in methods)
    return ", ".join(names)


def _ways(branches: int) -> str:
    return "" if branches == 1 else str(branches)


def _rule(places: Places, equation: Equation) -> tuple[str, str]:
    return places.of(equation), places.said(equation)
