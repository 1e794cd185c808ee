"""Problem: what is to be solved, checked against the mechanism, as frozen data."""
