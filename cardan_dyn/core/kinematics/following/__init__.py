"""Following: from one closed configuration to others, without leaving the assembly mode."""
