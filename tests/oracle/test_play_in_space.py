"""Scans of clearance in pin bearings against a free cross between two forks in space.

The cross is a disc of 0.5 kg, the shafts meet at 20° and shaft 1 turns at 150 rad/s, shaft 2 drives
a flywheel. A bearing without clearance is a spring in the simulation, in series with the others.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest
from testkit.cross_in_space import NAMES, CrossInSpace, Run
from testkit.pin_rigs import THETA, rig, scene

from cardan_dyn import clearance
from cardan_dyn.analytic import single_joint
from cardan_dyn.clearance import JointScan, scan
from cardan_dyn.motion.clearance.opened_scene import OpenPin, opened

BETA, SPEED, RADIUS, STIFFNESS, TIGHT = np.radians(20.0), 150.0, 0.05, 1e8, 1.5e8
MASS, DISC, COMPACT = 0.5, (1.5e-4, 1.5e-4, 3e-4), (3e-4, 3e-4, 3e-4)
RATIO = 0.2
START, END = 1.15, 1.82
"""Where runs begin, the joint pressed one way, and end, after the reversal at φ = π/2."""


def moment(phi: float) -> float:
    """What the cross passes on without play [N m]."""
    torque = THETA * SPEED**2 * single_joint.acceleration_ratio(BETA, phi)
    return float(torque / np.sqrt(1.0 - (np.sin(BETA) * np.cos(phi)) ** 2))


@lru_cache(maxsize=8)
def both(
    pins: tuple[str, ...],
    gap: float,
    inertia: tuple[float, float, float] = DISC,
    ratio: float = RATIO,
) -> tuple[JointScan, CrossInSpace, Run]:
    """A scan and a simulation of the same joint."""
    # Springs and dampers of one relaxation time, one behind the other, are one such pair.
    series = 1.0 + (STIFFNESS / TIGHT if len(pins) == 1 else 0.0)
    found = scan(
        scene(rig(MASS, inertia), BETA),
        SPEED,
        joints="cross",
        bearings=pins,
        radius=RADIUS,
        clearance=gap,
        stiffness=STIFFNESS / series,
        damping_ratio=ratio / np.sqrt(series),
    )["cross"]
    clearances = tuple(0.5 * gap if name in found.bearings else 0.0 for name in NAMES)
    damping = 2.0 * ratio * np.sqrt(STIFFNESS * found.mean_mass)
    first, second, third, fourth = clearances
    model = CrossInSpace(
        beta=BETA,
        speed=SPEED,
        inertia=THETA,
        mass=MASS,
        cross_inertia=inertia,
        radius=RADIUS,
        half_clearance=(first, second, third, fourth),
        stiffness=STIFFNESS,
        damping=damping,
        tight=TIGHT,
    )
    return found, model, model.run(START, moment, END)


def peaks(found: JointScan, run: Run) -> np.ndarray:
    """Greatest forces of the open bearings in the first swing after the reversal."""
    item = found.reversals[1]
    last = item.contact_time + 3.2 * np.sqrt(item.reduced_mass / STIFFNESS)
    after = run.time - item.position / SPEED
    chosen = (after > 0.5 * item.contact_time) & (after < last)
    opened = [NAMES.index(name) for name in found.bearings]
    return np.asarray(np.linalg.norm(run.forces, axis=2)[chosen][:, opened].max(axis=0))


@pytest.mark.slow
@pytest.mark.parametrize("pin", ["pin_in", "pin_out"])
def test_one_pin(pin: str) -> None:
    found, _, run = both((pin,), 1e-5)
    item = found.reversals[1]
    assert not item.doubts
    assert found.doubts  # There is no interval: bearings of a cross are not followed.
    # The ramp bends a little over the flight, so that what is expected is too high.
    np.testing.assert_allclose(peaks(found, run), item.two_mass_peak, rtol=8e-3)
    assert np.all(peaks(found, run) < item.two_mass_peak)
    assert run.touches > 0


@pytest.mark.slow
def test_both_pins_with_a_light_cross() -> None:
    found, _, run = both(("pin_in", "pin_out"), 4e-6)
    item = found.reversals[1]
    assert not item.doubts
    assert found.doubts  # There is no interval: bearings of a cross are not followed.
    expected = item.two_mass_peak * np.array(item.share)
    np.testing.assert_allclose(peaks(found, run), expected, rtol=4e-3)


@pytest.mark.slow
def test_the_flight_takes_as_long_as_expected() -> None:
    """A bearing lets go where the force vanishes, and strikes after t₁ with v₁."""
    found, model, run = both(("pin_in",), 1e-5)
    item = found.reversals[1]
    force = np.linalg.norm(run.forces[:, 0], axis=1)
    flying = run.time[(force == 0.0) & (run.time > 1.5 / SPEED)]
    assert flying[0] == pytest.approx(item.position / SPEED, abs=0.01 * item.contact_time)
    assert flying[-1] - flying[0] == pytest.approx(item.contact_time, rel=0.01)
    index = int(np.searchsorted(run.time, flying[-1]))
    _, rates, *_ = model.bearings(run.time[index], run.states[index])
    assert np.linalg.norm(rates[0]) == pytest.approx(item.impact_speed, rel=0.02)


@pytest.mark.slow
def test_a_compact_cross_is_doubted_for_a_reason() -> None:
    """Its own inertia pulls its ends out of the moment's plane, or keeps them on the wall."""
    for pin, doubt, least in (("pin_in", "beside the force", 0.03), ("pin_out", "turns thr", 0.2)):
        found, _, run = both((pin,), 4e-6, COMPACT)
        item = found.reversals[1]
        assert any(doubt in text for text in item.doubts)
        assert abs(item.two_mass_peak / np.max(peaks(found, run)) - 1.0) > least


