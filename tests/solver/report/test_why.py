"""A derivation in print."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import rulesheets
import solver
from solver.__main__ import main
from solver.report.derivation import Derivation, why, why_latex, why_markdown, why_text

LENS = """\
variables
  f = 50   [mm]  " focal length
  u = 200 [mm]
  v        [mm]
  m
rules
  1/f = 1/u + 1/v
  if m > 0 then m = v/u else m = -v/u
"""


def derive(text: str, name: str) -> Derivation:
    return why(solver.solve(rulesheets.loads(text)), name)


def test_text_shows_form_numbers_and_value() -> None:
    lines = why_text(derive("variables\n  a = -15\n  b = 3\n  c\nrules\n  c/a = b", "c")).split(
        "\n"
    )
    assert lines == [
        "c = -45, from 2 inputs by 1 of 1 rule",
        "",
        "Given",
        "    a = -15",
        "    b = 3",
        "",
        "1  c = b*a = 3*(-15) = -45",
        "       <text>:6  c/a = b",
    ]


def test_a_leading_sign_needs_no_parentheses() -> None:
    text = why_text(derive("variables\n  a = -15\n  b = -3\n  c\nrules\n  c = a*b - (a - b)", "c"))
    assert "c = a*b - (a - b) = -15*(-3) - (-15 - (-3)) = 57" in text


def test_a_block_shows_equations_unknowns_and_tears() -> None:
    text = why_text(derive("x + y = 5\nx - y = 1", "x"))
    assert "together, iterating on" in text
    assert "such that x - y = 1" in text
    assert text.count("<text>:1  x + y = 5") == 1


def test_one_equation_that_is_iterated_says_so() -> None:
    text = why_text(derive("w + exp(w) = 1", "w"))
    assert "w: by iteration" in text
    assert "which gives w = 0" in text


def test_an_arm_shows_its_condition_and_the_values_it_was_read_at() -> None:
    text = why_text(derive("a = 2\nif a > 1 then y = 3*a else y = 0", "y"))
    assert "<text>:2  if a > 1 then y = 3*a\n" in text
    assert "because a > 1   (a = 2)" in text
    other = why_text(derive("a = 0\nif a > 1 then y = 3*a else y = 0", "y"))
    assert "<text>:2  else y = 0\n" in other
    assert "because not (a > 1)   (a = 0)" in other


def test_markdown_is_a_numbered_list_with_mathematics() -> None:
    text = why_markdown(derive(LENS, "v"))
    assert "- $f = 50$ mm: focal length" in text
    assert r"1. $v = \frac{1}{\frac{1}{f} - \frac{1}{u}}" in text
    assert "`1/f = 1/u + 1/v` (\\<text\\>:7)" in text
    assert text.count("$") % 2 == 0


def test_latex_is_an_align_environment() -> None:
    text = why_latex(derive(LENS, "v"))
    assert text.startswith("\\begin{align*}\n") and text.endswith("\n\\end{align*}")
    rows = [line for line in text.split("\n")[1:-1] if not line.strip().startswith("%")]
    assert len(rows) == 3
    assert all(row.count("&=") == 1 for row in rows)
    assert all(row.endswith(r" \\") for row in rows[:-1])
    assert r"\text{mm}" in rows[-1]


def test_latex_escapes_units() -> None:
    text = why_latex(derive("variables\n  p = 5 [%]\n  q [m^2]\nrules\n  q = p", "q"))
    assert r"\text{\%}" in text and r"\text{m\^{}2}" in text


@pytest.mark.parametrize(
    ("rule", "latex"),
    [
        ("y = -a*b/c", r"y &= - \frac{a b}{c}"),
        ("y = 1*(-1)/c", r"y &= - \frac{1}{c}"),
        ("y = a/b*c/2", r"y &= \frac{a c}{b \cdot 2}"),
        ("y = a^(1/3)", r"y &= a^{\frac{1}{3}}"),
        ("y = -(a/b)", r"y &= - \frac{a}{b}"),
        ("y = a - (-b)*c", r"y &= a - \left(- b c\right)"),
        ("if given('x) then y = x else y = 1", r"\text{if } \text{given } x"),
    ],
)
def test_quotients_are_fractions(rule: str, latex: str) -> None:
    from rulesheets.algebra import listing

    assert latex in listing(rulesheets.loads(rule), latex=True)


# --- the command ----------------------------------------------------------------

Run = Callable[..., tuple[int, str, str]]


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    sheet = tmp_path / "lens.tk"
    sheet.write_text(LENS)

    def run(*words: str) -> tuple[int, str, str]:
        code = main(["why", str(sheet), *words])
        out, err = capsys.readouterr()
        return code, out, err

    return run


def test_the_command_prints_the_chain(run: Run) -> None:
    code, out, _ = run("v", "--set", "u=200")
    assert code == 0
    assert out.startswith("v = 66.66666667 mm, from 2 inputs by 1 of 3 rules\n")
    assert run("v", "--latex")[1].startswith("\\begin{align*}")
    assert run("v", "--markdown")[1].startswith("`v = ")


def test_the_command_says_that_a_name_is_an_input(run: Run) -> None:
    assert run("f") == (0, "f = 50 mm is an input\n", "")


def test_the_command_says_why_there_is_no_value(run: Run) -> None:
    code, out, _ = run("v", "--clear", "f")
    assert code == 1
    assert out.startswith("v has no value\n\nerror[S510]")
    assert run("v", "--clear", "f", "--latex")[1].startswith("v has no value")


def test_an_unknown_name_is_a_mistake_of_the_command(run: Run) -> None:
    code, out, err = run("V")
    assert (code, out) == (2, "")
    assert "did you mean v?" in err


def test_forms_exclude_each_other(run: Run) -> None:
    assert run("v", "--latex", "--markdown")[0] == 2
