"""The table of rules: complete, and every name in it exists."""

import importlib
import inspect
import runpy
from pathlib import Path

import pytest

from cardan_dyn.analytic import limits, rules
from cardan_dyn.analytic._data import read

TESTED = Path(__file__).parent / "tested_rules.toml"
DOCS = Path(__file__).parents[2] / "docs"
RULES = list(rules.RULES.values())
PRACTICE = (
    "bending_speed",
    "centred_double_joint",
    "design_torque",
    "installation",
    "shaft_design",
    "support_forces",
    "torsional_speed",
    "uniformity",
)
BUILDING_BLOCKS = {"support_forces.shaft_axes", "support_forces.double_shaft_wrenches"}


@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.key)
def test_names_in_a_rule_exist(rule):
    for name in rule.functions:
        module, function = name.split(".")
        assert callable(getattr(importlib.import_module(f"cardan_dyn.analytic.{module}"), function))
    assert set(rule.limits) <= set(limits.LIMITS)
    words = (rule.title, rule.formula, rule.source, rule.example, *rule.assumptions)
    assert all(word.strip() for word in words)
    assert rule.functions
    assert rule.assumptions


def test_every_rule_is_tested():
    tested = read(TESTED)
    assert list(tested) == list(rules.RULES)
    for places in tested.values():
        assert places
        for place in places:
            file, test = place.split("::")
            assert file.startswith("test_")
            assert test.startswith("test_")
            text = (TESTED.parent / file).read_text(encoding="utf-8")
            assert f"def {test}(" in text, place


def test_every_function_of_practice_belongs_to_a_rule():
    named = {name for rule in RULES for name in rule.functions}
    public = {
        f"{module}.{name}"
        for module in PRACTICE
        for name, value in vars(importlib.import_module(f"cardan_dyn.analytic.{module}")).items()
        if inspect.isfunction(value)
        and value.__module__ == f"cardan_dyn.analytic.{module}"
        and not name.startswith("_")
    }
    assert public - named == BUILDING_BLOCKS


def test_every_limit_belongs_to_a_rule():
    assert {name for rule in RULES for name in rule.limits} == set(limits.LIMITS)


def test_keys():
    assert [rule.key for rule in RULES] == list(rules.RULES)
    with pytest.raises(TypeError):
        rules.RULES["own"] = RULES[0]


def test_own_derivations_say_against_what_they_were_held():
    own = [rule for rule in RULES if "own derivation" in rule.source]
    assert own
    for rule in own:
        assert any(word in rule.example for word in ("own derivation", "finite elements"))


def test_pages_and_data_agree():
    pages = runpy.run_path(str(DOCS / "write_pages.py"))["PAGES"]
    assert {path.name for path in pages} == {"practice.md", "errata.md", "interface.md"}
    for path, page in pages.items():
        assert path.read_text(encoding="utf-8") == page()
    text = (DOCS / "practice.md").read_text(encoding="utf-8")
    assert all(f"| `{name}` |" in text for name in limits.LIMITS)
