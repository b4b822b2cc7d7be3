"""Equations and any well-posed set of inputs in, solution path and checked answers out."""
