"""MJCF: MuJoCo's notation to a description, by a reader of its own."""
