"""Advice of errors of mobility is followed word by word for random chains, and has to work."""

from __future__ import annotations

from collections import Counter

import numpy as np
import pytest
from chains import Redraw, random_chain

import cardan_dyn as cd

SEEDS = range(100)
"""Some hundred chains come out of them, about two thirds with too few drives."""


def random_mechanism(seed: int) -> tuple[cd.Mechanism, list[str]] | None:
    """A mechanism and its joints with a single coordinate in random order; None without any."""
    rng = np.random.default_rng(seed)
    try:
        mechanism = cd.load(random_chain(rng).text)
    except Redraw:
        return None
    single = [name for name, joint in mechanism.joints.items() if joint.nv == 1]
    rng.shuffle(single)
    return (mechanism, single) if single else None


def refused(mechanism: cd.Mechanism, drives: list[str], held: dict[str, float]) -> cd.CardanError:
    """Return the error of a scene; it has to be one."""
    try:
        cd.Scene(mechanism, drive=drives, held=held)
    except cd.CardanError as error:
        return error
    raise AssertionError("no error")


def works(mechanism: cd.Mechanism, drives: list[str], held: dict[str, float]) -> bool:
    """Return whether a scene can be made and swept where it starts."""
    sweep = cd.Scene(mechanism, drive=drives, held=held).sweep(np.zeros((1, len(drives))))
    return sweep.loop_residual < 1e-9


def decided(mechanism: cd.Mechanism, drive: str) -> list[str] | None:
    """Return drives that decide the motion, as errors advise; None if they say there are none."""
    try:
        cd.Scene(mechanism, drive=drive)
    except cd.MobilityError as error:
        text = str(error)
        if "check loops and couplings" in text:
            return None
        assert all(name in text for name in error.surplus)
        return [name for name in [drive] if name not in error.surplus] + list(error.advised)
    return [drive]


@pytest.mark.slow
def test_what_is_missing_can_be_driven_and_held() -> None:
    count: Counter[str] = Counter()
    for seed in SEEDS:
        drawn = random_mechanism(seed)
        drives = decided(drawn[0], drawn[1][0]) if drawn else None
        if not drawn or not drives:
            continue
        mechanism, first = drawn[0], drives[0]
        assert works(mechanism, drives, {}), seed
        assert works(mechanism, [first], dict.fromkeys(drives[1:], 0.0)), seed
        count["several" if len(drives) > 1 else "one"] += 1
    assert count["several"] > 25
    assert count["one"] > 10


@pytest.mark.slow
def test_every_joint_of_which_one_is_missing_does() -> None:
    count = 0
    for seed in SEEDS:
        drawn = random_mechanism(seed)
        drives = decided(drawn[0], drawn[1][0]) if drawn else None
        if not drawn or not drives or len(drives) < 2:
            continue
        text = str(refused(drawn[0], drives[:-1], {}))
        listed = text.partition("drive or hold one of: ")[2].partition(";")[0].split(", ")
        for name in listed:
            assert works(drawn[0], [*drives[:-1], name], {}), (seed, name)
            count += 1
    assert count > 40


@pytest.mark.slow
def test_what_is_too_much_can_be_left_out() -> None:
    """One more joint is driven, or held, than the mechanism has motions."""
    count: Counter[str] = Counter()
    for seed in SEEDS:
        drawn = random_mechanism(seed)
        drives = decided(drawn[0], drawn[1][0]) if drawn else None
        if not drawn or not drives:
            continue
        mechanism, single = drawn
        spare = [name for name in single if name not in drives]
        for name in spare[:1]:
            try:
                cd.Scene(mechanism, drive=drives, held={name: 0.0})
            except cd.MobilityError as error:
                for left_out in error.surplus:
                    kept = [drive for drive in drives if drive != left_out]
                    held = {} if left_out == name else {name: 0.0}
                    assert works(mechanism, kept, held), (seed, left_out)
                    count["drive" if left_out in drives else "held"] += 1
            except cd.AssemblyError as error:
                # A loop that is a truss keeps the joint where it is.
                assert f"where {name} cannot move" in str(error)
    assert count["held"] > 12
    assert count["drive"] > 12
