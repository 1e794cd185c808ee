"""Building responses: checks of the arguments, refinement of known functions, and the proof."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from testkit.linkages import coupling, four_bar, gears, loop
from testkit.scenes import universal

import cardan_dyn as cd
from cardan_dyn.core.response import build as build_module
from cardan_dyn.core.response.domain import Domain
from cardan_dyn.core.response.sampling import Sampled

Function = Callable[[np.ndarray], np.ndarray]


class KnownFunction:
    """Stands for the sampler of a problem whose only function is known, with its condition."""

    def __init__(self, function: Function, condition: float = 1.0) -> None:
        self.function, self.condition = function, condition

    def solve(self, positions: np.ndarray) -> Sampled:
        values = self.function(positions)[None]
        return Sampled(values, self.condition, np.zeros((0, 6)), frozenset())


class UnitScales:
    """Stands for the scales of functions of size 1; a function below `floor` is empty."""

    floor = 0.0

    def of(self, values: np.ndarray) -> np.ndarray:
        return np.ones(len(values))

    def empty(self, values: np.ndarray) -> np.ndarray:
        return np.max(np.abs(values), axis=1) < self.floor

    def rounding(self, cancellation: float, condition: float) -> np.ndarray:
        return np.zeros(1)


def refined(
    function: Function, tolerance: float, domain: Domain, condition: float = 1.0
) -> tuple[int, float]:
    """Number of steps that the refinement ends with, and the error that it reports."""
    sampler = KnownFunction(function, condition)
    positions = domain.at_share(np.linspace(0.003, 0.997, 77))
    first, checks = sampler.solve(domain.nodes(16)), (positions, function(positions)[None], 1.0)
    steps = build_module._refined(UnitScales(), tolerance, domain, first, *checks)
    answer = None
    while True:
        try:
            request = steps.send(answer)
        except StopIteration as end:
            samples, error = end.value
            break
        answer = sampler.solve(request)
    np.testing.assert_array_equal(
        samples.values, sampler.solve(domain.nodes(domain.steps(samples.values.shape[1]))).values
    )
    return domain.steps(samples.values.shape[1]), error


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize("decay", [0.3, 0.8, 0.95])
def test_a_period_takes_as_many_samples_as_its_coefficients_ask_for(
    decay: float, tolerance: float
) -> None:
    """Poisson's kernel has the coefficients `decay` to the order, here times its least value."""

    def kernel(x: np.ndarray) -> np.ndarray:
        return (1.0 - decay) ** 2 / (1.0 - 2.0 * decay * np.cos(x) + decay**2)

    scale = (1.0 - decay) / (1.0 + decay)
    count, error = refined(kernel, tolerance, Domain(0.3, 2.0 * np.pi, True))
    # Two waves per order, each missing and added to a lower one; all of them in phase at the peak.
    missing = [
        4.0 * scale * decay ** (steps // 2 + 1) / (1.0 - decay) for steps in (count, count // 2)
    ]
    assert missing[0] < 3.0 * tolerance
    assert count == 16 or missing[1] > 0.3 * tolerance
    assert error <= tolerance
    assert missing[0] <= 3.0 * error


def test_a_range_takes_few_samples_for_a_polynomial_and_more_for_a_pole() -> None:
    domain = Domain(0.5, 1.5, False)
    assert refined(lambda x: 0.1 * x**3 - x, 1e-12, domain)[0] == 16
    # Coefficients of 1 / (p - x) fall by p + √(p² - 1), p = 1.2 in units of half the range.
    count, _ = refined(lambda x: 0.3 / (0.5 + 1.2 * 1.5 - x), 1e-12, domain)
    ratio = 1.2 + np.sqrt(1.2**2 - 1.0)
    assert ratio**-count < 1e-12 < 10.0 * ratio ** (-count / 2)


def noisy(x: np.ndarray) -> np.ndarray:
    """A smooth function with errors of 1e-9 that depend on the last digits of the position."""
    return np.cos(x) + 1e-9 * np.sin(1e12 * x)


def test_errors_that_the_condition_explains_end_the_refinement() -> None:
    _, error = refined(noisy, 1e-13, Domain(0.3, 2.0 * np.pi, True), condition=1e4)
    assert 1e-10 < error < 1e-8


def test_errors_that_nothing_explains_are_refused() -> None:
    message = (
        r"the response reaches \d\.\de-\d\d with \d+ samples, not 1e-13: the closure equations "
        r"have condition 1\.0e\+00; ask for a greater tolerance, or for a range farther "
        "from dead points"
    )
    with pytest.raises(cd.AccuracyError, match=message) as caught:
        refined(noisy, 1e-13, Domain(0.3, 2.0 * np.pi, True))
    assert caught.value.tolerance == 1e-13
    assert caught.value.residual > 1e-10
    assert caught.value.position is None


def test_the_number_of_samples_is_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(build_module, "_GREATEST_COUNT", 64)
    with pytest.raises(cd.AccuracyError, match="with 64 samples, not 1e-10"):
        refined(np.abs, 1e-10, Domain(0.0, 1.0, False))


@pytest.mark.parametrize(
    "domain", [Domain(0.3, 2.0 * np.pi, True), Domain(0.5, 1.5, False)], ids=["period", "range"]
)
def test_checks_lie_between_the_samples_of_every_round(domain: Domain) -> None:
    checks = build_module._check_positions(domain)
    low, high = sorted(domain.at_share(np.array([0.0, 1.0])))
    assert np.all((low < checks) & (checks < high))
    assert len(np.unique(checks)) == len(checks)
    # Those at either end of a range are samples of later rounds.
    scattered = checks[:32]
    for count in (128, 1024, 2**15):
        nodes = np.sort(domain.nodes(count))
        assert not np.any(np.isin(scattered, nodes))
        if not domain.periodic:
            assert np.any((nodes[0] < checks) & (checks < nodes[1]))
            assert np.any((nodes[-2] < checks) & (checks < nodes[-1]))


@pytest.mark.parametrize(
    "interval",
    [3, "ab", {0.0: 1.0}, (1.0,), [0.0, 1.0, 2.0], np.array(1.0), np.zeros(3), {0.0, 1.0}],
    ids=repr,
)
def test_what_is_no_pair_is_no_interval(joint: cd.Mechanism, interval: object) -> None:
    with pytest.raises(cd.ArgumentError, match=r"interval is .*, expected \(low, high\)"):
        universal(joint, 0.5).response(interval=interval)  # type: ignore[arg-type]


@pytest.mark.parametrize("interval", [(0.0, 1.0), [0.0, 1.0], np.array([0.0, 1.0])], ids=repr)
def test_pairs_of_any_sequence_are_intervals(joint: cd.Mechanism, interval: object) -> None:
    response = universal(joint, 0.5).response(1e-6, interval=interval)  # type: ignore[arg-type]
    assert response.interval == (0.0, 1.0)


@pytest.mark.parametrize(
    ("interval", "message"),
    [
        ((1.0, 0.0), "the interval from 1 to 0 is empty"),
        ((1.0, 1.0), "the interval from 1 to 1 is empty"),
        ((1e6, 1e6 + 1e-8), "the interval from 1000000 to 1000000 is empty"),
        (([0.0], 1.0), r"interval\[0\] has shape \(1,\), expected a number"),
        ((0.0, np.inf), r"interval\[1\] is not finite"),
    ],
)
def test_empty_intervals_and_ends_that_are_no_numbers(
    joint: cd.Mechanism, interval: object, message: str
) -> None:
    with pytest.raises(cd.ArgumentError, match=message):
        universal(joint, 0.5).response(interval=interval)  # type: ignore[arg-type]


@pytest.mark.parametrize("tolerance", [0.0, -1.0, 2e-16, 1.0, 3.0])
def test_tolerances_out_of_range_are_refused(joint: cd.Mechanism, tolerance: float) -> None:
    message = re.escape(f"tolerance is {tolerance:g}, expected 2.2e-16 … 1")
    with pytest.raises(cd.ArgumentError, match=message):
        universal(joint, 0.5).response(tolerance)


def test_a_response_needs_one_drive_that_comes_back_and_wrenches_that_stay_the_same(
    joint: cd.Mechanism,
) -> None:
    both = cd.Scene(joint, drive=["bearing_in", "joint_angle"])
    message = r"a response needs one drive, not \['bearing_in', 'joint_angle'\]"
    with pytest.raises(cd.ArgumentError, match=message):
        both.response()
    changing = cd.Wrench(force=np.ones((2, 3)))
    pushed = cd.Scene(
        joint, drive="bearing_in", held={"joint_angle": 0.5}, loads={"shaft_out": changing}
    )
    with pytest.raises(cd.ArgumentError, match="the wrench on 'shaft_out' changes from sample to"):
        pushed.response()
    slide = cd.Scene(cd.load("slider_crank"), drive="piston_guide", near={"crank_bearing": 1.0})
    message = "slider_crank: drive 'piston_guide' does not come back to where it was within a few"
    with pytest.raises(cd.CardanError, match=message):
        slide.response()


def test_a_period_begins_where_the_scene_starts() -> None:
    wheels = cd.load(gears(coupling("mesh", "a", "b", -2.5)))
    for start in (0.0, 0.7):
        scene = cd.Scene(wheels, drive="a", near={"a": start})
        domain = scene.response()._data[0].series.domain
        # The second wheel turns five times while the first one turns twice.
        assert domain == pytest.approx((start, 4.0 * np.pi, True))


def test_what_is_proven_of_a_response_is_the_worst_of_its_samples(joint: cd.Mechanism) -> None:
    scene = universal(joint, 0.8)
    response = scene.response(1e-9)
    proof, positions = response.proof, np.linspace(0.0, 6.3, 400)
    conditions = scene.sweep(positions).condition
    assert proof.tolerance == 1e-9
    assert proof.condition == pytest.approx(float(np.max(conditions)), rel=1e-2)
    assert proof.error >= np.finfo(float).eps * proof.condition
    assert proof.unproven == ()
    for residual in (proof.loop_residual, proof.balance_residual, proof.power_residual):
        assert 0.0 < residual < 1e-12
    # Of two wheels whose moments are known neither is open.
    wheels = cd.Scene(cd.load(gears(coupling("mesh", "a", "b", -2.5))), drive="a").response()
    assert wheels._data[0].coupling_unique == {"mesh": True}


def test_a_strict_scene_refuses_in_a_response_as_it_does_in_a_sweep(joint: cd.Mechanism) -> None:
    strict = universal(joint, 0.5, strict=True)
    with pytest.raises(cd.IndeterminateError) as of_sweep:
        strict.sweep(0.0)
    with pytest.raises(cd.IndeterminateError) as of_response:
        strict.response()
    assert of_response.value.components == of_sweep.value.components
    assert str(of_response.value) == str(of_sweep.value)
    # Compliances decide what is statically indeterminate; without outputs nothing has to be.
    decided = universal(
        joint,
        0.5,
        strict=True,
        compliance={name: np.full(6, 1e-6) for name in ("bearing_in", "bearing_out")},
    )
    assert decided.response().error < 1e-12
    assert universal(joint, 0.5, strict=True, outputs=[]).response().error < 1e-12


def test_a_tolerance_out_of_reach_is_refused(
    joint: cd.Mechanism, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Towards a dead point forces grow without bound, and no polynomial follows them."""
    rocker = cd.Scene(cd.load(four_bar(loop("continuous"))), drive="d", loads={"a": -2.0})
    low, high = rocker.motion_range()
    monkeypatch.setattr(build_module, "_GREATEST_COUNT", 1024)
    with pytest.raises(cd.AccuracyError, match=r"the response reaches .* not 1e-12") as caught:
        rocker.response(1e-12, interval=(low + 1e-7, high - 1e-7))
    assert caught.value.residual > 1e-12
    scene = universal(joint, 0.5)
    with pytest.raises(cd.ArgumentError, match="tolerance is 0"):
        scene.response(0.0)
    with pytest.raises(cd.ArgumentError, match="a response needs one drive"):
        cd.Scene(joint, drive=["bearing_in", "joint_angle"]).response()


def test_a_cardan_joint_takes_no_more_samples_than_it_needs(joint: cd.Mechanism) -> None:
    assert universal(joint, np.deg2rad(50.0)).response().sample_count == 128
    assert universal(joint, np.deg2rad(80.0)).response().sample_count == 512
