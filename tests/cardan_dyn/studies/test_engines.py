"""Engines: whoever computes a study, its results are the same bits, and what is lost is said."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

import cardan_dyn as cd
from cardan_dyn import studies
from cardan_dyn.practice.studies.engines import Finished, Here
from cardan_dyn.practice.studies.study import local_client

TURN = np.linspace(0.0, 6.0, 12)


class Moments:
    """A scene that learns while it is used: its sweeps need not be the same to the last bit."""

    def __init__(self) -> None:
        self.scene = cd.Scene(
            cd.load("double_shaft_z"),
            drive="bearing_in",
            held={"joint_angle_1": 0.3, "joint_angle_2": 0.3},
            loads={"bearing_out": -100.0},
        )

    def __call__(self, first: float, second: float) -> dict[str, Any]:
        held = {"joint_angle_1": first, "joint_angle_2": second}
        turn = self.scene.sweep(TURN, held=held)
        return {"bending": turn["bearing_out"].bending, "effort": turn.drive_effort}


def study_of(**options: Any) -> studies.Study:
    laws = {"first": (norm(0.3, 0.02), "rad"), "second": (norm(0.3, 0.02), "rad")}
    return cd.study(Moments(), studies.samples(laws, 40, seed=2), chunk=6, **options)


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    with local_client(2) as connected:
        yield connected


@pytest.mark.slow
def test_results_are_the_same_bits_whoever_computes_them(client: Any) -> None:
    here = study_of(workers=1).run().dataset.load()
    study = study_of(client=client)
    assert "2 threads of the Dask cluster" in study.plan().where
    assert study.run().dataset.drop_attrs().identical(here.drop_attrs())
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as executor:
        others = study_of(executor=executor).run().dataset
        assert others.drop_attrs().identical(here.drop_attrs())


def test_studies_that_share_workers_do_not_take_each_others_job() -> None:
    def of(factor: float) -> studies.Study:
        return cd.study(lambda a: factor * a, {"a": np.arange(20.0)}, executor=executor, chunk=1)

    with ThreadPoolExecutor(2) as executor, ThreadPoolExecutor(2) as beside:
        every = [beside.submit(of(factor).run) for factor in (2.0, 3.0)]
        for factor, study in zip((2.0, 3.0), every, strict=True):
            found = study.result(60.0).dataset.value
            np.testing.assert_array_equal(found, factor * np.arange(20.0))


@pytest.mark.slow
def test_a_case_that_ends_its_worker_is_a_failure_and_stops_no_other(client: Any) -> None:
    def deadly(a: float) -> float:
        if a == 5.0:
            os.kill(os.getpid(), signal.SIGKILL)
        return a

    # With a shape of chunks, the first case alone is computed in this process.
    study = cd.study(deadly, {"a": np.arange(8.0)}, client=client, chunk=1).run()
    assert study.failures.a.tolist() == [5.0]
    assert study.failures.type.tolist() == ["KilledWorker"]
    np.testing.assert_array_equal(study.dataset.value.dropna("a"), [0, 1, 2, 3, 4, 6, 7])


def test_cases_that_only_waited_at_lost_workers_are_no_failures(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Dask gives up everything that a lost worker held, the innocent as well."""
    from distributed.scheduler import KilledWorker

    class Lost(Here):
        room = 3

        def finished(self) -> Iterator[Finished]:
            held = [task.box[0].start for task in self._tasks]
            if 1 not in held:
                yield from super().finished()
                return
            given_up.append(held)
            for task in self._tasks[:]:
                self._tasks.remove(task)
                yield task, KilledWorker("compute", None, 3)  # type: ignore[arg-type]

    given_up: list[list[int]] = []
    monkeypatch.setattr("cardan_dyn.practice.studies.study.Here", Lost)
    found = cd.study(lambda x: x, {"x": np.arange(8.0)}, workers=1, chunk=1).run()
    assert given_up == [[0, 1, 2], [1]]
    assert found.failures.x.tolist() == [1.0]
    np.testing.assert_array_equal(found.dataset.value.dropna("x"), [0, 2, 3, 4, 5, 6, 7])


