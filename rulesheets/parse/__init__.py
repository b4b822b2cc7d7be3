"""Text → RuleSheet: logical lines (layout), sections, and the content of each line (grammar)."""
