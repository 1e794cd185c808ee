"""Damage: what was written and is not there as it was is computed again and said, or refused."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray
import zarr

import cardan_dyn as cd
from cardan_dyn.practice.studies.parameters import Samples
from cardan_dyn.practice.studies.store import Store
from cardan_dyn.practice.studies.study import Study

LOG = "CARDAN_DYN_CALLS_OF_A_TEST"
"""Variable of the environment that names where calls are written: a global would be a part."""


def computed(a: float, b: float) -> xarray.Dataset:
    if LOG in os.environ:
        with Path(os.environ[LOG]).open("a") as log:
            log.write(f"{a} {b}\n")
    if a == 7.0 and b == 2.0:
        raise ValueError("seven")
    at = np.array([0.5, 1.5])
    curve = ("at", a + b * at, {"units": "N"})
    return xarray.Dataset({"curve": curve, "nothing": ((), np.nan)}, {"at": ("at", at)})


def study_of(store: Any, count: int = 8) -> cd.studies.Study:
    axes = {"a": (np.arange(float(count)), "m"), "b": [1.0, 2.0]}
    return cd.study(computed, axes, store=store, workers=1, chunk={"a": 3, "b": 2})


@pytest.fixture(scope="module")
def kept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    store = tmp_path_factory.mktemp("kept") / "kept.zarr"
    study_of(store).run()
    return store


def calls() -> set[tuple[float, ...]]:
    """Return the cases that were computed in a test."""
    lines = Path(os.environ[LOG]).read_text().splitlines()
    return {tuple(map(float, line.split())) for line in lines}


@pytest.fixture(autouse=True)
def log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "calls").touch()
    monkeypatch.setenv(LOG, str(tmp_path / "calls"))


@pytest.fixture
def store(kept: Path, tmp_path: Path) -> Path:
    return shutil.copytree(kept, tmp_path / "kept.zarr")


def files(store: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(store)): path.read_bytes()
        for path in store.rglob("*")
        if path.is_file()
    }


def flipped(path: Path) -> None:
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 4
    path.write_bytes(data)


def emptied(path: Path) -> None:
    path.write_bytes(b"")


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-5])


def zeroed(path: Path) -> None:
    path.write_bytes(bytes(path.stat().st_size))


CHUNKS = ["curve/c/1/0/0", "nothing/c/1/0", "state/c/1/0"]
WAYS = [flipped, emptied, cut, zeroed, Path.unlink]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "damage"),
    [(CHUNKS[0], way) for way in WAYS] + [(name, way) for name in CHUNKS[1:] for way in WAYS[::4]],
)
def test_a_damaged_chunk_is_computed_again_and_said(
    name: str, damage: Callable[[Path], None], kept: Path, store: Path
) -> None:
    damage(store / name)
    study = study_of(store)
    assert study.damage.place.tolist() == ["a 3 to 5, b 0 to 1"]
    assert (study.plan().done, study.plan().damaged) == (10, 6)
    for look in (lambda: study.dataset, lambda: study.failures):
        with pytest.raises(cd.CardanError, match=r"damaged in 6 cases .*a 3 to 5.*run\(\)"):
            look()
    with pytest.warns(UserWarning, match="damaged in 6 cases .*this run makes it again"):
        study.run()
    assert calls() >= {(a, b) for a in (3.0, 4.0, 5.0) for b in (1.0, 2.0)}
    assert files(store) == files(kept)
    assert study.damage.empty
    assert study_of(store).damage.empty


@pytest.mark.slow
def test_bytes_anywhere_in_a_chunk_count(store: Path) -> None:
    path = store / "curve/c/0/0/0"
    data = path.read_bytes()
    for place in range(0, len(data), 9):
        path.write_bytes(data[:place] + bytes([data[place] ^ 1 << place % 8]) + data[place + 1 :])
        assert study_of(store).damage.cases.tolist() == [6], place


def test_only_what_is_damaged_is_computed_again(store: Path) -> None:
    flipped(store / "curve/c/0/0/0")
    flipped(store / "nothing/c/0/0")
    study = study_of(store)
    with pytest.warns(UserWarning, match="damaged in 6 cases .* and 1 more"):
        study.run()
    assert calls() == {(a, b) for a in (0.0, 1.0, 2.0) for b in (1.0, 2.0)}


@pytest.mark.parametrize("damage", [emptied, Path.unlink])
@pytest.mark.parametrize(
    "name", ["curve/zarr.json", "state/zarr.json", "a/zarr.json", "at/zarr.json", "a/c/0", "at/c/0"]
)
def test_what_follows_from_the_study_is_written_anew(
    name: str, damage: Callable[[Path], None], kept: Path, store: Path
) -> None:
    """Descriptions of arrays, and coordinates: no case has to be computed for them."""
    damage(store / name)
    study = study_of(store)
    with pytest.raises(cd.CardanError, match=r"damaged beside its cases .*run\(\) writes it anew"):
        _ = study.dataset
    with pytest.warns(UserWarning, match="damaged beside its cases .*this run writes it anew"):
        study.run()
    assert calls() == set()
    assert files(store) == files(kept)


@pytest.mark.parametrize(
    ("old", "new"),
    [('"units": "N"', '"units": "J"'), ('"at"', '"au"'), ("\n    8,", "\n    9,"), ("NaN", "0")],
)
def test_descriptions_that_say_something_else_are_damage(
    old: str, new: str, kept: Path, store: Path
) -> None:
    path = store / "curve/zarr.json"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new))
    with pytest.warns(UserWarning, match="zarr.json"):
        study_of(store).run()
    assert files(store) == files(kept)


@pytest.mark.parametrize("damage", [flipped, Path.unlink])
def test_texts_of_failures_are_read_too(
    damage: Callable[[Path], None], kept: Path, store: Path
) -> None:
    damage(store / "failure/c/2/0")
    with pytest.warns(UserWarning, match="damaged in 4 cases .failure a 6 to 7"):
        study = study_of(store).run()
    assert study.failures.message.tolist() == ["seven"]
    assert files(store) == files(kept)


def test_each_bit_of_what_is_said_of_a_study_counts(store: Path) -> None:
    """Damaged, nothing of it is believed, and nothing is written over."""
    path = store / "zarr.json"
    data = path.read_bytes()
    chance = np.random.default_rng(0)
    for place in chance.choice(len(data), 15, replace=False):
        path.write_bytes(data[:place] + bytes([data[place] ^ 2]) + data[place + 1 :])
        before = files(store)
        try:
            study = study_of(store).run()
        except cd.CardanError:
            assert files(store) == before
        else:  # What others may write there as they like.
            assert study.dataset.attrs.keys() >= {"study_function", "study_chunk"}
    assert calls() == set()


@pytest.mark.parametrize("damage", [emptied, cut, Path.unlink])
def test_a_study_of_which_nothing_is_said_is_left_alone(
    damage: Callable[[Path], None], store: Path
) -> None:
    damage(store / "zarr.json")
    before = files(store)
    said = "there is something, but no study" if damage is Path.unlink else "copy of its zarr.json"
    with pytest.raises(cd.CardanError, match=f"{said}.*name another store"):
        study_of(store).run()
    assert files(store) == before


def test_a_longer_study_mends_what_it_goes_on_from(store: Path) -> None:
    emptied(store / "curve/c/2/0/0")
    with pytest.warns(UserWarning, match="damaged in 4 cases .*a 6 to 7"):
        data = study_of(store, 10).run().dataset
    at = np.array([0.5, 1.5])
    expected = np.arange(10.0)[:, None, None] + np.array([1.0, 2.0])[:, None] * at
    expected[7, 1] = np.nan
    np.testing.assert_array_equal(data.curve, expected)
    assert {(6.0, 1.0), (9.0, 2.0)} <= calls()
    assert (0.0, 1.0) not in calls()


@pytest.mark.slow
def test_a_retry_says_what_it_leaves(store: Path) -> None:
    emptied(store / "curve/c/0/0/0")
    study = study_of(store)
    with pytest.warns(UserWarning, match=r"damaged in 6 cases .*; run\(\) makes it again"):
        study.run(retry=True)
    assert calls() == {(7.0, 2.0)}
    assert study.plan().done == 10
    data = study.dataset
    assert data.curve[:3].isnull().all() and (data.state[:3] == 0).all()
    assert study.run().plan().done == 16


def test_a_damaged_store_that_is_read_only_is_refused(store: Path) -> None:
    emptied(store / "curve/c/0/0/0")
    study = study_of(zarr.storage.LocalStore(store, read_only=True))
    assert study.plan().damaged == 6
    with pytest.raises(cd.CardanError, match="read-only: name another store"):
        study.run()


def test_a_store_out_of_reach_is_not_damaged(store: Path) -> None:
    """A network that fails says nothing of what is there: all would be computed again."""

    class OutOfReach(zarr.storage.WrapperStore):
        def with_read_only(self, read_only: bool = False) -> OutOfReach:
            return type(self)(self._store.with_read_only(read_only))

        async def get(self, key: str, *more: Any, **options: Any) -> Any:
            if key.startswith("curve/c"):
                raise ConnectionError("the network is down")
            return await super().get(key, *more, **options)

    before = files(store)
    with pytest.raises(cd.CardanError, match="network is down"):
        study_of(OutOfReach(zarr.storage.LocalStore(store))).run()
    assert files(store) == before


@pytest.mark.parametrize(
    ("shape", "dtype"), [((8, 2, 2), "i8"), ((8, 2, 2), "f4"), ((8, 2), "f8"), ((8, 4, 1, 1), "f8")]
)
def test_arrays_of_others_are_refused_before_anything_is_computed(
    shape: tuple[int, ...], dtype: str, store: Path
) -> None:
    group = zarr.open_group(store, mode="r+")
    group.create_array("curve", shape=shape, dtype=dtype, overwrite=True)
    before = files(store)
    with pytest.raises(cd.CardanError, match=r"curve holds .*something else has written it"):
        study_of(store).run()
    assert calls() == set()
    assert files(store) == before


@pytest.mark.slow
def test_arrays_of_others_that_look_alike_are_computed_again(store: Path, kept: Path) -> None:
    group = zarr.open_group(store, mode="r+")
    group.create_array("curve", shape=(8, 2, 2), dtype="f8", chunks=(3, 2, 2), overwrite=True)
    group["curve"][...] = 1.0
    with pytest.warns(UserWarning, match="damaged in 16 cases"):
        study = study_of(store).run()
    assert len(calls()) == 16
    assert files(store) == files(kept)
    assert len(study.failures) == 1


def test_studies_of_other_formats_are_refused(store: Path) -> None:
    zarr.open_group(store, mode="r+").attrs["study_format"] = "1"
    with pytest.raises(cd.CardanError, match="of format 1, and this version reads 2"):
        study_of(store).run()


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["file", "local"])
def test_urls_of_this_machine_are_paths(scheme: str, tmp_path: Path) -> None:
    url = f"{scheme}://{tmp_path}/deep/in/it.zarr"
    study = study_of(url).run()
    assert study.plan().done == 16
    assert (tmp_path / "deep/in/it.zarr/zarr.json").exists()
    assert study.store.free < np.inf
    # Whoever gives options wants the file system behind it.
    other = f"{scheme}://{tmp_path}/other.zarr"
    axes = {"a": [1.0], "b": [1.0]}
    options = {"auto_mkdir": True}
    cd.study(computed, axes, store=other, storage_options=options, workers=1).run()
    assert (tmp_path / "other.zarr/zarr.json").exists()


def test_options_of_a_path_and_packages_that_are_missing_are_said(tmp_path: Path) -> None:
    axes = {"a": [1.0], "b": [1.0]}
    with pytest.raises(cd.ArgumentError, match="storage_options are of the file system of a URL"):
        cd.study(computed, axes, store=tmp_path / "x.zarr", storage_options={"anon": True})
    with pytest.raises(cd.MissingExtraError, match=r"hdfs|s3fs"):
        _study_without("s3fs", "s3://bucket/x.zarr", axes).plan()
    with pytest.raises(cd.CardanError, match="Protocol not known: nosuch"):
        cd.study(computed, axes, store="nosuch://x", workers=1).plan()
    assert calls() == set()


def _study_without(package: str, store: str, axes: Any) -> cd.studies.Study:
    import importlib.util

    if importlib.util.find_spec(package) is not None:
        pytest.skip(f"{package} is installed")
    return cd.study(computed, axes, store=store, workers=1)


def test_attributes_of_results_change_no_number() -> None:
    """Conventions of other files' attributes would scale them, or make dates of them."""

    def odd(a: float) -> xarray.Dataset:
        about = {"units": "days since 2000-01-01"}
        scaled = {"scale_factor": 10.0, "add_offset": 3.0, "_FillValue": 2.0, "units": "hours"}
        return xarray.Dataset({"x": ((), a, about), "y": ((), a, scaled)})

    data = cd.study(odd, {"a": [1.0, 2.0]}, workers=1).run().dataset
    assert data.y.attrs == {"units": "hours"}
    assert data.x.values.tolist() == data.y.values.tolist() == [1.0, 2.0]


