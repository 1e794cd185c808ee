"""Viewer: a sweep as a moving scene with its moments, in a browser or as one HTML file.

Needs the extra `viz` (meshcat, whose three.js draws it, and Jinja).
"""

from __future__ import annotations

import html
import json
import os
import sys
import threading
import webbrowser
from collections.abc import Mapping, Sequence
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...core.elements.element import Element
from ...core.mechanism.configuration import Configuration
from ...core.results.point_motion import motions_of
from ...core.results.sweep import Sweep
from ...figures.style import refuse_grid
from ...kit.checks import described, file_path, mapping, names, positive, whole, writing
from ...kit.errors import ArgumentError, MissingExtraError
from ...motion.simulation.equilibrium import Equilibrium
from ...motion.simulation.trajectory import Trajectory
from .commands import Arrays, meshcat
from .readings import course, readings
from .scenery import Parts, Scenery, build
from .still import Still

if TYPE_CHECKING:
    from ...core.results.point_motion import Points

HOST = "127.0.0.1"


def view(
    sweep: Sweep | Trajectory | Equilibrium | Configuration,
    *,
    joints: Sequence[str] | None = None,
    visuals: bool = True,
    moments: bool = True,
    forces: bool = True,
    axes: bool = True,
    traces: bool = True,
    labels: bool = True,
    elements: bool | Sequence[Element] = True,
    swings: Sequence[str] = (),
    points: Points = (),
    duration: float | None = None,
    frames: int = 1440,
    title: str | None = None,
    units: Mapping[str, tuple[str, float]] | None = None,
) -> View:
    """Draw a sweep as a scene that moves, or a configuration as one that does not.

    Moments are split into torsion (along the joint axis) and bending (across it); where a shaft
    turns in a bearing that stands still, its whole moment 𝔐 draws a trace in the axes that turn
    with the shaft (Grossmann 1939). Every arrow shows what the parent exerts on the child.

    Args:
        sweep: over one dimension, of any number of samples; a trajectory, which is shown at
            equidistant times; an equilibrium; or a configuration, which has no wrenches to be
            drawn.
        joints: whose arrows, axes and names are drawn; all outputs of the sweep if not given.
        visuals: draw the shapes that the description gives its links; those without one, or all of
            them without this, are made up from their joints.
        moments: draw torsion and bending.
        forces: draw forces.
        axes: draw the joint axes, those of loops marked.
        traces: draw the moments of the shafts and the curves they trace.
        labels: draw the joint names.
        elements: draw the force elements of the scene: springs and dampers, bushings, brakes for
            dry friction, and actuators by arrows as great as their efforts. Of a configuration,
            which has none, those that are listed here.
        swings: coordinates that swing as in a mode, whose size is chosen to be seen, as in
            `mode_sweep`; the page says so, and draws no drive there.
        points: whose paths are drawn, with the points on them: names of links or frames, or names
            to `(link, xyz)`, as in `Sweep.to_dataframe`; those that a task leads are drawn besides.
        duration: time in which the sweep is shown once [s]; if not given, its own where it has one
            that can be followed (2 to 60 s), else 8 s. The page can change it.
        frames: greatest number of samples that are shown, chosen evenly.
        title: of the page; the mechanism's name if not given.
        units: in which the page tells quantities instead: units of results, such as N·m, to others
            and their factors, `{"m": ("in", 1.0 / 0.0254)}`.

    Returns:
        A view: `.open()` shows it in a browser, `.export(path)` writes it as one HTML file; as
        the last value of a notebook's cell it is shown there.

    Raises:
        MissingExtraError: meshcat is not installed; the message names the install command.
        ModelError: a joint is unknown or not among the outputs.
        ArgumentError: the sweep has no or several dimensions, a number is out of range, units are
            no units with their factors, or listed elements do not fit the configuration.
    """
    meshcat()  # Reports a missing extra before anything is computed.
    if duration is not None:
        duration = positive("duration", duration)
    frames = whole("frames", frames)
    shot = _shot(sweep, frames, elements)
    shown = shot.outputs if joints is None else names("joints", joints)
    for name in shown:
        shot[name]  # Raises an error if it is unknown.
    count = min(len(shot), frames)
    samples = np.unique(np.linspace(0, len(shot) - 1, count).round().astype(int))
    swings = names("swings", swings)
    if points and isinstance(shot, Still):
        raise ArgumentError("a configuration does not move, and points of it leave no paths")
    loads = moments or forces
    parts = Parts(visuals, moments, forces, axes, traces, labels, elements is not False, loads)
    paths = {
        name: point.position
        for named in (getattr(sweep, "led_points", {}), points)
        for name, point in motions_of(shot, named).items()
    }
    scenery, arrays = build(shot, shown, parts, samples, frozenset(swings), paths), Arrays()
    along = course(shot, samples, timed=isinstance(sweep, Trajectory))
    told = readings(shot, shown, samples, arrays, along, frozenset(swings))
    told["units"] = _checked_units(units)
    own = 0.0 if along.seconds is None else float(along.seconds[-1])
    told["duration"] = duration or (own if 2.0 <= own <= 60.0 else 8.0)
    return View(render(scenery, title or shot.mechanism.name, told, arrays))


