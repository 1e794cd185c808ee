"""Run all benchmarks and stress maps: `python -m benchmarks [--fast] [names …]`.

Writes one JSON file per task, pictures, and the Markdown tables `benchmarks.md` and `stress.md` to
`benchmarks/results`, or the folder `--results`. `--fast` measures a part of each task with few
repeats. Names are those of the tasks, and `stress`.
"""

from __future__ import annotations

import argparse
import os
import sys
import time
from pathlib import Path

# One thread everywhere, before NumPy is imported: the other engines use one as well.
for _name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")
if not __package__:
    sys.path.insert(0, str(Path(__file__).parents[1]))

TASKS = (
    "universal_joint",
    "double_shaft",
    "free_spin",
    "four_bars",
    "drive_lines",
    "many_designs",
    "waiting",
    "short_calls",
    "in_a_loop",
    "skipping",
    "start_up",
    "long_time",
    "thousand_periods",
    "hammering",
    "studies",
    "stability_charts",
    "stress_simulation",
    "stress",
)


def main(arguments: list[str] | None = None) -> None:
    """Run what the command line asks for."""
    import importlib

    parser = argparse.ArgumentParser(prog="benchmarks", description=(__doc__ or "").split(":")[0])
    parser.add_argument("names", nargs="*", metavar="name", help=", ".join(TASKS))
    parser.add_argument("--fast", action="store_true", help="few repeats, few points")
    parser.add_argument("--results", type=Path, metavar="FOLDER", help="where results are written")
    options = parser.parse_args(arguments)
    unknown = set(options.names) - set(TASKS)
    if unknown:
        parser.error(f"unknown: {', '.join(sorted(unknown))}; choose from {', '.join(TASKS)}")
    from benchmarks import records, stress_all

    records.RESULTS = options.results or records.RESULTS
    sections = []
    for name in options.names or TASKS:
        start = time.perf_counter()
        if name == "stress":
            stress_all.run(options.fast)
            continue
        module = importlib.import_module(f"benchmarks.{name}")
        question = (module.__doc__ or "").strip()
        body = f"## {name.replace('_', ' ')}\n\n{question}\n\n{module.run(options.fast)}\n"
        records.path(f"{name}.md").write_text(body, encoding="utf-8")
        print(f"{body}\n({time.perf_counter() - start:.0f} s)\n", flush=True)
    for name in TASKS:
        section = records.path(f"{name}.md")
        if name != "stress" and section.exists():
            sections.append(section.read_text(encoding="utf-8"))
    facts = ", ".join(f"{key} {value}" for key, value in records.machine().items() if value)
    head = f"# Run time and error\n\nLast run on: {facts}. Ratios are those of one run.\n\n"
    records.path("benchmarks.md").write_text(head + "\n".join(sections), encoding="utf-8")


if __name__ == "__main__":
    main()
