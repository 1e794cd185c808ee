"""Names: what shells complete, without loading anything that computes."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path

import click
from click.shell_completion import CompletionItem

_PACKAGE = Path(__file__).parent.parent.parent
_LINES = _PACKAGE / "practice" / "drive_lines" / "line" / "examples"
_JOINT = re.compile(r"<(?:joint|loop|loop_joint|hinge|slide)\b[^>]*?\bname\s*=\s*[\"']([^\"']+)")
_COMMENT = re.compile(r"<!--(.*?)-->", re.DOTALL)

Completer = Callable[[click.Context, click.Parameter, str], list[CompletionItem]]


def mechanisms() -> dict[str, Path]:
    """Return the bundled mechanisms by name."""
    inside = _PACKAGE / "urdf"
    folder = inside if inside.is_dir() else _PACKAGE.parent / "urdf"
    return {path.stem: path for path in sorted(folder.glob("*.urdf"))}


def lines() -> dict[str, Path]:
    """Return the drive lines that come with the package by name."""
    return {path.stem: path for path in sorted(_LINES.glob("*.toml"))}


def about(path: Path) -> str:
    """Return the first sentence of the comment at the head of a bundled file."""
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".toml":
        head = re.match(r"(?:#.*\n)*", text)
        comment = re.sub(r"^# ?", "", head.group() if head else "", flags=re.MULTILINE)
    else:
        found = _COMMENT.search(text)
        comment = found.group(1) if found else ""
    words = " ".join(comment.split())
    return re.split(r"\s\(|:\s|(?<=[a-z°])\.(?:\s|$)", words, maxsplit=1)[0]


def joints(source: str) -> list[str]:
    """Return the names of joints and loops that a bundled or other file describes."""
    path = mechanisms().get(source, Path(source))
    try:
        if path.stat().st_size > 4_000_000:  # Somebody waits at a prompt.
            return []
        return list(dict.fromkeys(_JOINT.findall(path.read_text(encoding="utf-8"))))
    except (OSError, ValueError):
        return []


def complete_source(of: Callable[[], dict[str, Path]]) -> Completer:
    """Return what completes names of bundled files, and paths."""

    def complete(
        ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        known = [CompletionItem(name) for name in of() if name.startswith(incomplete)]
        return known or [CompletionItem(incomplete, type="file")]

    return complete


def complete_joint(
    ctx: click.Context, param: click.Parameter, incomplete: str
) -> list[CompletionItem]:
    """Complete names of joints of the mechanism before them; `=` and a value follow some."""
    ends = "=" if "=" in (param.make_metavar(ctx) or "") else ""
    # An option that still lacks its value keeps the others from being read.
    words = [ctx.params.get("source"), *os.environ.get("COMP_WORDS", "").split()[2:]]
    found = next((names for word in words if word and (names := joints(word))), [])
    return [CompletionItem(f"{name}{ends}") for name in found if name.startswith(incomplete)]
