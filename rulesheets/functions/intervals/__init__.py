"""Interval forms of the functions: on one box of floats (``forms``), on arrays of boxes (``arrays``)."""
