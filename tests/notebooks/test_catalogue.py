"""What the notebook of the catalogue shows: Z and W, its example, its residual angles."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from stories import tell

from cardan_dyn.analytic import compound_angle, drive_line, single_joint, support_forces
from cardan_dyn.drive_lines import arrangements


@pytest.fixture(scope="module")
def story() -> SimpleNamespace:
    return tell("catalogue")


@pytest.mark.slow
def test_z_and_w_turn_uniformly(story: SimpleNamespace) -> None:
    beta = story.beta
    for shaft in (story.z_shaft, story.w_shaft):
        np.testing.assert_allclose(shaft.motion.position("bearing_out"), story.position, atol=1e-13)
        np.testing.assert_allclose(shaft.motion.ratio("bearing_out"), 1.0, rtol=1e-13)
    ratio = story.single.motion.ratio("bearing_out")
    np.testing.assert_allclose(ratio, story.rule, rtol=1e-12)
    np.testing.assert_allclose(story.alone, single_joint.non_uniformity(beta), rtol=1e-12)
    for drawn, found, _ in story.lines.values():
        np.testing.assert_allclose(found, drawn, atol=1e-12)
    in_z, in_w = (
        shaft.wrench("bearing_out", "world").axis[0] for shaft in (story.z_shaft, story.w_shaft)
    )
    np.testing.assert_allclose(in_z, [1.0, 0.0, 0.0], atol=1e-14)  # Z: the end shafts are parallel
    np.testing.assert_allclose(in_w, [np.cos(2 * beta), np.sin(2 * beta), 0.0], atol=1e-14)


def test_the_forces_of_z_and_w_differ(story: SimpleNamespace) -> None:
    for name, sense in (("Z", 0.0), ("W", 2.0)):
        np.testing.assert_allclose(story.forces[name], story.statics[name], atol=1e-10)
        greatest = sense * story.torque * np.sin(story.beta) / story.length
        np.testing.assert_allclose(story.forces[name][0], greatest, atol=1e-10)
        np.testing.assert_allclose(np.max(story.forces[name]), greatest, atol=1e-10)


def test_the_example_in_space(story: SimpleNamespace) -> None:
    v_1, h_1, v_2, h_2 = story.v_1, story.h_1, story.v_2, story.h_2
    assert round(story.beta_1, 4) == 16.4225
    assert round(story.beta_2, 4) == 16.3956
    assert round(story.phi, 3) == 70.873
    np.testing.assert_allclose(
        np.radians([story.beta_1, story.beta_2]),
        [compound_angle.compound_angle(h_1, v_1), compound_angle.compound_angle(h_2, v_2)],
        rtol=1e-12,
    )
    gamma = float(compound_angle.fork_offset(h_1, v_1, h_2, v_2))
    np.testing.assert_allclose(np.deg2rad(story.phi), abs(gamma), rtol=1e-12)
    # Bild 18 adds the angles themselves, and is read off to half a degree and to one.
    as_drawn = [np.hypot(*tip) for tip in story.drawn]
    np.testing.assert_allclose(as_drawn, [16.55, 16.62], atol=5e-3)
    np.testing.assert_allclose(
        np.tan(np.hypot(*np.deg2rad(story.planes[0]))),
        np.hypot(np.tan(h_1), np.tan(v_1)),
        rtol=1e-12,
    )
    # What is left is that of both angles' difference; with equal ones nothing is.
    pair = np.radians([story.beta_1, story.beta_2])
    residual = float(drive_line.residual_angle(pair, np.array([0.0, 0.5 * np.pi])))
    np.testing.assert_allclose(story.left, single_joint.non_uniformity(residual), rtol=1e-4)
    scale = np.tan(pair[0]) / np.tan(pair[1])
    evened = [float(np.arctan(scale * np.tan(angle))) for angle in (v_2, h_2)]
    matched = story.turned("double_shaft_spatial", story.projections(v_1, h_1, *evened))
    np.testing.assert_allclose(matched.motion.ratio("bearing_out"), 1.0, rtol=1e-13)
    # Forks 70.873° from where they belong: both joints add up for the most part.
    phases = np.array([0.0, 0.5 * np.pi + abs(gamma)])
    misphased = float(drive_line.residual_angle([story.beta, story.beta], phases))
    np.testing.assert_allclose(story.wrong, single_joint.non_uniformity(misphased), rtol=1e-3)
    assert story.wrong > story.alone


def test_the_residual_angle(story: SimpleNamespace) -> None:
    phases = np.array([0.0, 0.5 * np.pi])
    pairs = np.radians(np.stack([story.small + 2.0, story.small], axis=-1))
    exact = np.rad2deg(drive_line.residual_angle(pairs, phases))
    np.testing.assert_allclose(story.found_residual, exact, rtol=1e-8)
    first_order = np.rad2deg(drive_line.residual_angle_approximate(pairs, phases))
    np.testing.assert_allclose(story.his_residual, first_order, rtol=1e-12)
    at = {two: index for index, two in enumerate(story.small)}
    for two, exactly, printed in ((10.0, 6.6673, 6.6332), (38.0, 13.5601, 12.4900)):
        assert round(story.found_residual[at[two]], 4) == exactly
        assert round(story.his_residual[at[two]], 4) == printed
    assert round(float(single_joint.non_uniformity(np.deg2rad(3.0))), 7) == 0.0027428


def test_a_line_of_three_joints(story: SimpleNamespace) -> None:
    phases = np.array([0.0, 0.5, 1.0]) * np.pi
    np.testing.assert_allclose(
        story.line.motion.ratio("bearing_out"),
        drive_line.speed_ratio(story.three, phases, story.position),
        rtol=1e-13,
    )
    exact = float(drive_line.residual_angle(story.three, phases))
    np.testing.assert_allclose(np.deg2rad(story.line_residual), exact, rtol=1e-6)
    assert round(story.line_residual, 3) == 0.121
    first_order = drive_line.residual_angle_approximate(story.three, phases)
    np.testing.assert_allclose(first_order, 0.0, atol=1e-7)


@pytest.mark.parametrize("arrangement", ["Z", "W"])
def test_bearing_forces_of_planar_lines(story: SimpleNamespace, arrangement: str) -> None:
    beta, apart, options = story.beta, story.length, story.options
    spans = support_forces.Spans(**dict(zip("abef", options["spans"], strict=True)))
    build = {"Z": arrangements.z_arrangement, "W": arrangements.w_arrangement}[arrangement]
    found = build(beta, apart, **options).analyse()
    in_plane, normal = support_forces.planar_support_forces(
        beta, beta, options["torque"], apart, spans, arrangement
    )
    forces = found.total.bearing_radial
    for index, bearing in enumerate(found.bearings):
        # The pin of the input fork is normal to the plane of the side view at 0.
        np.testing.assert_allclose(forces[0, index], getattr(normal, bearing), rtol=1e-9)
        np.testing.assert_allclose(
            forces[90, index],
            getattr(in_plane, bearing),
            rtol=1e-9,
            atol=1e-9 * options["torque"],
        )


def test_bearing_forces_in_space(story: SimpleNamespace) -> None:
    # No printed formula has them; the mechanism and the statics of all shafts agree.
    in_space, options = story.in_space, story.options
    np.testing.assert_allclose(
        in_space.joint_angles, np.radians([story.beta_1, story.beta_2]), rtol=1e-12
    )
    assert [round(offset, 2) for offset in story.offsets] == [-70.87, -72.30]
    graphical = arrangements.graphical_method(story.v_1, story.h_1, story.v_2, story.h_2)
    np.testing.assert_allclose(np.rad2deg(graphical.fork_offset), story.offsets[0], rtol=1e-9)
    found = story.bearings
    statics = support_forces.line_support_forces(
        in_space.geometry.directions,
        found.position - float(in_space.geometry.plane_offsets[0]),
        options["torque"],
        in_space.geometry.lengths[1:-1],
        np.zeros(0),
        support_forces.Spans(**dict(zip("abef", options["spans"], strict=True))),
        in_space.fork_offsets,
    )
    for index, bearing in enumerate(found.bearings):
        expected = np.linalg.norm(getattr(statics, bearing), axis=-1)
        np.testing.assert_allclose(found.total.bearing_radial[:, index], expected, rtol=1e-9)
        np.testing.assert_allclose(story.peaks[bearing], np.max(expected), rtol=1e-9)
