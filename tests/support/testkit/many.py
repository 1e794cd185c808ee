"""Several copies of a mechanism in one description."""

from __future__ import annotations

import xml.etree.ElementTree as ET


def in_one(text: str, count: int, base: str = "ground") -> str:
    """Copies of a URDF side by side on one base, their names numbered."""
    root = ET.Element("robot", name="many")
    ET.SubElement(root, "link", name=base)
    for index in range(count):
        for item in ET.fromstring(text):
            if item.get("name") == base:
                continue
            for part in item.iter():
                for key in ("name", "link"):
                    if part.get(key) not in (None, base):
                        part.set(key, f"{part.get(key)}_{index}")
            root.append(item)
    return ET.tostring(root, encoding="unicode")
