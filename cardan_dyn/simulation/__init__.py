"""Simulation: the motion of what is not prescribed, with the wrenches along the way."""
