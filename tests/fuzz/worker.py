"""Worker: a process that judges one seed after the other, and may die of one.

It reads a line `family first last` at a time, and writes a line of JSON per seed. What C++
libraries print goes to a file, from which the parent learns how a worker died.
"""

from __future__ import annotations

import contextlib
import faulthandler
import json
import os
import resource
import signal
import sys
import tempfile
import time
import warnings
from pathlib import Path

_SPARE = 12 << 30
_NOISE = 600


def status(key: str, process: str = "self") -> int:
    """Return a field of a process' status in bytes, 0 where there is none."""
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{process}/status").read_text(encoding="ascii").splitlines():
            if line.startswith(key):
                return int(line.split()[1]) << 10
    return 0


def _limit() -> None:
    """Refuse absurd allocations, beyond the much that libraries map when they are imported."""
    mapped = status("VmSize")
    if mapped:
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (mapped + _SPARE, hard))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def _peak(reset: bool = False) -> int:
    if reset:
        with contextlib.suppress(OSError):
            Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    return status("VmHWM")


def main(noise: Path) -> None:
    """Judge what the parent asks for until it hangs up."""
    # Copies: a number handed over as a path opens, and then closes, one of the first three.
    requests = os.fdopen(os.dup(0), encoding="utf-8")
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    capture = os.open(noise, os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND)
    os.dup2(capture, 1)
    os.dup2(capture, 2)
    faulthandler.enable(capture)
    faulthandler.register(signal.SIGUSR1, capture)

    def answer(content: dict[str, object]) -> None:
        answers.write(json.dumps(content) + "\n")
        answers.flush()

    from judge import judge

    warnings.simplefilter("error")
    # Which of two assemblies was taken is told as it should be; results are judged all the same.
    warnings.filterwarnings("ignore", ".*: loops are open at the description's zero, and two")
    _limit()
    with tempfile.TemporaryDirectory() as directory:
        answer({"ready": status("VmRSS")})
        for line in requests:
            family, first, last = line.split()
            for seed in range(int(first), int(last)):
                os.ftruncate(capture, 0)
                before, begin = _peak(reset=True), time.perf_counter()
                verdict = judge(family, seed, Path(directory))
                seconds = time.perf_counter() - begin
                finding = verdict.finding
                answer(
                    {
                        "seed": seed,
                        "outcome": verdict.outcome,
                        "finding": finding and vars(finding),
                        "seconds": round(seconds, 4),
                        "grown": _peak() - before,
                        "noise": noise.read_text("utf-8", "replace")[:_NOISE] if finding else "",
                    }
                )


if __name__ == "__main__":
    main(Path(sys.argv[1]))
