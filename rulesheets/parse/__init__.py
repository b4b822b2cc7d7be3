"""Text → RuleSheet: lines (layout), sections, and what each line says (grammar, builder).

``parse`` raises RuleSheetError with a diagnosis for every line that is wrong.
"""

from rulesheets.parse.sections import parse

__all__ = ["parse"]
