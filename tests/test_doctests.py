"""The examples in docstrings do what they say."""

import doctest
import importlib
import pkgutil

import pytest

import analytic
import cardan_dyn

MODULES = sorted(
    module.name
    for package in (analytic, cardan_dyn)
    for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
)


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str) -> None:
    assert doctest.testmod(importlib.import_module(name)).failed == 0


def test_both_packages_have_examples() -> None:
    for package in ("analytic", "cardan_dyn"):
        modules = [importlib.import_module(name) for name in MODULES if name.startswith(package)]
        assert sum(doctest.testmod(module).attempted for module in modules) > 0
