"""The architecture: imports run one way, and the core says what others may take of it."""

import ast
import re
from functools import cache
from pathlib import Path

import cardan_dyn
from cardan_dyn import core
from cardan_dyn.core.description.description import GUESTS

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "cardan_dyn"
COMPILED = PACKAGE / "core" / "compiled"
STOREYS = ("kit", "core", "motion", "practice")

FLOORS = (
    ("_version", "analytic", "arrays", "errors"),
    (
        "checks",
        "compiled",
        "frozen",
        "markup",
        "quantities",
        "roots",
        "threads",
        "time_left",
        "units",
    ),
    ("differences", "periodic"),
    ("extremes", "figures", "tape"),
    ("description",),
    ("mechanism",),
    ("elements", "mechanics"),
    ("problem", "proof"),
    ("kinematics",),
    ("dynamics",),
    ("results",),
    ("response", "simulation", "transmission"),
    ("formats",),
    ("viewer",),
    ("scene",),
    ("drive_lines", "clearance", "vibration", "studies"),
    ("report",),
    ("command_line",),
)
"""The rooms of `docs/architecture.md`, from the ground up: each may import from lower floors."""
ON_FLOOR = {room: floor for floor, rooms in enumerate(FLOORS) for room in rooms}
FILES = sorted(
    path
    for path in PACKAGE.rglob("*.py")
    if path.parent.name not in STOREYS or path.name != "__init__.py"
)


def module_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@cache
def statements(path: Path) -> list[ast.Import | ast.ImportFrom]:
    """Return all import statements of a file."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [node for node in ast.walk(tree) if isinstance(node, ast.Import | ast.ImportFrom)]


def imports(path: Path) -> set[str]:
    """Modules of the package that a file imports anywhere: lazily, or for its types alone."""
    own = list(path.relative_to(ROOT).with_suffix("").parts)
    found = set()
    for node in statements(path):
        if isinstance(node, ast.ImportFrom):
            base = own[: len(own) - node.level] if node.level else []
            source = [*base, *(node.module or "").split(".")] if node.module else base
            name = ".".join(source)
            for alias in node.names:
                inside = f"{name}.{alias.name}"
                found.add(inside if inside in MODULES else name)
        else:
            found |= {alias.name for alias in node.names}
    return {name for name in found if name.startswith("cardan_dyn")}


MODULES = {module_of(path) for path in FILES}


@cache
def graph() -> dict[str, set[str]]:
    """Return what each module imports of the package."""
    return {
        module_of(path): imports(path)
        for path in FILES
        if path.parent != PACKAGE or path.name != "__init__.py"
    }


def room_of(module: str) -> str:
    _, *parts = module.split(".")
    return parts[parts[0] in STOREYS]


def test_motion_and_practice_take_of_the_core_what_it_offers() -> None:
    offered = {f"{module}.{name}" for module, names in core.OFFERED.items() for name in names}
    taken: dict[str, set[str]] = {"motion": set(), "practice": set()}
    for path in FILES:
        if path.parent == PACKAGE:
            continue
        for name in names_of(path):
            _, *own = module_of(path).split(".")
            _, storey, *other = name.split(".")
            if own[0] in taken and storey == "core":
                taken[own[0]].add(".".join(other))
    taken = {
        own: {name for name in names if name.rpartition(".")[2] not in cardan_dyn.__all__}
        for own, names in taken.items()
    }
    # Nothing is offered that nobody takes.
    assert taken["practice"] | taken["motion"] == offered


def test_the_core_knows_its_guests_by_one_table() -> None:
    """It imports none of them, and each has what the core asks of it."""
    functions = {"reader": "parse", "second_reading": "reread", "visuals": "visuals"}
    for package in GUESTS.values():
        assert package.startswith("cardan_dyn.practice.formats.")
        for module, function in functions.items():
            text = (ROOT / package.replace(".", "/") / f"{module}.py").read_text(encoding="utf-8")
            assert f"\ndef {function}(" in text, (package, module)
    texts = {path: path.read_text(encoding="utf-8") for path in (PACKAGE / "core").rglob("*.py")}
    naming = [path.name for path, text in texts.items() if "practice." in text]
    assert naming == ["description.py"]


def names_of(path: Path) -> set[str]:
    """Names of the package that a file imports anywhere, each with its module in front."""
    own = list(path.relative_to(ROOT).with_suffix("").parts)
    return {
        ".".join([*own[: len(own) - node.level], *(node.module or "").split("."), alias.name])
        for node in statements(path)
        if isinstance(node, ast.ImportFrom) and node.level and node.module
        for alias in node.names
    }


def test_imports_run_down_and_never_in_a_circle() -> None:
    upwards = {
        (module, other)
        for module, others in graph().items()
        for other in others
        if other == "cardan_dyn"
        or (
            room_of(other) != room_of(module)
            and ON_FLOOR[room_of(other)] >= ON_FLOOR[room_of(module)]
        )
    }
    assert not upwards
    done: set[str] = set()

    def visit(module: str, path: tuple[str, ...]) -> None:
        assert module not in path, " -> ".join((*path, module))
        if module not in done:
            for other in sorted(graph().get(module, set())):
                visit(other, (*path, module))
            done.add(module)

    for module in sorted(graph()):
        visit(module, ())


def test_the_proof_takes_nothing_from_what_it_proves() -> None:
    used = {other for module in graph() if room_of(module) == "proof" for other in graph()[module]}
    grounds = {room for floor in FLOORS[:7] for room in floor} - {"analytic"}
    assert {room_of(other) for other in used} <= {"proof", *grounds}


def test_no_compiled_function_knows_the_proof() -> None:
    """What it shares with those that solve, machine and arrays, knows no mechanics."""
    for path in (PACKAGE / "core" / "proof").glob("*.py"):
        assert "compiled" not in path.read_text(encoding="utf-8"), path.name


def test_every_compiled_function_is_called_and_twins_name_it() -> None:
    sources = {path.name: path.read_text(encoding="utf-8") for path in COMPILED.glob("*.[ch]")}
    listed = sources["kernels.h"].split("#define EVERY_FUNCTION")[1].split("#define")[0]
    functions = set(re.findall(r"WITH\((\w+)\)", listed))
    texts = [path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")]
    twins = {twin for text in texts for twin in re.findall(r"# Twin: `(\w+)` of (\S+\.c)", text)}
    assert {name for name, _ in twins} == functions
    for name, file in twins:
        assert re.search(rf"^PyObject \*{name}\(", sources[Path(file).name], re.MULTILINE), name
    called = {name for text in texts for name in re.findall(r"kernel\.(\w+)\(", text)}
    # What runs programs: these are written down in Python, and computed by NumPy as well.
    machine = sources["kernels.h"].split("#define EVERY_MACHINE")[1].split("#else")[0]
    assert called == functions | set(re.findall(r"WITH\((\w+)\)", machine))


def test_every_room_is_in_the_architecture() -> None:
    rooms = {
        path.name.removesuffix(".py")
        for place in (PACKAGE, *(PACKAGE / storey for storey in STOREYS))
        for path in place.iterdir()
        if path.suffix == ".py" or (path / "__init__.py").is_file()
    } - {"__init__", *STOREYS}
    assert rooms == set(ON_FLOOR)
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
    assert not {room for room in rooms if not re.search(rf"\b{room}\b", text)} - {"_version"}