@pytest.mark.slow
def test_chunks_are_few_and_small_for_the_scheduler(client: Any) -> None:
    """A megabyte that the function holds is sent once, and not with every chunk."""
    weight = np.arange(131_072.0)

    def slow(a: float) -> float:
        time.sleep(0.01)
        return a + weight[1]

    seen = []

    def look(done: int, failed: int) -> None:
        seen.append(client.run_on_scheduler(tasks_of))

    def tasks_of(dask_scheduler: Any) -> tuple[int, int]:
        import pickle

        mine = [task for key, task in dask_scheduler.tasks.items() if "compute" in str(key)]
        return len(mine), max((len(pickle.dumps(task.run_spec)) for task in mine), default=0)

    cd.study(slow, {"a": np.arange(400.0)}, client=client, chunk=5).run(progress=look)
    assert len(seen) == 80
    assert max(count for count, _ in seen) <= 8  # Three for each of two workers, and what ended.
    assert 0 < max(size for _, size in seen) < 3000


@pytest.mark.slow
def test_a_worker_without_the_package_is_refused_before_anything_is_computed() -> None:
    from distributed import Client, LocalCluster

    start = (
        "import sys; sys.modules['cardan_dyn'] = None\n"
        "from distributed.cli.dask_worker import main; main()"
    )
    with (
        LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0") as cluster,
        Client(cluster) as connected,
    ):
        words = ["--nthreads", "1", "--no-nanny", "--no-dashboard", "--host", "127.0.0.1"]
        worker = subprocess.Popen([sys.executable, "-c", start, cluster.scheduler_address, *words])
        try:
            connected.wait_for_workers(1, timeout=60)
            with pytest.raises(cd.CardanError, match=r"cannot import cardan_dyn.*pip install"):
                study_of(client=connected).run()
        finally:
            worker.kill()
            worker.wait()


def half(x: float) -> float:
    return x / 2.0


def test_an_executor_that_is_shut_down_is_said() -> None:
    from concurrent.futures import ThreadPoolExecutor

    executor = ThreadPoolExecutor(1)
    executor.shutdown()
    with pytest.raises(cd.CardanError, match="what is finished is kept"):
        cd.study(half, {"x": [1.0]}, executor=executor).run()


@pytest.mark.slow
@pytest.mark.parametrize("count", [10, 1000])
def test_engines_hold_a_few_chunks_however_many_there_are(count: int) -> None:
    from concurrent.futures import ThreadPoolExecutor

    class Watched(ThreadPoolExecutor):
        waiting = most = 0

        def submit(self, *arguments: Any, **options: Any) -> Any:  # type: ignore[override]
            future = super().submit(*arguments, **options)
            self.waiting += 1
            self.most = max(self.most, self._work_queue.qsize())
            return future

    def plain(x: float) -> float:
        return x

    with Watched(2) as executor:
        cd.study(plain, {"x": np.arange(float(count))}, executor=executor, chunk=5).run()
        assert executor.waiting >= count // 5
        assert executor.most <= 6


def test_arguments_that_contradict_each_other_are_refused() -> None:
    with pytest.raises(cd.ArgumentError, match="expected a dask"):
        cd.study(abs, {"x": [1.0]}, client="tcp://127.0.0.1:8786")
    with pytest.raises(cd.ArgumentError, match=r"expected one of concurrent\.futures"):
        cd.study(abs, {"x": [1.0]}, executor=4)
    with pytest.raises(cd.ArgumentError, match="expected a function"):
        cd.study("abs", {"x": [1.0]})
    with pytest.raises(cd.ArgumentError, match="dimensions are x"):
        cd.study(abs, {"x": [1.0]}, chunk={"y": 2})
