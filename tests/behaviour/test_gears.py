"""Gears: teeth press on bearings as machine elements say, and what nothing states is open."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.gear_trains import GearTrain
from testkit.linkages import coupling, gears

import cardan_dyn as cd

pytestmark = pytest.mark.usefixtures("loaded_once")

POSITIONS = np.array([-1.3, 0.0, 0.4, 7.0])


def compare(train: GearTrain, tolerance: float = 1e-11) -> None:
    """Refuse a sweep whose wrenches differ from the equilibrium of the shafts."""
    scene = train.scene(cd)
    turn = scene.sweep(POSITIONS, speed=train.speed, acceleration=train.acceleration)
    assert turn.unique.all()
    assert turn.left_open.text == ""
    expected = [train.wrenches(position) for position in POSITIONS]
    largest = max(np.abs(each[name]).max() for each in expected for name in turn.outputs)
    for name in turn.outputs:
        wrench = turn.wrench(name, "world")
        found = np.stack([wrench.force, wrench.moment], axis=1)
        right = np.array([each[name] for each in expected])
        np.testing.assert_allclose(found, right, rtol=0.0, atol=tolerance * largest, err_msg=name)
    for name, moment in turn.coupling_moment.items():
        right = np.array([each[name] for each in expected])
        np.testing.assert_allclose(moment, right, rtol=0.0, atol=tolerance * largest)
    assert turn.balance_residual < 1e-13


@pytest.mark.parametrize("seed", range(5))
def test_bearings_of_random_trains(seed: int) -> None:
    rng = np.random.default_rng(seed)
    compare(GearTrain(rng, int(rng.integers(2, 5)), level=seed % 2 == 0))


@pytest.mark.slow
@pytest.mark.campaign
def test_bearings_of_a_hundred_random_trains() -> None:
    for seed in range(100, 200):
        rng = np.random.default_rng(seed)
        compare(GearTrain(rng, int(rng.integers(2, 7)), level=seed % 2 == 0))


def planetary(planets: int, sun: str, stated: str) -> str:
    """A sun, and planets around it on a carrier that turns as the sun's axis does."""
    text = '<robot name="planetary"><link name="ground"/>'
    text += "".join(f'<link name="{name}"/>' for name in ("sun", "carrier"))
    text += f"""<joint name="s" type="{sun}"><parent link="ground"/><child link="sun"/>
      <axis xyz="0 0 1"/></joint>
      <joint name="k" type="continuous"><parent link="ground"/><child link="carrier"/>
      <axis xyz="0 0 1"/></joint>"""
    for k in range(planets):
        angle = 2.0 * np.pi * k / planets
        text += f"""<link name="planet_{k}"/><joint name="p{k}" type="continuous">
          <parent link="carrier"/><child link="planet_{k}"/>
          <origin xyz="{0.3 * np.cos(angle)} {0.3 * np.sin(angle)} 0"/><axis xyz="0 0 1"/>
          <mimic joint="k" multiplier="2" name="m{k}" {stated}/></joint>"""
    return text + "</robot>"


def test_a_planet_rolls_on_the_sun_that_stands() -> None:
    """Radii 0.2 m and 0.1 m; 6 N·m on the planet are borne by 60 N at the pitch point."""
    stated = 'forces="mesh" pressure_angle="0.4"'
    scene = cd.Scene(
        cd.load(planetary(1, "fixed", stated)), drive="k", loads={"p0": -6.0}, gravity=None
    )
    turn = scene.sweep(POSITIONS, speed=2.0)
    # The teeth turn the planet by +6 N·m: 60 N against the carrier's motion at its inner point.
    arm = np.array([np.cos(POSITIONS), np.sin(POSITIONS), 0.0 * POSITIONS]).T
    across = np.array([-np.sin(POSITIONS), np.cos(POSITIONS), 0.0 * POSITIONS]).T
    on_planet = -60.0 * across + 60.0 * np.tan(0.4) * arm
    np.testing.assert_allclose(turn.wrench("p0", "world").force, -on_planet, atol=1e-12)
    np.testing.assert_allclose(turn["p0"].torsion, -6.0, atol=1e-12)
    # On the carrier at 0.3 m; the teeth take no part in what its bearing carries about its axis.
    np.testing.assert_allclose(turn.wrench("k", "world").force, -on_planet, atol=1e-12)
    np.testing.assert_allclose(turn.drive_effort, 60.0 * 0.3 - 6.0, atol=1e-12)
    np.testing.assert_allclose(turn["k"].torsion, turn.drive_effort, atol=1e-12)
    assert turn.unique.all()
    assert turn.balance_residual < 1e-14


