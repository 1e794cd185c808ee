"""Read: find a description, and choose the reader of its notation."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from .errors import ModelError, choices

if TYPE_CHECKING:
    from .description import Description


def bundled_directory() -> Path:
    """Return the directory of the bundled descriptions.

    A wheel carries it inside the package; in a checkout it stands beside the package.
    """
    inside = Path(__file__).parent / "urdf"
    return inside if inside.is_dir() else Path(__file__).parent.parent / "urdf"


def bundled_names() -> list[str]:
    """Return the names of the bundled descriptions that `load` accepts."""
    return sorted(path.stem for path in bundled_directory().glob("*.urdf"))


def read(source: str | os.PathLike[str], strict: bool = True) -> Description:
    """Read a bundled description by name, a file by path, or URDF text.

    Args:
        source: name in `bundled_names()`, path, or text that starts with `<`.
        strict: whether inertias that no body can have are refused.

    A file's loops may be written in URDF+ notation (`<loop>`, `<coupling>`), in that of NVIDIA
    Isaac (`<loop_joint>`), in Gepetto's YAML file of the same name beside the URDF, or as
    `<equality>` of an MJCF file.

    Raises:
        ModelError: what is wrong, where, and the valid choices.
    """
    if not isinstance(source, (str, os.PathLike)):
        raise ModelError(
            f"load() takes a name, a path or URDF text, not {type(source).__name__}; "
            f"bundled descriptions: {choices(bundled_names())}"
        )
    if isinstance(source, str) and source.lstrip("\ufeff \t\r\n").startswith("<"):
        return _parse(source.lstrip("\ufeff \t\r\n"), "URDF text", None, strict)
    path = _find(os.fspath(source))
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise ModelError(f"{path}: cannot be read as text ({error})") from error
    return _parse(text, str(path), path, strict)


def _parse(text: str, where: str, path: Path | None, strict: bool) -> Description:
    from xml.etree import ElementTree

    from . import urdf
    from .description import SourceText

    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        raise ModelError(f"{where}: malformed XML: {error}") from error
    if root.tag == "mujoco":
        from . import mjcf

        return replace(mjcf.parse(root, text, where, path, strict), source=SourceText(text, path))
    if root.tag != "robot":
        raise ModelError(
            f"{where}: the outermost element is <{root.tag}>, expected <robot> or <mujoco>"
        )
    return replace(urdf.parse(root, where, path, strict), source=SourceText(text, path))


def _find(name: str) -> Path:
    bundled = bundled_directory() / f"{name}.urdf"
    if name in bundled_names():
        return bundled
    path = Path(name)
    try:
        found = path.is_file()
    except (OSError, ValueError):
        found = False
    if not found:
        raise ModelError(
            f"no description {name!r}: it is neither a file nor a bundled name; "
            f"bundled descriptions: {choices(bundled_names())}"
        )
    return path
