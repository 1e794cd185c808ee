"""Stores: local, in memory or of objects; what cannot be kept is said before, or loses nothing."""

from __future__ import annotations

import errno
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
import pytest
import xarray
import zarr

import cardan_dyn as cd
from cardan_dyn import studies
from cardan_dyn.practice.studies.store import Store


def half(a: float) -> dict[str, Any]:
    return {"half": a / 2.0, "row": np.full(3, a)}


AXIS = {"a": (np.arange(10.0), "m")}


@pytest.mark.slow
def test_object_storage_works_as_a_local_store_does(tmp_path: Path) -> None:
    place = "memory://studies/half.zarr"
    local = cd.study(half, AXIS, store=tmp_path / "half.zarr", workers=1, chunk=3).run().dataset
    study = cd.study(half, AXIS, store=place, workers=1, chunk=3).run()
    assert study.dataset.drop_attrs().identical(local.drop_attrs())
    longer = cd.study(half, {"a": (np.arange(12.0), "m")}, store=place, workers=1).run()
    np.testing.assert_array_equal(longer.dataset.half, np.arange(12.0) / 2.0)
    with pytest.raises(cd.CardanError, match="another study"):
        cd.study(half, {"a": np.ones(12)}, store=place, workers=1).run()


def test_results_can_be_read_while_others_are_computed(tmp_path: Path) -> None:
    place, seen = tmp_path / "half.zarr", []

    def look(done: int, failed: int) -> None:
        data = xarray.open_zarr(place, consolidated=False)
        states = data.state.values
        # What is done is right, whenever it is looked at.
        np.testing.assert_array_equal(
            data.half.values[states == 1], np.arange(10.0)[states == 1] / 2
        )
        seen.append((done, int(states.sum())))

    cd.study(half, AXIS, store=place, workers=1, chunk=4).run(progress=look)
    assert seen == [(4, 4), (8, 8), (10, 10)]


def test_a_chunk_counts_once_all_of_it_is_there(tmp_path: Path, monkeypatch: Any) -> None:
    """Ended between two arrays, a chunk is absent, and computed again."""
    place = tmp_path / "half.zarr"
    original, written = zarr.Array.__setitem__, []

    def ending(array: Any, key: Any, value: Any) -> None:
        if array.basename == "row" and len(written) == 2:
            raise SystemExit("killed")
        if array.basename == "half":
            written.append(key)
        original(array, key, value)

    with monkeypatch.context() as patch:
        patch.setattr(zarr.Array, "__setitem__", ending)
        with pytest.raises(SystemExit):
            cd.study(half, AXIS, store=place, workers=1, chunk=4).run()
    study = cd.study(half, AXIS, store=place, workers=1)
    np.testing.assert_array_equal(study.dataset.state, [1] * 4 + [0] * 6)
    assert study.plan().done == 4
    np.testing.assert_array_equal(study.run().dataset.row[:, 0], np.arange(10.0))


class FullStore(zarr.storage.WrapperStore):
    """A disk on which no more than some objects have room."""

    room = 10**9

    def with_read_only(self, read_only: bool = False) -> FullStore:
        return type(self)(self._store.with_read_only(read_only))

    async def set(self, key: str, value: Any, *more: Any) -> None:
        type(self).room -= 1
        if type(self).room < 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        await super().set(key, value, *more)


def test_a_full_disk_loses_nothing(tmp_path: Path) -> None:
    FullStore.room = 10**9
    place = FullStore(zarr.storage.LocalStore(tmp_path / "half.zarr"))
    study = cd.study(half, AXIS, store=place, workers=1, chunk=2)

    def fill(done: int, failed: int) -> None:
        FullStore.room = 4 if done == 4 else FullStore.room

    with pytest.raises(cd.CardanError, match=r"No space left.*make room.*what is finished is kept"):
        study.run(progress=fill)
    FullStore.room = 10**9
    done = int(study.dataset.state.sum())
    assert 4 <= done < 10
    np.testing.assert_array_equal(study.run().dataset.half, np.arange(10.0) / 2.0)


