"""What the package index is given has no link that leads nowhere."""

from __future__ import annotations

import importlib.util
import re
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
ADDRESS = "https://example.org/owner/name"


@pytest.fixture(scope="module")
def script() -> ModuleType:
    spec = importlib.util.spec_from_file_location("for_index", ROOT / "docs" / "for_index.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_links_and_pictures_of_the_readme_are_addresses(script: ModuleType) -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    text = script.absolute(readme, ADDRESS, "v1.2.3")
    targets = re.findall(r"\]\(([^)\s]+)\)", text)
    assert targets
    for target in targets:
        assert target.startswith(("https://", "#")), target
    assert f"{ADDRESS}/raw/v1.2.3/docs/images/first_screen.png" in targets
    within = f"{ADDRESS}/blob/v1.2.3/"
    linked = [target.removeprefix(within) for target in targets if target.startswith(within)]
    assert linked
    for path in linked:
        assert (ROOT / path.partition("#")[0]).exists(), path
    # Nothing else is changed.
    assert re.sub(r"\]\([^)]*\)", "", text) == re.sub(r"\]\([^)]*\)", "", readme)


def test_the_project_has_its_addresses(script: ModuleType) -> None:
    before = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    project = tomllib.loads(script.with_urls(before, ADDRESS, "v1.2.3"))
    assert project["project"].pop("urls")["Issues"] == f"{ADDRESS}/issues"
    assert project == tomllib.loads(before)


def test_documentation_is_the_site_where_there_is_one(script: ModuleType) -> None:
    assert script.site("https://github.com/owner/name", "v1.2.3") == "https://owner.github.io/name/"
    assert script.site(ADDRESS, "v1.2.3") == f"{ADDRESS}/blob/v1.2.3/docs/guide.md"
    assert (ROOT / "docs" / "guide.md").exists()
