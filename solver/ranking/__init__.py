"""Which of several answers comes first, told from their numbers alone."""
