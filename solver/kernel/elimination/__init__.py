"""Blocks that elimination settles: linear, polynomial, by formula, or contradictory whatever the values."""
