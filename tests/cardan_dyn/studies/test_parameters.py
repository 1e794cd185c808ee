"""Parameters: values by index are those of the whole, whatever part is asked for."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import stats
from scipy.stats import norm, qmc, uniform

import cardan_dyn as cd
from cardan_dyn import studies
from cardan_dyn.practice.studies.parameters import METHODS, checked_parameters

LAWS = {"a": norm(1.0, 0.2), "b": (uniform(2.0, 3.0), "m")}


@pytest.mark.parametrize("method", METHODS)
def test_any_part_of_samples_is_a_part_of_the_whole(method: str) -> None:
    block = studies.samples(LAWS, 100, seed=5, method=method)
    whole = block.values(0, 100)
    for start, stop in ((0, 1), (17, 50), (99, 100)):
        for name, values in block.values(start, stop).items():
            np.testing.assert_array_equal(values, whole[name][start:stop])
    assert whole["b"].min() >= 2.0
    assert whole["b"].max() <= 5.0
    # Quantiles of 100 samples are near those of the distribution.
    assert abs(np.median(whole["a"]) - 1.0) < 0.07


def test_samples_are_those_of_scipy() -> None:
    cube = qmc.Sobol(2, seed=np.random.default_rng(5)).random(64)
    values = studies.samples(LAWS, 64, seed=5).values(0, 64)
    np.testing.assert_array_equal(values["a"], norm(1.0, 0.2).ppf(cube[:, 0]))


@pytest.mark.parametrize("method", ["sobol", "halton", "random"])
def test_longer_samples_begin_like_shorter_ones(method: str) -> None:
    short = studies.samples(LAWS, 32, seed=1, method=method).values(0, 32)
    long = studies.samples(LAWS, 128, seed=1, method=method).values(0, 32)
    for name, values in short.items():
        np.testing.assert_array_equal(values, long[name])


def test_lines_and_arrays_are_axes() -> None:
    parameters = checked_parameters({"a": studies.Line(0.0, 1.0, 11), "b": (["x", "y"], "")})
    assert parameters.shape == (11, 2)
    assert parameters.case((5, 1)) == {"a": 0.5, "b": "y"}
    mesh = parameters.mesh((slice(2, 4), slice(0, 2)))
    assert mesh["a"].shape == (2, 1)
    assert mesh["b"].shape == (1, 2)


def test_a_billion_cases_take_no_memory() -> None:
    long = studies.Line(0.0, 1.0, 10**9)
    many = studies.samples(LAWS, 10**9, seed=0, method="random")
    parameters = checked_parameters([{"c": long}, many])
    assert parameters.count == 10**18
    case = parameters.case((10**9 - 1, 10**9 - 1))
    assert case["c"] == 1.0


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "empty"),
        ({"a": []}, "a is empty"),
        ({"a": [1.0, np.nan]}, "not finite at index 1"),
        ({"a": [[1.0]]}, "shape"),
        ({"a": object()}, "expected values"),
        ([{"a": [1.0]}, {"a": [2.0]}], "occurs twice"),
        (3, "expected a mapping"),
        ({"a/b": [1.0]}, "slash"),
    ],
)
def test_what_no_study_can_vary_is_refused(given: object, said: str) -> None:
    with pytest.raises(cd.ArgumentError, match=said):
        cd.study(max, given)


def test_wrong_samples_are_refused() -> None:
    with pytest.raises(cd.ArgumentError, match="expected a distribution"):
        studies.samples({"a": [1.0]}, 4, seed=0)
    with pytest.raises(cd.ArgumentError, match="quantiles"):
        studies.samples({"a": norm(0.0, -1.0)}, 4, seed=0)
    with pytest.raises(cd.ArgumentError, match="did you mean 'sobol'"):
        studies.samples({"a": norm()}, 4, seed=0, method="sobel")
    with pytest.raises(cd.ArgumentError, match="power of 2"):
        studies.sobol_samples({"a": norm()}, 100, seed=0)
    with pytest.raises(cd.ArgumentError, match="one length"):
        studies.points({"a": [1.0], "b": [1.0, 2.0]})


def test_a_billion_by_mistake_is_refused_and_said_how_to_mean_it() -> None:
    axis = np.linspace(0.0, 1.0, 1000)
    with pytest.raises(cd.ArgumentError, match=r"1,000,000,000 cases.*most_cases=1000000000"):
        cd.study(max, {"a": axis, "b": axis, "c": axis})


def test_distributions_are_told_apart_by_what_they_return() -> None:
    """Histograms have one name, and classes of users no text but their place in memory."""

    class Even:
        def __init__(self, width: float) -> None:
            self.width = width

        def ppf(self, part: np.ndarray) -> np.ndarray:
            return self.width * part

    def histogram(power: int) -> object:
        return stats.rv_histogram(np.histogram(np.linspace(0.0, 1.0, 100) ** power))

    def law(distribution: object) -> object:
        return studies.samples({"a": distribution}, 4, seed=1).described(4)["distributions"]

    for made in (histogram, lambda power: histogram(power)(), lambda power: Even(float(power))):
        assert law(made(1)) == law(made(1))
        assert law(made(1)) != law(made(2))
    assert law(stats.norm) == law(stats.norm())
    assert "0x" not in str(law(stats.norm))


@pytest.mark.parametrize("values", [[1, "a"], np.ma.masked_greater([1.0, 9.0], 5.0)])
def test_values_that_would_be_others_are_refused(values: object) -> None:
    with pytest.raises(cd.CardanError, match=r"give one kind|masked"):
        cd.study(str, {"x": values})


@pytest.mark.parametrize("name", ["", " ", "a/b", ".", "..", "zarr.json", "a\0b", "x" * 300])
def test_names_that_no_array_of_a_store_can_have_are_refused(name: str) -> None:
    with pytest.raises(cd.ArgumentError, match="a parameter is called"):
        cd.study(np.sin, {name: [1.0]})
    with pytest.raises(cd.ArgumentError, match="a dimension is called"):
        studies.points({"x": [1.0]}, dim=name)
    with pytest.raises(cd.CardanError, match="a result is called"):
        cd.study(lambda x: {name: x}, {"x": [1.0]}, workers=1).run()
