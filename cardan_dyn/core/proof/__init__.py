"""Proof: a result checked from the description alone, by nothing that took part in solving it."""
