"""Mechanism reports as text and as HTML."""

from __future__ import annotations

from dataclasses import replace

from cardan_dyn.scene.mechanism_report import ComponentReport, LoopReport, MechanismReport

REPORT = MechanismReport(
    name="<b>rig & co</b>",
    notation="URDF+ <loop>",
    coordinates=7,
    rank=6,
    mobility=1,
    length=0.25,
    components=[ComponentReport(("<i>pin", "bolt"), (), 7, 6, 5, False)],
    loops=[
        LoopReport("<i>pin", "continuous", 3, {"a<": "force xyz", "b": "moment x"}),
        LoopReport("bolt", "fixed", 6, {}),
    ],
    idle_rods=[("up", "down")],
    drivable=("bolt.y", "bolt.x", "<i>pin"),
    warnings=("mass < 0",),
)


def test_what_cannot_move_offers_no_drives() -> None:
    assert "can be driven" not in str(replace(REPORT, mobility=0))


def test_texts_of_a_report() -> None:
    assert str(REPORT).splitlines() == [
        "<b>rig & co</b>: mobility 1, 0 without idle rods",
        "  7 joint coordinates, 6 independent closure equations",
        "  loops: URDF+ <loop>; characteristic length 0.25 m",
        "  loop <i>pin (continuous): rank 3 of 6, 3 redundant by itself",
        "  loop bolt (fixed): rank 6 of 6, 0 redundant by itself",
        "  leaves open at a<: force xyz",
        "  leaves open at b: moment x",
        "  can be driven or held: bolt.y, bolt.x, <i>pin",
        "  component <i>pin, bolt: mobility 1 of 7 coordinates, 6 independent equations, "
        "6 self-stresses",
        "  idle rod at up – down: it may spin about its line and needs no drive",
        "  the description's zero is a singular configuration of <i>pin, bolt: "
        "only 5 of 6 equations are independent there",
        "  warning: mass < 0",
    ]


def test_notebooks_show_escaped_texts() -> None:
    assert REPORT._repr_html_() == (
        "<div><p>&lt;b&gt;rig &amp; co&lt;/b&gt;: mobility 1, 0 without idle rods</p>"
        "<ul><li>7 joint coordinates</li><li>6 independent closure equations</li>"
        "<li>loops: URDF+ &lt;loop&gt;</li><li>characteristic length 0.25 m</li></ul>"
        "<table><thead><tr><th>loop</th><th>type</th><th>rank of 6</th><th>redundant</th>"
        "<th>leaves open</th></tr></thead><tbody>"
        "<tr><td>&lt;i&gt;pin</td><td>continuous</td><td>3</td><td>3</td>"
        "<td>a&lt;: force xyz; b: moment x</td></tr>"
        "<tr><td>bolt</td><td>fixed</td><td>6</td><td>0</td><td></td></tr></tbody></table>"
        "<ul><li>can be driven or held: bolt.y, bolt.x, &lt;i&gt;pin</li>"
        "<li>component &lt;i&gt;pin, bolt: mobility 1 of 7 coordinates, 6 independent equations, "
        "6 self-stresses</li>"
        "<li>idle rod at up – down: it may spin about its line and needs no drive</li>"
        "<li>the description&#x27;s zero is a singular configuration of &lt;i&gt;pin, bolt: "
        "only 5 of 6 equations are independent there</li><li>warning: mass &lt; 0</li></ul></div>"
    )
