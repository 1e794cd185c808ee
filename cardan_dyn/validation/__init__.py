"""Validation: bundled mechanisms against the closed forms of the literature."""
