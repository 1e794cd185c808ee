"""Every kind of result, in odd cases: kept, copied, tabled, written and drawn alike."""

from __future__ import annotations

import copy
import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from testkit import elastic_rigs

import cardan_dyn as cd
from cardan_dyn import clearance, drive_lines, vibration

pandas = pytest.importorskip("pandas", reason="tables need pandas")
xarray = pytest.importorskip("xarray", reason="tables need xarray")
pytestmark = pytest.mark.usefixtures("loaded_once")

TURN = np.linspace(0.0, 6.0, 7)
COPIES: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda item: pickle.loads(pickle.dumps(item)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}
TURNING, SLIDING = 'joint 1, "é" [m]', "slide=°/\n2"
ODD = """<robot name='a "b", &lt;c&gt;/ü'><link name="base"/>
  <link name="l,1"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <link name="l 2"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  <joint name="joint 1, &quot;é&quot; [m]" type="continuous"><parent link="base"/>
    <child link="l,1"/><axis xyz="0 0 1"/></joint>
  <joint name="slide=°/&#10;2" type="prismatic"><parent link="l,1"/><child link="l 2"/>
    <origin xyz="1 0 0"/><limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>"""


def universal(**options: Any) -> cd.Scene:
    given = {"drive": "bearing_in", "held": {"joint_angle": 0.5}}
    return cd.Scene(cd.load("universal_joint"), **{**given, **options})


def sprung(**options: Any) -> cd.Scene:
    springs = [cd.JointSpring("bearing_out", 20.0, 0.1, name='ä "'), cd.JointFriction("pin_in", 1)]
    return universal(elements=springs, **options)


def free(**options: Any) -> cd.Scene:
    return universal(drive=(), free="bearing_in", **options)


def odd(**options: Any) -> cd.Scene:
    return cd.Scene(cd.load(ODD), **options)


def two_drives() -> cd.Sweep:
    scene = universal(drive=["bearing_in", "joint_angle"], held={})
    return scene.sweep(np.column_stack([TURN, 0.1 + 0.05 * TURN]), speed=[1.0, 2.0])


def needle(kind: Callable[..., Any], *given: Any, **options: Any) -> Any:
    scene = cd.Scene(cd.load("needle_drive"), drive="main_shaft")
    contact = {"clearance": 1e-4, "stiffness": 1e8, "damping_ratio": 0.25}
    return kind(scene, *given, **contact, **options)


def scanned() -> clearance.Scan:
    return needle(clearance.scan, 300.0, joints=["coupler_pin", "needle_pin"])


def rig(damping: float = 0.1) -> cd.Scene:
    line = elastic_rigs.torsional_line(damping_in=damping)
    return elastic_rigs.scene(line, np.radians(10.0))


MADE: dict[str, Callable[[], Any]] = {
    "one sample": lambda: universal().sweep(0.3),
    "varying load": lambda: universal().sweep(TURN, 3.0, loads={"bearing_out": TURN}),
    "grid": lambda: universal().sweep(TURN, speed=[[1.0], [2.0]]),
    "designs": lambda: universal().sweep(TURN, held={"joint_angle": [[0.1], [0.2], [0.3]]}),
    "two drives": two_drives,
    "efforts alone": lambda: universal(outputs=[]).sweep(TURN),
    "elements": lambda: sprung().sweep(TURN, 2.0),
    "elements, one sample": lambda: sprung().sweep(0.1),
    "odd names": lambda: odd(drive=[TURNING, SLIDING]).sweep(
        [[0.1, 0.2], [0.2, 0.3]], loads={"l,1": cd.Wrench(force=np.ones((2, 3)))}
    ),
    "response": lambda: universal().response().sweep(TURN, 2.0),
    "response on a grid": lambda: universal().response().sweep(TURN, [[1.0], [2.0]]),
    "free": lambda: free().simulate(0.1, speed=10.0, method="quadrature"),
    "free by steps": lambda: free().simulate(0.1, speed=10.0, method="DOP853"),
    "free at one time": lambda: free().simulate(0.1, speed=10.0).at(0.05),
    "free at rest": lambda: free().simulate(0.1),
    "free with elements": lambda: sprung(drive=(), free="bearing_in").simulate(0.1, speed=3.0),
    "free beside a drive": lambda: universal(
        drive="joint_angle", held={}, free="bearing_in"
    ).simulate(0.1, motion={"joint_angle": 0.2}, speed={"bearing_in": 5.0}),
    "free, odd names": lambda: odd(free=[TURNING, SLIDING]).simulate(
        0.1, speed=[3.0, 1.0], events=[cd.Event(lambda t, x, v: x[TURNING] - 0.1, name='e "1"')]
    ),
    "line": lambda: drive_lines.DriveLine.from_toml("truck").analyse(),
    "line without weight": lambda: drive_lines.DriveLine.from_toml("pto").analyse(
        speed=50.0, torque=100.0
    ),
    "scan": scanned,
    "scan of a joint": lambda: scanned()["coupler_pin"],
    "contacts": lambda: needle(
        clearance.simulate, 300.0, joints="coupler_pin", turns=0.3, rtol=1e-7
    ),
    "periodic motion": lambda: vibration.periodic_motion(rig(), [0.9, 1.0, 1.1]),
    "linearisation": lambda: vibration.linearise(rig(), 0.7),
    "campbell": lambda: vibration.campbell(rig(), 1.0),
    "forced response": lambda: vibration.forced_response(rig(), [0.9, 1.1], joints=["twist_in"]),
    "floquet": lambda: vibration.floquet(rig(), [0.9, 1.1]),
    "critical speeds": lambda: vibration.critical_speeds(rig(0.0), [0.8, 1.2], orders=(1, 2.5)),
    "no critical speed": lambda: vibration.critical_speeds(rig(), [1.6, 1.7]),
    "run-up": lambda: vibration.run_up(rig(), 0.6, 0.7, 30.0),
}


