"""Tapes: many samples of every mechanism beside each of them solved alone."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from compare import differences, sweep_of
from scenes import draw
from testkit.alone import without_tapes
from testkit.bundled import EVERY_KIND
from testkit.linkages import coupling, gears

import cardan_dyn as cd
from cardan_dyn.core.dynamics import tape, taped
from cardan_dyn.core.dynamics.inverse_dynamics import InverseDynamics
from cardan_dyn.scene.usual_motion import usual_motion

ROUNDING = 2e-14
"""Relative errors stay below this times the condition, as the guide says of any result."""
GRAVITY = (0.3, -2.0, -9.5)


def alone(swept: Callable[[], cd.Sweep], monkeypatch: pytest.MonkeyPatch) -> cd.Sweep:
    """Return a sweep whose samples are solved one by one."""
    with monkeypatch.context() as patch:
        without_tapes(patch)
        return swept()


@pytest.fixture
def solved_by_tape(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[bool]]:
    """Yield of which blocks tapes solved all samples."""
    answers: list[bool] = []
    found, by_tapes = taped.TapedSolver._found, taped.TapedSolver._by_tapes

    def told(*arguments: Any, **options: Any) -> object:
        *given, close = arguments
        asked: list[object] = []

        def closing(samples: object) -> object:
            asked.append(samples)
            return close(samples)

        result = found(*given, closing, **options)
        if taped.TapedSolver._by_tapes is by_tapes:
            answers.append(not asked)
        return result

    monkeypatch.setattr(taped.TapedSolver, "_found", told)
    yield answers


def assert_same(first: cd.Sweep, second: cd.Sweep) -> None:
    allowed = ROUNDING * np.maximum(first.condition, second.condition)
    np.testing.assert_allclose(first.condition, second.condition, rtol=1e-6)
    for rate in ("q", "v", "a"):
        one, other = (getattr(sweep.motion, rate) for sweep in (first, second))
        size = np.max(np.abs(one), axis=-1) + 1.0
        assert np.all(np.max(np.abs(one - other), axis=-1) <= allowed * size), rate
    size = np.max([wrench.magnitude for wrench in first.values()], axis=(0, 1))
    for name, wrench in first.items():
        for one, other in (
            (wrench.force, second[name].force),
            (wrench.moment, second[name].moment),
        ):
            assert np.all(np.abs(one - other).max(axis=-1) <= allowed * size + 1e-300), name
        assert np.array_equal(wrench.unique, second[name].unique), name
    for residual, one in first.proven.residuals.items():
        other = second.proven.residuals[residual]
        assert np.isnan(one) == np.isnan(other), residual
        assert np.isnan(one) or abs(one - other) <= np.max(allowed), residual
    efforts = [(first.coupling_moment, second.coupling_moment)]
    efforts.append((first.holding_effort, second.holding_effort))
    pairs = [(one[name], other[name]) for one, other in efforts for name in one]
    if first._source.drive_effort() is not None:
        pairs.append((first.drive_effort, second.drive_effort))
    for one, other in pairs:
        scale = np.max(np.abs(one), initial=1e-300) + np.max(size)
        assert np.max(np.abs(one - other), initial=0.0) <= np.max(allowed) * scale


@pytest.mark.parametrize("name", EVERY_KIND)
def test_bundled_mechanisms(
    name: str, monkeypatch: pytest.MonkeyPatch, solved_by_tape: list[bool]
) -> None:
    for speed in (0.0, None):
        usual = usual_motion(cd.load(name), samples=24)
        scene = usual.scene.replace(gravity=GRAVITY)
        arguments = usual.positions, usual.speed if speed is None else speed, 1.0
        assert_same(
            scene.sweep(*arguments),
            alone(lambda: scene.replace().sweep(*arguments), monkeypatch),  # noqa: B023
        )
    assert all(solved_by_tape)
    assert solved_by_tape


@pytest.mark.parametrize("name", EVERY_KIND)
def test_texts_on_arrays_have_the_bits_of_their_programs(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is known to be zero while a text is traced changes no sum."""
    compared: list[int] = []
    run = tape.Tape.run

    def both(self: tape.Tape, rows: tape.Prescribed, x: np.ndarray) -> object:
        inputs = [*(row for part in rows.parts for row in part)]
        assert not any(row.any() for row, acts in zip(inputs, self.acting, strict=True) if not acts)
        equations, program = self.equations, self._program
        columns = [*x[equations.per_sample], *x[equations.uniform, :1]]
        given = dict(zip(program.inputs, [*inputs, *columns], strict=True))
        shaped = {
            key: np.squeeze(value) if np.size(value) == 1 else value for key, value in given.items()
        }
        traced = program.run_on_arrays(shaped, x.shape[1])
        acting = (row if acts else 0.0 for row, acts in zip(inputs, self.acting, strict=True))
        rounding = equations.rounding(dict(enumerate(self._shadows)))
        with np.errstate(all="ignore"):
            told = equations.given(acting, list(x))
            computed = equations.results(told, list(x), self.order, 0.0, rounding)
        for one, other in zip(traced, computed, strict=True):
            np.testing.assert_array_equal(one, np.broadcast_to(other, one.shape))
        compared.append(x.shape[1])
        return run(self, rows, x)

    monkeypatch.setattr(tape.Tape, "run", both)
    usual = usual_motion(cd.load(name), samples=11)
    scene = usual.scene.replace(gravity=GRAVITY)
    scene.sweep(usual.positions, usual.speed, 1.0)
    assert max(compared) == 11


