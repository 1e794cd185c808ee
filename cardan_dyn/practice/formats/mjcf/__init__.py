"""MJCF: MuJoCo's notation to a description, by MuJoCo's own parser and compiler, and back."""
