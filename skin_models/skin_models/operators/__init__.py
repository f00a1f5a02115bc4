"""Numerical operators that several effects share, each over a whole array at once and one sample at a time."""
