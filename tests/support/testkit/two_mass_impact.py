"""The two-mass model of an impact across a clearance, by its equations of motion at 50 digits."""

from __future__ import annotations

import mpmath as mp

EXAMPLE = {"mass": 3.6, "stiffness": 1e7, "half_clearance": 0.5e-4, "ramp": 360e3}
"""The paper's."""
STARTS = ["rest", "release"]


class Motion:
    """Both stages of the two-mass model, each solved by its own differential equation."""

    def __init__(self, mass, stiffness, half_clearance, ramp, start):
        m, c, s, r = (mp.mpf(x) for x in (mass, stiffness, half_clearance, ramp))
        self.omega, self.ramp = mp.sqrt(c / m), r
        v_0 = r / c if start == "release" else mp.mpf(0)

        def play_left(t):
            # m q'' = r t from q = 0, q' = v_0.
            return v_0 * t + r * t**3 / (6 * m) - 2 * s

        upper = mp.cbrt(12 * m * s / r)
        self.t_1 = self.between(play_left, mp.mpf(0), upper)
        self.v_1 = v_0 + r * self.t_1**2 / (2 * m)
        # F'' + omega^2 F = omega^2 r (t_1 + u): ramp plus free oscillation, from F = 0, F' = c v_1.
        conditions = mp.matrix([[1, 0], [0, self.omega]])
        right = mp.matrix([-r * self.t_1, c * self.v_1 - r])
        self.cosine, self.sine = mp.lu_solve(conditions, right)

    def force(self, u):
        free = self.cosine * mp.cos(self.omega * u) + self.sine * mp.sin(self.omega * u)
        return self.ramp * (self.t_1 + u) + free

    def peak(self):
        """Time and force of the first maximum; None if the force never turns back."""

        def slope(u):
            return mp.diff(self.force, u)

        def curvature(u):
            return mp.diff(self.force, u, 2)

        # The slope is a constant plus a sine: it falls to its least value once in a period.
        step = mp.pi / self.omega / 10
        for k in range(1, 41):
            if curvature((k - 1) * step) < 0 <= curvature(k * step):
                flattest = self.between(curvature, (k - 1) * step, k * step)
                if slope(flattest) > 0:
                    return None
                root = self.between(slope, mp.mpf(0), flattest)
                return root, self.force(root)
        raise AssertionError

    @staticmethod
    def between(function, low, high):
        return mp.findroot(function, (low, high), solver="anderson", tol=1e-120, maxsteps=200)
