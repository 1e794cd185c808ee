from __future__ import annotations

import gc
import warnings

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
        from cardan_dyn import compiled  # noqa: F401
    for warning in caught:
        pytest.exit(str(warning.message))


def pytest_collection_finish() -> None:
    """Spare the garbage collector some ten thousand tests, which stay to the end."""
    gc.freeze()


@pytest.fixture(scope="session")
def joint() -> cd.Mechanism:
    return cd.load("universal_joint")


@pytest.fixture(scope="session")
def shaft() -> cd.Mechanism:
    return cd.load("double_shaft_z")


@pytest.fixture(scope="session")
def positions() -> np.ndarray:
    return POSITIONS
