"""The universal joint at more than 50 digits, from the geometry of its cross alone.

Both pins are vectors that turn with their shafts; the output rotation is the one at which
they are orthogonal, the moment is the vector normal to both, and derivatives are taken
numerically. None of the closed forms under test is used.
"""

import mpmath as mp
import numpy as np

# Leads of 1e-32 rad at rotations of 1e7 rad and second differences still leave 50 digits.
mp.mp.dps = 150

# Smaller than any reference that is not zero, greater than the noise of differentiation.
NOTHING = mp.mpf(10) ** -80

ULP = 2.0**-52


def cross(a, b):
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a, b):
    return sum(x * y for x, y in zip(a, b, strict=True))


def norm(a):
    return mp.sqrt(dot(a, a))


def turned(vector, axis, angle):
    """`vector`, which is normal to `axis`, turned about it."""
    side = cross(axis, vector)
    return tuple(v * mp.cos(angle) + s * mp.sin(angle) for v, s in zip(vector, side, strict=True))


class Cross:
    """Both shafts, both pins and the moment's direction at one position."""

    def __init__(self, beta, phi_1):
        self.beta, self.phi_1 = mp.mpf(beta), mp.mpf(phi_1)
        self.e_1 = (mp.mpf(1), mp.mpf(0), mp.mpf(0))
        self.e_2 = (mp.cos(self.beta), mp.sin(self.beta), mp.mpf(0))
        self.e_x = (mp.sin(self.beta), -mp.cos(self.beta), mp.mpf(0))
        self.e_z = (mp.mpf(0), mp.mpf(0), mp.mpf(-1))
        self.phi_2 = self.output(self.phi_1)
        self.pin_1, self.pin_2 = self.input_pin(self.phi_1), self.output_pin(self.phi_2)
        self.normal = cross(self.pin_1, self.pin_2)

    def input_pin(self, phi_1):
        return turned((mp.mpf(0), mp.mpf(1), mp.mpf(0)), self.e_1, phi_1)

    def output_pin(self, phi_2):
        return turned((mp.mpf(0), mp.mpf(0), mp.mpf(1)), self.e_2, phi_2)

    def output(self, phi_1):
        """phi_2 with both pins orthogonal, less than a quarter turn from phi_1."""
        pin = self.input_pin(phi_1)
        start, quarter = dot(pin, self.output_pin(0)), dot(pin, self.output_pin(mp.pi / 2))
        root = mp.atan2(start, -quarter)
        return root + mp.pi * mp.nint((phi_1 - root) / mp.pi)

    def speed_ratio(self):
        return mp.diff(self.output, self.phi_1)

    def acceleration_ratio(self):
        return mp.diff(self.output, self.phi_1, 2)

    def moment_per_input_torque(self):
        return tuple(n / dot(self.normal, self.e_1) for n in self.normal)

    def moment_per_output_torque(self):
        return tuple(n / dot(self.normal, self.e_2) for n in self.normal)

    def swing_angles(self):
        psi_1 = mp.atan2(dot(self.normal, cross(self.pin_1, self.e_1)), dot(self.normal, self.e_1))
        psi_2 = mp.atan2(dot(self.normal, cross(self.e_2, self.pin_2)), dot(self.normal, self.e_2))
        return psi_1, psi_2


def relative_errors(values, references):
    """Relative errors of floats against 50 digits; a reference of zero asks for zero."""
    values = np.ravel(np.asarray(values, dtype=float))
    assert len(values) == len(references)
    errors = []
    for value, reference in zip(values, references, strict=True):
        difference = abs(mp.mpf(float(value)) - reference)
        if abs(reference) > NOTHING:
            errors.append(float(difference / abs(reference)))
        else:
            errors.append(float(difference > NOTHING))
    return np.array(errors)


TO_60 = np.radians([0.0, 1e-9, 1e-4, 0.5, 1.0, 8.5, 20.0, 30.0, 45.0, 50.0, 60.0])
NEAR_90 = np.radians([89.0, 89.99, 89.999])


def special_rotations():
    """Multiples of 90 degrees, tiny angles and their neighbours, and a million turns."""
    quarters = np.arange(-4, 6) * (np.pi / 2)
    far = (4_000_000 + np.arange(4)) * (np.pi / 2)
    tiny = np.array([1e-9, -1e-9, 1e-30])
    return np.concatenate([quarters, quarters[:4] + 1e-9, far, -far[:2] + 0.7, tiny])


def grid(betas, seed):
    """Pairs (beta, phi_1): every beta at the special rotations and at random ones."""
    rng = np.random.default_rng(seed)
    pairs = [(beta, phi) for beta in betas for phi in special_rotations()]
    for span in (7.0, 6.3e6):
        pairs += [(beta, phi) for beta in betas for phi in rng.uniform(-span, span, 12)]
    return np.array(pairs).T
