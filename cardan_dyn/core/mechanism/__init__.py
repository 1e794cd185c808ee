"""Mechanism: Pinocchio's model of the tree, a weld per loop, and the layout of coordinates."""
