"""Command line: `cardan-dyn`."""
