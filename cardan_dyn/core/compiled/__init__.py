"""Compiled: the machine that runs what was traced, and steps of an integrator, in C.

NumPy does both where the extension is not at hand: it is built while the package is installed, if
there is a compiler. Setting the environment variable `CARDAN_DYN_COMPILED=0` does without it.
Results agree but for rounding. `cardan-dyn --version` says whether it is used, and why not.

`kernel` is None where the extension was not built or cannot be loaded, or in a checkout is of other
sources than those beside it, as a checksum tells. `machine.c` goes along rows of eight integers
that say what is done with registers, each a number for every lane of a block of 4 or 32 (`run_one`
runs a single lane, as `stepping.c` does for the stages of a step). `machine.h` has the table of
operations, `machine_lanes.h` the text that is compiled for each set of instructions (AVX2, and what
every processor has) and each size of blocks; all round alike. A program is checked when it is made,
so that none that was damaged or made up leaves its memory. `lowering.c` makes the rows of a graph:
which instructions, in which registers. `stepping.c` is the twin of `Stepper._taken` of
`elements/stepping.py`, which says so. `kernels.h` lists what Python calls, `arrays.h` takes arrays
from it.
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
