"""Steps and blocks to many digits."""
