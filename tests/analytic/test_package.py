"""What holds for the whole package: dependencies, documentation, doctests."""

import ast
import doctest
import importlib
import inspect
import sys
from pathlib import Path

import pytest

from cardan_dyn import analytic

FOLDER = Path(analytic.__file__).parent
MODULES = sorted(path.stem for path in FOLDER.glob("*.py") if not path.stem.startswith("_"))
FUNCTIONS = [
    pytest.param(function, id=f"{name}.{function.__name__}")
    for name in MODULES
    for function in vars(importlib.import_module(f"cardan_dyn.analytic.{name}")).values()
    if inspect.isfunction(function)
    and function.__module__ == f"cardan_dyn.analytic.{name}"
    and not function.__name__.startswith("_")
]


def test_every_module_is_public():
    assert sorted(analytic.__all__) == MODULES
    assert all(hasattr(analytic, name) for name in MODULES)


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.py")), ids=lambda path: path.stem)
def test_imports_nothing_but_numpy(path):
    # TOML is read by the standard library from Python 3.11 on.
    allowed = {"numpy", "tomllib", "tomlkit"} | sys.stdlib_module_names
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            assert {alias.name.split(".")[0] for alias in node.names} <= allowed
        elif isinstance(node, ast.ImportFrom):
            # One dot: its own modules, also where the folder is imported as `analytic`.
            assert node.level == 1 or (node.module or "").split(".")[0] in allowed


@pytest.mark.parametrize("name", MODULES)
def test_all_lists_what_is_public(name):
    module = importlib.import_module(f"cardan_dyn.analytic.{name}")
    public = {
        key
        for key, value in vars(module).items()
        if not key.startswith("_") and getattr(value, "__module__", None) == module.__name__
    }
    assert public - {"Zero", "Start"} <= set(module.__all__)
    assert all(hasattr(module, key) for key in module.__all__)


@pytest.mark.parametrize("name", MODULES)
def test_doctests(name):
    assert doctest.testmod(importlib.import_module(f"cardan_dyn.analytic.{name}")).failed == 0


@pytest.mark.parametrize("function", FUNCTIONS)
def test_docstring(function):
    text = inspect.getdoc(function)
    assert "Returns:" in text
    assert "Source:" in text
    parameters = inspect.signature(function).parameters
    if parameters:
        assert "Raises:" in text
        described = text.split("Args:")[1].split("Returns:")[0]
        for parameter in parameters:
            assert f"    {parameter}: " in described, parameter
