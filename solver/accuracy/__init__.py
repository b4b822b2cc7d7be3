"""Whether the rules hold at an answer, and how far it may be off."""
