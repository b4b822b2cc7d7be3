"""What a solve came to, in the user's names and places, and what would cure it."""
