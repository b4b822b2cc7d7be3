"""A path followed to every answer, case by case, with more digits where floats do not tell."""
