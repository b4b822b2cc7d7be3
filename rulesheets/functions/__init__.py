"""The built-in functions: their values, derivatives, inverses and enclosures.

``TABLE`` and ``PLANNED`` cost nothing to import. The forms for arrays (``arrays``), for many
digits (``extended``) and for intervals (``intervals``) are modules of their own, because each
needs a heavy library.
"""

from rulesheets.functions.builtin import Builtin, Preimage
from rulesheets.functions.table import PLANNED, TABLE

__all__ = ["PLANNED", "TABLE", "Builtin", "Preimage"]
