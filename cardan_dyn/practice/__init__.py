"""Practice: drive lines, studies, reports, scenes and the command line."""