def _checked_units(units: object) -> dict[str, tuple[str, float]]:
    found = {}
    for unit, told in mapping("units", units).items():
        if not (isinstance(told, tuple) and len(told) == 2 and isinstance(told[0], str)):
            raise ArgumentError(
                f"units[{unit!r}] is {described(told)}, expected another unit and its factor: "
                '("in", 1.0 / 0.0254)'
            )
        found[unit] = told[0], positive(f"the factor of units[{unit!r}]", told[1])
    return found


def _shot(
    sweep: Sweep | Trajectory | Equilibrium | Configuration,
    frames: int,
    elements: bool | Sequence[Element],
) -> Sweep | Still:
    """Return what is drawn: of a trajectory, the sweep along it at equidistant times."""
    if isinstance(sweep, Configuration):
        return Still(sweep, () if isinstance(elements, bool) else elements)
    if not isinstance(elements, bool):
        raise ArgumentError(
            f"elements is {described(elements)}; only a configuration takes a list, others have "
            "the elements of their scene: give True or False"
        )
    if isinstance(sweep, Trajectory):
        return sweep.evenly(frames).sweep
    shot = sweep.sweep if isinstance(sweep, Equilibrium) else sweep
    if not isinstance(shot, Sweep):
        raise ArgumentError(
            f"view() takes the result of a sweep or a configuration, not {type(shot).__name__}"
        )
    refuse_grid(shot)
    return shot


class View:
    """A scene that can be shown.

    Attributes:
        html: the page, complete: no other file and no network is needed.
    """

    def __init__(self, page: str) -> None:
        self.html = page
        self._server: Server | None = None

    @property
    def url(self) -> str:
        """Address at which a browser on this machine finds the page.

        A server on 127.0.0.1 starts when this is first read, and ends with the process.
        """
        return self._started().url

    def _started(self) -> Server:
        if self._server is None:
            self._server = Server(self.html)
        return self._server

    def open(self, timeout: float = 10.0) -> bool:
        """Show the page in a browser, if there is one with a display.

        Args:
            timeout: how long to wait for the browser to fetch the page [s], so that a script may
                end after this.

        Returns:
            Whether a browser has fetched it.
        """
        if not _has_display():
            return False
        try:
            return webbrowser.open(self.url, new=2) and self._started().wait(timeout)
        except webbrowser.Error:
            return False

    def export(self, path: str | os.PathLike[str]) -> Path:
        """Write the page and return its path.

        Raises:
            ArgumentError: no path, or the file cannot be written.
        """
        file = file_path("path", path)
        with writing(file) as part:
            part.write_text(self.html, encoding="utf-8")
        return file

    def serve(self) -> None:
        """Serve the page until `close` is called or the process is interrupted."""
        self._started().join()

    def close(self) -> None:
        """End the server, if there is one."""
        if self._server is not None:
            self._server.close()
            self._server = None

    def embedded(self, height: int = 560, title: str = "Moving scene") -> str:
        """Return an HTML element that contains the page.

        Args:
            height: of the element [px].
            title: of the element, which readers of screens say.
        """
        # With "h" as an entity, a search for links in a document that contains this page finds
        # only those of the document itself.
        page = html.escape(self.html).replace("http", "&#104;ttp")
        return (
            f'<iframe title="{html.escape(title)}" srcdoc="{page}" loading="lazy" '
            f'style="width: 100%; height: {height}px; border: 1px solid #ddd"></iframe>'
        )

    def _repr_html_(self) -> str:
        return self.embedded()

    def __repr__(self) -> str:
        address = "not served yet" if self._server is None else f"at {self._server.url}"
        return f"<View of {len(self.html) / 1e6:.1f} MB, {address}>"