def test_too_little_room_is_said_before_anything_is_computed(
    tmp_path: Path, monkeypatch: Any
) -> None:
    monkeypatch.setattr(Store, "free", 5.0)
    with pytest.raises(cd.CardanError, match="may take 330 bytes, and 5 bytes are free"):
        cd.study(half, AXIS, store=tmp_path / "half.zarr", workers=1).run()
    assert not (tmp_path / "half.zarr").exists()


def test_a_read_only_store_is_refused_and_still_read(tmp_path: Path) -> None:
    place = tmp_path / "half.zarr"
    cd.study(half, AXIS, store=place, workers=1).run()
    closed = zarr.storage.LocalStore(place, read_only=True)
    more = cd.study(half, {"a": (np.arange(12.0), "m")}, store=closed, workers=1)
    with pytest.raises(cd.CardanError, match="read-only: name another store"):
        more.run()
    assert cd.study(half, AXIS, store=closed, workers=1).run().dataset.half.shape == (10,)


def test_what_is_no_study_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "thesis.txt").write_text("years of work")
    with pytest.raises(cd.CardanError, match="no study; name another store"):
        cd.study(half, AXIS, store=tmp_path / "full", workers=1).run()
    assert (tmp_path / "full" / "thesis.txt").exists()
    zarr.open_group(tmp_path / "group.zarr", mode="w").attrs["owner"] = "somebody"
    with pytest.raises(cd.CardanError, match="no study; name another store"):
        cd.study(half, AXIS, store=tmp_path / "group.zarr", workers=1).run()
    zarr.create_array(tmp_path / "array.zarr", data=np.zeros(3))
    with pytest.raises(cd.CardanError, match=r"array\.zarr"):
        cd.study(half, AXIS, store=tmp_path / "array.zarr", workers=1).run()


def test_a_function_that_cannot_be_sent_is_refused_first() -> None:
    lock = Lock()

    def locked(a: float) -> float:
        with lock:
            return a

    with pytest.raises(cd.CardanError, match=r"cannot be pickled.*make files, locks"):
        cd.study(locked, AXIS).plan()


def test_provenance_is_in_the_dataset(joint: cd.Mechanism) -> None:
    scene = cd.Scene(joint, drive="bearing_in", held={"joint_angle": 0.5})
    wanted = studies.Sweeps(scene, "bearing_out.torsion")
    study = cd.study(wanted, {"position": [0.0, 1.0], "loads.bearing_out": [-1.0]}, workers=1)
    told = study.run().dataset.attrs
    assert cd.__version__ in told["study_versions"]
    assert "universal_joint" in told["study_descriptions"]
    assert "<robot" in told["study_descriptions"]
    assert "description of 'universal_joint'" in told["study_parts"]
    assert {"study_machine", "study_parameters"} <= set(told)


def test_a_changed_description_is_noticed(tmp_path: Path, joint: cd.Mechanism) -> None:
    def wanted(mechanism: cd.Mechanism) -> studies.Sweeps:
        scene = cd.Scene(mechanism, drive="bearing_in", held={"joint_angle": 0.5})
        return studies.Sweeps(scene, "drive_effort")

    axis = {"loads.bearing_out": [-1.0, -2.0], "position": [0.1]}
    place = tmp_path / "study.zarr"
    cd.study(wanted(joint), axis, store=place, workers=1).run()
    text = joint.to_urdf()
    changed = cd.load(text.replace('mass value="1.36', 'mass value="1.46'))
    with pytest.raises(cd.CardanError, match="the description of 'universal_joint' differs"):
        cd.study(wanted(changed), axis, store=place, workers=1).run()


def test_every_case_failing_is_said_at_once() -> None:
    def broken(a: float) -> float:
        raise RuntimeError("no such thing")

    with pytest.raises(cd.CardanError, match=r"none of 8 cases.*'a': 0.0.*no such thing"):
        cd.study(broken, AXIS, workers=1).plan()


@pytest.mark.parametrize(
    ("function", "said"),
    [
        (lambda a: "word", "a study keeps numbers"),
        (lambda a: {}, "returned nothing"),
        (lambda a: {"state": a}, "none of failure, state"),
        (lambda a: xarray.Dataset({"state": a}), "none of failure, state"),
        (lambda a: xarray.Dataset({"y": ("failure", [a])}), "none of failure, state"),
        (lambda a: xarray.Dataset({"y": ("x", [a])}, {"state": ("x", [1])}), "coordinate .*state"),
        (lambda a: {"y\\z": a}, "without a slash"),
        (lambda a: 2**60 + 1, "no double is"),
    ],
)
def test_what_no_study_can_keep_is_refused(function: Any, said: str) -> None:
    with pytest.raises(cd.CardanError, match=said):
        cd.study(function, AXIS, workers=1).plan()


