"""Checks whether the rules hold at an answer, and estimates its errors."""
