"""The free bodies prove themselves: differences of positions, power, and errors put in on purpose.

Were they wrong, a comparison with them would say nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from types import SimpleNamespace

import hand_written
import numpy as np
import pytest
from compare import differences
from free_bodies import Oracle, Position
from scenes import Case, draw, followed, solved

pytestmark = pytest.mark.slow

SEEDS = range(40)


@pytest.fixture(scope="module")
def cases() -> list[tuple[Case, Oracle, list[Position]]]:
    drawn = []
    for seed in SEEDS:
        case = draw(seed)
        oracle = Oracle(case.chain)
        drawn.append((case, oracle, followed(case, oracle)))
    return drawn


def moved(case: Case, oracle: Oracle, x: Position, shift: np.ndarray) -> Position:
    targets = dict(zip(case.drives, shift, strict=True))
    targets = {name: x[name][0] + step for name, step in targets.items()}
    return oracle.close(x, targets, case.prescribed, case.chain.size)[0]


def test_rates_are_those_of_the_positions(
    cases: list[tuple[Case, Oracle, list[Position]]],
) -> None:
    """Links of the closed chain, moved along the drives, against twists and accelerations."""
    for case, oracle, positions in cases:
        x, speed, acceleration = positions[-1], case.speeds[-1], case.accelerations[-1]
        geometry = oracle.geometry(x)
        rates = [dict(zip(case.drives, rate, strict=True)) for rate in (speed, acceleration)]
        v, a = oracle.rates(geometry, *rates, case.prescribed, case.chain.size)
        twist, bias = oracle.twists(geometry, v)
        step = 1e-4
        near = [
            oracle.geometry(moved(case, oracle, x, t * speed + 0.5 * t * t * acceleration)).links
            for t in (-step, step)
        ]
        for link, placement in geometry.links.items():
            before, after = (links[link] for links in near)
            change = bias[link] + geometry.columns[:, oracle.above[link]] @ a[oracle.above[link]]
            point, spin = placement[:3, 3], twist[link][3:]
            velocity = twist[link][:3] + np.cross(spin, point)
            difference = (after[:3, 3] - before[:3, 3]) / (2.0 * step)
            scale = case.chain.size * (1.0 + np.max(np.abs(v)) + np.max(np.abs(v)) ** 2)
            assert np.max(np.abs(difference - velocity)) < 1e-4 * scale, case.features
            difference = (after[:3, 3] - 2.0 * point + before[:3, 3]) / step**2
            expected = change[:3] + np.cross(change[3:], point) + np.cross(spin, velocity)
            assert np.max(np.abs(difference - expected)) < 1e-2 * scale, case.features
            turned = (after[:3, :3] - before[:3, :3]) / (2.0 * step) @ placement[:3, :3].T
            assert turned[2, 1] - turned[1, 2] == pytest.approx(2.0 * spin[0], abs=1e-3)


def test_bodies_are_balanced_and_no_power_is_lost(
    cases: list[tuple[Case, Oracle, list[Position]]],
) -> None:
    """Efforts of the drives by virtual power, in which no wrench of any joint occurs."""
    for case, oracle, positions in cases:
        for sample, x in enumerate(positions):
            statics = solved(case, oracle, x, sample, case.chain.size)
            assert statics.residual < 1e-11, case.features
            geometry = oracle.geometry(x)
            rates = [
                dict(zip(case.drives, rate[sample], strict=True))
                for rate in (case.speeds, case.accelerations)
            ]
            v, a = oracle.rates(geometry, *rates, case.prescribed, case.chain.size)
            for name in case.drives:
                unit = case.chain.size if oracle.slides[oracle.rate_columns([name])[0]] else 1.0
                virtual, _ = oracle.rates(
                    geometry, {name: unit}, {}, case.prescribed, case.chain.size
                )
                left = (
                    oracle.power(geometry, v, a, virtual, case.acting) + unit * statics.effort[name]
                )
                fastest = np.max(np.abs(np.where(oracle.slides, virtual / unit, virtual)))
                assert abs(left) < 1e-10 * statics.scale * (1.0 + fastest), case.features


def test_closed_forms() -> None:
    """Shares and weights that need no equation."""
    case = hand_written.shared_support("continuous")
    oracle = Oracle(case.chain)
    statics = solved(case, oracle, followed(case, oracle)[1], 1, 0.7)
    for name in ("first", "second"):
        np.testing.assert_allclose(statics.wrench[name], [0, 0, 9.8, 0, 0, 0], atol=1e-14)
    case = hand_written.hung_from_the_world()
    oracle = Oracle(case.chain)
    statics = solved(case, oracle, followed(case, oracle)[0], 0, 2.0)
    np.testing.assert_allclose(statics.wrench["free"], 0.0, atol=1e-13)
    np.testing.assert_allclose(statics.wrench["weld"], [0, 0, -100, 0, 108, 0], atol=1e-12)


@dataclass
class Answer:
    """What a sweep would be if the free bodies were the package."""

    mechanism: SimpleNamespace
    condition: np.ndarray
    motion: SimpleNamespace
    joints: dict[str, SimpleNamespace]
    drive_effort: np.ndarray
    holding_effort: dict[str, np.ndarray] = field(default_factory=dict)

    def __getitem__(self, joint: str) -> SimpleNamespace:
        return self.joints[joint]


def answer_to(case: Case, oracle: Oracle, positions: list[Position]) -> Answer:
    size = case.chain.size
    statics = [solved(case, oracle, x, sample, size) for sample, x in enumerate(positions)]
    rates = [
        oracle.rates(
            oracle.geometry(x),
            dict(zip(case.drives, case.speeds[sample], strict=True)),
            dict(zip(case.drives, case.accelerations[sample], strict=True)),
            case.prescribed,
            size,
        )
        for sample, x in enumerate(positions)
    ]

    def column(values: list[np.ndarray]) -> np.ndarray:
        stacked = np.stack(values)
        return stacked[:, 0] if stacked.shape[1] == 1 else stacked

    def table(order: int) -> dict[str, np.ndarray]:
        return {
            name: column([rate[order][span] for rate in rates])
            for name, span in oracle.columns.items()
            if span.stop > span.start
        }

    where = {name: column([x[name] for x in positions]) for name in table(0)}
    velocity, acceleration = table(0), table(1)
    return Answer(
        SimpleNamespace(characteristic_length=size),
        np.ones(len(positions)),
        SimpleNamespace(
            position=where.__getitem__,
            velocity=velocity.__getitem__,
            acceleration=acceleration.__getitem__,
            tables=(where, velocity, acceleration),
        ),
        {
            joint.name: SimpleNamespace(
                force=np.stack([item.wrench[joint.name][:3] for item in statics]),
                moment=np.stack([item.wrench[joint.name][3:] for item in statics]),
                unique=np.max([item.influence[joint.name] for item in statics], axis=0) < 1e-7,
            )
            for joint in oracle.wrenched
        },
        np.array([[item.effort[name] for name in case.drives] for item in statics]),
        {name: np.array([item.effort[name] for item in statics]) for name in case.held},
    )


def shifted_wrench(answer: Answer, joint: str) -> None:
    scale = max(np.linalg.norm(part.force[-1]) for part in answer.joints.values())
    answer.joints[joint].force[-1, 1] += 1e-6 * scale


def shifted_moment(answer: Answer, joint: str) -> None:
    scale = max(np.linalg.norm(part.moment[-1]) for part in answer.joints.values())
    answer.joints[joint].moment[0, 2] += 1e-6 * scale


def flipped_flag(answer: Answer, joint: str) -> None:
    answer.joints[joint].unique[3] ^= True


def shifted_effort(answer: Answer, joint: str) -> None:
    answer.drive_effort[0, 0] += 1e-6 * (1.0 + abs(answer.drive_effort[0, 0]))


def shifted_position(answer: Answer, joint: str) -> None:
    answer.motion.tables[0]["a"][1] += 1e-6


def shifted_velocity(answer: Answer, joint: str) -> None:
    answer.motion.tables[1]["b"][1] *= 1.0 + 1e-6


def shifted_acceleration(answer: Answer, joint: str) -> None:
    answer.motion.tables[2]["c"][1] *= 1.0 + 1e-6


@pytest.mark.parametrize("joint", ["swivel", "a", "b", "c", "d"])
@pytest.mark.parametrize(
    "fault",
    [
        *(shifted_wrench, shifted_moment, flipped_flag, shifted_effort),
        *(shifted_position, shifted_velocity, shifted_acceleration),
    ],
)
def test_a_small_fault_is_noticed(fault: Callable[[Answer, str], None], joint: str) -> None:
    case = hand_written.swivelled_four_bar([0.0, 0.3, 1.0])
    oracle = Oracle(case.chain)
    answer = answer_to(case, oracle, followed(case, oracle))
    assert not differences(case, answer)
    fault(answer, joint)
    assert differences(case, answer)


def test_what_the_free_bodies_say_agrees_with_itself(
    cases: list[tuple[Case, Oracle, list[Position]]],
) -> None:
    for case, oracle, positions in cases:
        differing = differences(case, answer_to(case, oracle, positions))
        assert not differing, f"{sorted(case.features)}: {differing}"


def test_cases_have_everything(cases: list[tuple[Case, Oracle, list[Position]]]) -> None:
    """A generator that stopped drawing something would go unnoticed."""
    seen = frozenset().union(*(case.features for case, _, _ in cases))
    tree = ("revolute", "continuous", "prismatic", "planar", "floating")
    loops = (*tree[:4], "fixed", "spherical", "universal", "cylindrical")
    expected = {*(f"tree {kind}" for kind in tree), *(f"loop {kind}" for kind in loops)}
    expected |= {"moving base", "coupling", "compliance", "held", "held twice", "scaled"}
    expected |= {"several drives", "successor world", "fixed loop to world", "quasi-static"}
    assert not expected - seen
