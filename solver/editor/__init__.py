"""What an editor asks of a sheet: its words, their meaning, and the language server that tells both."""
