"""Drawings, plots and charts: the one room of matplotlib, entered by commands and the page alone."""
