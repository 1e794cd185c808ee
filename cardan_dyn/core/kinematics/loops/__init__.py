"""Loops: which joints they depend on, and the order in which groups of them are solved."""
