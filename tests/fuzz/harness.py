"""Harness: many seeds in worker processes, and what they found."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import select
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

FAMILIES = ("descriptions", "arguments")
SECONDS = 10.0
MEMORY = 1 << 30
_START = 120.0
_CHUNK = 40
_STALE = 400 << 20


@dataclass(frozen=True)
class Found:
    """A finding and the seed it came from."""

    family: str
    seed: int
    kind: str
    place: str
    message: str
    noise: str = ""


@dataclass
class Outcome:
    """What a run came to.

    Attributes:
        findings: in order of seeds.
        outcomes: how often cases ended how.
        slow: the longest times [s] with their seeds.
        seconds: the whole time.
    """

    findings: list[Found] = field(default_factory=list)
    outcomes: Counter[str] = field(default_factory=Counter)
    slow: list[tuple[float, int]] = field(default_factory=list)
    seconds: float = 0.0

    def groups(self) -> dict[tuple[str, str], list[Found]]:
        """Return findings by kind and place, the most frequent first."""
        grouped: dict[tuple[str, str], list[Found]] = {}
        for item in self.findings:
            grouped.setdefault((item.kind, item.place), []).append(item)
        return dict(sorted(grouped.items(), key=lambda entry: -len(entry[1])))

    def __str__(self) -> str:
        total = sum(self.outcomes.values())
        rate = total / self.seconds if self.seconds else 0.0
        lines = [f"{total} cases in {self.seconds:.0f} s, {rate:.0f} per second"]
        lines += [f"  {count:7d}  {name}" for name, count in self.outcomes.most_common()]
        lines.append("slowest: " + ", ".join(f"{s:.1f} s (seed {seed})" for s, seed in self.slow))
        lines.append(f"{len(self.findings)} findings in {len(self.groups())} groups")
        for (kind, place), items in self.groups().items():
            first = min(items, key=lambda item: item.seed)
            lines.append(f"{len(items):6d}  {kind} at {place or 'unknown'}, seed {first.seed}")
            lines.append(f"        {' '.join(first.message.split())[:200]}")
        return "\n".join(lines)


class Worker:
    """A worker process, started again whenever it died or had to be ended."""

    def __init__(self, directory: Path, index: int) -> None:
        self._noise = directory / f"noise_{index}"
        self._process: subprocess.Popen[bytes] | None = None
        self._rest = b""
        self._size = 0

    def _start(self) -> subprocess.Popen[bytes]:
        spec = importlib.util.find_spec("cardan_dyn")
        if spec is None or spec.origin is None:
            raise SystemExit("cardan_dyn cannot be imported")
        paths = [str(Path(spec.origin).parents[1]), os.environ.get("PYTHONPATH", "")]
        # One thread: the small matrices here gain nothing from more, and they would count twice.
        threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"), "1")
        process = subprocess.Popen(
            [sys.executable, str(Path(__file__).with_name("worker.py")), str(self._noise)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, **threads, "PYTHONPATH": os.pathsep.join(filter(None, paths))},
        )
        self._process, self._rest = process, b""
        ready = self._line(_START)
        if not isinstance(ready, dict):
            raise SystemExit(f"a worker did not start: {ready}\n{self._heard()}")
        self._size = int(ready["ready"])
        return process

    def stop(self) -> None:
        """End the process."""
        process, self._process = self._process, None
        if process is not None:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    pipe.close()

    def _resident(self) -> int:
        from worker import status

        return status("VmRSS", str(self._process.pid)) if self._process else 0

    def _heard(self) -> str:
        return self._noise.read_text("utf-8", "replace") if self._noise.exists() else ""

    def _line(self, seconds: float) -> dict[str, object] | str:
        """Return the next answer, or why there is none: `hang`, `memory`, `process died`."""
        assert self._process is not None and self._process.stdout is not None
        end = time.monotonic() + seconds
        while b"\n" not in self._rest:
            ready, _, _ = select.select([self._process.stdout], [], [], 0.1)
            if ready:
                part = os.read(self._process.stdout.fileno(), 1 << 16)
                if not part:
                    return "process died"
                self._rest += part
            elif self._size and self._resident() > self._size + MEMORY + _STALE:
                return "memory"
            elif time.monotonic() > end:
                return "hang"
        line, _, self._rest = self._rest.partition(b"\n")
        return dict(json.loads(line))

    def judge(self, family: str, first: int, last: int) -> Iterator[dict[str, object]]:
        """Yield an answer per seed."""
        seed = first
        while seed < last:
            process = self._process or self._start()
            assert process.stdin is not None
            process.stdin.write(f"{family} {seed} {last}\n".encode())
            process.stdin.flush()
            while seed < last:
                answer = self._line(SECONDS)
                if isinstance(answer, str):
                    yield self._lost(answer, seed)
                    seed += 1
                    break
                yield answer
                seed += 1
        if self._process and self._resident() > self._size + _STALE:
            self.stop()  # What earlier cases left must not count for later ones.

    def _lost(self, why: str, seed: int) -> dict[str, object]:
        """Return an answer for a seed that gave none; the process is ended."""
        assert self._process is not None
        if why != "process died":
            # The worker writes where it is before it is ended.
            self._process.send_signal(signal.SIGUSR1)
            time.sleep(0.3)
            code = ""
        else:
            code = f"exit status {self._process.wait()}; "
        noise = self._heard()
        self.stop()
        frames = re.findall(r'File "([^"]+)", line (\d+)', noise)
        inside = [frame for frame in frames if "/cardan_dyn/" in frame[0] or "/fuzz/" in frame[0]]
        path, line = (inside or frames or [("", "")])[0]
        place = f"{Path(path).name}:{line}" if path else ""
        finding = {"kind": why, "place": place, "message": (code + noise)[:400]}
        return {"seed": seed, "outcome": why, "finding": finding, "seconds": 0.0, "noise": noise}


def run(family: str, start: int, count: int, workers: int = 1) -> Outcome:
    """Judge the seeds from `start` on."""
    outcome, lock, begin = Outcome(), threading.Lock(), time.monotonic()
    chunks = iter(range(start, start + count, _CHUNK))

    def work(worker: Worker) -> None:
        try:
            while True:
                with lock:
                    first = next(chunks, None)
                if first is None:
                    return
                for answer in worker.judge(family, first, min(first + _CHUNK, start + count)):
                    with lock:
                        _note(outcome, family, answer)
        finally:
            worker.stop()

    with tempfile.TemporaryDirectory() as directory:
        threads = [
            threading.Thread(target=work, args=(Worker(Path(directory), index),))
            for index in range(workers)
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    outcome.findings.sort(key=lambda item: item.seed)
    outcome.seconds = time.monotonic() - begin
    return outcome


def _note(outcome: Outcome, family: str, answer: dict[str, object]) -> None:
    seed, finding = int(str(answer["seed"])), answer["finding"]
    outcome.outcomes[str(answer["outcome"])] += 1
    outcome.slow = sorted([*outcome.slow, (float(str(answer["seconds"])), seed)])[::-1][:5]
    noise = str(answer.get("noise", ""))
    if isinstance(finding, dict):
        outcome.findings.append(Found(family, seed, **finding, noise=noise))
    elif int(str(answer.get("grown", 0))) > MEMORY:
        text = f"{int(str(answer['grown'])) >> 20} MB more"
        outcome.findings.append(Found(family, seed, "memory", "", text, noise))


def show(family: str, seed: int) -> str:
    """Return the case of a seed as text."""
    if family == "descriptions":
        import descriptions

        return str(descriptions.case(seed))
    import arguments

    return arguments.call(seed)
