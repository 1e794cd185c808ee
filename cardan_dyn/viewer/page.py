"""Page of the viewer: one HTML file that needs no network, and a server for it."""

from __future__ import annotations

import base64
import json
import threading
from functools import cache
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

from ..errors import MissingExtraError
from .commands import meshcat
from .scenery import Scenery

HOST = "127.0.0.1"
_POINT_DECIMALS = 6
"""Decimals of the points that the camera has to see [m]: micrometres, which no screen shows."""
_JOIN_SECONDS = 0.5
"""Time after which waiting for the server starts again. Some systems do not deliver Ctrl-C to a
thread that waits without a limit."""


def render(scenery: Scenery, title: str) -> str:
    """Return the page of a scene, meshcat's viewer included.

    Raises:
        MissingExtraError: meshcat or Jinja is not installed.
    """
    # A "</script>" in a name would end the element that contains the text.
    labels = json.dumps(scenery.drawing.labels, ensure_ascii=False).replace("<", "\\u003c")
    return str(
        _template().render(
            title=title,
            legend=scenery.legend,
            scales=scenery.scales,
            script=meshcat().script,
            commands=[
                base64.b64encode(command).decode("ascii") for command in scenery.drawing.packed()
            ],
            labels=labels,
            points=json.dumps(scenery.points.round(_POINT_DECIMALS).tolist()),
        )
    )


@cache
def _template() -> Any:
    try:
        from jinja2 import Environment, PackageLoader
    except ImportError as error:
        raise MissingExtraError('the viewer needs Jinja: pip install "cardan-dyn[viz]"') from error
    environment = Environment(loader=PackageLoader("cardan_dyn.viewer"), autoescape=True)
    return environment.get_template("scene.html")


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
            self._thread.join(_JOIN_SECONDS)

    def close(self) -> None:
        """End the server."""
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()
