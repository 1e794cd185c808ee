"""Report: the validation as table, figures, turning scenes and one page."""
