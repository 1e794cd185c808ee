"""Viewer: mechanisms turning with their moments drawn on them, in meshcat.

Needs the extra `viz`.
"""
