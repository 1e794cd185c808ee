"""Every number of the errata is computed again, the wrong ones from the printed statement."""

from pathlib import Path

import numpy as np
import pytest

from cardan_dyn.analytic import (
    clearance,
    compound_angle,
    drive_line,
    errata,
    grossmann,
    impact,
    peak_factor,
    single_joint,
    thoma,
)

PAGE = Path(__file__).parents[2] / "docs" / "errata.md"
DEGREE = np.pi / 180
LINE = (0.0, np.pi / 2)
EXAMPLE = {"mass": 3.6, "stiffness": 1e7, "half_clearance": 0.5e-4, "ramp": 360e3}


def weisbach_tangents():
    beta = np.cos(30 * DEGREE) * np.tan(135 * DEGREE)
    return [(None, beta - np.tan(135 * DEGREE))]


def weisbach_tangent():
    return [(1.074, np.tan(single_joint.equal_speed_angle(30 * DEGREE, zero="normal")))]


def weisbach_lead():
    alpha = np.degrees(single_joint.equal_speed_angle(30 * DEGREE, zero="normal"))
    lead = np.degrees(single_joint.greatest_lead(30 * DEGREE))
    printed = (47 * 60 + 3, 42 * 60 + 57, 4 * 60 + 6)
    return list(zip(printed, (60 * alpha, 60 * (90 - alpha), 60 * lead), strict=True))


def thoma_sense():
    """Both ways from Thoma's own direction cosines, in his axes."""
    cos_lambda, cos_mu, _ = thoma.moment_cosines(50 * DEGREE, 0.0)
    assert cos_mu == pytest.approx(-0.642788, abs=5e-7)
    # (6) with M_t = 1; and the moment whose component in the sense of rotation, -y, is 1.
    return [(cos_lambda / cos_mu, cos_lambda / -cos_mu)]


def thoma_neglect():
    beta, phi = 8.5 * DEGREE, np.linspace(0, 2 * np.pi, 20001)
    exact = thoma.rig_moments(beta, phi, 1.0, 1.0)
    small = thoma.rig_moments_small_angle(beta, phi, 1.0, 1.0)
    printed = 100 * round((1 - np.cos(beta)) ** 2, 5)
    return [
        (printed, 100 * np.max(abs(s - e)) / np.max(abs(e)))
        for s, e in zip(small, exact, strict=True)
    ]


def grossmann_8():
    beta, values = 50 * DEGREE, []
    for phi_1 in (0.7, 0.0):
        phi_2 = single_joint.output_angle(beta, phi_1)
        root = np.sqrt(1 + np.tan(beta) ** 2 * np.cos(phi_2) ** 2)
        printed = np.tan(beta) * abs(np.cos(phi_2)) / (np.cos(beta) * root)
        values.append((printed, grossmann.moments_from_output(beta, phi_2).bending_2))
    return values


def catalogue_limit():
    return [(None, single_joint.non_uniformity(3 * DEGREE))]


def residual(*degrees):
    return np.degrees(drive_line.residual_angle_approximate(np.radians(degrees), LINE))


def catalogue_order():
    assert 10**2 - 12**2 < 0
    return [(None, residual(10, 12))]


def catalogue_first_order():
    return [
        (residual(*pair), np.degrees(drive_line.residual_angle(np.radians(pair), LINE)))
        for pair in ((12, 10), (40, 38))
    ]


def catalogue_example():
    assert np.hypot(15, 7) == pytest.approx(16.55, abs=0.005)
    return [(16.5, np.degrees(compound_angle.compound_angle(7 * DEGREE, 15 * DEGREE)))]


def catalogue_offset_sign():
    h1, v1, h2, v2 = np.tan(np.radians([7, 15, 12, -11.5]))
    both = np.degrees(np.arctan(h1 / v1) + np.arctan(h2 / v2))
    return [(both, np.degrees(compound_angle.fork_offset(*np.radians([7, 15, 12, -11.5]))))]


def catalogue_projections():
    def axis(vertical, horizontal):
        return np.array([1.0, np.tan(vertical * DEGREE), np.tan(horizontal * DEGREE)])

    def example(first_vertical, first_horizontal):
        """Shafts whose projections bend by (15, 7) and (-11.5, 12) degrees."""
        v, h = first_vertical, first_horizontal
        axes = axis(v, h), axis(v + 15, h + 7), axis(v + 15 - 11.5, h + 7 + 12)
        return np.degrees(
            [
                compound_angle.angle_between(*axes[:2]),
                compound_angle.angle_between(*axes[1:]),
                compound_angle.offset_between(*axes),
            ]
        )

    formulas = np.degrees(
        [
            compound_angle.compound_angle(7 * DEGREE, 15 * DEGREE),
            compound_angle.compound_angle(12 * DEGREE, -11.5 * DEGREE),
            compound_angle.fork_offset(*np.radians([7, 15, 12, -11.5])),
        ]
    )
    np.testing.assert_allclose(example(-15, -7), formulas, rtol=1e-14)
    first, second, offset = example(0, 0)
    assert first == pytest.approx(formulas[0], rel=1e-14)
    return [(formulas[1], second), (formulas[2], offset)]


def catalogue_complement():
    h1, v1, h2, v2 = np.radians([7, 15, 12, -11.5])
    planes = [compound_angle.bending_plane(*pair) for pair in ((h1, v1), (h2, v2))]
    turned = np.degrees(planes[1] - planes[0])
    assert turned == pytest.approx(109.127, abs=5e-4)
    return [(180 - turned, np.degrees(compound_angle.fork_offset(h1, v1, h2, v2)))]


