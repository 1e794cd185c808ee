"""Forces: what acts on a mechanism from outside."""
