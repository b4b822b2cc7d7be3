"""Sweeps that follow the curve of answers through its turning points, one branch after another."""
