"""How a line is best: where its forks stand, and its lengths and places."""
