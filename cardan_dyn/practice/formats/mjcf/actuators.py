"""Actuators: what those of a compiled model may exert along joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from ....core.description.description import UNBOUNDED, ActuatorDescription
from ....core.description.elements import GREATEST
from ....kit.arrays import Array


def actuators(
    model: Any, driven: Mapping[int, int], names: Mapping[int, str]
) -> Iterator[ActuatorDescription]:
    """Yield the actuators that act along single joints, see `ActuatorDescription`.

    Args:
        model: `mujoco.MjModel`.
        driven: actuators to the joints along which they act, by their indices.
        names: of the joints with one coordinate that move, by their index.
    """
    for index, joint in driven.items():
        if joint in names:
            is_direct, force = _force(model, index)
            control = UNBOUNDED
            if is_direct and model.actuator_ctrllimited[index]:
                control = ends(model.actuator_ctrlrange[index])
            yield ActuatorDescription(
                model.actuator(index).name,
                names[joint],
                float(model.actuator_gear[index, 0]),
                force,
                control,
                is_direct,
            )


def _force(model: Any, index: int) -> tuple[bool, tuple[float, float]]:
    """Return whether the control is the force, and the least and greatest force.

    The force is a gain times the control, or times an activation that follows it, and a bias. Where
    gain or bias go by position or speed, as those of a servo, only `forcerange` bounds it.
    """
    import mujoco

    gains, biases, dynamics = mujoco.mjtGain, mujoco.mjtBias, mujoco.mjtDyn
    amplifies, kind, bias = (
        int(of[index])
        for of in (model.actuator_gaintype, model.actuator_dyntype, model.actuator_biastype)
    )
    gain, offset = model.actuator_gainprm[index], model.actuator_biasprm[index]
    has_gain = amplifies == gains.mjGAIN_FIXED or (
        amplifies == gains.mjGAIN_AFFINE and not np.any(gain[1:3])
    )
    has_bias = bias == biases.mjBIAS_AFFINE
    is_constant = has_gain and (
        bias == biases.mjBIAS_NONE or (has_bias and not np.any(offset[1:3]))
    )
    follows = kind in (dynamics.mjDYN_FILTER, dynamics.mjDYN_FILTEREXACT)
    force = control = np.array(UNBOUNDED)
    clamps = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL
    if clamps and model.actuator_ctrllimited[index] and (follows or kind == dynamics.mjDYN_NONE):
        control = np.array(ends(model.actuator_ctrlrange[index]))
        if follows:  # From zero, where an activation starts.
            control = np.array([min(control[0], 0.0), max(control[1], 0.0)])
    if model.actuator_actlimited[index]:
        control = np.clip(control, *ends(model.actuator_actrange[index]))
    if is_constant:
        force = np.sort(gain[0] * control if gain[0] else np.zeros(2)) + offset[0] * has_bias
    if model.actuator_forcelimited[index]:
        force = np.clip(force, *model.actuator_forcerange[index])
    is_direct = is_constant and kind == dynamics.mjDYN_NONE and gain[0] == 1.0
    return is_direct and not (has_bias and offset[0]), ends(force)


def ends(values: Array) -> tuple[float, float]:
    """Return the least and the greatest value of a range, infinite beyond `GREATEST`."""
    infinite = np.copysign(np.inf, values)
    least, greatest = np.where(np.abs(values) > GREATEST, infinite, values).tolist()
    return least, greatest
