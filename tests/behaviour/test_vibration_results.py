"""Results of the vibration as their users meet them: written, read back, copied, in threads."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn import vibration

SPEEDS = np.linspace(0.9, 1.1, 5)
ANGLES = np.radians([10.0, 40.0])
NAMES = (
    *("motion", "linearisation", "campbell", "response", "bare response", "missed", "floquet"),
    *("chart", "critical", "calm", "run-up"),
)


def _line(damping: float = 0.1) -> cd.Scene:
    line = elastic_rigs.torsional_line(damping_in=damping)
    return elastic_rigs.scene(line, np.radians(10.0))


def _results() -> dict[str, Any]:
    """One of every class, of a line that has unstable speeds where its joint angle is great."""
    scene, undamped = _line(), _line(0.0)
    return {
        "motion": vibration.periodic_motion(scene, SPEEDS),
        "linearisation": vibration.linearise(scene, 0.7),
        "campbell": vibration.campbell(scene, SPEEDS),
        "response": vibration.forced_response(scene, SPEEDS, joints=["bearing_out", "twist_in"]),
        "bare response": vibration.forced_response(scene, SPEEDS, joints=[]),
        "missed": vibration.forced_response(_line(0.01), [0.5, 0.8], joints=[], max_amplitude=0.02),
        "floquet": vibration.floquet(scene, SPEEDS),
        "chart": vibration.floquet(undamped, SPEEDS, held={"joint_angle": ANGLES}, edges=True),
        "critical": vibration.critical_speeds(undamped, [0.8, 1.2], orders=(1, 2.5)),
        "calm": vibration.critical_speeds(scene, [1.6, 1.7]),
        "run-up": vibration.run_up(scene, 0.6, 0.7, 30.0),
    }


@pytest.fixture(scope="module")
def results() -> dict[str, Any]:
    results = _results()
    assert tuple(results) == NAMES
    # There is something of everything to be written.
    assert results["missed"].missed
    assert [len(found) for found in results["chart"].region] == [1, 1]
    assert len(results["critical"]) > 1
    assert not len(results["calm"])
    return results


def _read(path: Path) -> dict[str, np.ndarray]:
    with np.load(path) as stored:  # No pickled objects are allowed.
        return {name: stored[name] for name in stored.files}


def _parts(result: Any) -> dict[str, Any]:
    """Every array, number and name of a result by the name that it should have in a file."""
    parts: dict[str, Any] = {"drive": result.scene.drives[0], "free": result.scene.free}
    for field in fields(result):
        value = getattr(result, field.name)
        if field.name == "missed":
            parts |= {"missed.speed": list(value), "missed.reason": list(value.values())}
        elif isinstance(value, Mapping):
            parts |= {f"{field.name}.{key}": item for key, item in value.items()}
        elif field.name == "campbell":
            own = _parts(value)
            parts |= {f"campbell.{key}": own[key] for key in own if key not in ("drive", "free")}
        elif field.name == "rows":
            for column in vibration.CriticalSpeed._fields:
                parts[f"table.{column}"] = [getattr(row, column) for row in value]
        elif field.name == "barriers":
            for column in vibration.TorqueBarrier._fields:
                parts[f"barriers.{column}"] = [getattr(item, column) for item in value]
        elif field.name == "region":
            every = [(design, row) for design, found in enumerate(value) for row in found]
            if value:
                parts["region.design"] = [design for design, _ in every]
                for column in vibration.Region._fields:
                    parts[f"region.{column}"] = [getattr(row, column) for _, row in every]
        elif field.name != "scene":
            parts[field.name] = value
    return parts


@pytest.mark.slow
@pytest.mark.parametrize("name", NAMES)
def test_a_saved_result_is_read_back_whole(
    results: dict[str, Any], name: str, tmp_path: Path
) -> None:
    result = results[name]
    result.save(tmp_path / "result.npz")
    stored, expected = _read(tmp_path / "result.npz"), _parts(result)
    assert set(stored) == set(expected)
    for key, value in expected.items():
        array = np.asarray(value)
        assert stored[key].shape == array.shape, key
        if array.size:
            assert stored[key].dtype == array.dtype, key
        np.testing.assert_array_equal(stored[key], array, err_msg=key)


@pytest.mark.slow
def test_files_of_names_are_read_without_pickle(results: dict[str, Any], tmp_path: Path) -> None:
    results["response"].save(tmp_path / "response.npz")
    stored = _read(tmp_path / "response.npz")
    assert stored["drive"] == "bearing_in"
    assert stored["free"].tolist() == ["twist_in"]
    assert stored["joints"].tolist() == ["bearing_out", "twist_in"]


@pytest.mark.parametrize("name", NAMES)
def test_copies_are_the_same(results: dict[str, Any], name: str, tmp_path: Path) -> None:
    result = results[name]
    for twin in (copy.copy(result), copy.deepcopy(result), pickle.loads(pickle.dumps(result))):
        assert repr(twin) == repr(result)
        own, other = (_read(item.save(tmp_path / "all.npz")) for item in (result, twin))
        assert set(own) == set(other)
        for key, value in own.items():
            np.testing.assert_array_equal(other[key], value, err_msg=key)


@pytest.mark.slow
def test_scenes_serve_several_threads() -> None:
    """None of which forks: it might do so while another one holds a lock."""
    scene = _line()
    twins = [scene, copy.deepcopy(scene), pickle.loads(pickle.dumps(scene)), scene]

    def work(given: cd.Scene) -> list[np.ndarray]:
        chart = vibration.floquet(given, SPEEDS, held={"joint_angle": ANGLES}, workers=2)
        return [chart.trace, vibration.forced_response(given, SPEEDS).wrench]

    with ThreadPoolExecutor(1) as pool:
        expected = pool.submit(work, _line()).result()
    with ThreadPoolExecutor(len(twins)) as pool:
        for found in pool.map(work, twins):
            for own, other in zip(found, expected, strict=True):
                np.testing.assert_array_equal(own, other)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("urdf", "unit", "mass", "prefix"),
    [
        (elastic_rigs.torsional_line(damping_in=0.1), "rad", "kg·m²", ""),
        (elastic_rigs.rotor(), "m", "kg", "p"),  # It swings by 90 pm.
    ],
)
def test_figures_have_the_units_of_what_they_draw(
    urdf: str, unit: str, mass: str, prefix: str
) -> None:
    scene = elastic_rigs.scene(urdf, 0.1)
    speeds = [0.3, 0.4]
    motion, response = (
        vibration.periodic_motion(scene, 0.3),
        vibration.forced_response(scene, speeds),
    )
    assert motion.plot().axes[0].get_ylabel() == f"free coordinates [{prefix}{unit}]"
    assert response.plot().axes[0].get_ylabel() == f"amplitude [{unit}]"
    linear = vibration.linearise(scene, 0.3)
    first, *_ = linear.plot().axes
    assert first.get_ylabel() == f"mass [{mass}]"
    # Over a whole period: what it begins with is what it ends with.
    line = first.lines[0]
    assert line.get_xdata()[-1] == pytest.approx(np.degrees(linear.period))
    assert line.get_ydata()[-1] == line.get_ydata()[0]
