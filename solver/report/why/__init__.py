"""A derivation as text, Markdown or LaTeX: what was given, then each number with its rule."""

from solver.report.why.latex import why_latex
from solver.report.why.markdown import why_markdown
from solver.report.why.text import why_text

__all__ = ["why_latex", "why_markdown", "why_text"]
