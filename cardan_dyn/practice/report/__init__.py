"""Report: the bundled mechanisms against the closed forms of the literature, and pages."""
