"""Formats: notations beside URDF, guests of the core.

`sdf`, `mjcf` (by MuJoCo's own parser and compiler, and back) and `pinocchio` (`from_pinocchio`)
each have a `reader`, and a `second_reading` for the proof that shares nothing with it and places
what it finds by `renumbered`. The core names those of texts in `GUESTS`. `together` adds masses up.
Shapes of links are read from the text only when they are shown (`visuals`, those of URDF as well),
each a `visual`; files of meshes are the viewer's business.
"""
