"""The chart of speed against accuracy, and of stability over an input: as a table, as CSV, and drawn."""
