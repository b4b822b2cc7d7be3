"""Blocks that are searched: over the range of a tear, box by box, from many starts, and for curves."""