@pytest.mark.slow
def test_samples_solved_alone_have_the_same_bits_in_any_company(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """By tapes that are made for them, and by those that were made for others."""
    rng = np.random.default_rng(1)
    positions = np.column_stack([rng.uniform(-3.0, 3.0, 60), rng.uniform(-1.5, 1.5, 60)])
    parts = [slice(k, k + 7) for k in range(0, 60, 7)]
    without_tapes(monkeypatch)
    four_bar = usual_motion(cd.load("four_bar"), samples=60)
    soft = {name: np.diag([1e-9, 2e-9, 3e-9, 1e-6, 2e-6, 0.0]) for name in four_bar.scene.mechanism}
    for scene, at, speed in (
        (
            cd.Scene(
                cd.load("universal_joint"), drive=["bearing_in", "joint_angle"], gravity=GRAVITY
            ),
            positions,
            [9.0, 2.0],
        ),
        (four_bar.scene.replace(compliance=soft), four_bar.positions, four_bar.speed),
    ):
        first, again = (scene.sweep(at, speed) for _ in range(2))
        apart = [scene.sweep(at[part], speed) for part in parts]
        for name, wrench in first.items():
            for of in ("force", "moment"):
                expected = getattr(wrench, of)
                np.testing.assert_array_equal(getattr(again[name], of), expected)
                joined = np.concatenate([getattr(part[name], of) for part in apart])
                np.testing.assert_array_equal(joined, expected)


@pytest.mark.parametrize("name", EVERY_KIND)
def test_outputs_that_leave_loops_out(
    name: str, monkeypatch: pytest.MonkeyPatch, solved_by_tape: list[bool]
) -> None:
    usual = usual_motion(cd.load(name), samples=10)
    for joint in usual.scene.mechanism.joints:
        scene = usual.scene.replace(gravity=GRAVITY, outputs=[joint])
        assert_same(
            scene.sweep(usual.positions, usual.speed, 1.0),
            alone(
                lambda: scene.replace().sweep(usual.positions, usual.speed, 1.0),  # noqa: B023
                monkeypatch,
            ),
        )
    assert all(solved_by_tape)
    assert solved_by_tape


@pytest.mark.parametrize("seed", range(25))
def test_random_chains_against_free_bodies(seed: int) -> None:
    """Their oracle shares nothing with the package."""
    case = draw(seed)
    assert not differences(case, sweep_of(case))


def test_what_acts_may_differ_from_sample_to_sample(
    monkeypatch: pytest.MonkeyPatch, solved_by_tape: list[bool]
) -> None:
    rng = np.random.default_rng(3)
    count = 257
    scene = cd.Scene(
        cd.load("double_shaft_z"),
        drive="bearing_in",
        held={"joint_angle_1": 0.4, "joint_angle_2": -0.3},
        gravity=GRAVITY,
    )
    links = [name for name in scene.mechanism.links if scene.mechanism.links[name][0] > 0]

    def swept() -> cd.Sweep:
        return scene.replace().sweep(
            rng_positions,
            speed,
            acceleration,
            held={"joint_angle_1": angle},
            loads={
                "bearing_out": torque,
                links[1]: cd.Wrench(force=force, moment=(1.0, 2.0, 3.0), point=(0.1, 0.0, 0.2)),
                links[-1]: cd.Wrench(force=(5.0, -3.0, 1.0), frame="world", moment=force),
            },
            gravity=gravity,
            inertia={links[0]: factor, links[-1]: 1.7},
        )

    rng_positions, angle = rng.uniform(-7.0, 7.0, count), rng.uniform(0.1, 1.2, count)
    speed, acceleration = rng.normal(size=(2, count)) * 20.0
    torque, factor = rng.normal(size=count) * 50.0, rng.uniform(0.5, 2.0, count)
    force, gravity = rng.normal(size=(2, count, 3)) * 9.0
    assert_same(swept(), alone(swept, monkeypatch))
    assert all(solved_by_tape)
    assert solved_by_tape


def test_small_numbers_beside_great_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is rounding of zero that acts at another sample or along another drive."""
    mechanism = cd.load("universal_joint")
    scene = cd.Scene(mechanism, drive=["bearing_in", "joint_angle"], near={"joint_angle": 0.5})
    positions = np.linspace([0.1, 0.4], [2.0, 0.6], 50)
    speeds = np.tile([3.0, 1e-25], (50, 1))
    only_second = scene.sweep(positions, speeds * [0.0, 1.0]).motion.v
    both = scene.sweep(positions, speeds, 0.0).motion.v
    column = mechanism.coordinates.rates_of(["joint_angle"])[0]
    np.testing.assert_allclose(both[:, column], 1e-25)
    assert np.abs(only_second).max() <= 1e-24
    assert np.all(np.abs(only_second).max(axis=1) > 0.0)

    link = next(name for name, (body, _) in mechanism.links.items() if body > 1)
    force = np.zeros((50, 3))
    force[::2, 0], force[1::2, 1] = 1e12, 1e-12
    still = cd.Scene(mechanism, drive="bearing_in", held={"joint_angle": 0.5})
    for frame in ("world", "link"):

        def swept(frame: str = frame) -> cd.Sweep:
            loads = {link: cd.Wrench(force=force, frame=frame)}
            return still.replace().sweep(positions[:, 0], loads=loads)

        found, expected = swept(), alone(swept, monkeypatch)
        for name in found.outputs:
            size = expected[name].magnitude[0] + 1e-300
            apart = np.abs(found[name].force - expected[name].force).max(axis=1)
            assert np.all(apart <= 1e-12 * np.maximum(size, np.linalg.norm(force, axis=1))), name


def test_a_position_comes_out_alike_whatever_is_asked_beside_it() -> None:
    """To the last bit, once the tapes of a scene are made."""
    usual = usual_motion(cd.load("universal_joint"), samples=301)
    usual.scene.sweep(usual.positions, 3.0)
    known = usual.scene.sweep(usual.positions, 3.0)
    chosen = np.random.default_rng(0).permutation(len(usual.positions))[:200]
    mixed = usual.scene.sweep(usual.positions[chosen], 3.0)
    assert np.array_equal(mixed.motion.q, known.motion.q[chosen])
    for joint in known.outputs:
        assert np.array_equal(mixed[joint].force, known[joint].force[chosen]), joint
        assert np.array_equal(mixed[joint].moment, known[joint].moment[chosen]), joint


def test_samples_that_no_tape_holds_for_are_solved_alone(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """However few tapes serve, the wrenches are right, and errors tell of the same sample."""
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", gravity=GRAVITY)
    positions = np.linspace(0.0, 2.0 * np.pi, 400)

    def swept() -> cd.Sweep:
        return scene.replace().sweep(positions, 3.0)

    expected = alone(swept, monkeypatch)
    for growth in (1e-30, 1.05, 2.0):
        monkeypatch.setattr(tape, "THRESHOLD", 1.0 / growth)
        scene.mechanism.kept.forget("tapes")
        assert_same(swept(), expected)


def test_elements_at_samples_whose_motion_no_tape_finds(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = usual_motion(cd.load("elastic_double_shaft"), samples=200)

    def swept() -> cd.Sweep:
        return usual.scene.replace(gravity=GRAVITY).sweep(usual.positions, usual.speed, 1.0)

    closed, expected = taped._closed, alone(swept, monkeypatch)

    def partly(*arguments: object) -> object:
        holds = closed(*arguments)  # type: ignore[arg-type]
        holds[1::7] = False
        arguments[2].x[1::7] = np.nan  # type: ignore[attr-defined]
        return holds

    monkeypatch.setattr(taped, "_closed", partly)
    assert_same(swept(), expected)


def test_what_is_open_at_samples_that_are_solved_alone_is_open(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing", gravity=GRAVITY)
    positions = np.linspace(0.0, 2.0 * np.pi, 400)
    counts: list[int] = []
    openings = tape.Tape.openings

    def opened(self: tape.Tape, rows: tape.Prescribed, x: np.ndarray) -> object:
        """Find all open where a tape is one of a sample's own order."""
        if not self.acting.all():
            return openings(self, rows, x)
        counts.append(x.shape[1])
        return np.ones((4, 6)), set()

    monkeypatch.setattr(tape.Tape, "openings", opened)
    monkeypatch.setattr(InverseDynamics, "prove_flags", lambda self, solution: None)
    assert scene.sweep(positions).unique.any()
    assert not counts
    closed = taped._closed

    def partly(*arguments: object) -> object:
        holds = closed(*arguments)  # type: ignore[arg-type]
        holds[::5] = False
        return holds

    monkeypatch.setattr(taped, "_closed", partly)
    monkeypatch.setattr(taped, "MOST_TAPES", 1)
    assert not scene.sweep(positions).unique.any()
    assert sum(counts) == 16  # Of 80 to which tapes were asked again.


@pytest.mark.parametrize("length", [0.3, 1.7])
def test_moments_that_closed_trains_leave_open_are_least(
    length: float, monkeypatch: pytest.MonkeyPatch, solved_by_tape: list[bool]
) -> None:
    """Of wheels alone, and of two wheels and a rack, whose coupling exerts a force."""
    wheels = [("ab", "a", "b", -2.0), ("bc", "b", "c", -3.0), ("ca", "c", "a", 1.0 / 6.0)]
    train = gears(*(coupling(*item) for item in wheels), third=True)
    slide = train.replace('"c" type="continuous"', '"c" type="prismatic"').replace(
        '<origin xyz="2 0 0"/><axis xyz="0 0 1"/>',
        f'<origin xyz="{2.0 * length} 0 0"/><axis xyz="0 0 1"/>'
        '<limit lower="-100" upper="100" effort="1" velocity="1"/>',
    )
    assert slide.count("prismatic") == 1
    for text in (train, slide):
        scene = cd.Scene(cd.load(text), drive="a", loads={"c": -4.0, "b": 1.0})
        arguments = np.linspace(0.0, 3.0, 20), 2.0, 1.0
        sweep = scene.sweep(*arguments)
        assert sweep.coupling_unique == {"ab": False, "bc": False, "ca": False}
        expected = alone(lambda: scene.replace().sweep(*arguments), monkeypatch)  # noqa: B023
        assert_same(sweep, expected)
        assert sweep.coupling_unique == expected.coupling_unique
        assert np.ptp([np.abs(moment).max() for moment in sweep.coupling_moment.values()]) > 0.1
    assert all(solved_by_tape)
    assert solved_by_tape


def test_what_a_tape_leaves_out_is_not_lost(
    monkeypatch: pytest.MonkeyPatch, solved_by_tape: list[bool]
) -> None:
    """A tape that another thread made for what acts there does not hold for what acts here."""
    scene = cd.Scene(cd.load("four_bar"), drive="crank_bearing")
    positions = np.linspace(0.0, 2.0 * np.pi, 40)
    scene.sweep(positions)
    made = tape.Tape.__init__
    (tapes,) = scene.mechanism.kept._values["tapes"].values()
    unloaded = tapes[0].acting

    def always_unloaded(*arguments: object) -> None:
        acting = arguments[-1]
        made(*arguments[:-1], acting if np.all(acting) else unloaded)  # type: ignore[arg-type]

    loads = {"rocker_bearing": -3.0}
    with monkeypatch.context() as patch:
        patch.setattr(tape.Tape, "__init__", always_unloaded)
        sweep = scene.sweep(positions, loads=loads)
    assert solved_by_tape == [True, False]
    assert_same(sweep, alone(lambda: scene.replace().sweep(positions, loads=loads), monkeypatch))


def test_dead_points_are_refused_as_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = cd.Scene(cd.load("slider_crank"), drive="piston_guide", near={"crank_bearing": 1.0})
    low, high = scene.motion_range()
    positions = np.append(np.linspace(low + 0.1 * (high - low), high, 50)[:-1], high)
    told = []
    for by_tape in (False, True):
        with pytest.raises(cd.CardanError) as caught:
            if by_tape:
                scene.sweep(positions)
            else:
                alone(lambda: scene.sweep(positions), monkeypatch)
        told.append((type(caught.value), str(caught.value)))
    assert told[0] == told[1]
