"""Builds the compiled functions with the wheel, where there is a compiler; else does without them.

`python hatch_build.py` builds them in place.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ROOT = Path(__file__).resolve().parent
SOURCES = ROOT / "cardan_dyn" / "compiled"


def build() -> Path:
    """Compile the extension in place, and return it.

    Raises:
        Exception: of setuptools, if there is no compiler, or it fails.
    """
    from setuptools import Distribution, Extension

    extension = Extension(
        "cardan_dyn.compiled._kernel",
        sorted(str(path.relative_to(ROOT)) for path in SOURCES.glob("*.c")),
        depends=[str(path) for path in SOURCES.glob("*.h")],
        define_macros=[("Py_LIMITED_API", "0x030b0000")],
        # A sum of products is rounded alike on all processors.
        extra_compile_args=["-O3", "-std=c11", "-ffp-contract=off", "-fno-math-errno"],
        py_limited_api=True,
    )
    command = Distribution({"name": "cardan_dyn", "ext_modules": [extension]}).get_command_obj(
        "build_ext"
    )
    with tempfile.TemporaryDirectory() as temporary:
        command.inplace, command.build_temp = True, temporary
        command.ensure_finalized()
        command.run()
    return SOURCES / Path(command.get_ext_filename("_kernel"))


class CompiledFunctions(BuildHookInterface):
    """Adds the extension to the wheel."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build it, and say for what the wheel is."""
        if self.target_name != "wheel":
            return
        try:
            built = build()
        except Exception as error:
            self.app.display_warning(f"No compiled functions, NumPy does their work: {error}")
            return
        from packaging.tags import sys_tags

        build_data["pure_python"] = False
        build_data["tag"] = f"cp311-abi3-{next(sys_tags()).platform}"
        build_data["artifacts"].append(str(built.relative_to(ROOT)))


if __name__ == "__main__":
    sys.exit(print(build()))
