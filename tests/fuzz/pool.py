"""Pool: mechanisms, scenes and results that calls with odd arguments start from."""

from __future__ import annotations

import datetime
import decimal
import fractions
import json
from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import oddities

import cardan_dyn as cd
from cardan_dyn.core.response import file as response_file

OPTIONS: dict[str, str] = {
    "four_bar": "drive='crank_bearing', gravity=[0.0, 0.0, -9.81]",
    "slider_crank": "drive='crank_bearing', loads={'crank_bearing': -1.0}",
    "universal_joint": "drive='bearing_in', held={'joint_angle': 0.4}, loads={'bearing_out': -2.0}",
    "thoma_rig": "drive='bearing_in', held={'joint_angle': 0.3}, gravity=[0.0, -9.81, 0.0]",
    "gear": "drive='first', loads={'second': -1.0}",
    "arm": "drive=['turn', 'slide'], gravity=[0.0, 0.0, -9.81]",
}

_BODY = """<link name="{}"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>"""
_JOINT = '<joint name="{}" type="{}"><parent link="{}"/><child link="{}"/><axis xyz="0 0 1"/>{}'
TEXTS: dict[str, str] = {
    "gear": '<robot name="gear"><link name="house"/>'
    + "".join(_BODY.format(name) + "</link>" for name in ("one", "two"))
    + _JOINT.format("first", "continuous", "house", "one", "</joint>")
    + _JOINT.format("second", "continuous", "house", "two", '<origin xyz="1 0 0"/></joint>')
    + '<coupling name="teeth"><predecessor link="one"/><successor link="two"/>'
    '<ratio value="-2"/></coupling></robot>',
    "arm": '<robot name="arm"><link name="house"/>'
    + "".join(_BODY.format(name) + "</link>" for name in ("one", "two"))
    + _JOINT.format("turn", "continuous", "house", "one", "</joint>")
    + _JOINT.format("slide", "prismatic", "one", "two", '<limit effort="1" velocity="1"/></joint>')
    + "</robot>",
}


@cache
def mechanism(name: str) -> cd.Mechanism:
    """Return a mechanism of the pool."""
    return cd.load(TEXTS.get(name, name))


@cache
def scene(name: str) -> cd.Scene:
    """Return a scene of the pool."""
    return eval(f"cd.Scene(mechanism({name!r}), {OPTIONS[name]})")


@cache
def response(name: str) -> cd.Response:
    """Return a response of the pool."""
    return scene(name).response()


@cache
def swept(name: str) -> cd.Sweep:
    """Return a sweep of the pool."""
    count = len(scene(name).drives)
    return scene(name).sweep(np.linspace(0.0, 0.3, 4)[:, None] * np.ones(count))


def refresh() -> None:
    """Build the pool anew, so that one case cannot spoil the next."""
    for made in (mechanism, scene, response, swept):
        made.cache_clear()


def saved(
    directory: Path,
    name: str,
    *,
    cut: int | None = None,
    flip: int | None = None,
    drop: str | None = None,
    change: tuple[str, Callable[[np.ndarray], np.ndarray]] | None = None,
    head: tuple[str, Callable[[object], object]] | None = None,
    sealed: bool = False,
) -> Path:
    """Return the path of a saved response that was damaged in one way.

    Args:
        directory: for the file.
        name: of the scene.
        cut, flip: byte at which the file ends, or has another bit.
        drop, change, head: array that is left out or changed, entry of the header that is changed.
        sealed: whether the checksum is made to fit the damage.
    """
    path = directory / "saved.npz"
    response(name).save(path)
    content = path.read_bytes()
    if cut is not None:
        path.write_bytes(content[: cut % len(content)])
    if flip is not None:
        index = flip % len(content)
        path.write_bytes(content[:index] + bytes([content[index] ^ 16]) + content[index + 1 :])
    if drop or change or head:
        with np.load(path) as file:
            arrays = {key: file[key] for key in file.files if key != drop}
        if change:
            arrays[change[0]] = change[1](arrays[change[0]])
        if head:
            header = json.loads(str(arrays["header"]))
            try:
                header[head[0]] = head[1](header.get(head[0]))
            except TypeError:  # It has nothing that could be changed in this way.
                header[head[0]] = None
            arrays["header"] = np.array(json.dumps(header))
        if sealed:
            parts = {key: array for key, array in arrays.items() if key != "checksum"}
            arrays["checksum"] = np.array(response_file._checksum(parts))
        np.savez(path, **arrays)
    return path


def namespace(directory: Path) -> dict[str, object]:
    """Return what the code of a call refers to."""
    return {
        **{"cd": cd, "np": np, "Path": Path, "decimal": decimal, "fractions": fractions},
        **{"datetime": datetime, "directory": directory, "TEXTS": TEXTS},
        **{"mechanism": mechanism, "scene": scene, "response": response, "swept": swept},
        **{made.__name__: made for made in oddities.CLASSES},
        "saved": lambda name, **damage: saved(directory, name, **damage),
    }


def evaluate(code: str, directory: Path) -> object:
    """Return what a call returns."""
    return eval(code, namespace(directory))
