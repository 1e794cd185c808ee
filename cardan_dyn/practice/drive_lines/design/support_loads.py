"""Support loads: forces of all bearings of a line of any number of joints, in closed form.

Crosses and shafts without mass pass on moments alone at the joints: joint k with the torque T_k of
its input shaft, the angle theta_k of its input pin from the bending plane and W = exp(2 i theta)

    M_k = T_k [x + tan(beta_k)/2 ((1 - Re W) y - Im W z)],
    T_(k+1) = T_k |1 - kappa W|² / (1 - kappa²)

with x along the input shaft, y in the bending plane and z normal to it. Statics of the shafts then
gives the forces of bearings as fixed sums of these moments: neither the position nor the fork
phases are in their factors. So designs × positions are one product of arrays.

Joints of constant velocity pass on T [x + tan(beta/2) y], and T as it is. The force of a centring
acts between the shafts beside its piece.

Source:
    Thoma 1920 (6), (7) for the moments; statics of the shafts. For two joints the result is that of
    `analytic.support_forces`.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ....kit.arrays import NOTHING, Array
from ....kit.errors import ArgumentError, ModelError, choices
from ..line.data import LineData
from ..line.geometry import centring_places
from ..line.supports import Support, spline_distance, supports


class SupportLoads(NamedTuple):
    """Forces of bearings per moment of joints.

    Attributes:
        names: of the bearings.
        shafts: `(b,)` indices of their shafts.
        axes: `(b, 3, 2)` two world axes across each of these shafts.
        factors: `(b, 2, n, 3)` force that bearing b exerts on its shaft along these axes per moment
            of joint k along x, y, z of its bend [1/m].
        betas: `(n,)` joint angles [rad].
        even: `(n,)` which joints are those of constant velocity.
    """

    names: tuple[str, ...]
    shafts: Array
    axes: Array
    factors: Array
    betas: Array
    even: Array

    def forces(self, phases: Array, rotation: Array, torque: float = 1.0) -> Array:
        """Return the forces of the bearings on their shafts in world axes `(..., b, 3)` [N].

        Args:
            phases: `(..., n)` fork phases [rad].
            rotation: `(...)` of the line, as in `analytic.drive_line`, broadcast against phases
                without their last axis [rad].
            torque: of the input shaft [N·m].
        """
        return np.einsum("bxa,...ba->...bx", self.axes, torque * self._across(phases, rotation))

    def squares(self, phases: Array, rotation: Array) -> Array:
        """Return the squares of the forces per torque of the input shaft `(..., b)` [1/m²]."""
        return np.asarray(np.sum(self._across(phases, rotation) ** 2, axis=-1))

    def _across(self, phases: Array, rotation: Array) -> Array:
        found = moments(self.betas, phases, rotation, self.even)
        flat = (
            found.reshape(*found.shape[:-2], -1) @ self.factors.reshape(-1, self.betas.size * 3).T
        )
        return np.asarray(flat.reshape(*found.shape[:-2], len(self.names), 2))


def moments(
    betas: Array, phases: Array, rotation: Array, even: Sequence[bool] | Array = ()
) -> Array:
    """Return the moments of joints per torque of the input shaft `(..., n, 3)`.

    Each is that of a shaft on the next: along x of the shaft, y in the bending plane, z normal to
    it.

    Args:
        betas: `(n,)` joint angles [rad].
        phases: `(..., n)` fork phases [rad].
        rotation: `(...)` of the line, broadcast against phases without their last axis [rad].
        even: `(n,)` which joints are those of constant velocity; none unless given.
    """
    shape = np.broadcast_shapes(phases.shape[:-1], np.shape(rotation))
    result = np.empty((*shape, len(betas), 3))
    pins = np.exp(2j * np.asarray(phases))
    torque, lead = np.ones(shape), np.exp(2j * np.asarray(rotation))
    for k, beta in enumerate(betas):
        if len(even) and even[k]:
            # Along the normal of the plane that halves the angle between both shafts.
            result[..., k, :] = torque[..., None] * [1.0, np.tan(beta / 2.0), 0.0]
            continue
        kappa = np.tan(beta / 2.0) ** 2
        # `lead` is the rotation of the shaft behind the joint, `pin` that of its pin.
        pin = lead * pins[..., k]
        bend = torque * (np.tan(beta) / 2.0)
        result[..., k, 0] = torque
        result[..., k, 1] = bend * (1.0 - pin.real)
        result[..., k, 2] = -bend * pin.imag
        below = 1.0 - kappa * pin
        torque = torque * (below.real**2 + below.imag**2) / (1.0 - kappa**2)
        lead = lead * (np.conj(below) / below)
    return result


def support_loads(line: LineData, chosen: Sequence[str] | None = None) -> SupportLoads:
    """Return the forces of bearings of a line.

    Args:
        line: the line.
        chosen: names of the bearings; all unless given.

    Raises:
        ArgumentError: no bearing is chosen.
        ModelError: the line is not held, has no bearings or none of a name, or statics leaves a
            force open.
    """
    bearings = supports(line).bearings
    if not bearings:
        raise ModelError("the line has no bearings whose forces could be told; give bearings")
    unknowns = _unknowns(line, bearings)
    balance, applied = _balances(line, bearings, unknowns)
    inverse = np.linalg.pinv(balance)
    solved = -inverse @ applied
    size = max(float(np.max(np.abs(solved))), 1.0)
    if np.max(np.abs(balance @ solved + applied)) > NOTHING * size:
        raise ModelError("the bearings cannot hold the line in balance; give it more bearings")
    left_open = np.eye(len(inverse)) - inverse @ balance
    axes = np.stack([line.geometry.frames[item.shaft][:, 1:] for item in bearings])
    factors = np.empty((len(bearings), 2, line.count, 3))
    for row, item in enumerate(bearings):
        start = unknowns["bearing", row].start
        columns = slice(start, start + 2)
        if np.max(np.abs(left_open[columns])) > NOTHING:
            raise ModelError(
                f"statics leaves the force of bearing {item.name} open: "
                f"{'; '.join(supports(line).indeterminate) or 'too many bearings'}; leave out one"
            )
        factors[row] = solved[columns].reshape(2, line.count, 3)
    every = [item.name for item in bearings]
    names = every if chosen is None else [chosen] if isinstance(chosen, str) else [*chosen]
    for name in names:
        if name not in every:
            raise ModelError(
                f"the line has no bearing {name!r}; bearings: {choices(every, name)}",
                name=name if isinstance(name, str) else None,
            )
    if not names:
        raise ArgumentError("bearings is empty; name the bearings whose forces count")
    rows = [every.index(name) for name in names]
    shafts = np.array([bearings[row].shaft for row in rows])
    return SupportLoads(
        tuple(names), shafts, axes[rows], factors[rows], line.joint_angles, line.even
    )


def _unknowns(line: LineData, bearings: Sequence[Support]) -> dict[tuple[str, int], slice]:
    """Return the columns of unknowns, by what they are and its number.

    Forces of joints k in world axes, of shaft k - 1 on shaft k; of bearings along y, z and, if
    locating, x; at end shafts without bearings forces and bending; across what centrings slide on.
    """
    sizes = {("joint", k): 3 for k in range(1, line.count + 1)}
    sizes |= {("bearing", row): 2 + item.locating for row, item in enumerate(bearings)}
    sizes |= {("end", k): 5 for k in (0, line.count) if not line.shafts[k].bearings}
    sizes |= {("centring", k): 2 for k in line.centred}
    ends = itertools.accumulate(sizes.values())
    return {
        key: slice(end - size, end) for (key, size), end in zip(sizes.items(), ends, strict=True)
    }


def _balances(
    line: LineData, bearings: Sequence[Support], unknowns: dict[tuple[str, int], slice]
) -> tuple[Array, Array]:
    """Return what unknowns and moments of joints `(3 n,)` contribute to the balances of shafts."""
    rows, applied = [], []
    count = max(columns.stop for columns in unknowns.values())
    # The torques balance by the motion of the joints.
    keep = [0, 1, 2, 4, 5]
    for index in range(line.count + 1):
        matrix, known = np.zeros((6, count)), np.zeros((6, 3 * line.count))
        behind = np.zeros(count)
        frame, origin = line.geometry.frames[index], line.geometry.centres[max(index - 1, 0)]
        has_spline, cut = line.shafts[index].spline is not None, 0.0
        if has_spline:
            cut = spline_distance(line, index)
        for number, sense in ((index, 1.0), (index + 1, -1.0)):
            if 1 <= number <= line.count:
                arm = frame.T @ (line.geometry.centres[number - 1] - origin)
                columns = unknowns["joint", number]
                force = sense * frame.T
                matrix[:3, columns] = force
                matrix[3:, columns] = np.cross(arm, force, axisb=0, axisc=0)
                known[3:, columns] = sense * frame.T @ _bend_axes(line, number)
                if has_spline and arm[0] > cut:
                    behind[columns] = force[0]
        for row, item in enumerate(bearings):
            if item.shaft == index:
                arm = np.array([item.along, 0.0, 0.0])
                places = range(count)[unknowns["bearing", row]]
                for column, axis in zip(places, (1, 2, 0), strict=False):
                    matrix[axis, column] = 1.0
                    matrix[3:, column] = np.cross(arm, np.eye(3)[axis])
                    if item.behind and axis == 0:
                        behind[column] = 1.0
        for piece in line.centred:
            if index not in (piece - 1, piece + 1):
                continue
            columns, axes = unknowns["centring", piece], _centring_axes(line, piece)
            place = centring_places(line.shafts, line.geometry, piece)[0]
            point = line.geometry.centres[piece - 1] + place * line.geometry.directions[piece - 1]
            force = (1.0 if index > piece else -1.0) * frame.T @ axes
            matrix[:3, columns] = force
            matrix[3:, columns] = np.cross(frame.T @ (point - origin), force, axisb=0, axisc=0)
            if has_spline and index < piece:
                behind[columns] = force[0]
        if ("end", index) in unknowns:
            matrix[keep, unknowns["end", index]] = np.eye(5)
        rows.append(matrix[keep])
        applied.append(known[keep])
        if has_spline:
            rows.append(behind[None])
            applied.append(np.zeros((1, 3 * line.count)))
    return np.concatenate(rows), np.concatenate(applied)


def _centring_axes(line: LineData, piece: int) -> Array:
    """Return the world axes `(3, 2)` of the force of a centring on the shaft behind its piece.

    It acts across the piece if a disc passes it on, across the shaft that it slides along if a ball
    does.
    """
    kind, slides = line.shafts[piece].centring, piece
    if kind is not None and kind.kind == "ball":
        slides = piece - 1 if kind.fixed_to == "rear" else piece + 1
    return line.geometry.frames[slides][:, 1:]


def _bend_axes(line: LineData, number: int) -> Array:
    """Return x along the shaft before a joint, y in the bending plane and z, as columns."""
    along, normal = line.geometry.directions[number - 1], line.geometry.frames[number][:, 2]
    return np.stack([along, np.cross(normal, along), normal], axis=1)
