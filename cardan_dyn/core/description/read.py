"""Read: find a description, and choose the reader for its notation."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING

from ...kit.checks import described, flag, shortened
from ...kit.errors import ArgumentError, ModelError, choices

if TYPE_CHECKING:
    from .description import Description

_MOST_BUNDLED = 100
"""Bundled descriptions that messages list: all of them, since nothing else names them."""
_BLANK = "\ufeff \t\r\n"
"""What may stand before a text's first element."""


@cache
def bundled_directory() -> Path:
    """Return the directory of the bundled descriptions.

    A wheel carries it inside the package; in a checkout it stands beside the package.
    """
    package = Path(__file__).parents[2]
    inside = package / "urdf"
    return inside if inside.is_dir() else package.parent / "urdf"


def bundled_names() -> list[str]:
    """Return the names of the bundled descriptions that `load` accepts."""
    return sorted(path.stem for path in bundled_directory().glob("*.urdf"))


def read(
    source: str | os.PathLike[str], strict: bool = True, model: str | None = None
) -> Description:
    """Read a bundled description by name, a file by path, or text.

    A file's loops may be written in URDF+ notation (`<loop>`, `<coupling>`), in that of NVIDIA
    Isaac (`<loop_joint>`), as `<constraint>` proposed for ROS, as closing frames of
    onshape-to-robot, in Gepetto's YAML file of the same name beside the URDF, in a file
    `loop_closures.yaml` there, as `<equality>` of an MJCF file, or as joints of an SDF file that
    do not belong to its tree.

    Args:
        source: name in `bundled_names()`, path, or text that starts with `<`.
        strict: whether to refuse what is probably wrong: inertias that no body can have, misspelled
            words of a URDF or SDF file, forces in an MJCF or SDF file that no wrench considers.
        model: name of the one to read of an SDF file that has several.

    Raises:
        ModelError: what is wrong, where, and the valid choices.
        ArgumentError: `strict` is neither True nor False, or the name is no text.
    """
    strict = flag("strict", strict)
    if model is not None and not isinstance(model, str):
        raise ArgumentError(f"model is the name of one of an SDF text, not {described(model)}")
    if isinstance(source, str) and source.lstrip(_BLANK).startswith("<"):
        return _parse(source.lstrip(_BLANK), "text", None, strict, model)
    path = _find(_name(source))
    if path.suffix == ".toml":
        raise ModelError(
            f"{path} is TOML, which describes drive lines and no mechanism: use "
            "`cardan-dyn driveline`, or DriveLine.from_toml"
        )
    from .elements import file_text

    return _parse(file_text(path, str(path)), str(path), path, strict, model)


def _parse(
    source: str | bytes, where: str, path: Path | None, strict: bool, model: str | None
) -> Description:
    from . import urdf
    from .description import GUESTS, SourceText
    from .elements import xml_root
    from .left_out import dynamics_left_out, limits_left_out

    root, text = xml_root(source, where)
    if model is not None and root.tag != "sdf":
        raise ArgumentError(f"{where}: only SDF has several models; leave out model=")
    guest = GUESTS.get(root.tag, "")
    if not guest and root.tag != "robot":
        others = " or ".join(f"<{tag}>" for tag in GUESTS)
        raise ModelError(
            f"{where}: the outermost element is <{root.tag}>, expected <robot>, {others}"
        )
    if path is None:
        where = f"{guest.rpartition('.')[2].upper() or 'URDF'} text"
    reader = import_module(f"{guest}.reader") if guest else urdf
    given = SourceText(text, path, model=model, guest=guest)
    description: Description = reader.parse(root, given, where, strict)
    warnings = (
        *description.warnings,
        *dynamics_left_out(description.joints_and_loops, where),
    )
    # The bundled files have limits only because URDF demands them of hinges and slides.
    if path is None or path.parent != bundled_directory():
        warnings += tuple(limits_left_out(description.joints, where))
    return replace(description, warnings=warnings)


def _name(source: object) -> str:
    """Return a name or path as a string."""
    try:
        name = os.fspath(source)  # type: ignore[call-overload]
    except Exception:  # The path may be an object of any class, which may raise anything.
        name = None
    if isinstance(name, str):
        return str(name)
    raise ModelError(
        f"load() takes a name, a path or text, not {type(source).__name__}; "
        f"bundled descriptions: {choices(bundled_names(), most=_MOST_BUNDLED)}"
    )


def _find(name: str) -> Path:
    bundled = bundled_directory()
    if f"{name}.urdf" in os.listdir(bundled):  # noqa: PTH208  # A path for each takes ten times as long.
        return bundled / f"{name}.urdf"
    path = Path(name)
    try:
        exists = path.is_file()
    except (OSError, ValueError):  # A name that is too long, or contains a null character.
        exists = False
    if not exists:
        raise ModelError(
            f"no description {shortened(repr(name))}: it is neither a file nor a bundled name; "
            f"bundled descriptions: {choices(bundled_names(), name, most=_MOST_BUNDLED)}"
        )
    return path
