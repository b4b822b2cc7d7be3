"""What ``backsolve solve`` derives from an answer on request: sensitivities."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from solver.commands.option import Option

if TYPE_CHECKING:
    from solver.result import Result
    from solver.sensitivities import Sensitivities


def add_derived_options(parser: ArgumentParser) -> None:
    parser.add_argument(
        "--sensitivity",
        metavar="NAME,…",
        nargs="?",
        const="",
        help="derivatives of outputs by inputs: of those named, else of all",
    )


def derived_text(result: Result, arguments: Namespace, *, color: bool) -> str:
    """What the options ask for, as blocks of text; empty where they ask for nothing."""
    blocks = []
    if arguments.sensitivity is not None:
        from solver.report.sensitivity import sensitivity_text

        blocks.append(sensitivity_text(_sensitivities(result, arguments.sensitivity), color=color))
    return "\n\n".join(blocks)


def derived_json(result: Result, arguments: Namespace) -> dict[str, object]:
    """The same as members of the JSON object."""
    members: dict[str, object] = {}
    if arguments.sensitivity is not None:
        from solver.report.json import diagnosis_json
        from solver.report.sensitivity import sensitivity_json

        found = _sensitivities(result, arguments.sensitivity)
        members["sensitivities"] = sensitivity_json(found)
        members["sensitivity_diagnoses"] = [diagnosis_json(diagnosis) for diagnosis in found.diagnoses]
    return members


def _sensitivities(result: Result, text: str) -> Sensitivities:
    """Names that are inputs choose columns, others rows. Raises RuleSheetError for unknown names."""
    from rulesheets.variables import variable_named

    option = Option("sensitivity", text)
    names = list(filter(None, map(str.strip, text.split(","))))
    for name in names:
        variable_named(name, result.model, option.place(name))
    inputs = [name for name in names if name in result.inputs]
    outputs = [name for name in names if name not in result.inputs]
    return result.sensitivity(outputs or None, inputs or None)
