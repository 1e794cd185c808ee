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

from ._data import read

__all__ = ["RULES", "Rule"]


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
