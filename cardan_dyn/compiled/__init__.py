"""Compiled: the machine that runs what was traced, in C.

NumPy runs it where the extension is not at hand: it is built while the package is installed, if
there is a compiler. Setting the environment variable `CARDAN_DYN_COMPILED=0` does without it.
Results agree but for rounding. `cardan-dyn --version` says whether it is used, and why not.
"""

from __future__ import annotations

import os
import warnings
import zlib
from importlib import import_module
from pathlib import Path
from typing import Any


def _found() -> tuple[Any, str]:
    """Return the module of compiled functions and an empty text, or None and why there is none."""
    if os.environ.get("CARDAN_DYN_COMPILED") == "0":
        return None, "switched off by CARDAN_DYN_COMPILED=0"
    try:
        found = import_module("._kernel", __name__)
    except ModuleNotFoundError:
        return None, "this installation has none"
    except ImportError as error:
        return None, _missed(f"they cannot be loaded: {error}; install the package again")
    # A checkout has the sources, which may have changed since; a wheel has not.
    sources = sorted(Path(__file__).parent.glob("*.[ch]"))
    checksum = zlib.crc32(b"".join(path.read_bytes() for path in sources))
    if sources and getattr(found, "sources", None) != checksum:
        why = "they were made of other sources; compile them again: python hatch_build.py"
        return None, _missed(why)
    return found, ""


def _missed(why: str) -> str:
    warnings.warn(f"without compiled functions, {why}", RuntimeWarning, stacklevel=2)
    return why


kernel: Any
"""The module of compiled functions; None where they are not at hand."""
absent: str
"""Why they are not at hand; empty if they are."""
kernel, absent = _found()
