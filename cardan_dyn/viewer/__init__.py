"""Viewer: mechanisms turning with their moments drawn on them, in meshcat.

Needs the extra `viz`.
"""

from .viewing import View, view

__all__ = ["View", "view"]
