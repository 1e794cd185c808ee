"""Drawing: forks, shafts and crosses where they are, and labels that stay clear of each other."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from testkit.line_data import random_line

pytest.importorskip("matplotlib", reason="figures need it")

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.text import Text

from cardan_dyn.drive_lines import Bearing, DriveLine, Shaft, ShaftJoint, Tube, examples
from cardan_dyn.practice.drive_lines import drawing
from cardan_dyn.practice.drive_lines.wording import Wording
from cardan_dyn.practice.formats.visuals import visuals_of


@pytest.mark.parametrize("seed", range(4))
def test_pins_of_forks_by_crosses_alone(seed: int) -> None:
    line = random_line(5, seed, bend=0.5)
    axes, pin = line.geometry.directions, np.array([0.0, 0.0, 1.0])
    front, rear = drawing.fork_pins(line)
    # The driving pin of the input fork is horizontal, and across its shaft.
    pin = np.cross([0.0, 0.0, 1.0], axes[0])
    pin /= np.linalg.norm(pin)
    for k, axis in enumerate(axes[:-1]):
        assert abs(rear[k] @ pin) == pytest.approx(1.0, abs=1e-12)
        # The other pin of a cross is across its first one and across the next shaft.
        driven = np.cross(pin, axes[k + 1])
        driven /= np.linalg.norm(driven)
        assert abs(front[k + 1] @ driven) == pytest.approx(1.0, abs=1e-12)
        assert rear[k] @ axis == pytest.approx(0.0, abs=1e-12)
        if k + 1 < line.count:
            # Turned about the shaft by the fork offset, by the right-hand rule.
            offset = line.fork_offsets[k]
            side = np.cross(axes[k + 1], driven)
            pin = np.cos(offset) * driven + np.sin(offset) * side
    assert np.isnan(front[0]).all() and np.isnan(rear[-1]).all()


def test_shafts_and_crosses_are_to_scale() -> None:
    shafts = [
        Shaft(bearings=[Bearing(distance=0.1), Bearing(distance=0.3)]),
        Shaft(length=0.8, tube=Tube(outer_diameter=0.12, wall=0.005)),
        Shaft(),
    ]
    line = DriveLine(shafts=shafts, joints=[ShaftJoint(cross_span=0.15), ShaftJoint()])
    parts = np.concatenate([part.points for part in drawing.solids(line)])
    middle = [part.points for part in drawing.solids(line) if np.ptp(part.points[:, 0]) > 0.5]
    assert len(middle) == 1 and np.abs(middle[0][:, 1]).max() == pytest.approx(0.06)
    near = parts[np.abs(parts[:, 0]) < 0.02]
    # The cross of joint 1: its driving pin to the left, its other one up.
    assert np.abs(near[:, 1]).max() == pytest.approx(0.075, abs=0.02)
    along = drawing.line_points(line)
    assert along[1:3] == pytest.approx(np.array([[0.0, 0.0, 0.0], [0.8, 0.0, 0.0]]))


@pytest.mark.parametrize("name", ["truck", "pto", "paper_machine"])
def test_a_drawing_shows_what_stands_in_the_scene(name: str) -> None:
    line = DriveLine.from_toml(name)
    turn = line.scene().sweep([0.0])
    visuals, _ = visuals_of(line.mechanism.description)
    places = [
        turn.point(item.link).position[0] + turn.orientation(item.link)[0] @ item.placement[:3, 3]
        for item in visuals
    ]
    drawn = [part.points.mean(axis=0) for part in drawing.solids(line)]
    assert len(drawn) == len(places)
    order = [int(np.argmin(np.linalg.norm(np.array(drawn) - place, axis=1))) for place in places]
    np.testing.assert_allclose(np.array(drawn)[order], places, atol=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_hulls(seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(40, 2))
    expected = points[ConvexHull(points).vertices]
    found = drawing.hull(points)
    assert sorted(map(tuple, found)) == sorted(map(tuple, expected))
    assert drawing.hull(np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]])).shape == (2, 2)


def long_names() -> DriveLine:
    line = random_line(6, 1)
    names = [f"shaft {k} of a very long name that needs several lines" for k in range(7)]
    shafts = [
        Shaft(**{**vars(shaft), "name": n}) for shaft, n in zip(line.shafts, names, strict=True)
    ]
    return line.replace(shafts=shafts, name="long")


LINES = {name: DriveLine.from_toml(name) for name in examples()} | {
    "one joint": random_line(1, 1),
    "six joints": random_line(6, 4),
    "long names": long_names(),
    "no data": DriveLine(shafts=[Shaft(), Shaft(length=0.9, slope_side=0.2), Shaft()]),
    "even": random_line(3, 2).replace(joints=[ShaftJoint(kind="constant_velocity")] * 3),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", LINES)
def test_views_have_one_scale_and_labels_are_clear_of_each_other(name: str) -> None:
    line = LINES[name]
    figure = drawing.arrangement(line, wording=Wording("de", "imperial"))
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    render = canvas.get_renderer()
    scales = []
    for panel in figure.axes:
        box = panel.get_window_extent(render)
        x, y = np.ptp(panel.get_xlim()), np.ptp(panel.get_ylim())
        scales += [box.width / x, box.height / y]
        # Without the leaders, which an annotation counts as its own.
        texts = [Text.get_window_extent(text, render) for text in panel.texts]
        assert len(texts) == 2 * line.count + 1
        for index, one in enumerate(texts):
            assert not any(one.overlaps(other) for other in texts[:index])
            assert figure.bbox.x0 <= one.x0 and one.x1 <= figure.bbox.x1
            assert box.y0 - 1.0 <= one.y0 and one.y1 <= box.y1 + 1.0
    assert scales == pytest.approx([scales[0]] * 4, rel=1e-6)
    shown = {text.get_text() for panel in figure.axes for text in panel.texts}
    angle = f"{np.degrees(line.joint_angles[0]):.3f}°".replace(".", ",")
    assert any(text.startswith(f"β1 = {angle}") for text in shown)
