"""Mechanics: the equations of one sample of a mechanism, as arithmetic on scalars and 3-vectors."""