def catalogue_planar_lines():
    """The right value by shafts in space: the greatest and smallest ratio of the line."""
    beta, phi = 12 * DEGREE, np.linspace(0, np.pi, 200_001)
    middle = single_joint.output_angle(beta, phi)
    ratio = single_joint.speed_ratio(beta, phi) * single_joint.speed_ratio(beta, middle + np.pi / 4)
    exact = np.degrees(np.arccos(np.sqrt(ratio.min() / ratio.max())))
    first = np.degrees(drive_line.residual_angle_approximate([beta] * 2, [0, np.pi / 4]))
    assert exact == pytest.approx(first, rel=0.02)
    return [(0.0, first), (np.hypot(12, 12), first)]


def dresig_start():
    return [(impact.reversal(**EXAMPLE).peak, impact.reversal(**EXAMPLE, start="release").peak)]


def dresig_products():
    return [(None, 1e3 * clearance.contact_time(3.6, 0.5e-4, 360e3))]


def dresig_16():
    s, ramp = 0.5e-4, 360e3
    return [(np.cbrt(18 * s**2 * ramp / 3.6 * 6 * s), clearance.impact_speed(3.6, s, ramp))]


def dresig_time():
    tau = clearance.tau(**EXAMPLE)
    # (26) at the impact, t = t_1 in its second term: 1 + 1 + 0 - 1.
    printed = 12 * 1e7 * 0.5e-4 / tau**2 * (1 + tau / tau - 1)
    return [(printed, impact.contact_force(0.0, **EXAMPLE))]


def dresig_28():
    return [(np.pi / 2 - x, np.arccos(x)) for x in (0.1, 1.0)]


def dresig_branch():
    values = []
    for tau in (0.5, 1.0, 1.5):
        arc = np.arccos((4 - 2 * tau**3 - 2 * tau**2) / (4 + tau**4))
        values.append((6 / tau + 12 / tau**2 + 12 / tau**3 * arc, peak_factor.peak_factor(tau)))
    return values


def dresig_29():
    return [
        (peak_factor.peak_factor_linearised(tau), peak_factor.peak_factor(tau)) for tau in (1, 2, 5)
    ]


def dresig_mass():
    def exponents(function):
        step = 1e-6
        return {
            name: np.log(
                function(**EXAMPLE | {name: EXAMPLE[name] * np.exp(step)})
                / function(**EXAMPLE | {name: EXAMPLE[name] * np.exp(-step)})
            )
            / (2 * step)
            for name in EXAMPLE
        }

    peak = exponents(lambda **example: impact.reversal(**example).peak)
    tau = exponents(clearance.tau)
    rounded = [peak[name] for name in ("ramp", "half_clearance", "mass", "stiffness")]
    assert 3 * peak["ramp"] == pytest.approx(1.91, abs=0.005)  # the ramp is k_1 Omega^3
    assert rounded == pytest.approx([0.64, 0.36, 0.32, 0.045], abs=0.005)
    assert min(peak, key=lambda name: abs(peak[name])) == "stiffness"
    assert min(tau, key=lambda name: abs(tau[name])) == "mass"
    return [(tau[name], peak[name]) for name in ("mass", "stiffness")]


RECOMPUTED = {
    "weisbach-inequality": weisbach_tangents,
    "weisbach-tangent": weisbach_tangent,
    "weisbach-lead": weisbach_lead,
    "thoma-sense": thoma_sense,
    "thoma-neglect": thoma_neglect,
    "grossmann-8": grossmann_8,
    "catalogue-limit": catalogue_limit,
    "catalogue-order": catalogue_order,
    "catalogue-first-order": catalogue_first_order,
    "catalogue-example": catalogue_example,
    "catalogue-offset-sign": catalogue_offset_sign,
    "catalogue-projections": catalogue_projections,
    "catalogue-complement": catalogue_complement,
    "catalogue-planar-lines": catalogue_planar_lines,
    "dresig-start": dresig_start,
    "dresig-products": dresig_products,
    "dresig-16": dresig_16,
    "dresig-time": dresig_time,
    "dresig-28": dresig_28,
    "dresig-branch": dresig_branch,
    "dresig-29": dresig_29,
    "dresig-mass": dresig_mass,
}


@pytest.mark.parametrize("erratum", errata.ERRATA, ids=lambda erratum: erratum.key)
def test_numbers(erratum):
    assert bool(erratum.numbers) == (erratum.key in RECOMPUTED)
    if not erratum.numbers:
        return
    for number, (printed, right) in zip(erratum.numbers, RECOMPUTED[erratum.key](), strict=True):
        assert number.right == pytest.approx(right, rel=1e-5, abs=1e-12), number.what
        if number.printed is None:
            assert printed is None
        else:
            assert number.printed == pytest.approx(printed, rel=1e-5), number.what
            assert abs(number.printed - number.right) > 1e-4 * abs(number.right), number.what


def test_the_wrong_branch_begins_at_two():
    tau = np.array([2.0, 2.5, 10.0])
    arc = np.arccos((4 - 2 * tau**3 - 2 * tau**2) / (4 + tau**4))
    printed = 6 / tau + 12 / tau**2 + 12 / tau**3 * arc
    np.testing.assert_allclose(printed, peak_factor.peak_factor(tau), rtol=1e-12)


def test_every_entry_is_on_the_page():
    page = PAGE.read_text(encoding="utf-8")
    assert len({erratum.key for erratum in errata.ERRATA}) == len(errata.ERRATA)
    for erratum in errata.ERRATA:
        assert erratum.printed in page
        assert erratum.right in page


def test_selection():
    assert errata.errata() == errata.ERRATA
    chosen = errata.errata("Thoma 1920")
    assert chosen
    assert all(erratum.source == "Thoma 1920" for erratum in chosen)
    with pytest.raises(ValueError, match="source = 'Euler' is not one of 'Weisbach and Herrmann'"):
        errata.errata("Euler")
