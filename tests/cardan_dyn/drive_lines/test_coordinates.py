"""Coordinates of all joints of a line, against loops that are closed from there."""

from __future__ import annotations

import numpy as np
import pytest
from testkit.line_data import NEAR, end_bearings, random_line

from cardan_dyn.drive_lines import (
    Bearing,
    Centring,
    DriveLine,
    Shaft,
    ShaftJoint,
    Spline,
    Variants,
    examples,
)
from cardan_dyn.practice.drive_lines.verdict.coordinates import coordinates
from cardan_dyn.practice.drive_lines.verdict.solving import closed_near

POSITIONS = np.array([0.0, 0.7, 2.0, 9.0, -30.0])
ROUNDING = 1e-13


def behind_a_spline() -> DriveLine:
    """A centre bearing on each piece of a shaft; on another one, only behind the spline."""
    slopes = [(0.0, 0.0), (0.1, 0.2), (-0.2, 0.1), (0.1, -0.1), (0.0, 0.1)]
    forks = (0.0, 0.4, -0.5, 0.2, 0.0)
    bearings = {1: (0.2, 0.75), 2: (0.7,)}
    shafts = [
        Shaft(
            slope_side=side,
            slope_plan=plan,
            length=0.9,
            fork_offset=fork,
            spline=Spline() if k in (1, 2) else None,
            bearings=[Bearing(distance=at, locating=k == 1) for at in bearings.get(k, ())],
        )
        for k, ((side, plan), fork) in enumerate(zip(slopes, forks, strict=True))
    ]
    return DriveLine(shafts=shafts)


def even() -> DriveLine:
    """A line with joints of constant velocity, before a shaft with bearings and one without."""
    line = random_line(4, 3)
    kinds = ("constant_velocity", "cross", "constant_velocity", "cross")
    return line.replace(joints=[ShaftJoint(kind=kind) for kind in kinds])


def centred(**centring: object) -> DriveLine:
    """A centred double joint before another joint."""
    return DriveLine(
        shafts=[
            Shaft(bearings=end_bearings(0)),
            Shaft(length=0.15, fork_offset=0.3, centring=Centring(**centring)),
            Shaft(slope_side=0.2, slope_plan=0.5, length=0.9, fork_offset=-1.0, spline=Spline()),
            Shaft(slope_side=0.1, bearings=[Bearing(distance=NEAR[1]), Bearing(distance=0.3)]),
        ]
    )


LINES = {
    **{name: DriveLine.from_toml(name) for name in examples()},
    **{f"random {count}": random_line(count, count) for count in (1, 2, 5)},
    "behind a spline": behind_a_spline(),
    "even": even(),
    "disc": centred(kind="disc"),
    "ball at the rear": centred(kind="ball", fixed_to="rear", equal_at=0.4),
    "ball at the front": centred(kind="ball", fixed_to="front", equal_at=0.7),
}


def designs(line: DriveLine) -> Variants:
    """Return designs that differ in all that may vary."""
    rng, count = np.random.default_rng(1), 6
    if line.centred:
        return line.variants(
            fork_offsets=rng.uniform(-3.0, 3.0, (count, line.count - 1)),
            misalignments={"joint_plane_1": rng.uniform(-1.0, 1.0, count)},
        )
    inner = line.count - 1
    lengths = line.geometry.lengths[1:-1] * rng.uniform(1.0, 1.3, (count, inner))
    forks = rng.uniform(-3.0, 3.0, (count, inner))
    return line.variants(
        angles=rng.uniform(0.0, 1.2, (count, line.count)),
        planes=rng.uniform(-3.0, 3.0, (count, line.count)),
        **({"fork_offsets": forks, "lengths": lengths} if inner else {}),
    )


@pytest.mark.parametrize("name", LINES)
def test_loops_are_closed_there(name: str) -> None:
    line = LINES[name]
    variants = designs(line)
    for chosen in (None, variants):
        moved = {} if chosen is None else {key: at[:, None] for key, at in chosen.moved.items()}
        positions = POSITIONS if chosen is None else np.tile(POSITIONS, (chosen.designs, 1))
        held = {key.name: at for key, at in moved.items()}
        scene = line.scene(held=dict.fromkeys(held, 0.0))
        known = coordinates(line, positions, moved)
        assert known is not None
        closed = closed_near(scene, positions, held, known)
        assert max(block.residual.max() for block in closed.blocks) < ROUNDING
        # How far Newton's method moved what was given.
        assert max(block.correction.max() for block in closed.blocks) < ROUNDING


def test_shafts_off_their_axes_have_no_closed_form() -> None:
    line = LINES["random 2"]
    moved = {
        key: at[:, None]
        for key, at in line.variants(misalignments={"offset_y_1": [1e-3]}).moved.items()
    }
    assert coordinates(line, POSITIONS[None], moved) is None
