"""Units: texts, exact conversion, and the check of dimensions. A solve never sees one."""

from rulesheets.library import Library, Unit, UnitError, convert, library

__all__ = ["Library", "Unit", "UnitError", "convert", "library"]
