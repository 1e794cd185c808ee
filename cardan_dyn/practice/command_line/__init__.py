"""Command line: `cardan-dyn`."""

from .commands import main

__all__ = ["main"]
