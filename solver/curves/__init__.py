"""Sweeps that follow the curve of answers through its turning points, one branch after another.

core: which unknowns the curve has to be followed in   system: their rules as a problem of numbers
tracing: from a seed to a branch                       rows: points of a branch as rows of a table
following: all branches over the range of a sweep
"""
