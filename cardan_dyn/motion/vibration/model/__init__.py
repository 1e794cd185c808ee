"""Model: the equation of free coordinates along a motion, and its linear modes."""