def test_no_file_is_left_that_nobody_reads(kept: Path) -> None:
    assert {path.split("/")[0] for path in files(kept)} == {
        *("a", "at", "b", "curve", "failure", "nothing", "state", "zarr.json")
    }
    assert [path.name for path in (kept / "failure/c").iterdir()] == ["2"]


def test_a_study_that_was_killed_before_it_had_arrays_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    place = tmp_path / "killed.zarr"

    def ending(*arguments: Any, **options: Any) -> None:
        raise SystemExit("killed")

    with monkeypatch.context() as patch:
        patch.setattr(Store, "open", ending)
        with pytest.raises(SystemExit):
            study_of(place).run()
    assert [path.name for path in place.iterdir()] == ["zarr.json"]
    assert study_of(place).run().plan().done == 16


def test_samples_that_scipy_has_changed_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from scipy.stats import norm

    def run() -> cd.studies.Study:
        given = cd.studies.samples({"a": norm(0.0, 1.0), "b": norm(0.0, 1.0)}, 4, seed=1)
        return cd.study(computed, given, store=tmp_path / "samples.zarr", workers=1).run()

    first = run().dataset.a.values
    original = Samples.values

    def other(self: Any, start: int, stop: int) -> Any:
        found = original(self, start, stop)
        last = np.where(np.arange(start, stop) == 3, np.nextafter(found["a"], 9.0), found["a"])
        return found | {"a": last}

    monkeypatch.setattr(Samples, "values", other)
    with pytest.raises(cd.CardanError, match=rf"a goes from {first[0]} to {first[-1]}.*SciPy"):
        run()


