"""SDF texts of descriptions, and small models."""

from __future__ import annotations

from xml.sax.saxutils import escape

import numpy as np
import pinocchio as pin

import cardan_dyn as cd
from cardan_dyn.core.description.description import Description, JointDescription, LoopDescription

WORDS = {
    **{kind: kind for kind in ("revolute", "continuous", "prismatic", "fixed", "universal")},
    "spherical": "ball",
}
"""Type of a joint to SDF's word for it, where it has one."""
INERTIAL = """<inertial><mass>{mass!r}</mass><pose>{pose}</pose><inertia><ixx>{xx!r}</ixx>
<iyy>{yy!r}</iyy><izz>{zz!r}</izz><ixy>{xy!r}</ixy><ixz>{xz!r}</ixz><iyz>{yz!r}</iyz></inertia>
</inertial>"""
FOUR_BAR = """<sdf version="{version}"><model name="four_bar">
<link name="crank"><pose>0 0 0 0 0 0</pose>{crank}</link>
<link name="coupler"><pose>0 0.5 0 0 0 0</pose>{coupler}</link>
<link name="rocker"><pose>2 0 0 0 0 0</pose>{rocker}</link>
{joints}</model></sdf>"""
JOINT = """<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>{pose}
<axis><xyz>0 0 1</xyz></axis></joint>"""
JOINTS = {
    "a": JOINT.format(name="a", kind="continuous", parent="world", child="crank", pose=""),
    "b": JOINT.format(name="b", kind="revolute", parent="crank", child="coupler", pose=""),
    "d": JOINT.format(name="d", kind="continuous", parent="world", child="rocker", pose=""),
    "c": JOINT.format(
        name="c",
        kind="continuous",
        parent="coupler",
        child="rocker",
        pose="<pose>0 2.5 0 0 0 0</pose>",
    ),
}


def massive(mass: float, centre: str) -> str:
    """Return the inertia that the links of `linkages` have."""
    return INERTIAL.format(
        mass=mass, pose=f"{centre} 0 0 0", xx=0.02, yy=0.03, zz=0.025, xy=0.0, xz=0.0, yz=0.0
    )


def four_bar(order: str = "abdc", version: str = "1.9", **joints: str) -> str:
    """Return the four-bar of `linkages`, its joints in any order; others in their place."""
    return FOUR_BAR.format(
        version=version,
        crank=massive(1.0, "0 0.25 0"),
        coupler=massive(2.0, "1 1 0"),
        rocker=massive(3.0, "0 1.25 0"),
        joints="".join({**JOINTS, **joints}[name] for name in order),
    )


def model(content: str, version: str = "1.9", name: str = "m") -> str:
    return f'<sdf version="{version}"><model name="{name}">{content}</model></sdf>'


def placements(description: Description) -> dict[str, np.ndarray]:
    """Return the placements of all links in the world at zero."""
    found = {description.root: np.eye(4)}
    while len(found) < len(description.links):
        for joint in description.joints:
            if joint.parent in found:
                found[joint.child] = found[joint.parent] @ joint.origin @ joint.child_placement
    return found


