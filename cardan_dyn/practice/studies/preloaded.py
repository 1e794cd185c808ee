"""Preloaded: what a local worker of Dask does before it computes.

Ctrl-C reaches every process of a terminal. The client then ends its workers itself.
"""

from __future__ import annotations

import signal


def dask_setup(worker: object) -> None:
    """Leave Ctrl-C to the client.

    Args:
        worker: of Dask, which calls this.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
