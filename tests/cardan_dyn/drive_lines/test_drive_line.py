import importlib
import pickle
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from testkit.line_data import double_shaft, random_line

from cardan_dyn import ArgumentError, ModelError
from cardan_dyn.drive_lines import DriveLine, DutyPoint, Shaft, Spline

LINE = DriveLine(shafts=[Shaft(), Shaft(length=0.9, slope_side=-0.1, spline=Spline()), Shaft()])
DOUBLE = double_shaft((0.0, 0.2, 0.0)).replace(speed=300, torque=400)


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


def counted(monkeypatch: pytest.MonkeyPatch, *names: str) -> dict[str, int]:
    """Count the calls of functions, by where they are."""
    counts = dict.fromkeys(names, 0)
    for name in names:
        module, owner, function = name.rsplit(".", 2)
        kind = getattr(importlib.import_module(f"cardan_dyn.{module}"), owner)
        original = getattr(kind, function)

        def call(
            *given: object, name: str = name, original: Any = original, **named: object
        ) -> Any:
            counts[name] += 1
            return original(*given, **named)

        monkeypatch.setattr(kind, function, call)
    return counts


@pytest.mark.slow
def test_a_verdict_makes_one_scene_and_one_sweep(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    cycle = [DutyPoint(share=0.25, speed=100.0 * k, torque=50.0) for k in range(4)]
    line = random_line(3, 1, mass=True).replace(
        speed=100.0, torque=200.0, duty_cycle=cycle, acceleration=50.0, reversing=True
    )
    shafts = [
        shaft if shaft.spline is None else replace(shaft, spline=Spline(friction=0.1, radius=0.02))
        for shaft in line.shafts
    ]
    made, closed, swept, followed = (
        "scene.scene.Scene.__init__",
        "core.dynamics.problem_solver.ProblemSolver.assembled_at",
        "scene.scene.Scene.sweep",
        "core.kinematics.assembly.Assembly.guesses",
    )
    counts = counted(monkeypatch, made, closed, swept, followed)
    line = line.replace(shafts=shafts)
    assert len(line.verdict()) > 20
    # Torque, one spline with friction, speed, acceleration and weight are one sweep.
    assert counts == {made: 1, closed: 1, swept: 1, followed: 0}
    line.analyse()
    line.analyse(speed=10.0)
    assert counts == {made: 1, closed: 3, swept: 3, followed: 0}
    designs = line.variants(angles=np.full((7, 3), 0.2))
    line.analyse(variants=designs)
    line.analyse(variants=designs)
    assert counts == {made: 2, closed: 5, swept: 5, followed: 0}


@pytest.mark.slow
def test_a_verdict_needs_no_optimiser() -> None:
    code = (
        "import sys; from cardan_dyn.drive_lines import DriveLine; "
        "rows = DriveLine.from_toml('truck').verdict().rows; "
        "print(len(rows) > 9, any(row.inverses for row in rows), 'scipy.optimize' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True", "True", "False"]


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


def test_what_is_not_given_comes_from_the_line() -> None:
    found = DOUBLE.analyse()
    assert found.speed == 300.0
    assert found.static.drive_torque == pytest.approx(np.full(360, 400.0))
    assert found.position == pytest.approx(np.radians(np.arange(360)))
    other = DOUBLE.analyse(speed=1, torque=2, positions=0.5)
    assert (other.speed, other.shape) == (1.0, (1,))
    assert other.static.drive_torque == pytest.approx([2.0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"speed": np.nan}, "speed is not finite"),
        ({"speed": [1, 2]}, r"speed has shape \(2,\), expected a number"),
        ({"torque": [1, 2]}, r"torque has shape \(2,\), expected a number or a value per position"),
        ({"torque": "much"}, "torque is not an array of real numbers"),
        ({"positions": []}, r"positions has shape \(0,\)"),
        ({"positions": np.ones((2, 2))}, r"positions has shape \(2, 2\)"),
        ({"torque_at": "middle"}, "torque_at is 'middle', expected 'input' or 'output'"),
        (
            {"torque_at": np.zeros(3)},
            "torque_at is an array of type float64, expected 'input' or 'output'",
        ),
        ({"slipping": "sideways"}, "slipping is 'sideways', expected 'in', 'out' or None"),
        ({"slipping": 1}, "slipping is 1"),
        ({"gravity": 9.81}, r"gravity has shape \(\), expected \(3,\)"),
        ({"variants": 3}, "variants is 3, expected what variants"),
        ({"acceleration": "x"}, "acceleration is not"),
    ],
)
def test_wrong_arguments(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(ArgumentError, match=message):
        DOUBLE.analyse(**arguments)


def test_variants_of_another_line() -> None:
    other = double_shaft((0.0, 0.3, 0.0)).variants(angles=[[0.1, 0.1]])
    with pytest.raises(ArgumentError, match="variants are those of another line"):
        DOUBLE.analyse(variants=other)
    # Another speed makes no difference.
    assert DOUBLE.replace(speed=1).analyse(variants=DOUBLE.variants()).shape == (1, 72)


def test_what_is_given_nowhere() -> None:
    line = double_shaft((0.0, 0.2, 0.0))
    with pytest.raises(ArgumentError, match="torque is given neither here nor by the line"):
        line.analyse(speed=1)
    with pytest.raises(ArgumentError, match="speed is given neither here nor by the line"):
        line.analyse(torque=1)
