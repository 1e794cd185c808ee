"""Do cost and memory of a drive line grow linearly with its number of joints?

Lines of 1 to 64 universal joints with masses at 100 rad/s, a unit torque at the end, all wrenches,
721 samples. Each length runs in a separate process; its peak memory is counted beyond that of
the import.
"""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

from .records import Record, markdown, save

NAME = "drive_lines"
COUNTS = (1, 2, 4, 8, 16, 32, 64)
SAMPLES = 721


def peak_megabytes() -> float:
    """Return the greatest memory that this process has held so far, nan if unknown.

    Not `getrusage`: its maximum survives the start of a new program, so that a child would report
    its parent's.
    """
    status = Path("/proc/self/status")
    if not status.exists():
        return float("nan")
    (line,) = [line for line in status.read_text().splitlines() if line.startswith("VmHWM")]
    return int(line.split()[1]) / 1024.0


def measure_one(count: int, repeats: int) -> dict[str, float]:
    """Measure one length, in this process."""
    import numpy as np

    import cardan_dyn as cd

    from .descriptions import drive_line

    before = peak_megabytes()
    start = time.perf_counter()
    mechanism = cd.load(drive_line(count))
    loaded = time.perf_counter()
    scene = cd.Scene(mechanism, drive="bearing_0", loads={f"bearing_{count}": -1.0})
    made = time.perf_counter()
    positions = np.linspace(0.0, 2.0 * np.pi, SAMPLES)
    least = float("inf")
    for _ in range(repeats):
        begin = time.perf_counter()
        sweep = scene.sweep(positions, 100.0)
        least = min(least, time.perf_counter() - begin)
    after = peak_megabytes()
    return {
        "load_ms": (loaded - start) * 1e3,
        "scene_ms": (made - loaded) * 1e3,
        "microseconds": least / SAMPLES * 1e6,
        "megabytes": after - before,
        "balance_residual": sweep.balance_residual,
    }


def measure(fast: bool = False) -> list[Record]:
    """Return all records."""
    import cardan_dyn as cd

    records: list[Record] = []
    for count in COUNTS[:3] if fast else COUNTS:
        command = [sys.executable, "-m", "benchmarks.drive_lines", str(count), "2" if fast else "5"]
        done = subprocess.run(
            command, cwd=Path(__file__).parents[1], capture_output=True, text=True, check=False
        )
        if done.returncode:
            failure = done.stderr.strip().splitlines()[-1]
            records.append(
                Record(NAME, "cardan_dyn sweep", parameters={"joints": count, "failed": failure})
            )
            continue
        values = json.loads(done.stdout)
        micros = values.pop("microseconds")
        first = records[0].microseconds if records else micros
        records.append(
            Record(
                task=NAME,
                method="cardan_dyn sweep",
                version=cd.__version__,
                parameters={
                    "joints": count,
                    "microseconds_per_joint": micros / count,
                    **values,
                },
                microseconds=micros,
                ratio=micros / (first or micros),
            )
        )
    return records


def answer(records: list[Record]) -> str:
    """Return how cost grows."""
    solved = [record for record in records if record.microseconds]
    first, last = solved[0], solved[-1]
    per_joint = [record.parameters["microseconds_per_joint"] for record in solved]
    lines = [
        f"From {first.parameters['joints']} to {last.parameters['joints']} joints a sample takes "
        f"{last.ratio:.3g} times as long; per joint and sample {min(per_joint):.3g} to "
        f"{max(per_joint):.3g} µs. Peak memory grows from {first.parameters['megabytes']:.3g} to "
        f"{last.parameters['megabytes']:.3g} MB, a scene takes "
        f"{last.parameters['scene_ms']:.3g} ms to make at the end."
    ]
    lines += [
        f"{record.parameters['joints']} joints: {record.parameters['failed']}"
        for record in records
        if not record.microseconds
    ]
    return "\n".join(lines)


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    head = ["joints", "µs/sample", "µs/(joint sample)", "load ms", "scene ms", "peak MB", "balance"]
    rows = []
    for record in records:
        if record.microseconds is None:
            rows.append([str(record.parameters["joints"]), "failed"] + [""] * 5)
            continue
        p = record.parameters
        rows.append(
            [str(p["joints"]), f"{record.microseconds:.3g}"]
            + [f"{p[k]:.3g}" for k in ("microseconds_per_joint", "load_ms", "scene_ms")]
            + [f"{p['megabytes']:.3g}", f"{p['balance_residual']:.1e}"]
        )
    return f"{markdown(head, rows)}\n\n{text}"


if __name__ == "__main__":
    print(json.dumps(measure_one(int(sys.argv[1]), int(sys.argv[2]))))
