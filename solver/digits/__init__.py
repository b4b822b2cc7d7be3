"""Rules in many decimal digits: Newton's method on a few of them, and double roots told from two."""
