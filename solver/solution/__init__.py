"""A path followed to every answer, case by case; what that comes to, in the user's names, and its cures."""
