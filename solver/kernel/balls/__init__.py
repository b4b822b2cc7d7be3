"""Roots proved in balls: existence, uniqueness, folds and double roots."""
