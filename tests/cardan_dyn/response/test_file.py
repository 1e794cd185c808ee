"""Files of responses: only their scene reads them, and damage to them is noticed."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from testkit.scenes import text, universal

import cardan_dyn as cd
from cardan_dyn.core.response import file as response_file

POSITIONS = np.linspace(-3.0, 9.0, 40)
PUSH = {"shaft_out": cd.Wrench(force=(0.0, 3.0, 10.0), moment=(1.0, 0.0, 0.0))}
SCENE: dict[str, object] = {
    "drive": "bearing_in",
    "held": {"joint_angle": 0.4},
    "loads": {"bearing_out": -2.0, **PUSH},
    "gravity": (0.0, 0.0, -9.81),
}


def scene(joint: cd.Mechanism, **changed: object) -> cd.Scene:
    return cd.Scene(joint, **{**SCENE, **changed})


@pytest.fixture(scope="module")
def saved(joint: cd.Mechanism, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("saved") / "response.npz"
    scene(joint).response().save(path)
    return path


def refused(path: Path, different: cd.Scene) -> str:
    with pytest.raises(cd.CardanError, match="response of another scene; different: ") as caught:
        different.load_response(path)
    return str(caught.value).split("different: ")[1]


def test_a_file_is_read_by_the_same_scene_made_again(joint: cd.Mechanism, saved: Path) -> None:
    # From another path, and with other efforts: neither changes the functions.
    again = scene(cd.load(text("universal_joint")), loads={**PUSH, "bearing_out": -7.0})
    read = again.load_response(saved)
    evaluated, direct = read.sweep(POSITIONS, 3.0), again.sweep(POSITIONS, 3.0)
    np.testing.assert_allclose(evaluated["pin_out"].moment, direct["pin_out"].moment, atol=1e-11)
    assert read.columns[:3] == ("speed²", "acceleration", "bearing_out")
    assert read.proof == scene(joint).response().proof


@pytest.mark.parametrize(
    "change",
    [
        lambda urdf: urdf.replace('<mass value="', '<mass value="1', 1),
        lambda urdf: urdf.replace('ixx="0.2145248"', 'ixx="0.2145249"'),
        lambda urdf: urdf.replace('<origin xyz="0.254 0 -0.09"/>', '<origin xyz="0.25 0 -0.09"/>'),
    ],
    ids=["mass", "inertia", "centre"],
)
def test_a_mechanism_of_other_masses_is_refused(saved: Path, change: Callable[[str], str]) -> None:
    urdf = text("universal_joint")
    assert change(urdf) != urdf
    assert refused(saved, scene(cd.load(change(urdf)))) == "description"


def test_a_mechanism_of_other_lengths_is_refused(tmp_path: Path) -> None:
    path, urdf = tmp_path / "response.npz", text("four_bar")
    longer = urdf.replace("0.4 ", "0.401 ")
    assert longer != urdf
    first, second = (cd.Scene(cd.load(each), drive="crank_bearing") for each in (urdf, longer))
    first.response().save(path)
    assert refused(path, second) == "description"


@pytest.mark.parametrize(
    ("difference", "changed"),
    [
        ("held", {"held": {"joint_angle": 0.4 + 1e-12}}),
        ("near", {"near": {"bearing_in": 0.5}}),
        ("compliance", {"compliance": {"bearing_in": np.ones(6)}}),
        ("outputs", {"outputs": ["bearing_in"]}),
        ("joint loads", {"loads": PUSH}),
        ("gravity", {"gravity": None}),
        ("link loads", {"loads": {"bearing_out": -2.0}}),
        (
            "link loads",
            {"loads": {"bearing_out": -2.0, "shaft_out": cd.Wrench((0.0, 3.0, 10.0), (9e3, 0, 0))}},
        ),
        (
            "link loads",
            {
                "loads": {
                    "bearing_out": -2.0,
                    "shaft_out": cd.Wrench((0.0, 3.0, 10.0), (1.0, 0.0, 0.0), "world"),
                }
            },
        ),
    ],
)
def test_another_scene_of_the_same_mechanism_is_refused_and_the_difference_named(
    joint: cd.Mechanism, saved: Path, difference: str, changed: dict[str, object]
) -> None:
    assert refused(saved, scene(joint, **changed)) == difference


def test_a_strict_scene_another_branch_and_another_order_of_held_joints_are_told_apart(
    shaft: cd.Mechanism, tmp_path: Path
) -> None:
    four_bar = cd.load("four_bar")
    crank = cd.Scene(four_bar, drive="crank_bearing")
    crank.response().save(tmp_path / "crank")
    branch_b = cd.Scene(four_bar, drive="crank_bearing", branch="B")
    assert refused(tmp_path / "crank", branch_b) == "branch"
    held = {"joint_angle_1": 0.5, "joint_angle_2": 0.4}
    double = cd.Scene(shaft, drive="bearing_in", held=held, outputs=["bearing_in"])
    double.response().save(tmp_path / "double")
    reordered = dict(reversed(held.items()))
    again = cd.Scene(shaft, drive="bearing_in", held=reordered, outputs=["bearing_in"])
    # In the other order each held joint would get the effort of the other one.
    assert refused(tmp_path / "double", again) == "held"


def test_another_version_of_the_package_is_refused(
    joint: cd.Mechanism, saved: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("cardan_dyn.core.response.identity.__version__", "0.0.7")
    assert refused(saved, scene(joint)) == "version of the package"


def rewritten(path: Path, change: Callable[[dict[str, np.ndarray]], object], target: Path) -> Path:
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    change(arrays)
    np.savez(target, **arrays)
    return target


def sign(arrays: dict[str, np.ndarray]) -> None:
    """Put the checksum of the content among the arrays of a file."""
    content = {key: array for key, array in arrays.items() if key != "checksum"}
    arrays["checksum"] = np.array(response_file._checksum(content))


@pytest.mark.parametrize("name", ["header", "values", "zero", "unique"])
def test_a_missing_array_is_noticed(
    joint: cd.Mechanism, saved: Path, tmp_path: Path, name: str
) -> None:
    path = rewritten(saved, lambda arrays: arrays.pop(name), tmp_path / "x.npz")
    message = "is damaged or was changed|is not a saved response"
    with pytest.raises(cd.CardanError, match=message):
        scene(joint).load_response(path)


@pytest.mark.parametrize("name", ["values", "zero", "constant", "unique"])
@pytest.mark.parametrize(
    "new",
    [
        lambda old: old[..., None],
        lambda old: old.astype("f4"),
        lambda old: old.ravel()[:1],
        lambda old: np.array("x"),
        lambda old: np.zeros(0),
        lambda old: old * np.nan,
        lambda old: ~old if old.dtype == bool else np.nextafter(old, 9.0),
    ],
    ids=["dimension", "type", "cut", "text", "empty", "nan", "last digit"],
)
def test_a_changed_array_is_noticed(
    joint: cd.Mechanism,
    saved: Path,
    tmp_path: Path,
    name: str,
    new: Callable[[np.ndarray], np.ndarray],
) -> None:
    def change(arrays: dict[str, np.ndarray]) -> None:
        arrays[name] = new(arrays[name])

    path = rewritten(saved, change, tmp_path / "x.npz")
    with pytest.raises(cd.CardanError, match=r"is damaged or was changed|is not a saved response"):
        scene(joint).load_response(path)


@pytest.mark.parametrize(
    ("name", "new"),
    [
        ("values", lambda old: old[:-1]),
        ("values", lambda old: old[:, :-1]),
        ("values", lambda old: old * np.inf),
        ("values", lambda old: old.astype("f4")),
        ("zero", lambda old: old[:-1]),
        ("constant", lambda old: old.astype(int)),
        ("unique", lambda old: old[:, :5]),
    ],
)
def test_shapes_that_do_not_suit_the_scene_are_refused_even_where_the_checksum_is_right(
    joint: cd.Mechanism,
    saved: Path,
    tmp_path: Path,
    name: str,
    new: Callable[[np.ndarray], np.ndarray],
) -> None:
    def change(arrays: dict[str, np.ndarray]) -> None:
        with np.errstate(invalid="ignore"):
            arrays[name] = new(arrays[name])
        sign(arrays)

    path = rewritten(saved, change, tmp_path / "x.npz")
    with pytest.raises(cd.CardanError, match="is not a saved response"):
        scene(joint).load_response(path)


@pytest.mark.parametrize(
    ("key", "new", "message"),
    [
        ("format", 1, "is of format 1, this version reads 3; save it again"),
        ("format", "x", "is of format 'x', this version reads 3; save it again"),
        ("columns", [["ACCELERATION", ""]], "is not a saved response .its arrays are not those"),
        ("columns", [["NOTHING", ""]], "is not a saved response .'NOTHING'"),
        ("domain", [0.0, 0.0, True], "is not a saved response .its arrays are not those"),
        ("domain", [0.0, 1.0], "is not a saved response .*missing"),
        ("proof", {"error": 1e-9}, "is not a saved response .'unproven'"),
        ("proof", {"unproven": [], "error": 1e-9}, "is not a saved response .*missing"),
        ("identity", {}, "is the response of another scene; different: version of the package, "),
        ("identity", 3, "is not a saved response"),
    ],
)
def test_headers_that_do_not_suit_the_scene_are_refused_even_where_the_checksum_is_right(
    joint: cd.Mechanism, saved: Path, tmp_path: Path, key: str, new: object, message: str
) -> None:
    def change(arrays: dict[str, np.ndarray]) -> None:
        header = json.loads(str(arrays["header"]))
        header[key] = new
        arrays["header"] = np.array(json.dumps(header))
        sign(arrays)

    path = rewritten(saved, change, tmp_path / "x.npz")
    with pytest.raises(cd.CardanError, match=message):
        scene(joint).load_response(path)


@pytest.mark.parametrize("count", [6, 9])
def test_too_few_samples_and_odd_numbers_of_them_are_refused(
    joint: cd.Mechanism, saved: Path, tmp_path: Path, count: int
) -> None:
    def change(arrays: dict[str, np.ndarray]) -> None:
        arrays["values"] = arrays["values"][:, :count]
        sign(arrays)

    path = rewritten(saved, change, tmp_path / "x.npz")
    with pytest.raises(cd.CardanError, match=r"is not a saved response \(its arrays are not those"):
        scene(joint).load_response(path)


@pytest.mark.slow
def test_a_changed_header_is_noticed(joint: cd.Mechanism, saved: Path, tmp_path: Path) -> None:
    with np.load(saved) as file:
        keys = list(json.loads(str(file["header"])))
    assert {"identity", "proof", "columns", "format"} <= set(keys)
    for key in keys:
        for value in (None, [0], "x", 7, [1], {"error": "x"}):

            def change(
                arrays: dict[str, np.ndarray], key: str = key, value: object = value
            ) -> None:
                header = json.loads(str(arrays["header"]))
                header[key] = value
                arrays["header"] = np.array(json.dumps(header))

            path = rewritten(saved, change, tmp_path / "x.npz")
            with pytest.raises(cd.CardanError, match="is damaged or was changed"):
                scene(joint).load_response(path)


def test_flipped_bytes_and_truncated_files_never_give_another_response(
    joint: cd.Mechanism, saved: Path, tmp_path: Path
) -> None:
    content, same = saved.read_bytes(), scene(joint)
    undamaged = same.load_response(saved)
    path = tmp_path / "damaged.npz"
    rng = np.random.default_rng(5)
    for index in rng.integers(0, len(content), 60).tolist():
        path.write_bytes(content[:index] + bytes([content[index] ^ 16]) + content[index + 1 :])
        try:
            read = same.load_response(path)
        except cd.CardanError:
            continue
        # Dates of a zip file's members may change.
        np.testing.assert_array_equal(read._data[0].series.values, undamaged._data[0].series.values)
    for size in rng.integers(0, len(content), 30).tolist():
        path.write_bytes(content[:size])
        with pytest.raises(cd.CardanError, match="is not a saved response"):
            same.load_response(path)


def test_foreign_files_are_refused(joint: cd.Mechanism, tmp_path: Path) -> None:
    same = scene(joint)
    np.save(tmp_path / "array.npy", np.zeros(3))
    np.savez(tmp_path / "arrays.npz", values=np.zeros(3))
    np.savez(tmp_path / "objects.npz", header=np.array([None], object))
    (tmp_path / "empty").write_bytes(b"")
    for name in ("array.npy", "arrays.npz", "objects.npz", "empty"):
        with pytest.raises(cd.CardanError, match="is not a saved response"):
            same.load_response(tmp_path / name)


def test_what_is_no_path_and_paths_that_lead_nowhere_are_refused(
    joint: cd.Mechanism, saved: Path, tmp_path: Path
) -> None:
    same = scene(joint)
    response = same.load_response(saved)
    for wrong in (None, 3, 1.5, b"bytes", ["x"], object()):
        with pytest.raises(cd.ArgumentError, match=r"path is .* expected a path"):
            same.load_response(wrong)  # type: ignore[arg-type]
        with pytest.raises(cd.ArgumentError, match=r"path is .* expected a path"):
            response.save(wrong)  # type: ignore[arg-type]
    for nowhere in (tmp_path, tmp_path / "no" / "file", "\x00", "a" * 9999, "\ud800"):
        with pytest.raises(cd.CardanError, match="cannot be read"):
            same.load_response(nowhere)
        with pytest.raises(cd.CardanError, match="cannot be written"):
            response.save(nowhere)


def test_a_response_survives_its_file(joint: cd.Mechanism, tmp_path: Path) -> None:
    scene = universal(joint, 0.5)
    response = scene.response()
    response.save(tmp_path / "response.npz")
    again = universal(joint, 0.5).load_response(tmp_path / "response.npz")
    first, second = response.sweep(POSITIONS, 3.0), again.sweep(POSITIONS, 3.0)
    np.testing.assert_array_equal(first["pin_out"].moment, second["pin_out"].moment)
    assert again.proof == response.proof
    with pytest.raises(cd.CardanError, match="response of another scene; different: held"):
        universal(joint, 0.6).load_response(tmp_path / "response.npz")
    (tmp_path / "other.npz").write_bytes(b"nothing")
    with pytest.raises(cd.CardanError, match="is not a saved response"):
        scene.load_response(tmp_path / "other.npz")
