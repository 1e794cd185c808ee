"""What messages name exists: classes and their attributes, functions, arguments, options, files."""

from __future__ import annotations

import ast
import inspect
import re
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import click
import pytest

from cardan_dyn.practice.command_line.commands import main

ROOT = Path(__file__).parents[1]
PACKAGES = (
    "cardan_dyn",
    "cardan_dyn.analytic",
    "cardan_dyn.clearance",
    "cardan_dyn.drive_lines",
    "cardan_dyn.figures",
    "cardan_dyn.studies",
    "cardan_dyn.core.tape",
    "cardan_dyn.vibration",
)
OTHERS = {"np", "plt", "axes", "stats", "data", "dir", "cos", "atan2", "max", "abs", "dict"}
"""Names of others that messages say, by themselves or in front of a point."""
ADDED = {"cd.StribeckFriction"}
"""Names that exist only once the changes of a page are made."""
OTHER_OPTIONS = {"--expand-auto-inertials"}
OTHER_PARAMETERS = {"subplot_kw", "charset"}
"""Options of other programs, and arguments of other functions."""


@cache
def public() -> dict[str, Any]:
    """Everything that a package lists for others to import, by its name."""
    found: dict[str, Any] = {}
    for package in PACKAGES:
        module = import_module(package)
        found |= {name: getattr(module, name) for name in module.__all__}
    return found


@cache
def classes() -> dict[str, type]:
    return {name: item for name, item in public().items() if inspect.isclass(item)}


@cache
def attributes(item: type) -> set[str]:
    """Names of methods, properties and fields of a class, or what its docstring lists."""
    fields = {name for base in item.__mro__ for name in vars(base).get("__annotations__", {})}
    texts = [inspect.getdoc(base) or "" for base in item.__mro__]
    listed = re.findall(r"^ {4}([\w, ]+):", "\n".join(texts), re.MULTILINE)
    return fields | set(dir(item)) | {name.strip() for line in listed for name in line.split(",")}


@cache
def members() -> set[str]:
    return {name for item in classes().values() for name in attributes(item)}


