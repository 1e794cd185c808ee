"""Extension of the site: a page for each public name, written from its docstring at each build."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from write_pages import interface

PACKAGES = (
    "cardan_dyn",
    "cardan_dyn.analytic",
    "cardan_dyn.clearance",
    "cardan_dyn.motion.clearance.drawing",
    "cardan_dyn.drive_lines",
    "cardan_dyn.figures",
    "cardan_dyn.studies",
    "cardan_dyn.vibration",
)


def public() -> Iterator[tuple[str, str, Any]]:
    """Yield the package, name and object of everything that users import."""
    for package in PACKAGES:
        module = import_module(package)
        for name in module.__all__:
            item = getattr(module, name)
            if not name.startswith("_") and getattr(item, "__name__", None) not in PACKAGES:
                yield package, name, item


def page(package: str, name: str, item: Any, is_first: bool) -> str:
    """Return the page of a public name; only the first page of a thing is one to be linked to."""
    full = f"{package}.{name}"
    lines = [f"# {name}", "", "```{eval-rst}", f".. currentmodule:: {package}", ""]
    if inspect.ismodule(item):
        lines += [f".. automodule:: {item.__name__}", "   :members:"]
    elif inspect.isclass(item):
        lines += [f".. autoclass:: {full}", "   :members:"]
        lines.append("   :inherited-members: Exception,tuple")
    elif callable(item):
        lines += [f".. autofunction:: {full}"]
    else:
        lines += [f".. autodata:: {full}"]
    if not is_first:
        lines.append("   :no-index:")
    return "\n".join([*lines, "```", ""])


def index() -> str:
    """Return the page that lists all public names in one line each."""
    hidden = [f"{package}.{name}" for package, name, _ in public()]
    return "\n".join([interface(linked=True), "```{toctree}", ":hidden:", *hidden, "```", ""])


def write(app: Any) -> None:
    """Write pages that have changed, and remove those of names that are gone."""
    folder = Path(app.srcdir) / "api"
    folder.mkdir(exist_ok=True)
    pages: dict[str, str] = {}
    known: set[int] = set()
    for package, name, item in public():
        pages[f"{package}.{name}.md"] = page(package, name, item, id(item) not in known)
        known.add(id(item))
    pages["index.md"] = index()
    for path in folder.glob("*.md"):
        if path.name not in pages:
            path.unlink()
    for name, text in pages.items():
        path = folder / name
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


def as_markdown(app: Any, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    """Read backticks and bars of docstrings as Markdown does: code, and plain bars."""
    text = re.sub(r"(?<!`)`([^`]+)`(?!`)", r"``\1``", "\n".join(lines))
    parts = re.split(r"(``.*?``)", text, flags=re.DOTALL)
    lines[:] = "".join(
        part if part.startswith("``") else part.replace("|", "\\|") for part in parts
    ).split("\n")


def as_text(app: Any, what: str, name: str, item: Any, options: Any, lines: list[str]) -> None:
    """Keep the first line of a property whole: what precedes a colon would become its type."""
    if what in {"property", "attribute", "data"} and lines and not lines[0].startswith(":"):
        lines[0] = f": {lines[0]}"  # As if the type were empty.


def without_aliases(
    app: Any, what: str, name: str, item: Any, skip: bool, options: Any
) -> bool | None:
    """Leave out fields of named tuples: the class has them in its signature and its docstring."""
    return True if type(item).__name__ == "_tuplegetter" else None


def setup(app: Any) -> dict[str, bool]:
    """Join the build."""
    app.connect("builder-inited", write)
    # Before Napoleon, which listens with 500.
    app.connect("autodoc-process-docstring", as_text, priority=400)
    app.connect("autodoc-process-docstring", as_markdown)
    app.connect("autodoc-skip-member", without_aliases)
    return {"parallel_read_safe": True}
