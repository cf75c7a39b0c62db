"""Practice with known truth: exercises, their grading, and what becomes of it over time."""