class SdfText:
    """Writes a description whose zero is closed, every pose and axis in a frame drawn by lot."""

    def __init__(self, description: Description, seed: int) -> None:
        self._description = description
        self._rng = np.random.default_rng(seed)
        self._frames = {"world": np.eye(4), **placements(description)}
        turn = pin.rpy.rpyToMatrix(*self._rng.uniform(-1.0, 1.0, 3)) if seed else np.eye(3)
        model_frame = pin.SE3(turn, self._rng.uniform(-1.0, 1.0, 3)).homogeneous
        self._frames["__model__"] = model_frame if seed else np.eye(4)
        self._seed = seed

    def text(self) -> str:
        """Return the text; with a seed, links and joints in an order drawn by lot."""
        description = self._description
        known = ["__model__"]
        links = []
        for link in self._shuffled(list(description.links)):
            if link.name == "world":
                continue
            base = str(self._rng.choice(known)) if self._seed else "__model__"
            known.append(link.name)
            inertial = INERTIAL.format(
                mass=link.mass,
                pose=" ".join(map(repr, [*link.centre.tolist(), 0.0, 0.0, 0.0])),
                **{
                    f"{'xyz'[i]}{'xyz'[j]}": float(link.inertia[i, j])
                    for i in range(3)
                    for j in range(i, 3)
                },
            )
            pose = self._pose(self._frames[link.name], base, None)
            links.append(f"<link name={quoted(link.name)}>{pose}{inertial}</link>")
        joints: list[JointDescription | LoopDescription] = [
            *description.joints,
            *description.loops,
        ]
        texts = [self._joint(joint, known) for joint in joints]
        if description.root != "world":
            texts.append(
                '<joint name="stand" type="fixed"><parent>world</parent>'
                f"<child>{escape(description.root)}</child></joint>"
            )
        # A link may come first in the file and still be placed relative to a later one.
        content = [*self._shuffled(links), *self._shuffled(texts)]
        placed = self._pose(self._frames["__model__"], "world", "world")
        return (
            f'<sdf version="1.9"><model name={quoted(description.name)}>{placed}'
            f"{''.join(content)}</model></sdf>"
        )

    def _joint(self, joint: JointDescription | LoopDescription, known: list[str]) -> str:
        if isinstance(joint, JointDescription):
            parent, child, origin = joint.parent, joint.child, joint.origin
        else:
            parent, child, origin = joint.predecessor, joint.successor, joint.predecessor_origin
        frame = self._frames[parent] @ origin
        base = str(self._rng.choice(known)) if self._seed else child
        axes = ""
        for tag, axis in (("axis", joint.axis), ("axis2", joint.axis_2)):
            if joint.type in ("fixed", "spherical") or (
                tag == "axis2" and joint.type != "universal"
            ):
                continue
            inside, name = axis, ""
            if self._seed and self._rng.random() < 0.5:
                other = str(self._rng.choice(known))
                inside = self._frames[other][:3, :3].T @ frame[:3, :3] @ axis
                name = f" expressed_in={quoted(other)}"
            xyz = " ".join(map(repr, inside.tolist()))
            axes += f"<{tag}><xyz{name}>{xyz}</xyz></{tag}>"
        return (
            f'<joint name={quoted(joint.name)} type="{WORDS[joint.type]}">'
            f"<parent>{escape(parent)}</parent><child>{escape(child)}</child>"
            f"{self._pose(frame, base, child)}{axes}</joint>"
        )

    def _pose(self, frame: np.ndarray, base: str, default: str | None) -> str:
        local = np.linalg.solve(self._frames[base], frame)
        quaternion = pin.Quaternion(local[:3, :3]).coeffs()
        numbers = " ".join(repr(float(value)) for value in (*local[:3, 3], *quaternion))
        named = "" if base == default else f" relative_to={quoted(base)}"
        return f'<pose rotation_format="quat_xyzw"{named}>{numbers}</pose>'

    def _shuffled(self, items: list) -> list:
        if self._seed:
            self._rng.shuffle(items)
        return items


def quoted(text: str) -> str:
    return f'"{escape(text, {chr(34): "&quot;"})}"'


def compare(found: cd.Sweep, reference: cd.Sweep, tolerance: float, decided: bool = False) -> int:
    """Compare all wrenches in the axes of the reference's joints, and the drive efforts.

    Args:
        tolerance: relative to the greatest force and moment.
        decided: compare only components that the laws of motion decide.

    Returns:
        How many components were compared.
    """
    compared, greatest = 0, float(np.max(np.abs(reference.drive_effort)))
    for component, columns in (("force", slice(0, 3)), ("moment", slice(3, 6))):
        values = [getattr(reference[name], component) for name in reference.outputs]
        greatest = max(greatest, float(np.max(np.abs(values))))
        allowed = tolerance * (float(np.max(np.abs(values))) or 1.0)
        for name, expected in zip(reference.outputs, values, strict=True):
            # The frame of the found joint may lie another way in its child.
            in_world = getattr(found.wrench(name, "world"), component)
            value = np.einsum("nji,nj->ni", reference.rotation(name), in_world)
            kept = reference[name].unique[columns] if decided else np.ones(3, dtype=bool)
            np.testing.assert_allclose(
                value[:, kept], expected[:, kept], rtol=0.0, atol=allowed, err_msg=name
            )
            compared += int(np.sum(kept))
    # Where a drive has nothing to do, its effort is the rounding of the wrenches.
    effort = np.abs(found.drive_effort - reference.drive_effort)
    assert np.max(effort) <= tolerance * greatest
    return compared
