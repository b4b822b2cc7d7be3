"""The rule sheet language: text in, equations out."""
