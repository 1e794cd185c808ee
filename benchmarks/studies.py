"""What does a study cost beside what it computes, and does it fit into memory, however long it is?

Overhead: a loop over cases of about 10 ms against the same study, and one call of a sweep against
a study whose chunks are such calls; processor time, alternately, least of several. Memory: greatest
of a process that studies 1000 to 1 000 000 cases. Workers: wall time of one local worker of Dask
over that of two (only a quiet machine of two cores tells), and what a chunk costs that computes
nothing.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import cardan_dyn as cd
from cardan_dyn import studies
from cardan_dyn.practice.studies.study import local_client

from .records import Record, markdown, save
from .timing import least_seconds

NAME = "studies"
_PER_CASE = 0.01
"""Time of a case [s], by the number of its positions."""


def _scene() -> cd.Scene:
    return cd.Scene(
        cd.load("double_shaft_z"),
        drive="bearing_in",
        held={"joint_angle_1": 0.5, "joint_angle_2": 0.5},
        loads={"bearing_out": -100.0},
    )


class Case:
    """A sweep of as many positions as take about 10 ms."""

    def __init__(self, positions: int) -> None:
        self.scene, self.positions = _scene(), np.linspace(0.0, 6.0, positions)

    def __call__(self, angle: float) -> dict[str, float]:
        """Return the greatest bending moment at a joint angle [rad]."""
        held = {"joint_angle_1": angle, "joint_angle_2": angle}
        turn = self.scene.sweep(self.positions, held=held)
        return {"bending": float(turn["bearing_out"].bending.max())}


def _of_ten_milliseconds() -> Case:
    """Return a case that takes about 10 ms of this processor."""
    positions = 100
    while True:
        case = Case(positions)
        case(0.4)
        start = time.process_time()
        for angle in np.linspace(0.41, 0.5, 10):
            case(float(angle))
        if time.process_time() - start > 10 * _PER_CASE:
            return case
        positions = int(1.2 * positions)


def _loop(fast: bool) -> list[Record]:
    """Cases one by one."""
    case, angles = _of_ten_milliseconds(), np.linspace(0.3, 0.6, 100 if fast else 500)

    def bare() -> None:
        for angle in angles.tolist():
            case(angle)

    def study() -> None:
        with tempfile.TemporaryDirectory() as folder:
            place = Path(folder) / "study.zarr"
            cd.study(case, {"angle": angles}, store=place, workers=1, chunk=100).run()

    return _compared("cases of 10 ms", bare, study, len(angles), fast)


def _calls(fast: bool) -> list[Record]:
    """Chunks of one call each."""
    scene, count = _scene(), 200_000 if fast else 1_000_000
    line = studies.Line(0.0, 200.0 * np.pi, count)

    def bare() -> None:
        swept = scene.sweep(line.values(0, count))
        assert np.isfinite(swept.drive_effort).all()

    def study() -> None:
        with tempfile.TemporaryDirectory() as folder:
            function = studies.Sweeps(scene, "drive_effort")
            place = Path(folder) / "study.zarr"
            cd.study(
                function, {"position": (line, "rad")}, store=place, workers=1, chunk=2**17
            ).run()

    return _compared("chunks of one sweep", bare, study, count, fast)


def _compared(name: str, bare: object, study: object, count: int, fast: bool) -> list[Record]:
    candidates = {"bare": bare, "study": study}
    seconds = least_seconds(candidates, 2 if fast else 5, 1e9, time.process_time)  # type: ignore[arg-type]
    return [
        Record(
            NAME,
            f"{name}: {who}",
            cd.__version__,
            parameters={"cases": count},
            microseconds=least / count * 1e6,
            ratio=least / seconds["bare"],
        )
        for who, least in seconds.items()
    ]


_MEMORY = """
import sys, tempfile
from pathlib import Path
import cardan_dyn as cd
from cardan_dyn import studies
from cardan_dyn.practice.studies.study import local_client

def peak():
    # Not `ru_maxrss`: that of a child begins with what its parent held.
    status = Path("/proc/self/status").read_text()
    return int(status.split("VmHWM:")[1].split()[0]) / 1024.0

def abs_of(x):
    return abs(x)

