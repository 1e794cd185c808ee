"""Core: what is given, what is asked, what is found and whether it is right."""
