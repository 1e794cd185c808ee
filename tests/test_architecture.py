"""The architecture: imports run one way."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "cardan_dyn"

FLOORS = (
    ("_version", "arrays", "errors"),
    ("checks", "frozen", "markup"),
    ("description", "forces"),
    ("mechanism",),
    ("elements",),
    ("problem", "proof"),
    ("kinematics",),
    ("dynamics",),
    ("results",),
    ("response", "simulation"),
    ("viewer",),
    ("scene",),
    ("validation", "drive_lines", "clearance"),
    ("figures",),
    ("vibration",),
    ("report",),
    ("command_line",),
)
"""The rooms of `docs/architecture.md`, from the ground up: each may import from lower floors."""
ON_FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
FILES = sorted(PACKAGE.rglob("*.py"))
TESTS = sorted((ROOT / "tests").rglob("test_*.py"))


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports(path: Path) -> set[str]:
    """Modules of the package that a file imports anywhere: lazily, or for its types alone."""
    own = list(path.relative_to(ROOT).with_suffix("").parts)
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            base = own[: len(own) - node.level] if node.level else []
            source = [*base, *(node.module or "").split(".")] if node.module else base
            name = ".".join(source)
            for alias in node.names:
                inside = f"{name}.{alias.name}"
                found.add(inside if inside in MODULES else name)
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return {name for name in found if name.startswith("cardan_dyn")}


MODULES = {module_of(path) for path in FILES}
GRAPH = {
    module_of(path): imports(path)
    for path in FILES
    if path.parent != PACKAGE or path.name != "__init__.py"
}


def room_of(module: str) -> str:
    return module.split(".")[1]


@pytest.mark.parametrize("module", sorted(GRAPH))
def test_imports_run_down(module: str) -> None:
    above = {
        other
        for other in GRAPH[module]
        if other == "cardan_dyn"
        or (
            room_of(other) != room_of(module)
            and ON_FLOOR[room_of(other)] >= ON_FLOOR[room_of(module)]
        )
    }
    assert not above


def test_no_module_imports_itself_by_way_of_others() -> None:
    done: set[str] = set()

    def visit(module: str, path: tuple[str, ...]) -> None:
        assert module not in path, " -> ".join((*path, module))
        if module not in done:
            for other in sorted(GRAPH.get(module, set())):
                visit(other, (*path, module))
            done.add(module)

    for module in sorted(GRAPH):
        visit(module, ())


def test_the_proof_takes_nothing_from_what_it_proves() -> None:
    rooms = {
        room_of(other) for module in GRAPH if room_of(module) == "proof" for other in GRAPH[module]
    }
    assert rooms <= {
        "proof",
        "errors",
        "arrays",
        "checks",
        "frozen",
        "description",
        "forces",
        "mechanism",
        "elements",
    }


def test_every_module_is_in_the_architecture() -> None:
    rooms = {
        path.name.removesuffix(".py")
        for path in PACKAGE.iterdir()
        if path.suffix == ".py" or (path / "__init__.py").is_file()
    } - {"__init__"}
    assert rooms == set(ON_FLOOR)
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| (`.*?) \| (.*) \|$", text, re.MULTILINE))
    known = {}
    for names, contents in rows.items():
        for room in re.findall(r"`(\w+)`", names):
            known[room] = set(re.findall(r"`(\w+)`", contents))
    missing = {
        str(path.relative_to(PACKAGE))
        for path in FILES
        if path.stem != "__init__" and path.parent != PACKAGE
        if path.stem not in known[path.relative_to(PACKAGE).parts[0]]
    }
    assert not missing
    assert rooms == set(known)


def test_no_test_imports_another_test() -> None:
    names = {path.stem for path in TESTS}
    for path in TESTS:
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                assert not names & {*(node.module or "").split("."), *(a.name for a in node.names)}
            elif isinstance(node, ast.Import):
                assert not names & {part for a in node.names for part in a.name.split(".")}
