"""Prepared plans as records of a solve: each answer's steps as one straight-line program, with
guards."""
