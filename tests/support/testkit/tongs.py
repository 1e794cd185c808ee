"""Lazy tongs: crossed arms in a row, raised by a slide between the lower ends."""

from __future__ import annotations

import numpy as np

import cardan_dyn as cd

from .rows_of_loops import joint_element, loop_element

ARM, SLOPE = 2.0, 0.5
"""Length [m] of the arms, and their slope [rad] at the description's zero."""
_ACROSS, _UP = float(ARM * np.cos(SLOPE)), float(ARM * np.sin(SLOPE))
_LIMIT = '<limit lower="-9" upper="9" effort="1e6" velocity="1"/>'


def two_chains(
    count: int, *, pin: str = "continuous", hinge: str = "0 0 1", cylinder: int | None = None
) -> cd.Mechanism:
    """Chains of arms a_k and b_k side by side, each on the one below; loops are the pins p_k.

    Args:
        count: of pairs of arms.
        cylinder: index k of the arm a_k from a quarter of which a cylinder without mass reaches to
            three quarters of b_k+1; none if None.
        pin: joint in the middle of each pair; `universal` ones join arms b_k on balls.
        hinge: axis of arms a_k in the frame of those below.
    """
    balls = pin == "universal"
    parts, below, ends = [_frame(count)], ("frame", "foot"), ("0 0 0", "0 0 0")
    for k in range(count):
        side = _side(k)
        first, second = ("continuous", hinge), ("spherical" if balls else "continuous", "0 0 1")
        for name, on, at, (kind, axis) in zip("ab", below, ends, (first, second), strict=True):
            parts.append(joint_element(kind, f"j{name}{k}", on, f"{name}{k}", at, axis))
        middles = f"{side * _ACROSS / 2} {_UP / 2} 0", f"{-side * _ACROSS / 2} {_UP / 2} 0"
        parts.append(loop_element(pin, f"p{k}", (f"a{k}", middles[0]), (f"b{k}", middles[1])))
        below = f"a{k}", f"b{k}"
        ends = f"{side * _ACROSS} {_UP} 0", f"{-side * _ACROSS} {_UP} 0"
    if cylinder is not None:
        parts.append(_cylinder(cylinder))
    return cd.load(f'<robot name="two_chains">{"".join(parts)}</robot>')


def pair_by_pair(count: int) -> cd.Mechanism:
    """The same tongs; each arm a_k carries b_k on its pin p_k, loops jb_k are the ends of b_k."""
    parts, below, end = [_frame(count)], "frame", "0 0 0"
    for k in range(count):
        side = _side(k)
        middle = f"{side * _ACROSS / 2} {_UP / 2} 0"
        parts.append(joint_element("continuous", f"ja{k}", below, f"a{k}", end))
        parts.append(f'<link name="on_pin{k}"/>')
        parts.append(joint_element("continuous", f"p{k}", f"a{k}", f"on_pin{k}", middle))
        parts.append(
            f'<joint name="in_arm{k}" type="fixed"><parent link="on_pin{k}"/><child link="b{k}"/>'
            f'<origin xyz="{side * _ACROSS / 2} {-_UP / 2} 0"/></joint>'
        )
        lower = ("foot", "0 0 0") if k == 0 else (f"b{k - 1}", f"{side * _ACROSS} {_UP} 0")
        parts.append(loop_element("continuous", f"jb{k}", lower, (f"b{k}", "0 0 0")))
        below, end = f"a{k}", f"{side * _ACROSS} {_UP} 0"
    return cd.load(f'<robot name="pair_by_pair">{"".join(parts)}</robot>')


def slopes(positions: np.ndarray) -> np.ndarray:
    """Return the slopes [rad] of the arms at positions of the slide [m]."""
    return np.arccos((_ACROSS - positions) / ARM)


def cylinder_length(slope: np.ndarray | float) -> np.ndarray:
    """Return the length [m] of the cylinder at slopes of the arms [rad]."""
    return 0.5 * ARM * np.hypot(np.cos(slope), 3.0 * np.sin(slope))


def _cylinder(k: int) -> str:
    side, length = _side(k), float(cylinder_length(SLOPE))
    along = f"{side * _ACROSS / 2 / length} {1.5 * _UP / length} 0"
    foot, head = (f"{side * part * _ACROSS} {part * _UP} 0" for part in (0.25, 0.75))
    return (
        '<link name="tube"/><link name="rod"/>'
        + joint_element("continuous", "foot", f"a{k}", "tube", foot)
        + f'<joint name="cylinder" type="prismatic"><parent link="tube"/><child link="rod"/>'
        f'<axis xyz="{along}"/>{_LIMIT}</joint>'
        + loop_element(
            "continuous",
            "head",
            ("rod", f"{side * _ACROSS / 2} {1.5 * _UP} 0"),
            (f"b{k + 1}", head),
        )
    )


def _side(k: int) -> int:
    """Return to which side arm a_k rises."""
    return 1 if k % 2 == 0 else -1


def _frame(count: int) -> str:
    arms = "".join(_arm(f"{name}{k}", side) for k in range(count) for name, side in _sides(k))
    return (
        f'<link name="frame"/><link name="foot"/>{arms}<joint name="slide" type="prismatic">'
        f'<parent link="frame"/><child link="foot"/><origin xyz="{_ACROSS} 0 0"/>'
        f'<axis xyz="-1 0 0"/>{_LIMIT}</joint>'
    )


def _sides(k: int) -> tuple[tuple[str, int], tuple[str, int]]:
    return ("a", _side(k)), ("b", -_side(k))


def _arm(name: str, side: int) -> str:
    return (
        f'<link name="{name}"><inertial><origin xyz="{side * _ACROSS / 2} {_UP / 2} 0"/>'
        '<mass value="3"/><inertia ixx="0.3" iyy="0.7" izz="1" ixy="0" ixz="0" iyz="0"/>'
        "</inertial></link>"
    )
