"""Errors found in the sources: what is printed, what is right, and numbers that show it.

Three kinds are kept apart:

- "wrong": as printed it gives a wrong value;
- "scan": introduced by the scanning of the copy in circulation, or not to be told from that;
- "scope": right, but only under a condition that is not stated.

References:
    The documents named in each entry; `analytic.single_joint`, `thoma`, `grossmann`,
    `compound_angle`, `clearance` and `impact` cite them in full.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["ERRATA", "Comparison", "Erratum", "as_markdown", "errata"]


@dataclass(frozen=True)
class Comparison:
    """One number, as the printed statement gives it and as it is.

    `printed` is None where the printed statement gives no real number.
    """

    what: str
    printed: float | None
    right: float


@dataclass(frozen=True)
class Erratum:
    """One error of a source."""

    key: str
    source: str
    place: str
    kind: Literal["wrong", "scan", "scope"]
    printed: str
    right: str
    numbers: tuple[Comparison, ...] = ()


WEISBACH = "Weisbach and Herrmann"
THOMA = "Thoma 1920"
GROSSMANN = "Grossmann 1939"
CATALOGUE = "Catalogue, chapter 6"
DRESIG = "Dresig and Thuemmel"

ERRATA: tuple[Erratum, ...] = (
    Erratum(
        key="weisbach-inequality",
        source=WEISBACH,
        place="paragraph 26, after cos c = tan beta / tan alpha",
        kind="wrong",
        printed="tan beta < tan alpha always.",
        right="|tan beta| < |tan alpha|. In the second and fourth quadrant both tangents are "
        "negative and tan beta is the greater, which is what the same sentence then says of the "
        "angles.",
        numbers=(Comparison("tan beta - tan alpha, c = 30 deg, alpha = 135 deg", None, 0.133975),),
    ),
    Erratum(
        key="weisbach-tangent",
        source=WEISBACH,
        place="paragraph 26, worked example, c = 30 deg",
        kind="wrong",
        printed="tan alpha = sqrt(1.155) = 1.074.",
        right="1.0746, rounded 1.075.",
        numbers=(Comparison("tan alpha", 1.074, 1.07457),),
    ),
    Erratum(
        key="weisbach-lead",
        source=WEISBACH,
        place="paragraph 26, worked example, c = 30 deg",
        kind="wrong",
        printed="alpha = 47 deg 3', beta = 42 deg 57', greatest deviation 4 deg 6'.",
        right="47 deg 3.5', 42 deg 56.5', 4 deg 7.0'. The printed angles follow from tangents of "
        "three decimals, 1.074 cut and 0.931 rounded, and their difference carries both errors.",
        numbers=(
            Comparison("alpha in minutes of arc", 2823.0, 2823.52),
            Comparison("beta in minutes of arc", 2577.0, 2576.48),
            Comparison("greatest lead in minutes of arc", 246.0, 247.032),
        ),
    ),
    Erratum(
        key="thoma-equation-number",
        source=THOMA,
        place="Beispiel, M_t = Theta omega_1^2 psi''",
        kind="scan",
        printed="Numbered (3), a number already given to sin^2 psi.",
        right="(8), by which the next paragraph refers to it.",
    ),
    Erratum(
        key="thoma-sense",
        source=THOMA,
        place="Beispiel, use of (6) and (7) with (8)",
        kind="scope",
        printed="M_x and M_z from (6) and (7), with M_t = Theta omega_1^2 psi''.",
        right="In (5) to (7) M_t is the component along +y, in (8) it is positive in the sense of "
        "rotation, along -y: the source's own cos mu is -cos alpha = -0.642788 at alpha = 50 deg, "
        "phi = 0. The M_x and M_z of the rig are therefore components along -x and -z.",
        numbers=(
            Comparison("M_x along +x for M_t = 1, alpha = 50 deg, phi = 0", 1.191754, -1.191754),
        ),
    ),
    Erratum(
        key="thoma-neglect",
        source=THOMA,
        place="Beispiel, before the small-angle forms",
        kind="scope",
        printed="(1 - cos alpha)^2 may be neglected even at rather great angles: it is 0.00012 "
        "at 8.5 deg.",
        right="M_t, M_x and M_z are of the size of 1 - cos alpha themselves, so the error relative "
        "to them is of the size of 1 - cos alpha = 0.011, not of its square.",
        numbers=(
            Comparison("error of M_t in percent of its peak, 8.5 deg", 0.012, 1.51305),
            Comparison("error of M_x in percent of its peak, 8.5 deg", 0.012, 2.68193),
            Comparison("error of M_z in percent of its peak, 8.5 deg", 0.012, 2.49814),
        ),
    ),
    Erratum(
        key="grossmann-8",
        source=GROSSMANN,
        place="(8), second form",
        kind="wrong",
        printed="B_2/D_1 = tan phi |cos alpha_2| / (cos phi sqrt(1 + tan^2 phi cos^2 alpha_2)).",
        right="B_2/D_1 = tan phi |cos alpha_2| / (cos phi (1 + tan^2 phi cos^2 alpha_2)), "
        "without the square root. The first form is right.",
        numbers=(
            Comparison("B_2/D_1, phi = 50 deg, alpha_1 = 0.7", 0.911503, 0.738665),
            Comparison("B_2/D_1, phi = 50 deg, alpha_1 = 0", 1.191754, 0.766044),
        ),
    ),
    Erratum(
        key="catalogue-limit",
        source=CATALOGUE,
        place="6.4 and 6.5",
        kind="scan",
        printed="beta_E congruent to 3 deg.",
        right="beta_E at most 3 deg.",
        numbers=(Comparison("degree of non-uniformity allowed, at 3 deg", None, 0.0027428),),
    ),
    Erratum(
        key="catalogue-order",
        source=CATALOGUE,
        place="6.4",
        kind="scope",
        printed="beta_E = sqrt(beta_1^2 - beta_2^2).",
        right="sqrt(|beta_1^2 - beta_2^2|): the second angle may be the greater.",
        numbers=(Comparison("beta_E in deg, beta_1 = 10 deg, beta_2 = 12 deg", None, 6.63325),),
    ),
    Erratum(
        key="catalogue-first-order",
        source=CATALOGUE,
        place="6.4 and 6.5",
        kind="scope",
        printed="beta_E = sqrt(+-beta_1^2 +-beta_2^2 ...).",
        right="Of first order. Exactly, cos beta_E is the product of cos beta_k over the joints of "
        "one fork position divided by that over the other, inverted if above 1.",
        numbers=(
            Comparison("beta_E in deg, 12 deg against 10 deg", 6.63325, 6.66729),
            Comparison("beta_E in deg, 40 deg against 38 deg", 12.489996, 13.56014),
        ),
    ),
    Erratum(
        key="catalogue-example",
        source=CATALOGUE,
        place="6.3, example of Bild 19",
        kind="scope",
        printed="beta_1 = 16.5 deg from beta_V1 = 15 deg and beta_H1 = 7 deg.",
        right="16.42 deg by the formula printed below it. The drawing adds the angles instead of "
        "their tangents, which holds for small angles and gives 16.55 deg here.",
        numbers=(Comparison("beta_1 in deg", 16.5, 16.4225),),
    ),
    Erratum(
        key="catalogue-offset-sign",
        source=CATALOGUE,
        place="6.3",
        kind="scope",
        printed="phi = phi_1 +- phi_2 with tan phi_k = tan beta_Hk / tan beta_Vk, the sign from "
        "the drawing.",
        right="gamma = p_2 - p_1 reduced by half turns, p_k = atan2(tan beta_Hk, tan beta_Vk): "
        "sign and quadrant follow, without a drawing.",
        numbers=(Comparison("offset of the example in deg, sign +", -21.6346, -70.8728),),
    ),
    Erratum(
        key="catalogue-projections",
        source=CATALOGUE,
        place="6.3",
        kind="scope",
        printed="Compound angles and fork offset from projections, without a condition.",
        right="All three are exact if the common shaft is parallel to both drawing planes. If the "
        "input shaft is, beta_1 still is exact, beta_2 and the offset are of first order.",
        numbers=(
            Comparison("beta_2 of the example in deg, input shaft parallel", 16.3956, 16.5543),
            Comparison("offset of the example in deg, input shaft parallel", -70.8728, -72.2954),
        ),
    ),
    Erratum(
        key="catalogue-complement",
        source=CATALOGUE,
        place="6.3, last sentence",
        kind="scope",
        printed="If phi is greater than 90 deg, its supplement (Ergaenzungswinkel) is taken.",
        right="The supplement is measured in the opposite sense: a fork turned by 109 deg one way "
        "stands like a fork turned by 71 deg the other way.",
        numbers=(
            Comparison("offset in deg, p_2 - p_1 = 109.127 deg in the example", 70.8728, -70.8728),
        ),
    ),
    Erratum(
        key="catalogue-planar-lines",
        source=CATALOGUE,
        place="6.5",
        kind="scope",
        printed="beta_E = sqrt(+-beta_1^2 ... +-beta_n^2) for lines of 3 or more joints.",
        right="Signs are enough if all phases are 0 or 90 deg: planar lines with forks in line or "
        "crossed, or forks that make up for the planes. Else, to first order, "
        "beta_E^2 = |sum of beta_k^2 exp(2 i gamma_k)|.",
        numbers=(
            Comparison("beta_E in deg, twice 12 deg, forks 45 deg off, sign -", 0.0, 14.2705),
            Comparison("beta_E in deg, twice 12 deg, forks 45 deg off, sign +", 16.970563, 14.2705),
        ),
    ),
    Erratum(
        key="dresig-start",
        source=DRESIG,
        place="(13)",
        kind="scope",
        printed="Both masses at rest when the force changes its sign.",
        right="A contact that unloads along the ramp separates with the relative speed "
        "(F_0/t_0)/c. The peak is then lower, and below tau = 1.8386 there is none.",
        numbers=(Comparison("F_12max of the example in N", 2181.89, 1833.27),),
    ),
    Erratum(
        key="dresig-products",
        source=DRESIG,
        place="(15), (24)",
        kind="scan",
        printed="Upright ms and cs, like units.",
        right="The products m s and c s.",
        numbers=(Comparison("t_1 of the example in ms", None, 1.81712),),
    ),
    Erratum(
        key="dresig-16",
        source=DRESIG,
        place="(16)",
        kind="scan",
        printed="v_1 = cbrt(18 s^2 F_0/m * 6 s/t_0) = 6 s/t_1.",
        right="v_1 = cbrt(18 s^2 F_0 / (m t_0)) = 6 s / t_1.",
        numbers=(Comparison("v_1 of the example in m/s", 0.0110521, 0.165096),),
    ),
    Erratum(
        key="dresig-masses",
        source=DRESIG,
        place="(18), (19)",
        kind="scan",
        printed="m_1 and m_2.",
        right="m_11 and m_22, as in (12) and (17).",
    ),
    Erratum(
        key="dresig-time",
        source=DRESIG,
        place="(24), (26)",
        kind="scan",
        printed="omega t / tau, with the time t from the reversal.",
        right="omega (t - t_1) / tau, with the time from the impact. With t the force would jump "
        "at the impact, against (25).",
        numbers=(Comparison("F_12 of the example at the impact in N", 654.163, 0.0),),
    ),
    Erratum(
        key="dresig-tilde",
        source=DRESIG,
        place="(25)",
        kind="scan",
        printed="Initial conditions of stage 2 for t = t - t_1 = 0.",
        right="For t~ = t - t_1 = 0: the tilde, which (26) and (27) keep, is lost.",
    ),
    Erratum(
        key="dresig-28",
        source=DRESIG,
        place="before (28)",
        kind="wrong",
        printed="arccos x = pi/2 - x for x near pi/2.",
        right="For x near 0. No x near pi/2 has an arc cosine.",
        numbers=(
            Comparison("arccos 0.1", 1.470796, 1.470629),
            Comparison("arccos 1, the nearest to pi/2 that exists", 0.570796, 0.0),
        ),
    ),
    Erratum(
        key="dresig-branch",
        source=DRESIG,
        place="(33), (36)",
        kind="wrong",
        printed="f = 6/tau + 12/tau^2 + 12/tau^3 arccos((4 - 2 tau^3 - 2 tau^2) / (4 + tau^4)).",
        right="f = 6/tau + 12/tau^2 + 24/tau^3 atan2(tau, tau - 2). The arc cosine takes the wrong "
        "branch for tau < 2, where the sine (27c) is negative; (27b) and (27c) together are right.",
        numbers=(
            Comparison("f(0.5)", 121.776, 601.410),
            Comparison("f(1)", 36.8496, 74.5487),
            Comparison("f(1.5)", 18.2154, 22.7914),
        ),
    ),
    Erratum(
        key="dresig-29",
        source=DRESIG,
        place="(29)",
        kind="scope",
        printed="Approximation of F_12max without a range.",
        right="8.0 % too small at tau = 2, 1.2 % at 3.03, 0.1 % at 5, and of no use below 2.",
        numbers=(
            Comparison("f(1)", 36.8496, 74.5487),
            Comparison("f(2)", 9.85620, 10.7124),
            Comparison("f(5)", 1.87597, 1.87783),
        ),
    ),
    Erratum(
        key="dresig-mass",
        source=DRESIG,
        place="section 3, after (36)",
        kind="scope",
        printed="The speed has the greatest influence, the mass the smallest.",
        right="So it is for tau (31). For the peak force c s f(tau), the stiffness counts least: "
        "in the example the peak grows like the speed to the power 1.91, k_1 to 0.64, the play to "
        "0.36, the mass to 0.32 and the stiffness to 0.045.",
        numbers=(
            Comparison("exponent of the mass, of tau and of the peak", -0.1666667, 0.318236),
            Comparison("exponent of the stiffness, of tau and of the peak", 0.5, 0.0452916),
        ),
    ),
)


def errata(source: str | None = None) -> tuple[Erratum, ...]:
    """Errors found in the sources, or in one of them.

    Args:
        source: name of a source as it stands in the table, or None for all.

    Returns:
        The entries, in the order of the sources.

    Raises:
        ValueError: no entry has this source.

    Source:
        `ERRATA`.

    >>> [erratum.place for erratum in errata("Grossmann 1939")]
    ['(8), second form']
    """
    if source is None:
        return ERRATA
    matching = tuple(erratum for erratum in ERRATA if erratum.source == source)
    if not matching:
        names = ", ".join(repr(name) for name in dict.fromkeys(e.source for e in ERRATA))
        raise ValueError(f"source = {source!r} is not one of {names}")
    return matching


def as_markdown() -> str:
    """The errata as the page of the documentation.

    Returns:
        Text in Markdown.

    Source:
        `ERRATA`.
    """
    lines = [
        "# Errata of the sources",
        "",
        "Errors found while the formulas were derived anew. The kinds: *wrong*, as printed it",
        "gives a wrong value; *scan*, introduced by the scanning of the copy in circulation, or",
        "not to be told from that; *scope*, right, but only under a condition that is not stated.",
        "The same table is `analytic.errata.ERRATA`.",
    ]
    for source in dict.fromkeys(erratum.source for erratum in ERRATA):
        lines += ["", f"## {source}"]
        for erratum in errata(source):
            lines += [
                "",
                f"### {erratum.place} ({erratum.key})",
                "",
                f"- Kind: {erratum.kind}",
                f"- Printed: {erratum.printed}",
                f"- Right: {erratum.right}",
            ]
            if erratum.numbers:
                lines += ["", "| number | printed | right |", "|---|---|---|"]
            for number in erratum.numbers:
                printed = "none" if number.printed is None else f"{number.printed:g}"
                # A vertical bar within a cell would end this cell of the table.
                what = number.what.replace("|", "\\|")
                lines.append(f"| {what} | {printed} | {number.right:.6g} |")
    return "\n".join(lines) + "\n"
