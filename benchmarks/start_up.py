"""How long does the first result take in a fresh interpreter?

Fresh processes that take turns; the least of each counts. Times of imports include what the
imported modules import in turn. A response is built three times in every process: the first one
with all that is imported for it, one of a new scene, whose motion is still to be followed, and
another one of that scene.
"""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from .records import Record, markdown, save, version

NAME = "start_up"
IMPORTS = ("numpy", "pinocchio", "cardan_dyn")
_IMPORT = """
import json, time
start = time.perf_counter()
import {module}
print(json.dumps({{"import {module}": time.perf_counter() - start}}))
"""
_FIRST = """
import json, time
start = time.perf_counter()
import cardan_dyn as cd
imported = time.perf_counter()
joint = cd.load("universal_joint")
loaded = time.perf_counter()
def make(): return cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.8727},
                            loads={"bearing_out": -1.0})
scene = make()
made = time.perf_counter()
scene.sweep([0.1])["bearing_out"].bending
first = time.perf_counter()
scene.response()
built = time.perf_counter()
fresh = make()
begun = time.perf_counter()
fresh.response()
responded = time.perf_counter()
fresh.response()
again = time.perf_counter()
print(json.dumps({"load": loaded - imported, "scene": made - loaded, "first result": first - made,
                  "import to first result": first - start, "first response": built - first,
                  "response of a new scene, β = 50°": responded - begun,
                  "response of a known scene, β = 50°": again - responded}))
"""


def measure(fast: bool = False) -> list[Record]:
    """Return all records; `microseconds` is the whole time, there are no samples."""
    scripts = [_IMPORT.format(module=module) for module in IMPORTS] + [_FIRST]
    least: dict[str, float] = {}
    for _ in range(3 if fast else 15):
        for script in scripts:
            done = subprocess.run(
                [sys.executable, "-c", script],
                cwd=Path(__file__).parents[1],
                capture_output=True,
                text=True,
                check=True,
            )
            for name, seconds in json.loads(done.stdout).items():
                least[name] = min(least.get(name, float("inf")), seconds)
    return [
        Record(
            task=NAME,
            method=name,
            version=version({"pinocchio": "pin", "cardan_dyn": "cardan-dyn"}.get(key, key)),
            parameters={"milliseconds": seconds * 1e3},
            microseconds=seconds * 1e6,
            ratio=seconds / least["import pinocchio"],
        )
        for name, seconds in least.items()
        for key in [name.removeprefix("import ")]
    ]


def answer(records: list[Record]) -> str:
    """Return the times in words."""
    return " ".join(
        f"{r.method}: {r.parameters['milliseconds']:.3g} ms ({r.ratio:.2f} of import pinocchio)."
        for r in records
    )


def run(fast: bool = False) -> str:
    """Measure, write results, and return the Markdown text."""
    records = measure(fast)
    text = answer(records)
    save(NAME, [record.flat() for record in records], text)
    rows = [[r.method, f"{r.parameters['milliseconds']:.3g}", f"{r.ratio:.2f}"] for r in records]
    return f"{markdown(['step', 'ms', 'ratio to import pinocchio'], rows)}\n\n{text}"
