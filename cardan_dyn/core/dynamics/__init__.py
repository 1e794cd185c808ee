"""Dynamics: wrenches and efforts of closed positions, and what statics leaves open."""