count, by_dask = int(sys.argv[1]), sys.argv[2] == "dask"
with tempfile.TemporaryDirectory() as folder:
    study = {"x": studies.Line(0.0, 1.0, count)}
    place = folder + "/study.zarr"
    if by_dask:
        with local_client(1) as client:
            cd.study(abs_of, study, store=place, client=client, chunk=1000).run()
            print(max(client.run(peak).values()))
    else:
        cd.study(abs_of, study, store=place, workers=1, chunk=1000).run()
print(peak())
"""


def _memory(fast: bool) -> list[Record]:
    """Greatest memory of processes that study more and more, and of a worker of Dask."""
    records = []
    for count in (10**3, 10**4) if fast else (10**3, 10**4, 10**5, 10**6):
        for how in ("here", "dask"):
            ran = subprocess.run(
                [sys.executable, "-c", _MEMORY, str(count), how],
                capture_output=True,
                text=True,
                check=True,
            )
            names = ("memory",) if how == "here" else ("memory of a worker", "memory of its client")
            for name, megabytes in zip(names, ran.stdout.split(), strict=True):
                parameters = {"cases": count, "megabytes": round(float(megabytes), 1)}
                records.append(Record(NAME, name, cd.__version__, parameters=parameters))
    return records


def nothing(x: float) -> float:
    """Return a number as it is."""
    return x


def _workers(fast: bool) -> list[Record]:
    """One and two local workers, by the clock on the wall."""
    case, count = _of_ten_milliseconds(), 200 if fast else 2000
    angles = np.linspace(0.3, 0.6, count)
    seconds, records = {}, []
    for workers in (1, 2):
        with local_client(workers) as client:
            cd.study(case, {"angle": angles[:4]}, client=client, chunk=1).run()  # All is imported.
            start = time.perf_counter()
            cd.study(case, {"angle": angles}, client=client, chunk=50).run()
            seconds[workers] = time.perf_counter() - start
            if workers == 2:
                chunks = 200 if fast else 2000
                start = time.perf_counter()
                cd.study(nothing, {"x": np.arange(float(chunks))}, client=client, chunk=1).run()
                idle = (time.perf_counter() - start) / chunks
                records.append(
                    Record(NAME, "a chunk of nothing", cd.__version__, microseconds=idle * 1e6)
                )
    for workers, spent in seconds.items():
        records.append(
            Record(
                NAME,
                f"{workers} local workers",
                cd.__version__,
                parameters={"cases": count},
                microseconds=spent / count * 1e6,
                ratio=seconds[1] / spent,
            )
        )
    return records


def measure(fast: bool = False) -> list[Record]:
    """Return all records; `ratio` is that to the bare call, of workers that of one to them."""
    return [*_loop(fast), *_calls(fast), *_memory(fast), *_workers(fast)]


def answer(records: list[Record]) -> str:
    """Return overheads, memory and what a second worker gains."""
    by_name = {record.method: record for record in records}
    memory = [record for record in records if record.method.startswith("memory")]
    spread = "; ".join(
        f"{name.removeprefix('memory of ') if ' of ' in name else 'a process alone'} "
        + ", ".join(
            f"{record.parameters['megabytes']} MB of {record.parameters['cases']:,}"
            for record in memory
            if record.method == name
        )
        for name in dict.fromkeys(record.method for record in memory)
    )
    return (
        f"Overhead: {_percent(by_name['cases of 10 ms: study'])} of cases of 10 ms, "
        f"{_percent(by_name['chunks of one sweep: study'])} of sweeps. Memory of cases: {spread}. "
        f"Two workers: {by_name['2 local workers'].ratio:.2f} times one; a chunk of nothing takes "
        f"{(by_name['a chunk of nothing'].microseconds or 0.0) / 1000.0:.1f} ms."
    )


def _percent(record: Record) -> str:
    return f"{100.0 * ((record.ratio or np.nan) - 1.0):.1f} %"


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    rows = [
        [
            record.method,
            f"{record.parameters.get('cases', '')}",
            "" if record.microseconds is None else f"{record.microseconds:.4g}",
            "" if record.ratio is None else f"{record.ratio:.3f}",
            f"{record.parameters.get('megabytes', '')}",
        ]
        for record in records
    ]
    return f"{markdown(['what', 'cases', 'µs per case', 'ratio', 'MB'], rows)}\n\n{text}"