@pytest.fixture(scope="module", params=MADE)
def result(request: pytest.FixtureRequest) -> Any:
    return MADE[request.param]()


def same(one: Any, other: Any) -> None:
    """Assert that all of two tables is equal, bit for bit."""
    first, second = one.to_dataframe(), other.to_dataframe()
    pandas.testing.assert_frame_equal(first, second, check_exact=True)
    # As text, in which numbers have all their digits, and nan is nan.
    assert repr(first.attrs) == repr(second.attrs)


def test_copies_say_what_was_read_bit_for_bit(result: Any) -> None:
    result.to_dataframe()
    for made in COPIES.values():
        same(made(result), result)


@pytest.mark.parametrize("name", ["free", "free by steps", "varying load", "scan"])
def test_copies_of_what_nobody_has_read_are_equal(name: str) -> None:
    """A trajectory closes its loops when it is read, and rounds as what was closed before."""
    result = MADE[name]()
    for again in [made(result) for made in COPIES.values()]:
        same(result, again)


def test_files_hold_all_columns(result: Any, tmp_path: Path) -> None:
    frame, units = result.to_dataframe(), result.to_dataframe().attrs["units"]
    # As texts: readers of numbers of older pandas round once more.
    read = pandas.read_csv(result.save(tmp_path / "a.csv"), dtype=str)
    assert len(read) == len(frame)
    numbers = [name for name in frame if frame[name].dtype.kind == "f"]
    for name in numbers:
        header = f"{name} [{units[name]}]" if units[name] else name
        np.testing.assert_array_equal(read[header].astype(float), frame[name])

    def refuse(constant: str) -> None:
        raise ValueError(f"{constant} is not JSON")

    text = result.save(tmp_path / "a.json").read_text(encoding="utf-8")
    columns = json.loads(text, parse_constant=refuse)["columns"]
    assert list(columns) == list(frame)
    for name in numbers:
        values = [float("nan" if value is None else value) for value in columns[name]]
        np.testing.assert_array_equal(values, frame[name])
    table = result.to_xarray()
    with xarray.open_dataset(result.save(tmp_path / "a.nc"), engine="scipy") as stored:
        full = {
            str(name) for name, values in table.variables.items() if values.size or not frame.size
        }
        assert full == set(map(str, stored.variables))
        for name in full & set(table.data_vars):
            if table[name].dtype.kind == "f":
                np.testing.assert_array_equal(stored[name], table[name])


def test_what_is_no_path_or_leads_nowhere_is_refused(result: Any, tmp_path: Path) -> None:
    for wrong in (3, None, b"a.csv", ["a.csv"]):
        with pytest.raises(cd.ArgumentError, match=r"path is .*, expected a path"):
            result.save(wrong)
    for suffix in (".csv", ".json", ".nc"):
        with pytest.raises(cd.ArgumentError, match="cannot be written"):
            result.save(tmp_path / "missing" / f"a{suffix}")


def test_two_drives_are_drawn_over_the_first() -> None:
    pytest.importorskip("matplotlib", reason="figures need matplotlib")
    (axes,) = two_drives().plot("bearing_in.drive_effort").axes
    np.testing.assert_allclose(axes.lines[0].get_xdata(), np.rad2deg(TURN))
    assert axes.get_xlabel() == "bearing_in.drive_position [°]"


def test_sweeps_trajectories_responses_and_tables_show_what_proves_them() -> None:
    for name in ("varying load", "free", "response"):
        result = MADE[name]()
        proven = getattr(result, "sweep", result).proven
        told = result.to_dataframe().attrs
        for residual, value in proven.residuals.items():
            assert getattr(result, residual) == value == told[residual]
    family = universal().responses(held={"joint_angle": [0.3, 0.6]})
    designs = family.sweep(TURN[:, None], 2.0).proven
    scenes = [universal(held={"joint_angle": angle}) for angle in (0.3, 0.6)]
    each = [scene.response().sweep(TURN, 2.0).proven for scene in scenes]
    assert designs.unproven == each[0].unproven
    for residual, value in designs.residuals.items():
        assert value < 1e-10
        np.testing.assert_equal(np.isnan(value), np.isnan(each[0].residuals[residual]))
