"""Units: texts, exact conversion, and the check of dimensions. A solve never sees one."""

from rulesheets.units.library import Library, library
from rulesheets.units.text import UnitError
from rulesheets.units.unit import Unit, convert

__all__ = ["Library", "Unit", "UnitError", "convert", "library"]
