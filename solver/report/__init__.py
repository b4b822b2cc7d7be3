"""What a person or a program reads of a solve: variable sheet, path, JSON, CSV."""
