"""Closing: the equations of loops, solved by Newton's method for many samples at once."""
