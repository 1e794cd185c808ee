"""Studies: what comes out is what a loop gives, whoever computes it, and what is done stays."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm, uniform

import cardan_dyn as cd
from cardan_dyn import studies


def product_of(a: float, b: float) -> dict[str, Any]:
    if b > 2.5 and a > 0.5:
        raise ValueError(f"{b} is too great")
    return {"x": a * b, "y": np.array([a, b, a - b])}


GRID = {"a": (np.linspace(0.0, 1.0, 5), "rad"), "b": [1.0, 2.0, 3.0]}


def test_results_are_those_of_a_loop() -> None:
    study = cd.study(product_of, GRID, units={"x": "m"}, workers=1).run()
    data = study.dataset
    assert data.x.dims == ("a", "b")
    assert data.a.attrs["units"] == "rad"
    assert data.x.attrs["units"] == "m"
    for i, a in enumerate(data.a.values):
        for j, b in enumerate(data.b.values):
            if b > 2.5 and a > 0.5:
                assert np.isnan(data.x[i, j])
                assert data.state[i, j] == 2
            else:
                assert data.x[i, j] == a * b
                np.testing.assert_array_equal(data.y[i, j], [a, b, a - b])


def test_variables_stand_in_the_order_in_which_they_were_named(tmp_path: Path) -> None:
    names = [f"{letter}_result" for letter in "qzwaxkmb"]

    def function(**given: float) -> dict[str, float]:
        return dict.fromkeys(names, sum(given.values()))

    parameters = {name: ([1.0, 2.0], "rad") for name in ("v", "c", "u", "d")}
    for place in (None, tmp_path / "study.zarr"):
        data = cd.study(function, parameters, store=place, workers=1).run().dataset
        assert list(data.data_vars) == [*names, "state"]
        assert list(data.coords) == ["v", "c", "u", "d"]
        assert data["c"].attrs["units"] == "rad"


def test_units_of_no_result_are_refused() -> None:
    study = cd.study(product_of, GRID, units={"xx": "m"}, workers=1)
    for ask in (study.plan, study.run):
        with pytest.raises(cd.ArgumentError, match=r"units\['xx'\]: .* results: .*mean 'x'"):
            ask()


def test_failures_are_a_table() -> None:
    failures = cd.study(product_of, GRID, workers=1, chunk=4).run().failures
    assert list(failures.columns) == ["a_index", "b_index", "a", "b", "type", "message"]
    assert failures.a.tolist() == [0.75, 1.0]
    assert set(failures.type) == {"ValueError"}
    assert failures.message.tolist() == ["3.0 is too great"] * 2


@pytest.mark.slow
def test_nothing_is_imported_before_it_is_used() -> None:
    code = (
        "import sys, cardan_dyn as cd; cd.study; cd.studies.Sweeps\n"
        "print(sorted({'dask', 'distributed', 'zarr', 'xarray', 'pandas'} & set(sys.modules)))"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"


class Counted:
    """A function that writes each call down, so that calls in other processes count as well."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def __call__(self, a: float, b: float) -> float:
        with self.path.open("a") as file:
            file.write(f"{a} {b}\n")
        return a + b

    @property
    def calls(self) -> int:
        return len(self.path.read_text().splitlines()) if self.path.exists() else 0


@pytest.mark.slow
def test_a_run_computes_what_is_missing_and_nothing_else(tmp_path: Path) -> None:
    function, place = Counted(tmp_path / "calls"), tmp_path / "study.zarr"
    cd.study(function, GRID, store=place, workers=1, chunk=2).run()
    function.path.unlink()
    cd.study(function, GRID, store=place, workers=1).run()
    assert function.calls == 0
    longer = {"a": (np.linspace(0.0, 1.5, 7), "rad"), "b": [1.0, 2.0, 3.0, 4.0]}
    study = cd.study(function, longer, store=place, workers=1).run()
    assert function.calls == 7 * 4 - 5 * 3
    a, b = np.linspace(0.0, 1.5, 7), np.arange(1.0, 5.0)
    np.testing.assert_array_equal(study.dataset.value, a[:, None] + b)


