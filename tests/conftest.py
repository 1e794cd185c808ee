from __future__ import annotations

import gc
import sys
import warnings
from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import numpy as np
import pytest

import cardan_dyn as cd

POSITIONS = np.linspace(0.0, 2.0 * np.pi, 721)
# Exactly representable main positions, beside those that linspace rounds.
POSITIONS[[0, 180, 360, 540, 720]] = [0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi, 2.0 * np.pi]
POSITIONS.setflags(write=False)


def pytest_sessionstart() -> None:
    """Refuse to test compiled functions that were made of other sources."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        from cardan_dyn.core import compiled  # noqa: F401
    for warning in caught:
        pytest.exit(str(warning.message))


def pytest_collection_finish() -> None:
    """Spare the garbage collector some ten thousand tests, which stay to the end.

    Where inertias are very different, MuJoCo's dynamics write a log into the folder of the caller
    unless somebody hears the warning.
    """
    gc.freeze()
    if "mujoco" in sys.modules:
        sys.modules["mujoco"].set_mju_user_warning(lambda _: None)


@pytest.fixture(scope="module")
def loaded_once() -> Iterator[None]:
    """Let `cd.load` return the same mechanism for the same text or name, for the tests of a file.

    Mechanisms are immutable, and results do not depend on what is known of one: tapes that a test
    has traced serve the next ones, where tracing would take most of their time.
    """
    load = cd.load
    known = lru_cache(maxsize=64)(load)

    def loaded(source: Any, **options: Any) -> cd.Mechanism:
        is_text = isinstance(source, str) and source.lstrip().startswith("<")
        if options or not (is_text or source in cd.bundled_names()):
            return load(source, **options)
        return known(source)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cd, "load", loaded)
        yield


@pytest.fixture(scope="session")
def joint() -> cd.Mechanism:
    return cd.load("universal_joint")


@pytest.fixture(scope="session")
def shaft() -> cd.Mechanism:
    return cd.load("double_shaft_z")


@pytest.fixture(scope="session")
def positions() -> np.ndarray:
    return POSITIONS
