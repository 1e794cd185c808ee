"""Builds the compiled functions with the wheel, if there is a compiler; else does without them.

`python hatch_build.py` and editable installations build them in place, wheels leave the sources
as they are. With `CARDAN_DYN_COMPILED=0` in the environment a wheel has none, and serves every
machine.
"""

from __future__ import annotations

import os
import sys
import tempfile
import zlib
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

ROOT = Path(__file__).resolve().parent
SOURCES = ROOT / "cardan_dyn" / "core" / "compiled"


def checksum() -> int:
    """Return what tells these sources from others; `cardan_dyn.core.compiled` compares it."""
    return zlib.crc32(b"".join(path.read_bytes() for path in sorted(SOURCES.glob("*.[ch]"))))


def build(folder: Path) -> Path:
    """Compile the extension into a folder, and return it.

    Raises:
        Exception: of setuptools, if there is no compiler, or it fails.
    """
    from setuptools import Distribution, Extension

    extension = Extension(
        "cardan_dyn.core.compiled._kernel",
        sorted(str(path) for path in SOURCES.glob("*.c")),
        define_macros=[("Py_LIMITED_API", "0x030b0000"), ("SOURCES", f"{checksum()}LL")],
        # Sums of products are rounded alike on all processors. No names of files for debuggers.
        extra_compile_args=["-O3", "-std=c11", "-ffp-contract=off", "-fno-math-errno", "-g0"],
        py_limited_api=True,
    )
    distribution = Distribution({"name": "cardan_dyn", "ext_modules": [extension]})
    command = distribution.get_command_obj("build_ext")
    with tempfile.TemporaryDirectory() as temporary:
        command.build_lib, command.build_temp = temporary, temporary
        command.force = True
        command.ensure_finalized()
        command.run()
        built = Path(command.get_ext_fullpath(extension.name))
        # What a running process has mapped must not change under it, nor be seen half written.
        target = folder / built.name
        whole = folder / f"{built.name}.{os.getpid()}"
        try:
            whole.write_bytes(built.read_bytes())
            whole.replace(target)
        finally:
            whole.unlink(missing_ok=True)
    return target


class CompiledFunctions(BuildHookInterface):
    """Adds the extension to a wheel."""

    PLUGIN_NAME = "custom"
    _temporary: tempfile.TemporaryDirectory[str] | None = None

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build it, and say for what machines the wheel is."""
        if os.environ.get("CARDAN_DYN_COMPILED") == "0":
            return
        self._temporary = tempfile.TemporaryDirectory()
        try:
            built = build(SOURCES if version == "editable" else Path(self._temporary.name))
        except Exception as error:
            self.app.display_warning(f"without compiled functions, so NumPy does it all: {error}")
            return
        from packaging.tags import sys_tags

        # Which Linux it runs on is for those to say who repair wheels.
        platforms = (tag.platform for tag in sys_tags())
        platform = next(name for name in platforms if not name.startswith(("many", "musl")))
        build_data["pure_python"] = False
        build_data["tag"] = f"cp311-abi3-{platform}"
        if version != "editable":
            build_data["force_include"][str(built)] = f"cardan_dyn/core/compiled/{built.name}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove what is in the wheel now."""
        if self._temporary is not None:
            self._temporary.cleanup()


if __name__ == "__main__":
    sys.exit(print(build(SOURCES)))
