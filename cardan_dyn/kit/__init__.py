"""Kit: what every storey uses, and nothing of mechanics."""
