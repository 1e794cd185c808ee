"""The bundled slider-crank with play in its crank pin, by Lagrange's equations written by hand.

Rod and piston have two freedoms: the piston's place x and the rod's direction psi from the crank
pin to the piston pin. The crank turns at constant speed; pin and bush touch as a spring with a
damper that does not pull. Numbers are read from the text of the description.
"""

from __future__ import annotations

from typing import NamedTuple
from xml.etree import ElementTree

import numpy as np
from scipy.integrate import solve_ivp

from cardan_dyn.core.description.read import bundled_directory


class LooseSliderCrank(NamedTuple):
    """Its data [m, kg, kg m², rad/s, N/m, N s/m]."""

    crank: float
    rod: float
    rod_mass: float
    rod_centre: float
    rod_inertia: float
    piston_mass: float
    speed: float
    play: float
    stiffness: float
    damping: float

    @classmethod
    def bundled(
        cls, speed: float, play: float, stiffness: float, damping: float
    ) -> LooseSliderCrank:
        """Read the numbers of the bundled description."""
        robot = ElementTree.parse(bundled_directory() / "slider_crank.urdf").getroot()

        def number(path: str, attribute: str, index: int = 0) -> float:
            element = robot.find(path)
            assert element is not None
            return float(element.attrib[attribute].split()[index])

        return cls(
            number("joint[@name='crank_pin']/origin", "xyz"),
            number("loop/predecessor/origin", "xyz"),
            number("link[@name='rod']/inertial/mass", "value"),
            number("link[@name='rod']/inertial/origin", "xyz"),
            number("link[@name='rod']/inertial/inertia", "izz"),
            number("link[@name='piston']/inertial/mass", "value"),
            speed,
            play,
            stiffness,
            damping,
        )

    def contact(self, angle: float, y: np.ndarray) -> tuple[float, np.ndarray, np.ndarray]:
        """What the law says [N], the direction of the pin in the bush, and the pin's gradients."""
        x, psi, dx, dpsi = y
        gradient = np.array([[1.0, self.rod * np.sin(psi)], [0.0, -self.rod * np.cos(psi)]])
        pin = np.array([x - self.rod * np.cos(psi), -self.rod * np.sin(psi)])
        bush = self.crank * np.array([np.cos(angle), np.sin(angle)])
        moved = gradient @ [dx, dpsi] - self.speed * self.crank * np.array(
            [-np.sin(angle), np.cos(angle)]
        )
        away = pin - bush
        distance = np.linalg.norm(away)
        away = away / distance
        depth = distance - self.play / 2.0
        return self.stiffness * depth + self.damping * (away @ moved), away, gradient

    def depth(self, angle: float, y: np.ndarray) -> float:
        """How deep the pin is in the wall [m]."""
        pin = np.array([y[0] - self.rod * np.cos(y[1]), -self.rod * np.sin(y[1])])
        bush = self.crank * np.array([np.cos(angle), np.sin(angle)])
        return float(np.linalg.norm(pin - bush) - self.play / 2.0)

    def rates(self, angle: float, y: np.ndarray, presses: bool) -> np.ndarray:
        """Lagrange's equations."""
        psi, dpsi = y[1], y[3]
        arm = self.rod - self.rod_centre
        coupling = self.rod_mass * arm
        mass = np.array(
            [
                [self.piston_mass + self.rod_mass, coupling * np.sin(psi)],
                [coupling * np.sin(psi), self.rod_inertia + self.rod_mass * arm**2],
            ]
        )
        force = np.array([-coupling * np.cos(psi) * dpsi**2, 0.0])
        if presses:
            pressure, away, gradient = self.contact(angle, y)
            force -= pressure * (gradient.T @ away)
        return np.concatenate([y[2:], np.linalg.solve(mass, force)])

    def forces(self, begun: float, y: np.ndarray, times: np.ndarray) -> np.ndarray:
        """Contact forces at times [N], all touches located.

        Args:
            begun: angle of the crank at time 0, when the wall presses.
            y: state then.
            times: ascending, from 0.
        """
        found = np.zeros(len(times))
        time, end, presses = 0.0, times[-1], True

        def angle(at: float) -> float:
            return begun + self.speed * at

        while time < end:
            state = presses

            def leaves(at: float, y: np.ndarray) -> float:
                return float(self.contact(angle(at), y)[0])

            def touches(at: float, y: np.ndarray) -> float:
                return self.depth(angle(at), y)

            event = leaves if state else touches
            event.terminal, event.direction = True, -1 if state else 1  # type: ignore[attr-defined]
            part = solve_ivp(
                lambda at, y, state=state: self.rates(angle(at), y, state),
                (time, end),
                y,
                method="DOP853",
                rtol=1e-12,
                atol=1e-15,
                events=event,
                dense_output=True,
                max_step=2e-5,
            )
            inside = (times >= time) & (times <= part.t[-1])
            if state:
                rows = part.sol(times[inside]).T
                found[inside] = [
                    self.contact(angle(at), row)[0]
                    for at, row in zip(times[inside].tolist(), rows, strict=True)
                ]
            time, y, presses = float(part.t[-1]), part.y[:, -1], not presses
        return found