def test_what_differs_is_refused(tmp_path: Path) -> None:
    place = tmp_path / "study.zarr"
    cd.study(product_of, GRID, store=place, workers=1).run()
    cases: list[tuple[Any, Any, str]] = [
        (product_of, {"a": (np.linspace(0.0, 2.0, 5), "rad"), "b": [1.0, 2.0, 3.0]}, "values of"),
        (product_of, {"a": np.linspace(0.0, 1.0, 5), "b": [1.0, 2.0, 3.0]}, "units of"),
        (product_of, {"a": (np.linspace(0.0, 1.0, 5), "rad"), "b": [1.0]}, "3 points there"),
        (product_of, {"b": [1.0, 2.0, 3.0], "a": [0.0]}, "dimensions are a, b"),
        (
            lambda a, b: {"x": a * b, "y": [a, b, a + b]},
            GRID,
            "it is one of product_of, and not of .*lambda",
        ),
    ]
    for function, parameters, said in cases:
        with pytest.raises(cd.CardanError, match=said):
            cd.study(function, parameters, store=place, workers=1).run()


SAMPLES = studies.samples({"a": (norm(1.0, 0.1), "rad"), "b": uniform(0.0, 3.0)}, 50, seed=3)


def test_results_do_not_depend_on_who_computes_them(tmp_path: Path) -> None:
    alone = cd.study(product_of, SAMPLES, workers=1, chunk=7).run().dataset
    with ThreadPoolExecutor(3) as executor:
        others = cd.study(product_of, SAMPLES, executor=executor, chunk=7).run().dataset
    assert alone.drop_attrs().identical(others.drop_attrs())


def test_retried_cases_are_computed_alone(tmp_path: Path) -> None:
    switch = tmp_path / "switch"

    def function(a: float) -> float:
        if a > 2.0 and not switch.exists():
            raise RuntimeError("not yet")
        return a

    place = tmp_path / "study.zarr"
    study = cd.study(function, {"a": np.arange(5.0)}, store=place, workers=1, chunk=2).run()
    assert len(study.failures) == 2
    switch.touch()
    study.run()
    assert len(study.failures) == 2
    assert study.plan().failed == 2
    assert "5, 5 of them done (2 failed): a 5" in str(study.plan())
    study.run(retry=True)
    assert "5, 5 of them done: a 5" in str(study.plan())
    assert study.failures.empty
    np.testing.assert_array_equal(study.dataset.value, np.arange(5.0))


def test_sweeps_are_one_call_per_chunk(joint: cd.Mechanism, monkeypatch: Any) -> None:
    scene = cd.Scene(
        joint, drive="bearing_in", held={"joint_angle": 0.5}, loads={"bearing_out": -100.0}
    )
    turn = np.linspace(0.0, 2.0 * np.pi, 73)
    wanted = {"peak": ("bearing_out.bending", "max"), "torque": "drive_effort"}
    angles = np.linspace(0.1, 1.0, 6)
    parameters = {"held.joint_angle": (angles, "rad"), "loads.bearing_out": [-100.0, -50.0]}
    function = studies.Sweeps(scene, wanted, position=turn)
    study = cd.study(function, parameters, workers=1, chunk=12)
    assert "one call of sweep" in str(study.plan())
    calls = []
    original = cd.Scene.sweep
    monkeypatch.setattr(cd.Scene, "sweep", lambda *a, **k: calls.append(1) or original(*a, **k))
    data = study.run().dataset
    assert len(calls) == 1
    # Grossmann: the greatest bending moment of the output shaft is the torque times tan β.
    expected = np.outer(np.tan(angles), [100.0, 50.0])
    np.testing.assert_allclose(data.peak, expected, rtol=1e-9)
    assert data.torque.dims == ("held.joint_angle", "loads.bearing_out", "position")
    assert data.peak.attrs["units"] == "N·m"
    assert data.position.attrs["units"] == "rad"


def test_what_is_not_installed_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    original = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "zarr" else original(name)
    )
    with pytest.raises(cd.MissingExtraError, match=r"needs zarr: pip install .*study"):
        cd.study(product_of, GRID)