def test_cases_of_another_shape_are_failures() -> None:
    def growing(a: float) -> Any:
        return {"x": np.zeros(3 if a > 7.0 else 2)} if a < 9.0 else {"y": a}

    failures = cd.study(growing, AXIS, workers=1).run().failures
    assert failures.a.tolist() == [8.0, 9.0]
    assert "as in the first one" in failures.message[0]
    assert "Return the same names" in failures.message[1]


def test_datasets_are_kept_with_their_coordinates() -> None:
    def curve(a: float) -> xarray.Dataset:
        at = np.linspace(0.0, 1.0, 4)
        return xarray.Dataset(
            {"y": ("at", a * at, {"units": "N"}), "n": ((), 3)}, {"at": ("at", at, {"units": "s"})}
        )

    data = cd.study(curve, AXIS, workers=1).run().dataset
    assert data.y.dims == ("a", "at")
    assert data.y.attrs["units"] == "N"
    assert data["at"].attrs["units"] == "s"
    np.testing.assert_array_equal(data.y.sel(a=4.0), 4.0 * np.linspace(0.0, 1.0, 4))
    assert data.n.dtype == float


def test_vectorized_functions_take_a_chunk_in_one_call() -> None:
    calls = []

    def product(a: np.ndarray, b: np.ndarray) -> dict[str, np.ndarray]:
        calls.append(np.broadcast_shapes(a.shape, b.shape))
        return {"x": a * b, "of_a": a**2, "rows": np.stack(np.broadcast_arrays(a, b), -1)}

    axes = {"a": np.arange(6.0), "b": np.arange(4.0)}
    study = cd.study(product, axes, vectorized=True, workers=1, chunk={"a": 3, "b": 4})
    assert "one call of the function with arrays" in study.plan().how
    data = study.run().dataset
    np.testing.assert_array_equal(data.x, np.outer(np.arange(6.0), np.arange(4.0)))
    np.testing.assert_array_equal(data.of_a, np.repeat(np.arange(6.0)[:, None] ** 2, 4, axis=1))
    assert data.rows.shape == (6, 4, 2)

    with pytest.raises(cd.ArgumentError, match="not vectorized"):
        cd.study(lambda a: a / np.max(a), {"a": [1.0, 2.0]}, vectorized=True, workers=1).plan()


def test_what_fails_in_a_call_of_many_is_found_by_halves() -> None:
    def root(a: np.ndarray) -> np.ndarray:
        if np.any(a == 7.0):
            raise ValueError("seven")
        return np.sqrt(a)

    study = cd.study(root, {"a": np.arange(64.0)}, vectorized=True, workers=1, chunk=64).run()
    assert study.failures.a.tolist() == [7.0]
    np.testing.assert_array_equal(
        study.dataset.value.dropna("a"), np.sqrt(np.delete(np.arange(64.0), 7))
    )


def test_a_store_that_was_extended_meanwhile_is_not_shortened(tmp_path: Path) -> None:
    place = tmp_path / "half.zarr"
    first = cd.study(half, AXIS, store=place, workers=1, chunk=4).run()
    cd.study(half, {"a": (np.arange(14.0), "m")}, store=place, workers=1).run()
    with pytest.raises(cd.CardanError, match="14 points there and 10 here"):
        first.run()
    assert xarray.open_zarr(place, consolidated=False).sizes["a"] == 14


def test_another_studys_results_are_not_shown(tmp_path: Path) -> None:
    cd.study(half, AXIS, store=tmp_path / "half.zarr", workers=1).run()
    other = cd.study(half, {"a": np.ones(10)}, store=tmp_path / "half.zarr", workers=1)
    for look in (lambda: other.dataset, lambda: other.failures, other.plan):
        with pytest.raises(cd.CardanError, match="another study"):
            look()


