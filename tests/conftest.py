from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import cardan_dyn as cd

SOURCES = Path(cd.__file__).parent / "compiled"
POSITIONS = np.linspace(0.0, 2.0 * np.pi, 721)
# Exactly representable main positions, beside those that linspace rounds.
POSITIONS[[0, 180, 360, 540, 720]] = [0.0, 0.5 * np.pi, np.pi, 1.5 * np.pi, 2.0 * np.pi]
POSITIONS.setflags(write=False)


def pytest_sessionstart() -> None:
    """Refuse to test compiled functions that were made of other sources."""
    built = [path.stat().st_mtime for path in SOURCES.glob("*.so")]
    written = [path.stat().st_mtime for path in SOURCES.glob("*.[ch]")]
    if built and min(built) < max(written, default=0.0):
        pytest.exit("compile again what changed in cardan_dyn/compiled: python hatch_build.py")


@pytest.fixture(scope="session")
def joint() -> cd.Mechanism:
    return cd.load("universal_joint")


@pytest.fixture(scope="session")
def shaft() -> cd.Mechanism:
    return cd.load("double_shaft_z")


@pytest.fixture(scope="session")
def positions() -> np.ndarray:
    return POSITIONS
