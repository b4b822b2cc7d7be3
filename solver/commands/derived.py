"""What ``backsolve solve`` derives from an answer on request: sensitivities, tolerances, Monte Carlo."""

from __future__ import annotations

from argparse import ArgumentParser, ArgumentTypeError, Namespace
from collections.abc import Iterator

from rulesheets.variables import variable_named
from solver.commands.option import Option
from solver.derivatives.sensitivities import Sensitivities
from solver.derivatives.tolerances import ToleranceBands
from solver.report.derived import (
    samples_json,
    samples_text,
    sensitivity_json,
    sensitivity_text,
    tolerances_json,
    tolerances_text,
)
from solver.report.json import diagnosis_json
from solver.result import Result
from solver.sampling import Samples, monte_carlo


def add_derived_options(parser: ArgumentParser) -> None:
    add = parser.add_argument
    add(
        "--sensitivity",
        metavar="NAME,…",
        nargs="?",
        const="",
        help="derivatives of outputs by inputs: of those named, else of all",
    )
    add("--tolerances", action="store_true", help="tolerances of the outputs (shown where inputs have some)")
    add("--monte-carlo", metavar="N", type=_samples, help="compare with N samples within the tolerances")
    add("--seed", metavar="K", type=int, default=0, help="the seed of the samples (0)")
    add(
        "--distribution",
        choices=("uniform", "normal"),
        default="uniform",
        help="of the samples: anywhere within the tolerance, or normal with the tolerance at 3 sigma",
    )


def _samples(text: str) -> int:
    if not text.isascii() or not text.isdigit() or not 2 <= int(text) <= 10_000_000:
        raise ArgumentTypeError("a number of samples from 2 to 10,000,000 is needed")
    return int(text)


def asked(arguments: Namespace) -> bool:
    """Whether an option asks for something derived."""
    return arguments.sensitivity is not None or bool(arguments.tolerances or arguments.monte_carlo)


def derived_text(result: Result, arguments: Namespace, *, color: bool) -> str:
    """What the options ask for, as blocks of text; empty where they ask for nothing."""
    return "\n\n".join(_texts(result, arguments, color))


def _texts(result: Result, arguments: Namespace, color: bool) -> Iterator[str]:
    if arguments.sensitivity is not None:
        yield sensitivity_text(_sensitivities(result, arguments.sensitivity), color=color)
    bands = _bands(result, arguments)
    if bands is not None:
        yield tolerances_text(bands, color=color)
        samples = _drawn(result, arguments, bands)
        if samples is not None:
            yield samples_text(samples, bands)


def derived_json(result: Result, arguments: Namespace) -> dict[str, object]:
    """The same as members of the JSON object."""
    members: dict[str, object] = {}
    if arguments.sensitivity is not None:
        found = _sensitivities(result, arguments.sensitivity)
        members["sensitivities"] = sensitivity_json(found)
        members["sensitivity_diagnoses"] = [diagnosis_json(diagnosis) for diagnosis in found.diagnoses]
    bands = _bands(result, arguments)
    if bands is not None:
        members["tolerances"] = tolerances_json(bands)
        members["tolerance_diagnoses"] = [diagnosis_json(diagnosis) for diagnosis in bands.diagnoses]
        samples = _drawn(result, arguments, bands)
        if samples is not None:
            members["monte_carlo"] = samples_json(samples)
    return members


def _sensitivities(result: Result, text: str) -> Sensitivities:
    """Names that are inputs choose columns, others rows. Raises RuleSheetError for unknown names."""
    option = Option("sensitivity", text)
    names = list(filter(None, map(str.strip, text.split(","))))
    for name in names:
        variable_named(name, result.model, option.place(name))
    inputs = [name for name in names if name in result.inputs]
    outputs = [name for name in names if name not in result.inputs]
    return result.sensitivity(outputs or None, inputs or None)


def _bands(result: Result, arguments: Namespace) -> ToleranceBands | None:
    """The bands where they are asked for, or where an input has a tolerance and there is an answer."""
    asked = arguments.tolerances or arguments.monte_carlo
    stated = any(result.model.variables[name].tolerance for name in result.inputs)
    return result.tolerance_bands() if asked or (stated and result.solutions) else None


def _drawn(result: Result, arguments: Namespace, bands: ToleranceBands) -> Samples | None:
    if not arguments.monte_carlo or not bands.tolerances or not result.solutions:
        return None
    return monte_carlo(result, arguments.monte_carlo, arguments.seed, arguments.distribution)