@pytest.mark.slow
def test_chunks_of_which_a_part_is_computed_are_read_too(
    store: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After an extension, a chunk holds cases that are done beside others that are not."""

    def ending(*arguments: Any) -> None:
        raise SystemExit("killed")

    with monkeypatch.context() as patch:
        patch.setattr(Study, "_engine", ending)
        with pytest.raises(SystemExit):
            study_of(store, 10).run()
    assert study_of(store, 10).damage.empty
    flipped(store / "curve/c/2/0/0")
    study = study_of(store, 10)
    assert study.damage.values.tolist()[0][:3] == ["curve", 4, "a 6 to 8, b 0 to 1"]
    assert (study.plan().done, study.plan().damaged) == (12, 4)
    assert "12 of them done (1 failed)" not in str(study.plan())
    assert ", 12 of them done, 4 damaged:" in str(study.plan())
    with pytest.warns(UserWarning, match="damaged in 4 cases"):
        study.run()
    assert study_of(store, 10).plan().done == 20


@pytest.mark.parametrize(("others", "cases"), [("state/c/1/0", 6), ("state", 16)])
def test_what_was_being_written_when_the_power_failed_is_said(
    others: str, cases: int, kept: Path, store: Path
) -> None:
    """A chunk without a state does not count, and is in the way of the others' Dataset."""
    emptied(store / "curve/c/1/0/0")
    path = store / others
    path.unlink() if path.is_file() else shutil.rmtree(path / "c")
    study = study_of(store)
    *states, curve = study.damage.values.tolist()
    assert {row[0] for row in states} == {"state"} and sum(row[1] for row in states) == cases
    assert curve[:3] == ["curve", 0, "a 3 to 5, b 0 to 1"]
    with pytest.raises(cd.CardanError, match=rf"damaged in {cases} cases .*run\(\)"):
        _ = study.dataset
    with pytest.warns(UserWarning, match="this run makes it again"):
        study.run()
    assert files(store) == files(kept)


def test_a_chunk_that_was_not_written_to_its_end_is_no_damage(kept: Path, store: Path) -> None:
    """As where a run is ended: of its results some are there, and no state."""
    (store / "state/c/1/0").unlink()
    (store / "nothing/c/1/0").unlink()
    study = study_of(store)
    assert study.damage.empty and study.plan().done == 10
    study.run()
    assert files(store) == files(kept)


def test_a_missing_chunk_is_seen_beside_one_that_does_not_count(store: Path) -> None:
    (store / "state/c/0/0").unlink()
    (store / "nothing/c/0/0").unlink()
    (store / "curve/c/1/0/0").unlink()
    assert study_of(store).damage.cases.tolist() == [6]