@cache
def parameters() -> set[str]:
    """Names of the arguments of all public callables."""
    callables = list(public().values())
    for item in classes().values():
        callables += [getattr(item, name, None) for name in dir(item) if not name.startswith("__")]
    # Methods that draw are found at the objects that results have as `plot`.
    for path in (ROOT / "cardan_dyn").rglob("plot*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef):
                names = [*node.args.args, *node.args.kwonlyargs]
                callables.append({argument.arg for argument in names})
    found: set[str] = set()
    for item in callables:
        if isinstance(item, set):
            found |= item
        elif callable(item):
            try:
                found |= set(inspect.signature(item).parameters)
            except (TypeError, ValueError):
                continue
    return found


def commands(group: click.Group) -> Iterator[click.Command]:
    for command in group.commands.values():
        yield command
        if isinstance(command, click.Group):
            yield from commands(command)


OPTIONS = {
    name
    for command in (main, *commands(main))
    for option in command.params
    for name in (*option.opts, *option.secondary_opts)
} | {"--help", "--version"}
COMMANDS = {command.name for command in commands(main)}


@cache
def trees() -> dict[Path, ast.Module]:
    return {
        path.relative_to(ROOT): ast.parse(path.read_text(encoding="utf-8"))
        for path in sorted((ROOT / "cardan_dyn").rglob("*.py"))
    }


def messages() -> Iterator[tuple[str, str]]:
    """Yield where a text stands and the text, of all that are raised, warned of or told."""
    for path, tree in trees().items():
        nodes = list(ast.walk(tree))
        # Docstrings are expressions that nothing uses.
        docstrings = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        strings = (node for node in nodes if isinstance(node, ast.JoinedStr))
        parts = {id(value) for node in strings for value in node.values}
        for node in nodes:
            if id(node) in docstrings:
                continue
            where = f"{path}:{getattr(node, 'lineno', 0)}"
            if isinstance(node, ast.JoinedStr):
                said = [
                    str(value.value) if isinstance(value, ast.Constant) else "{}"
                    for value in node.values
                ]
                yield where, "".join(said)
            elif (
                isinstance(node, ast.Constant)
                and isinstance(node.value, str)
                and id(node) not in parts
            ):
                yield where, node.value


def wrong_members(text: str) -> Iterator[str]:
    """Yield classes with members, and names of the package, that do not exist."""
    for name, member in re.findall(r"\b([A-Z]\w+)\.(?!md\b)([a-z]\w*)", text):
        if name in classes() and member not in attributes(classes()[name]):
            yield f"{name}.{member}"
    for name, member in re.findall(r"\bcd\.([a-zA-Z]\w*)(?:\.([a-zA-Z]\w*))?", text):
        if name not in public() or (member and member not in members_of(public()[name])):
            yield f"cd.{name}{f'.{member}' if member else ''}"


def members_of(item: object) -> set[str]:
    """Names behind a point after a public name, sub-packages included."""
    packages = {package.rpartition(".")[2] for package in PACKAGES} | {"drawing"}
    return attributes(item) if inspect.isclass(item) else set(dir(item)) | packages


def wrong_names(text: str) -> Iterator[str]:
    """Yield what a text names that does not exist."""
    yield from wrong_members(text)
    for name in re.findall(r"`([a-z]\w*)`", text):
        if not any(name in known for known in (public(), members(), parameters())):
            yield f"`{name}`"
    # Attributes of XML have quotes, and what the command line takes is in capitals.
    is_call = '="' not in text and "<" not in text and not re.match(r"[A-Z]+=", text)
    for name in re.findall(r"(?<![\w.{}])([a-z]\w*)=(?!=)", text) if is_call else ():
        if name not in parameters() | OTHER_PARAMETERS and " as " not in text:
            yield f"{name}="
    for owner, name in re.findall(r"(?:\b(\w+)(?:\[\S*\])?\.)?\b([a-z]\w+)\((?!s\))", text):
        if owner not in OTHERS and not any(
            name in known for known in (public(), members(), OTHERS)
        ):
            yield f"{name}()"
    for option in re.findall(r"(?<![\w-])--[a-z][a-z-]+", text):
        if option not in OPTIONS | OTHER_OPTIONS:
            yield option
    for command in re.findall(r"cardan-dyn ([a-z]+)", text):
        if command not in COMMANDS:
            yield f"cardan-dyn {command}"
    for page in re.findall(r"docs/[\w/]+\.md", text):
        if not (ROOT / page).is_file():
            yield page


@pytest.mark.slow
def test_every_name_in_a_message_exists() -> None:
    texts = [item for item in messages() if " " in item[1] and not item[1].startswith("<")]
    wrong = [f"{where}: {name}" for where, text in texts for name in wrong_names(text)]
    assert not wrong, "\n" + "\n".join(wrong)


PAGES = [ROOT / "README.md", ROOT / "cardan_dyn/AGENTS.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_name_on_a_page_exists(page: Path) -> None:
    assert not sorted(set(wrong_members(page.read_text(encoding="utf-8"))) - ADDED)


@pytest.mark.slow
def test_every_name_in_a_docstring_exists() -> None:
    wrong = []
    for path, tree in trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                names = wrong_members(ast.get_docstring(node) or "")
                wrong += [f"{path}: {name}" for name in names]
    assert not wrong, "\n" + "\n".join(wrong)


@pytest.mark.parametrize(
    "text",
    [
        "positions such as `Mechanism.assembled` finds",
        "see `cd.assembled`",
        "give surplus= to it",
        "call sweeped() first",
        "run cardan-dyn swept",
        "add --clearence to it",
        "see docs/nowhere.md",
        "an attribute of `nobody`",
    ],
)
def test_names_that_do_not_exist_are_found(text: str) -> None:
    assert len(list(wrong_names(text))) == 1