@pytest.mark.slow
def test_an_extension_that_was_killed_goes_on(tmp_path: Path, monkeypatch: Any) -> None:
    place = tmp_path / "half.zarr"
    cd.study(half, AXIS, store=place, workers=1, chunk=4).run()
    longer = {"a": (np.arange(14.0), "m")}

    def killed(what: str, ending: Any) -> None:
        with monkeypatch.context() as patch:
            patch.setattr(zarr.Array, what, ending)
            with pytest.raises(SystemExit):
                cd.study(half, longer, store=place, workers=1).run()

    def before(array: Any, key: Any, value: Any) -> None:
        raise SystemExit("killed")

    def within(array: Any, attributes: Any) -> None:
        if array.basename == "row":
            raise SystemExit("killed")
        original(array, attributes)

    original = zarr.Array.update_attributes
    killed("__setitem__", before)
    assert cd.study(half, AXIS, store=place, workers=1).run().dataset.row.shape == (10, 3)
    killed("update_attributes", within)
    study = cd.study(half, longer, store=place, workers=1)
    assert study.plan().done == 10
    with pytest.warns(UserWarning, match=r"damaged beside its cases \(half: .*another shape"):
        data = study.run().dataset
    np.testing.assert_array_equal(data.half, np.arange(14.0) / 2.0)