def _has_display() -> bool:
    """Return whether a browser can show a window: a text browser would take over the terminal."""
    if sys.platform in ("win32", "darwin"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def render(scenery: Scenery, title: str, told: dict[str, Any], arrays: Arrays) -> str:
    """Return the page of a scene, three.js included.

    Args:
        scenery: what is drawn.
        title: of the page.
        told: what it tells, see `readings`.
        arrays: of what it tells; those of the scene are added.

    Raises:
        MissingExtraError: meshcat or Jinja is not installed.
    """
    data = {
        "title": title,
        "scene": scenery.drawing.packed(arrays),
        "radius": scenery.drawing.size,
        "legend": [item._asdict() for item in scenery.drawing.legend],
        "scales": [item._asdict() for item in scenery.scales],
        "points": arrays.add(scenery.points),
        "normal": scenery.normal,
        "notes": list(scenery.notes),
        "bearings": list(scenery.bearings),
        "told": told,
    }
    # A "</script>" in a name would end the element that contains the text.
    text = json.dumps(data, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")
    page = templates("viewer").get_template("scene.html")
    return str(page.render(title=title, script=meshcat(), data=text, arrays=arrays.base64()))


def templates(room: str) -> Any:
    """Return the templates of the pages that a room of `practice` writes.

    Raises:
        MissingExtraError: Jinja is not installed.
    """
    try:
        from jinja2 import Environment, PackageLoader
    except ImportError as error:
        raise MissingExtraError('pages need Jinja: pip install "cardan-dyn[viz]"') from error
    return Environment(loader=PackageLoader(f"cardan_dyn.practice.{room}"), autoescape=True)


class Server:
    """Serves one page on this machine, from a thread that ends with its process.

    The page is complete: once a browser has loaded it, it works without the server.

    Args:
        page: HTML text.
    """

    def __init__(self, page: str) -> None:
        content = page.encode("utf-8")
        self._served = served = threading.Event()

        class Handler(BaseHTTPRequestHandler):
            def do_GET(self) -> None:
                if self.path.split("?")[0] != "/":
                    self.send_error(404)
                    return
                self.send_response(200)
                self.send_header("Content-Type", "text/html; charset=utf-8")
                self.send_header("Content-Length", str(len(content)))
                self.send_header("Cache-Control", "no-store")
                self.end_headers()
                self.wfile.write(content)
                served.set()

            def log_message(self, format: str, *arguments: object) -> None:  # noqa: A002
                """Write no log: a library prints nothing."""

        self._server = ThreadingHTTPServer((HOST, 0), Handler)
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://{HOST}:{self._server.server_address[1]}/"

    def wait(self, seconds: float | None = None) -> bool:
        """Wait until the page has been fetched once; return whether it was."""
        return self._served.wait(seconds)

    def join(self) -> None:
        """Wait until the server ends."""
        while self._thread.is_alive():
            # Some systems do not deliver Ctrl-C to a thread that waits without a limit.
            self._thread.join(0.5)

    def close(self) -> None:
        """End the server."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
