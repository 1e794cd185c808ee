"""The rules by which drive lines are judged, with formula, source, assumptions and proof.

A verdict on a drive line is composed of them: a value by the functions of a rule, a limit of
`limits.LIMITS` or of the user, the margin between both, and of the assumptions those that the line
does not meet. The functions know nothing of limits, and this table computes nothing.

References:
    Each rule names its sources; `analytic.limits` those of the figures.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from analytic._data import read
from analytic.limits import CRITICAL_CONSTANTS, LIMITS, POWER_FACTORS, SERVICE_FACTORS, Limit

__all__ = ["RULES", "Rule", "as_markdown"]


@dataclass(frozen=True)
class Rule:
    """One rule of practice.

    Attributes:
        key: its name in `RULES`.
        title: what it judges.
        formula: as its source writes it, in the units that it names.
        functions: functions of `analytic` that compute it, as "module.function".
        limits: names in `limits.LIMITS` of what it is held against, if there are any.
        source: who states it.
        assumptions: what must hold for it, one sentence each.
        example: published example, or what independent derivation it was held against.
    """

    key: str
    title: str
    formula: str
    functions: tuple[str, ...]
    limits: tuple[str, ...]
    source: str
    assumptions: tuple[str, ...]
    example: str


def _rule(key: str, row: Mapping[str, Any]) -> Rule:
    listed = {name: tuple(row.get(name, ())) for name in ("functions", "limits", "assumptions")}
    return Rule(key=key, **{**row, **listed})


RULES: Mapping[str, Rule] = MappingProxyType(
    {key: _rule(key, row) for key, row in read("rules.toml").items()}
)
"""Rules by name, in the order in which a shaft is designed."""


def as_markdown() -> str:
    """The rules and limits as the page of the documentation.

    Returns:
        Text in Markdown.

    Source:
        `RULES` and `analytic.limits`.
    """
    lines = [
        "# Rules of practice",
        "",
        "What makers and builders of drive lines compute, in the package `analytic`: formula,",
        "source, what must hold for it, and a worked example or an independent derivation that a",
        "test holds it against. The same table is `analytic.rules.RULES`; the figures at the end",
        "are `analytic.limits`, and any of them can be replaced. Symbols in formulas are those of",
        "the sources; functions take SI units and radians.",
        "",
        "Three ratings of joints look alike and are not: the rated torque T_D of the life formula",
        "(5000 h at n beta = 300 degrees/min), the capacity factor L_C, and the torque of a",
        "maker's own table, such as Klein's T = C R or T_e = T K_1 K_2 K_3. For 1000 N m,",
        "1450/min, 7 degrees and 2000 h the first is 2185 N m, Klein's 1339 N m.",
    ]
    for rule in RULES.values():
        lines += ["", f"## {rule.title} ({rule.key})", "", f"- Formula: {rule.formula}"]
        lines.append("- Functions: " + ", ".join(f"`{name}`" for name in rule.functions))
        if rule.limits:
            lines.append("- Limits: " + ", ".join(f"`{name}`" for name in rule.limits))
        lines += [f"- Source: {rule.source}", f"- Holds if: {' '.join(rule.assumptions)}"]
        lines.append(f"- Example: {rule.example}")
    lines += ["", "## Limits and constants", "", *_table(LIMITS)]
    lines += [
        "",
        "Constants C of omega = C sqrt(D^2 + d^2) / L^2:",
        "",
        *_table(CRITICAL_CONSTANTS),
    ]
    factors = {
        f"{load}, {end}": limit
        for load, pair in SERVICE_FACTORS.items()
        for end, limit in zip(("least", "greatest"), pair, strict=True)
    }
    lines += ["", "Service factors K by load, and factors K_3 by prime mover:", ""]
    lines += _table({**factors, **POWER_FACTORS})
    lines += [
        "",
        "Speeds and angles by size of joint are `analytic.limits.JOINT_SIZES`, factors of",
    ]
    lines += ["precision joints `analytic.limits.DIN_808_FACTORS`."]
    return "\n".join(lines) + "\n"


def _table(limits: Mapping[str, Limit]) -> list[str]:
    rows = [
        f"| `{name}` | {limit.value:.6g} | {limit.unit} | {limit.bound} | {limit.source} |"
        for name, limit in limits.items()
    ]
    return ["| name | value | unit | bound | source |", "|---|---|---|---|---|", *rows]