class Learning:
    """A function whose results depend on how often it was called."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, a: float) -> float:
        self.calls += 1
        return a + 100.0 * self.calls


def test_what_a_function_learns_while_it_is_timed_makes_no_difference(tmp_path: Path) -> None:
    function = Learning()
    study = cd.study(function, AXIS, workers=1, chunk=5)
    study.plan()
    expected = np.arange(10.0) + 100.0 * np.tile(np.arange(1.0, 6.0), 2)
    np.testing.assert_array_equal(study.run().dataset.value, expected)
    assert function.calls == 0


def test_ctrl_c_keeps_what_is_finished(tmp_path: Path) -> None:
    place = tmp_path / "half.zarr"

    def press(done: int, failed: int) -> None:
        if done >= 4:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        cd.study(half, AXIS, store=place, workers=1, chunk=2).run(progress=press)
    study = cd.study(half, AXIS, store=place, workers=1)
    assert study.plan().done == 4
    assert int(study.run().dataset.state.sum()) == 10


def test_names_that_clash_are_refused() -> None:
    def named(a: float) -> dict[str, float]:
        return {"a": a}

    with pytest.raises(cd.ArgumentError, match="a is a parameter"):
        cd.study(named, AXIS, workers=1).plan()


def never(**given: float) -> float:
    raise AssertionError("a case was computed")


@pytest.mark.parametrize(
    "name", ["state", "failure", "zarr.json", "a/b", "a\\b", "type", "message"]
)
def test_names_of_what_every_study_has_are_refused_before_anything_is_computed(name: str) -> None:
    with pytest.raises(cd.ArgumentError, match=r"a parameter is called|column of what failed"):
        cd.study(never, {name: [1.0]}, workers=1)


def test_names_of_dimensions_are_refused_likewise() -> None:
    with pytest.raises(cd.ArgumentError, match="a dimension is called 'state'"):
        cd.study(never, studies.points({"a": [1.0]}, dim="state"))
    with pytest.raises(cd.ArgumentError, match="a_index is a parameter, and a column"):
        cd.study(never, {"a": [1.0], "a_index": [2.0]})


@pytest.mark.slow
def test_a_store_that_was_killed_while_it_was_made_is_made_again(
    tmp_path: Path, monkeypatch: Any
) -> None:
    original = zarr.Array.update_attributes
    for count in range(1, 5):
        place, made = tmp_path / f"{count}.zarr", []

        def ending(array: Any, attributes: Any) -> Any:
            made.append(1)  # noqa: B023
            if len(made) == count:  # noqa: B023
                raise SystemExit("killed")
            return original(array, attributes)

        with monkeypatch.context() as patch:
            patch.setattr(zarr.Array, "update_attributes", ending)
            with pytest.raises(SystemExit):
                cd.study(half, AXIS, store=place, workers=1).run()
        assert int(cd.study(half, AXIS, store=place, workers=1).run().dataset.state.sum()) == 10
    left = tmp_path / "left.zarr"
    left.mkdir()
    (left / "zarr.0123.partial").write_text("{")
    assert cd.study(half, AXIS, store=left, workers=1).run().failures.empty


def test_results_along_other_axes_are_failures() -> None:
    """Numbers of the same shape that belong elsewhere would be wrong in silence."""

    def table(a: float) -> xarray.Dataset:
        dims = ("x", "y") if a < 8.0 else ("y", "x")
        at = [0.0, 1.0] if a < 9.0 else [0.0, 2.0]
        return xarray.Dataset({"z": (dims if a < 9.0 else ("x", "y"), np.eye(2))}, {"x": at})

    failures = cd.study(table, AXIS, workers=1).run().failures
    assert failures.a.tolist() == [8.0, 9.0]
    assert "return them in one order" in failures.message[0]
    assert "the coordinate x is another one" in failures.message[1]


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ([1, 2], [1, 2, 2.5]),
        (np.array([1, 2], np.int8), [1, 2, 300]),
        (np.array([1.0, 2.0], np.float32), [1.0, 2.0, 0.1]),
        ([False, True], [False, True, 0.5]),
        ([2**53, 2**53 + 1], [2**53, 2**53, 5]),
    ],
)
def test_coordinates_are_never_cut_where_a_study_is_extended(
    before: Any, after: Any, tmp_path: Path
) -> None:
    """The type of an axis is that of its first values: others would be there as other numbers."""

    def number(x: float) -> float:
        return float(x)

    place = tmp_path / "axis.zarr"
    cd.study(number, {"x": before}, store=place, workers=1).run()
    with pytest.raises(cd.CardanError, match=r"of type|values of parameter x differ"):
        cd.study(number, {"x": after}, store=place, workers=1).run()


def test_whole_values_extend_an_axis_of_any_type(tmp_path: Path) -> None:
    def twice(x: float) -> float:
        return 2.0 * x

    place = tmp_path / "axis.zarr"
    cd.study(twice, {"x": np.array([1, 2], np.int8)}, store=place, workers=1).run()
    data = cd.study(twice, {"x": [1.0, 2.0, 100.0]}, store=place, workers=1).run().dataset
    np.testing.assert_array_equal(data.x, [1, 2, 100])
    np.testing.assert_array_equal(data["value"], [2.0, 4.0, 200.0])


def test_any_error_is_kept_as_a_failure() -> None:
    """One whose text no file takes, one that cannot say itself, one that would end the process."""

    class MuteError(Exception):
        def __str__(self) -> str:
            raise RuntimeError

    def failing(x: int) -> int:
        if x:
            raise (ValueError("name \udcff"), MuteError(), SystemExit("bye"))[x - 1]
        return x

    said = cd.study(failing, {"x": [0, 1, 2, 3]}, workers=1).run().failures
    assert said["type"].tolist()[:2] == ["ValueError", "MuteError"]
    assert said.message[0] == "name \\udcff"
    assert "SystemExit: bye" in said.message[2]


def test_numbers_are_kept_as_doubles() -> None:
    """Those of a short type, too: another case may return a double, such as NaN."""

    def short(x: float) -> Any:
        return {"a": np.float32(x) if x < 1 else np.nan, "b": np.complex64(x)}

    study = cd.study(short, {"x": [0.0, 1.0]}, workers=1).run()
    assert study.failures.empty
    assert (study.dataset.a.dtype, study.dataset.b.dtype) == (float, complex)


def test_units_of_no_result_and_results_called_like_dimensions_are_refused() -> None:
    with pytest.raises(cd.CardanError, match="no such result; results: force"):
        cd.study(lambda x: {"force": x}, {"x": [0.0]}, units={"forze": "N"}, workers=1).run()
    with pytest.raises(cd.CardanError, match="a result and a dimension"):
        cd.study(lambda p: {"x": np.ones(3), "x_index": p}, {"p": [0.0]}, workers=1).run()


@pytest.mark.parametrize("function", [np.sort, lambda x: np.arange(5.0)])
def test_functions_of_arrays_that_mix_cases_are_refused(function: Any) -> None:
    """Right at the first values, which rise, or not at all for a case by itself."""
    values = [1.0, 2.0, 3.0, 9.0, 4.0]
    with pytest.raises(cd.CardanError, match=r"not vectorized|of one case"):
        cd.study(lambda x: function(x), {"x": values}, vectorized=True, workers=1).run()
