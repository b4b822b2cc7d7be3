"""Follows a path to every answer, case by case; determines status, messages and remedies."""
