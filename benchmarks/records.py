"""Records of measurements: JSON for programs, Markdown for readers."""

from __future__ import annotations

import json
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

RESULTS = Path(__file__).parent / "results"
"""Where results are written, unless a run says otherwise."""


def path(name: str) -> Path:
    """Return the path of a file of results, in a folder that exists."""
    RESULTS.mkdir(parents=True, exist_ok=True)
    return RESULTS / name


@dataclass(frozen=True)
class Record:
    """One measurement.

    Attributes:
        task: what was computed.
        method: who computed it.
        version: of that program.
        settings: how it was set.
        parameters: `beta_deg`, `samples`, `joints`, …
        error: greatest relative error, None if not measured.
        microseconds: per sample; for start-up and memory see `parameters`.
        ratio: time over that of the task's reference method in the same run.
    """

    task: str
    method: str
    version: str = ""
    settings: str = ""
    parameters: dict[str, Any] = field(default_factory=dict)
    error: float | None = None
    microseconds: float | None = None
    ratio: float | None = None

    def flat(self) -> dict[str, Any]:
        """Return it with its parameters beside the other fields."""
        values = asdict(self)
        return {**{k: v for k, v in values.items() if k != "parameters"}, **self.parameters}


def machine() -> dict[str, Any]:
    """Return on what and under which load the run was made."""
    return {
        "python": platform.python_version(),
        "machine": platform.machine(),
        "cores": os.cpu_count(),
        "load_average": round(os.getloadavg()[0], 2) if hasattr(os, "getloadavg") else None,
        **{name: version(name) for name in ("pin", "numpy", "scipy", "cardan-dyn")},
    }


def version(distribution: str) -> str:
    """Return the installed version of a distribution, empty if there is none."""
    from importlib import metadata

    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:
        return ""


def save(name: str, records: Sequence[dict[str, Any]], answer: str) -> None:
    """Write a task's records and its answer."""
    body = ",\n".join(" " + json.dumps(_short(record), ensure_ascii=False) for record in records)
    head = json.dumps({"machine": machine(), "answer": answer}, ensure_ascii=False)[1:-1]
    path(f"{name}.json").write_text(
        "{" + head + ', "records": [\n' + body + "\n]}\n", encoding="utf-8"
    )


def _short(record: dict[str, Any]) -> dict[str, Any]:
    return {
        key: float(f"{value:.4g}") if isinstance(value, float) and key != "parameter" else value
        for key, value in record.items()
        if value not in (None, "")
    }


def markdown(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Return a Markdown table."""
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])
