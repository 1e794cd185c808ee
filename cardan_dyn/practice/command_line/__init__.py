"""Command line: `cardan-dyn`.

`command_line` turns words into calls. `commands` has the commands, long lists of options are in
`*_options`, what they do is in `*_command` and imported when it is called, so that `--help` and
completion load nothing that computes. `options` are shared, `quantities` reads numbers with units
that depend on a joint; `group` says how commands end, `tables` print at any width, `names` are what
shells complete.
"""

from .commands import main

__all__ = ["main"]
