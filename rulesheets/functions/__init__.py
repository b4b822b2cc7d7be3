"""The functions of the language: a row each, with its values, slopes, inverse, ranges and traits.

``TABLE`` and ``PLANNED`` cost little to import. The forms for arrays (``arrays``, ``intervals.arrays``), for
many digits and for balls (``evaluate.digits``, ``evaluate.balls``) stand in modules of their own, because
each needs a heavy library.
"""

from rulesheets.functions.row import Function, Inverse
from rulesheets.functions.table import PLANNED, TABLE, named

__all__ = ["PLANNED", "TABLE", "Function", "Inverse", "named"]
