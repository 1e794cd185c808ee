"""What a drawing of the viewer says of its nodes."""

from __future__ import annotations

import numpy as np

from cardan_dyn.practice.viewer.commands import Drawing


def placed(drawing: Drawing, path: str) -> dict[str, np.ndarray]:
    """Return position, quaternion and scale of a node at the first sample."""
    pose = drawing.nodes[path]
    scale = np.broadcast_to(pose.scale[0], 3)
    return {"position": pose.position[0], "quaternion": pose.quaternion[0], "scale": scale}
