"""Torsional vibration of lines with universal joints, written down by hand.

The drive turns at constant speed, φ is its rotation, dashes are derivatives by it. A joint with the
angle β whose input pin lies in the plane of the shafts at zero turns its output by
φ₂ = θ + atan(κ sin 2θ / (1 - κ cos 2θ)), κ = tan²(β/2), with the ratio η = cos β / D and
D = cos²β cos²θ + sin²θ; η_θ = -cos β sin²β sin 2θ / D². With the pin normal to the plane φ₂ is the
inverse function, which is φ₂ counted from a quarter turn away.

Systems as `shooting` takes them. Nothing here knows the package under test.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Ratio:
    """Rotation behind a joint, the ratio η and its derivatives by the rotation in front."""

    rotation: Array
    first: Array
    second: Array


def joint(beta: float, rotation: Array, *, normal: bool = False) -> Ratio:
    theta = rotation + (np.pi / 2.0 if normal else 0.0)
    kappa = np.tan(beta / 2.0) ** 2
    lead = np.arctan(kappa * np.sin(2.0 * theta) / (1.0 - kappa * np.cos(2.0 * theta)))
    cosine, sine = np.cos(beta), np.sin(beta)
    nominal = (cosine * np.cos(theta)) ** 2 + np.sin(theta) ** 2
    second = -cosine * sine**2 * np.sin(2.0 * theta) / nominal**2
    return Ratio(rotation + lead, cosine / nominal, second)


@dataclass(frozen=True)
class SpringInFront:
    """(J₁ + J₂ η²) θ'' + J₂ η η_θ θ'² + k (θ - φ) + d (θ' - 1) = 0 for q = θ - φ.

    Attributes:
        beta: joint angle [rad].
        speed: r = Ω/ω_n with ω_n² = k / (J₁ + J₂).
        share: a = J₂ / (J₁ + J₂).
        damping_ratio: ζ = d / (2 √(k (J₁ + J₂))).
    """

    beta: float
    speed: float
    share: float = 0.5
    damping_ratio: float = 0.0

    def __call__(self, phi: float, q: Array, rate: Array) -> Array:
        at = joint(self.beta, phi + q)
        inertia = 1.0 - self.share + self.share * at.first**2
        forces = (
            self.share * at.first * at.second * (1.0 + rate) ** 2
            + q / self.speed**2
            + 2.0 * self.damping_ratio / self.speed * rate
        )
        return -forces / inertia


@dataclass(frozen=True)
class SpringBehind:
    """J₂ (φ₂ + q)'' + k q + d q' = 0: linear, since the drive decides φ₂."""

    beta: float
    speed: float
    damping_ratio: float = 0.0

    def __call__(self, phi: float, q: Array, rate: Array) -> Array:
        damping = 2.0 * self.damping_ratio / self.speed
        return -joint(self.beta, np.asarray(phi)).second - q / self.speed**2 - damping * rate


@dataclass(frozen=True)
class SpringsOnBothSides:
    """Twists q_1 = θ - φ in front of the joint and q_2 = χ - φ₂(θ) behind it, χ the flywheel's.

    (J₁ + J_f η²) θ'' + J_f η η_θ θ'² = -k₁ q₁ - d₁ q₁' + η (k₂ q₂ + d₂ q₂') and
    J₂ χ'' = -k₂ q₂ - d₂ q₂'.

    Attributes:
        beta: joint angle [rad].
        speed: Ω [rad/s].
        inertias: J₁, J_f of the output fork and J₂ [kg m²].
        stiffness: k₁, k₂ [N m/rad].
        damping: d₁, d₂ [N m s/rad].
    """

    beta: float
    speed: float
    inertias: tuple[float, float, float] = (0.5, 0.0, 0.5)
    stiffness: tuple[float, float] = (1.0, 1.0)
    damping: tuple[float, float] = (0.0, 0.0)

    def __call__(self, phi: float, q: Array, rate: Array) -> Array:
        front, fork, flywheel = self.inertias
        at = joint(self.beta, phi + q[0])
        efforts = [
            (k * x / self.speed + d * v) / self.speed
            for k, d, x, v in zip(self.stiffness, self.damping, q, rate, strict=True)
        ]
        turning = (1.0 + rate[0]) ** 2
        first = (-efforts[0] + at.first * efforts[1] - fork * at.first * at.second * turning) / (
            front + fork * at.first**2
        )
        behind = -efforts[1] / flywheel
        return np.stack([first, behind - at.second * turning - at.first * first])


@dataclass(frozen=True)
class ElasticMiddleShaft:
    """A double joint in phase, for the twist q of its middle shaft.

    Its front end turns by χ = φ₂(φ), its rear end by χ + q, the output by the inverse of φ₂ there,
    with the ratio η: (J_m + J₃ η²) (χ + q)'' + J₃ η η' (χ' + q')² + k q + d q' = 0.

    Attributes:
        beta: angle of both joints [rad].
        speed: r = Ω/ω_n with ω_n² = k / J₃.
        middle: J_m / J₃, inertia at the rear end of the middle shaft.
        damping_ratio: ζ = d / (2 √(k J₃)).
    """

    beta: float
    speed: float
    middle: float = 0.0
    damping_ratio: float = 0.0

    def __call__(self, phi: float, q: Array, rate: Array) -> Array:
        front = joint(self.beta, np.asarray(phi))
        rear = joint(self.beta, front.rotation + q, normal=True)
        forces = (
            rear.first * rear.second * (front.first + rate) ** 2
            + q / self.speed**2
            + 2.0 * self.damping_ratio / self.speed * rate
        )
        return -forces / (self.middle + rear.first**2) - front.second
