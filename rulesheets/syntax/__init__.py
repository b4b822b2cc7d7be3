"""Rules as trees: where they stand, what they are made of, and how they are walked."""
