"""Which of several answers comes first, from their numbers alone."""
