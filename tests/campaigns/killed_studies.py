"""A study whose worker, scheduler and client are killed: is it what an undisturbed one is?

    python tests/campaigns/killed_studies.py --cases 20000 --rounds 1

Two workers of Dask compute. At random times one of them, the scheduler and the client are ended by
SIGKILL, in a random order, and the study is resumed. In the end every file of the store is that of
a study that nobody disturbed, byte for byte, and no case was called after its result was stored.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

import cardan_dyn as cd
from cardan_dyn import studies

_PATIENCE = 3600.0
"""How long a study may take [s]."""
POSITIONS = np.linspace(0.0, 6.0, 8)


class Bending:
    """Bending moments of a universal joint, for an angle and a torque; writes down its calls."""

    def __init__(self, calls: Path | None) -> None:
        self.calls = None if calls is None else str(calls)
        self.scene = cd.Scene(
            cd.load("universal_joint"),
            drive="bearing_in",
            held={"joint_angle": 0.5},
            loads={"bearing_out": -100.0},
        )

    def __call__(self, angle: float, torque: float) -> dict[str, Any]:
        if self.calls is not None:
            with Path(f"{self.calls}-{os.getpid()}").open("a") as file:
                file.write(f"{time.time()} {angle!r} {torque!r}\n")
        turn = self.scene.sweep(
            POSITIONS, held={"joint_angle": angle}, loads={"bearing_out": torque}
        )
        return {"bending": turn["bearing_out"].bending, "effort": turn.drive_effort.max()}


def study_of(calls: Path | None, store: Path, cases: int, **options: Any) -> studies.Study:
    torques = -np.linspace(10.0, 200.0, 20)
    angles = np.linspace(0.05, 1.2, cases // 20)
    parameters = {"angle": (angles, "rad"), "torque": (torques, "N·m")}
    # Chunks neither fit the grid nor follow the clock.
    chunk = {"angle": max(2, cases // 20 // 60), "torque": 7}
    return cd.study(Bending(calls), parameters, store=store, chunk=chunk, **options)


def client(address: str, folder: Path, cases: int) -> None:
    """Compute the study as a user would, until it is done or the scheduler is lost."""
    from distributed import Client

    with Client(address, timeout=60) as connected:
        study_of(folder / "calls", folder / "killed.zarr", cases, client=connected).run()


class Cluster:
    """Processes, each of which can be killed and started anew."""

    def __init__(self, folder: Path, cases: int) -> None:
        self.folder, self.cases = folder, cases
        self.parts: dict[str, subprocess.Popen[bytes]] = {}
        self.address = ""
        self.scheduler()

    def start(self, name: str, *words: str) -> None:
        log = (self.folder / f"{name}.log").open("ab")
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        self.parts[name] = subprocess.Popen(
            [sys.executable, *words], stdout=log, stderr=log, env=environment
        )

    def scheduler(self) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{port}"
        words = ("-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1")
        self.start("scheduler", *words, "--port", str(port), "--no-dashboard", "--no-show")
        for name in ("worker 1", "worker 2"):
            self.worker(name)
        self.client()

    def worker(self, name: str) -> None:
        words = ("-m", "distributed.cli.dask_worker", self.address, "--host", "127.0.0.1")
        self.start(name, *words, "--nthreads", "1", "--no-nanny", "--no-dashboard")

    def client(self) -> None:
        words = (__file__, "--cases", str(self.cases), "--client", self.address)
        self.start("client", *words, "--folder", str(self.folder))

    def kill(self, what: str) -> None:
        """End a process by SIGKILL, and start what a user would start then."""
        victim = {"worker": "worker 1"}.get(what, what)
        self.parts[victim].send_signal(signal.SIGKILL)
        self.parts[victim].wait()
        if what == "worker":
            self.worker(victim)
        elif what == "client":
            self.client()
        else:
            # The client is told that the scheduler is gone, and ends by itself.
            code = self.parts["client"].wait(_PATIENCE)
            said = (self.folder / "client.log").read_text()
            assert code == 1, (code, said)
            assert "what is finished is kept" in said, said
            self.end()
            self.scheduler()

    def end(self) -> None:
        for part in self.parts.values():
            if part.poll() is None:
                part.terminate()
        for part in self.parts.values():
            try:
                part.wait(30.0)
            except subprocess.TimeoutExpired:
                part.kill()
                part.wait()


def done_cases(folder: Path, cases: int) -> np.ndarray:
    """Return which cases are stored, as their parameters `(N, 2)`."""
    import zarr

    try:
        group = zarr.open_group(folder / "killed.zarr", mode="r", use_consolidated=False)
        done = np.argwhere(np.asarray(group["state"][:]) == 1)
        angle, torque = np.asarray(group["angle"][:]), np.asarray(group["torque"][:])
    except (FileNotFoundError, KeyError):
        return np.empty((0, 2))
    return np.stack([angle[done[:, 0]], torque[done[:, 1]]], axis=1)


def calls_after(folder: Path, moment: float) -> set[tuple[float, float]]:
    found = set()
    for path in folder.glob("calls-*"):
        for line in path.read_text().splitlines():
            words = line.split()
            if len(words) == 3 and float(words[0]) > moment:
                found.add((float(words[1]), float(words[2])))
    return found


def content(store: Path) -> dict[str, bytes]:
    """Return all files of a store; an unfinished write leaves a partial one, which nobody reads."""
    return {
        str(path.relative_to(store)): path.read_bytes()
        for path in sorted(store.rglob("*"))
        if path.is_file() and path.suffix != ".partial"
    }


def campaign(cases: int, rounds: int, seed: int) -> None:
    chance = random.Random(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        cluster = Cluster(folder, cases)
        began = time.time()
        try:
            victims = [what for _ in range(rounds) for what in chance.sample(_VICTIMS, 3)]
            marks = sorted(chance.uniform(0.05, 0.9) for _ in victims)
            seen: list[tuple[float, np.ndarray]] = []
            for what, mark in zip(victims, marks, strict=True):
                stored = done_cases(folder, cases)
                while len(stored) < mark * cases:
                    assert time.time() < began + _PATIENCE, "the study does not go on"
                    assert cluster.parts["client"].poll() is None, _log(folder)
                    time.sleep(0.05)
                    stored = done_cases(folder, cases)
                seen.append((time.time(), stored))
                cluster.kill(what)
                print(f"{len(stored)} cases stored: killed the {what}", flush=True)
            code = cluster.parts["client"].wait(_PATIENCE)
            assert code == 0, _log(folder)
        finally:
            cluster.end()
        for moment, stored in seen:
            again = {tuple(case) for case in stored.tolist()} & calls_after(folder, moment)
            assert not again, f"{len(again)} finished cases were computed again"
        called = sum(len(path.read_text().splitlines()) for path in folder.glob("calls-*"))
        print(f"{called} calls for {cases} cases; no finished case was called again")
        # With the same path for calls, which is one of the attributes of the function.
        study_of(folder / "calls", folder / "calm.zarr", cases, workers=1).run()
        killed, calm = content(folder / "killed.zarr"), content(folder / "calm.zarr")
        assert killed.keys() == calm.keys(), killed.keys() ^ calm.keys()
        different = [path for path in calm if killed[path] != calm[path]]
        assert not different, different
        print(f"{len(calm)} files of the store are those of an undisturbed study, byte for byte")


def _log(folder: Path) -> str:
    return (folder / "client.log").read_text()[-3000:]


_VICTIMS = ["worker", "scheduler", "client"]

if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--cases", type=int, default=20_000)
    parser.add_argument("--rounds", type=int, default=1, help="times three kills")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--client", help=argparse.SUPPRESS)
    parser.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.client:
        client(given.client, given.folder, given.cases)
    else:
        campaign(given.cases, given.rounds, given.seed)