def test_load_shared_by_several_planets_is_open() -> None:
    """Two ways from one shaft to another, by a wheel each: what each carries is not known."""
    text = GearTrain(np.random.default_rng(1), 2, level=True).urdf()
    second = text[text.index('<coupling name="m0"') : text.index("</robot>")]
    text = text.replace("</robot>", second.replace('"m0"', '"again"') + "</robot>")
    turn = cd.Scene(cd.load(text), drive="j0", held={"base": 0.2}, loads={"j1": 3.0}).sweep(
        POSITIONS
    )
    assert turn.coupling_unique == {"m0": False, "again": False}
    assert not turn["j0"].unique.any()
    assert not turn["j1"].unique.any()
    assert turn["base"].unique.all()


def test_what_nothing_states_is_open() -> None:
    """The housing takes what the joints' moments differ by; its own joint carries what it must."""
    for seed in range(3):
        train = GearTrain(np.random.default_rng(seed), 3)
        train.forces = ""
        turn = train.scene(cd).sweep(POSITIONS, speed=train.speed, acceleration=train.acceleration)
        train.forces = 'forces="none"'
        stated = train.scene(cd).sweep(
            POSITIONS, speed=train.speed, acceleration=train.acceleration
        )
        expected = [train.wrenches(position) for position in POSITIONS]
        for name in turn.outputs:
            assert stated[name].unique.all()
            assert turn[name].unique.all() == (name == "base")
            assert turn[name].unique.any() == (name == "base")
            np.testing.assert_array_equal(turn[name].force, stated[name].force)
        for found in (turn.wrench("base", "world"), stated.wrench("base", "world")):
            values = np.stack([found.force, found.moment], axis=1)
            right = np.array([each["base"] for each in expected])
            np.testing.assert_allclose(values, right, rtol=0.0, atol=1e-11 * np.abs(right).max())
        assert turn.coupling_unique == {"m0": True, "m1": True}


def silent_train(**more: object) -> cd.Scene:
    train = GearTrain(np.random.default_rng(5), 2)
    train.forces = ""
    return train.scene(cd, **more)


def test_why_it_is_open_is_told() -> None:
    scene = silent_train()
    turn = scene.sweep(POSITIONS)
    told = "how 'm0', which couples j0 and j1, presses on their bearings is not described"
    assert told in str(turn)
    assert told in repr(turn["j0"])
    assert "nothing acts" not in repr(turn["j0"])
    assert "least norm" not in repr(turn["j0"])
    assert told in turn.to_xarray().attrs["not_unique"]
    assert "j0, j1 (force xyz, moment xyz)" in turn.to_xarray().attrs["not_unique"]
    assert told in str(cd.describe(scene.mechanism))
    assert not turn.wrench("j1", "world").unique.any()
    assert told in turn.left_open.why("j1")
    assert turn.left_open.why("base") == ""
    assert "not unique" in repr(turn["j1"].bearing_forces((-0.1, 0.1)))
    response = scene.replace(loads={"j1": 3.0}).response(interval=(-2.0, 8.0))
    assert not response.sweep(POSITIONS)["j0"].unique.any()
    assert told in str(response.sweep(POSITIONS))


@pytest.mark.parametrize("compliance", [None, {"j0": np.full(6, 1e-6)}])
def test_strict_scenes_refuse_what_is_open(compliance: object) -> None:
    scene = silent_train(strict=True, compliance=compliance)
    with pytest.raises(cd.IndeterminateError, match="'m0', which couples j0 and j1") as caught:
        scene.sweep(POSITIONS)
    assert set(caught.value.components) == {"j0", "j1"}
    assert 'forces="mesh"' in str(caught.value)
    only = scene.replace(outputs=["base"]).sweep(POSITIONS)
    assert only["base"].unique.all()


