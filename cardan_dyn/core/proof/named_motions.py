"""Named motions: which elementary motion the name of a joint or of a coordinate means."""

from __future__ import annotations

from ..mechanism.frames import ElementaryMotion, Frames


def named_motions(frames: Frames) -> dict[str, ElementaryMotion]:
    """Return the turns and slides by name: of a joint that has several, `joint.coordinate`.

    What is called like a coordinate of another joint is that joint.
    """
    motions_of: dict[str, list[ElementaryMotion]] = {joint: [] for joint in frames.joints}
    for motion in frames.motions:
        motions_of[frames.joints[motion.joint]].append(motion)
    result = {}
    for joint, motions in motions_of.items():
        for motion in motions:
            is_alone = len(motions) == 1
            name = joint if is_alone else f"{joint}.{_coordinate(motion, motions)}"
            if motion.kind != "ball" and (is_alone or name not in motions_of):
                result[name] = motion
    return result


def _coordinate(motion: ElementaryMotion, motions: list[ElementaryMotion]) -> str:
    """Return how a motion of a joint is called.

    Two motions of a kind are counted from the parent outwards. Three have the axes of the frame,
    and their letters; turns are told apart from slides where both are. A pin with clearance in
    two bearings has two slides, two tilts and its turn.
    """
    is_loose = [item.kind for item in motions] == ["slide", "slide", "turn", "turn", "turn"]
    if is_loose and motion.kind == "turn":
        names = ("tilt_1", "tilt_2", "turn")
        return next(name for name, item in zip(names, motions[2:], strict=True) if item is motion)
    alike = [item for item in motions if item.kind == motion.kind]
    if len(alike) == 1:
        return motion.kind
    if len(alike) == 2:
        return f"{motion.kind}_{1 if motion is alike[0] else 2}"
    letter = "xyz"[motion.axis.tolist().index(1.0)]
    return letter if motions[0].kind == motion.kind else f"{motion.kind}_{letter}"
