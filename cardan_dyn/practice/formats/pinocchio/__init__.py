"""Models that Pinocchio has loaded, and their constraints."""
