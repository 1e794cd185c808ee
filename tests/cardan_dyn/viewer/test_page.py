"""The page: what stands in it, and the server that hands it out once."""

from __future__ import annotations

import base64
import json
import re
import urllib.error
import urllib.request

import numpy as np
import pytest

pytest.importorskip("meshcat", reason="the viewer needs meshcat")
pytest.importorskip("jinja2", reason="the page needs Jinja")

from cardan_dyn.practice.viewer.commands import Arrays, Color, Drawing, Pose
from cardan_dyn.practice.viewer.scenery import Scale, Scenery
from cardan_dyn.practice.viewer.viewing import Server, render


def scenery(label: str) -> Scenery:
    drawing = Drawing(1.0)
    drawing.label("/labels/a", label, Color.of("#000000"), Pose(np.zeros(3)))
    triangle = np.eye(3), np.array([[0, 1, 2]])
    drawing.add("/axes/a", triangle, Color.of("#abcdef"), means="a meaning")
    points = np.array([[0.123456789, 0.0, 1.0]])
    scale = Scale("moment", "N·m", 20.0, None)
    return Scenery(drawing, (scale,), points)


def test_page_contains_its_scene() -> None:
    page = render(scenery("name"), "A & B", {}, Arrays())
    assert "<title>A &amp; B</title>" in page
    assert "#abcdef" in page and "a meaning" in page and '"per_metre": 20.0' in page
    data, arrays = (
        re.search(f'id="{name}">(.*?)</script>', page).group(1) for name in ("data", "arrays")
    )
    start, count, kind = json.loads(data)["points"]
    points = np.frombuffer(base64.b64decode(arrays), kind, count, start)
    assert points.tolist() == np.float32([0.123456789, 0.0, 1.0]).tolist()


def test_a_name_cannot_end_the_script() -> None:
    name = "</script><b>x"
    page = render(scenery(name), "title", {}, Arrays())
    assert name not in page
    (data,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', page)
    assert json.loads(data)["scene"]["labels"][0]["text"] == name


def test_server_serves_its_page_alone() -> None:
    server = Server("<p>ü</p>")
    try:
        assert not server.wait(0.0)
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(server.url + "other", timeout=10)
        assert not server.wait(0.0)
        with urllib.request.urlopen(server.url + "?again", timeout=10) as answer:
            assert answer.read().decode("utf-8") == "<p>ü</p>"
        assert server.wait(10.0)
    finally:
        server.close()
    server.join()
    with pytest.raises(urllib.error.URLError):
        urllib.request.urlopen(server.url, timeout=2)
