"""Exact derivatives of outputs with respect to inputs, and what tolerances make of them."""