@pytest.mark.campaign
@pytest.mark.slow
def test_the_package_simulates_the_same() -> None:
    """Both pins open, from the middle of the play: two impacts, by equations of other form."""
    damping, gap, start, turns = 8e3, 1e-5, 0.8, 0.175
    law = clearance.LinearContact(STIFFNESS, damping)
    reach = {"pin_in": RADIUS, "pin_out": RADIUS}
    still = scene(rig(MASS, DISC), BETA)
    loose = opened(still, [OpenPin(pin, gap, law, 0.0, 0.0, r) for pin, r in reach.items()])
    duration, free = turns * 2.0 * np.pi / SPEED, dict.fromkeys(loose.scene.free, 0.0)
    trajectory = loose.scene.simulate(
        duration, position={loose.drive: start, **free}, speed=free, motion={loose.drive: SPEED},
        rtol=1e-10,
    )  # fmt: skip
    found = clearance.ContactSimulation(trajectory, loose.contacts, loose.drive, SPEED)
    half = 0.5 * gap
    model = CrossInSpace(
        BETA,
        SPEED,
        THETA,
        MASS,
        DISC,
        RADIUS,
        half_clearance=(half, half, half, half),
        stiffness=STIFFNESS,
        damping=damping,
        tight=TIGHT,
    )
    step = 1e-6
    run = model.run(start, lambda _: 0.0, start + turns * 2.0 * np.pi, step=step, rtol=1e-10)
    sizes = np.linalg.norm(run.forces, axis=2)
    for column, name in enumerate(NAMES):
        impacts = [item for item in found.impacts if item.bearing == name]
        assert len(impacts) == 2
        for item in impacts:
            near = np.abs(run.time - start / SPEED - item.peak_time) < 20.0 * step
            assert np.max(sizes[near, column]) == pytest.approx(item.peak, rel=1e-5)
            before = run.time - start / SPEED < item.start - 2.0 * step
            after = run.time - start / SPEED > item.start + 2.0 * step
            assert sizes[before, column][-1] == 0.0 < sizes[after, column][0]


@pytest.mark.slow
@pytest.mark.parametrize("pin", ["pin_in", "pin_out"])
def test_the_package_simulates_what_it_expects(pin: str) -> None:
    """Theory beside the package's own simulation, in which the other pin is rigid."""
    still = scene(rig(MASS, DISC), BETA)
    scanned = scan(
        still,
        SPEED,
        joints="cross",
        bearings=pin,
        radius=RADIUS,
        clearance=1e-5,
        stiffness=STIFFNESS,
        damping_ratio=RATIO,
    )["cross"]
    item = scanned.reversals[1]
    law = clearance.LinearContact.of_ratio(STIFFNESS, RATIO, scanned.mean_mass)
    given = {"joints": pin, "clearance": 1e-5, "law": law, "radius": {pin: RADIUS}}
    found = clearance.simulate(still, SPEED, turns=0.165, position=0.8, rtol=1e-7, **given)
    struck = [impact for impact in found.impacts if impact.position > item.position]
    assert {impact.bearing for impact in struck} == set(scanned.bearings)
    for impact in struck:
        assert impact.peak == pytest.approx(item.two_mass_peak, rel=8e-3)
        assert impact.speed == pytest.approx(item.impact_speed, rel=1e-2)


@pytest.mark.slow
def test_the_simulation_keeps_energy() -> None:
    """Kinetic energy and that of the springs change by the work of fork 1 alone."""
    _, model, run = both(("pin_in",), 1e-5, ratio=0.0)
    energy, power = np.array(
        [balance(model, *state) for state in zip(run.time, run.states, run.forces, strict=True)]
    ).T
    steps = np.diff(run.time)
    work = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * steps)])
    exchanged = np.max(work) - np.min(work)
    assert np.max(np.abs(energy - energy[0] - work)) < 1e-4 * exchanged


def balance(
    model: CrossInSpace, time: float, y: np.ndarray, forces: np.ndarray
) -> tuple[float, float]:
    """Energy, and power of the drive."""
    ways, _, arms, pins, _, _ = model.bearings(time, y)
    kinetic = 0.5 * model.mass * y[7:10] @ y[7:10] + 0.5 * model.inertia * y[14] ** 2
    kinetic += 0.5 * float(np.array(model.cross_inertia) @ y[10:13] ** 2)
    has_play = np.array(model.half_clearance) > 0.0
    depth = np.maximum(np.linalg.norm(ways, axis=1) - np.array(model.half_clearance), 0.0)
    stiffness = np.where(has_play, model.stiffness, model.tight)
    elastic = 0.5 * float(stiffness @ depth**2) + 0.5 * model.tight * float(
        np.sum((pins @ y[:3]) ** 2)
    )
    torque = -np.cross(y[:3] + arms[:2], forces[:2]).sum(axis=0)[0]
    return float(kinetic + elastic), float(-torque * model.speed)
