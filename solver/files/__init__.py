"""Columns of numbers and symbols on disk: written as a whole or not at all, read in pieces."""
