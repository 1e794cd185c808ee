"""What a line does and whether that is allowed: analysis, limits and rules."""
