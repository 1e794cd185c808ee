import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from cardan_dyn import ModelError
from cardan_dyn.drive_lines import DriveLine, Shaft, Spline

LINE = DriveLine(shafts=[Shaft(), Shaft(length=0.9, slope_side=-0.1, spline=Spline()), Shaft()])


def test_replace_makes_another_line() -> None:
    other = LINE.replace(speed=300)
    assert type(other) is DriveLine
    assert (other.speed, other.shafts) == (300.0, LINE.shafts)
    assert LINE.speed is None


def test_replace_knows_its_fields() -> None:
    with pytest.raises(ModelError, match=r"no field 'sped'; fields: .*did you mean 'speed'"):
        LINE.replace(sped=3)
    with pytest.raises(ModelError, match="speed of a DriveLine is nan"):
        LINE.replace(speed=float("nan"))


def test_text_and_back() -> None:
    assert DriveLine.from_toml(LINE.to_toml()) == LINE


def test_its_mechanism_is_made_once() -> None:
    assert LINE.mechanism is LINE.mechanism
    other = pickle.loads(pickle.dumps(LINE))
    assert other == LINE
    assert "mechanism" not in vars(other)
    assert other.to_urdf() == LINE.to_urdf()


def test_scenes_take_what_scenes_take() -> None:
    scene = LINE.scene(loads={"bearing_out": -10.0}, held={"fork_offset_1": 0.1})
    sweep = scene.sweep(np.linspace(0, 1, 5), held={"fork_offset_1": np.linspace(0, 1, 3)[:, None]})
    assert sweep.shape == (3, 5)
    assert scene.drives == ("bearing_in",)


def test_what_statics_leaves_open() -> None:
    assert LINE.indeterminate == ()
    assert len(DriveLine(shafts=[Shaft(), Shaft()]).indeterminate) == 2
    loose = LINE.replace(shafts=[Shaft(), *[Shaft(length=1, spline=Spline())] * 2, Shaft()])
    with pytest.raises(ModelError, match="nothing holds joint 2 between shaft_1 and shaft_2"):
        loose.to_urdf()


def test_analyses_from_threads() -> None:
    line = LINE.replace(speed=10, torque=20)
    with ThreadPoolExecutor(3) as pool:
        found = list(pool.map(lambda _: line.analyse().static.bending_in, range(6)))
    assert all(np.array_equal(one, found[0]) for one in found)
