"""Branches: poses, their variants, and how they were searched."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import cardan_dyn as cd


@pytest.fixture(scope="module")
def stewart() -> cd.Scene:
    mechanism = cd.load("stewart_platform")
    return cd.Scene(mechanism, drive=[name for name in mechanism if name.startswith("leg_")])


@pytest.fixture(scope="module")
def branches(stewart: cd.Scene) -> cd.Branches:
    return stewart.branches()


@pytest.mark.slow
def test_the_stewart_platform_has_eight_poses(stewart: cd.Scene, branches: cd.Branches) -> None:
    """Poses of the platform, and no flips of yokes and wrists: each is another pose of it."""
    assert list(branches) == list("ABCDEFGH")
    assert len(branches) == 8
    assert branches.is_complete
    platforms = []
    for name in branches:
        configuration = stewart.replace(branch=name).configuration()
        assert configuration.branch == name
        assert configuration.loop_residual < 1e-12
        balls = [configuration.origin(f"ball_{leg}") for leg in range(2, 7)]
        platforms.append(np.concatenate([configuration.origin("ball_1_z"), *balls]))
    distances = np.linalg.norm(np.array(platforms)[:, None] - platforms, axis=2)
    assert np.min(distances + 10.0 * np.eye(8)) > 1e-2


@pytest.mark.slow
def test_variants_of_a_pose_leave_the_platform_where_it_is(
    stewart: cd.Scene, branches: cd.Branches
) -> None:
    first, second, *_ = branches.variants["C"]
    assert (first, second) == ("C", "C2")
    assert second not in branches
    places = [stewart.replace(branch=name).configuration() for name in (first, second)]
    for leg in range(2, 7):
        a, b = (place.origin(f"ball_{leg}") for place in places)
        np.testing.assert_allclose(a, b, atol=1e-9)
    variants = branches.variants["C"]
    assert branches[first] == variants[first] != variants[second]


@pytest.mark.slow
def test_they_say_how_complete_the_search_was(branches: cd.Branches) -> None:
    assert branches.starts >= 3 * branches.last_new
    count = sum(map(len, branches.variants.values()))
    assert repr(branches) == (
        f"<Branches: 8 poses ({count} variants were met), from {branches.starts} starts, of which "
        f"those after {branches.last_new} brought no new one>"
    )


@pytest.mark.slow
def test_unknown_branches_are_refused(branches: cd.Branches) -> None:
    assert "Z" not in branches
    assert branches.get("Z") is None
    with pytest.raises(cd.ArgumentError, match="branch 'Z' is no pose; poses: A, B"):
        branches["Z"]


@pytest.mark.parametrize(
    "copied", [copy.copy, copy.deepcopy, lambda item: pickle.loads(pickle.dumps(item))]
)
def test_they_can_be_copied_and_not_changed(copied: object, branches: cd.Branches) -> None:
    again = copied(branches)  # type: ignore[operator]
    assert dict(again) == dict(branches)
    assert again.variants == branches.variants
    with pytest.raises(cd.ImmutableError):
        again.starts = 1


def test_a_spherical_four_bar_has_two_poses() -> None:
    """All axes meet in a point; its links still have poses of their own."""
    lengths = np.deg2rad([40.0, 80.0, 70.0, 85.0])

    def link(name: str) -> str:
        return f'<link name="{name}"/>'

    def joint(name: str, parent: str, child: str, angle: float) -> str:
        return (
            f'<joint name="{name}" type="continuous"><parent link="{parent}"/>'
            f'<child link="{child}"/><origin xyz="0 0 0" rpy="0 {angle!r} 0"/>'
            '<axis xyz="0 0 1"/></joint>'
        )

    crank, coupler, rocker, base = (float(value) for value in lengths)
    text = (
        '<robot name="spherical"><link name="ground"/>'
        + "".join(map(link, ("a", "b", "c")))
        + joint("crank", "ground", "a", 0.0)
        + joint("first", "a", "b", crank)
        + joint("rocker", "ground", "c", base)
        + f'<loop name="second" type="continuous"><predecessor link="b"><origin '
        f'rpy="0 {coupler!r} 0"/></predecessor><successor link="c"><origin rpy="0 {rocker!r} 0"/>'
        '</successor><axis xyz="0 0 1"/></loop></robot>'
    )
    branches = cd.Scene(cd.load(text), drive="crank").branches()
    assert len(branches) == 2
    assert {len(names) for names in branches.variants.values()} == {1}
