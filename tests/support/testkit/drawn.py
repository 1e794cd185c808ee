"""What a drawing of the viewer says of its nodes."""

from __future__ import annotations

import numpy as np

from cardan_dyn.viewer.commands import Drawing


def placed(drawing: Drawing, path: str) -> dict[str, np.ndarray]:
    """Return position, quaternion and scale of a node at the first sample."""
    return {
        item["property"]: np.array(item["value"])
        for item in drawing.commands
        if item["type"] == "set_property" and item["path"] == path
    }
