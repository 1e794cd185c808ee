"""Where are digits lost, is it stated, and are the reported residuals true? All stress maps."""

from __future__ import annotations

import time
from types import ModuleType

from . import (
    stress_angle,
    stress_dead_point,
    stress_length,
    stress_mass,
    stress_misalignment,
    stress_speed,
    stress_turns,
)
from .maps import picture, table
from .records import path, save
from .timing import quick

MAPS: tuple[ModuleType, ...] = (
    stress_angle,
    stress_mass,
    stress_length,
    stress_speed,
    stress_turns,
    stress_dead_point,
    stress_misalignment,
)


def run(fast: bool = False) -> str:
    """Run all maps, or the ends of each, write them, and return the Markdown text."""
    sections = []
    for module in MAPS:
        start = time.perf_counter()
        measured = sorted(
            module.points(quick(module.GRID, fast)), key=lambda point: point.method != "sweep"
        )
        text = module.answer(measured)
        save(f"stress_{module.NAME}", [point.record() for point in measured], text)
        picture(measured, path(f"stress_{module.NAME}.png"), module.LABEL)
        question = (module.__doc__ or "").split("\n\n")[0]
        sections.append(
            f"## {question}\n\n{text}\n\n![{module.LABEL}](stress_{module.NAME}.png)\n\n"
            + table(measured)
        )
        seconds = time.perf_counter() - start
        print(f"stress {module.NAME} ({seconds:.0f} s): {text}\n", flush=True)
    body = "# Stress maps\n\n" + "\n\n".join(sections) + "\n"
    path("stress.md").write_text(body, encoding="utf-8")
    return body


if __name__ == "__main__":
    run()
