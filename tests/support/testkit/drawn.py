"""What a drawing of the viewer says of its nodes."""

from __future__ import annotations

import numpy as np

from cardan_dyn.practice.viewer.commands import Drawing


def placed(drawing: Drawing, path: str) -> dict[str, np.ndarray]:
    """Return position, quaternion and scale of a node at the first sample."""
    pose = drawing.nodes[path]
    return {name: getattr(pose, name)[0] for name in ("position", "quaternion", "scale")}