def test_forces_pass_through_joints_between_coupled_ones() -> None:
    """Of a chain in which the outer joint mimics the inner one, the middle joint knows its axis."""
    text = '<robot name="finger"><link name="l0"/>'
    for k, kind in enumerate(("revolute", "prismatic", "continuous")):
        mimic = '<mimic joint="j0" multiplier="0.5"/>' if k == 2 else ""
        limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>' if k < 2 else ""
        text += f"""<link name="l{k + 1}"/><joint name="j{k}" type="{kind}">
          <parent link="l{k}"/><child link="l{k + 1}"/><origin xyz="0.1 0 0"/>
          <axis xyz="0 0 1"/>{limit}{mimic}</joint>"""
    text += """<link name="l4"/><joint name="tip" type="continuous"><parent link="l3"/>
      <child link="l4"/><origin xyz="0.1 0 0"/><axis xyz="0 1 0"/></joint></robot>"""
    scene = cd.Scene(cd.load(text), drive=["j0", "tip"], held={"j1": 0.1}, loads={"j2": 2.0})
    turn = scene.sweep([[0.1, 0.2], [0.3, 0.4]])
    assert not turn["j0"].unique.any()
    assert not turn["j2"].unique.any()
    assert turn["j1"].unique.tolist() == [False, False, True, False, False, False]
    assert turn["tip"].unique.all()


def test_teeth_are_written_and_read(tmp_path: object) -> None:
    train = GearTrain(np.random.default_rng(8), 3)
    mechanism = cd.load(train.urdf())
    assert cd.load(mechanism.to_urdf()).description == mechanism.description
    follows = cd.load(planetary(1, "fixed", 'forces="mesh" helix_angle="0.2"'))
    again = cd.load(follows.to_urdf())
    assert again.description == follows.description
    assert again.description.couplings[0].mesh == (np.pi / 9.0, 0.2, None)
    # MJCF has no words for them: what its reader does not know is open.
    pair = cd.load(gears(coupling("m", "a", "b", -2.5, 'forces="mesh"')))
    assert len(pair.teeth) == 1 and not pair.undescribed
    with pytest.warns(UserWarning, match="no word for it: forces of coupling 'm'"):
        path = cd.write(pair, f"{tmp_path}/pair.xml")
    assert len(cd.load(path).undescribed) == 1


@pytest.mark.parametrize(
    ("stated", "message"),
    [
        ('forces="teeth"', "forces 'teeth' is unknown; forces: mesh, none"),
        ('pressure_angle="0.3"', 'pressure_angle is one of teeth: write forces="mesh"'),
        ('forces="none" along="0.3"', 'along is one of teeth: write forces="mesh"'),
        ('forces="mesh" pressure_angle="1.6"', "it has to lie between 0 and π/2"),
        ('forces="mesh" helix_angle="-1.6"', "it has to lie between -π/2 and π/2"),
    ],
)
def test_bad_statements(stated: str, message: str) -> None:
    with pytest.raises(cd.ModelError, match=message):
        cd.load(planetary(1, "fixed", stated))


def test_places_that_no_gears_have() -> None:
    good = planetary(1, "fixed", 'forces="mesh"')
    apart = '<origin xyz="0.3 0.0 0"/><axis xyz="0 0 1"/>'
    assert apart in good
    for changed, message in (
        ('<origin xyz="0.3 0.0 0"/><axis xyz="0 0.1 1"/>', "have parallel axes at a distance"),
        ('<origin xyz="0 0 0"/><axis xyz="0 0 1"/>', "have parallel axes at a distance"),
        ('<origin xyz="0.3 0 0.1"/><axis xyz="0 0 1"/>', "lie 0.1 m apart along their axes"),
    ):
        with pytest.raises(cd.ModelError, match=message):
            cd.load(good.replace(apart, changed))
    with pytest.raises(cd.ModelError, match="turn equally fast in the same sense"):
        cd.load(good.replace('multiplier="2"', 'multiplier="-1"'))
    slides = good.replace('name="p0" type="continuous"', 'name="p0" type="prismatic"')
    slides = slides.replace("<mimic", '<limit lower="-1" upper="1" effort="1" velocity="1"/><mimic')
    with pytest.raises(cd.ModelError, match="each on a joint that turns"):
        cd.load(slides)
    with pytest.raises(cd.ArgumentError, match="a response takes no gears with teeth"):
        cd.Scene(cd.load(good), drive="k").response()


@pytest.mark.parametrize("other", ['forces="none"', ""])
def test_teeth_that_share_their_moment_with_a_coupling_without_any_are_refused(other: str) -> None:
    text = gears(
        coupling("teeth", "a", "b", -2.5, 'forces="mesh"') + coupling("belt", "a", "b", -2.5, other)
    )
    scene = cd.Scene(cd.load(text), drive="a", loads={"b": -50.0})
    with pytest.raises(cd.ModelError, match="teeth has teeth, and shares its moment"):
        scene.sweep([0.3], speed=3.0)
