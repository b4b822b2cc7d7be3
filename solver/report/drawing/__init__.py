"""Answers as pictures: the figures of a sheet, drawn to scale. The one room of matplotlib."""

from solver.report.drawing.picture import draw

__all__ = ["draw"]
