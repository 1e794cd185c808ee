"""Compiled: a text of MJCF as MuJoCo's own parser and compiler understand it."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ....core.description.elements import (
    at_point,
    file_text,
    rotation_of_quaternion,
    unique,
    xml_root,
)
from ....kit.arrays import Array
from ....kit.errors import MissingExtraError, ModelError

_RUNNING = "Time = "
"""Part of warnings about MuJoCo's own solvers, of which nothing is asked here."""


class MeshGeom(NamedTuple):
    """A geom that shows a mesh and gives no mass, which stands as a ball in the compiled model.

    Attributes:
        file: of the mesh, as the text names it; empty where the text has the vertices.
        scale: `(3,)` along its axes.
        reference: `(4, 4)` placement of what counts as its origin, in the scaled mesh.
    """

    file: str
    scale: Array
    reference: Array


class Compiled(NamedTuple):
    """A model that MuJoCo has compiled.

    Attributes:
        model: `mujoco.MjModel`; what moves without a mass has the least that MuJoCo accepts.
        spec: `mujoco.MjSpec` of which it was made.
        links: per body the names of its links: one before each of its joints but the first, and
            that of the body itself.
        joints: per body the names of its joints, or of what fixes it where it has none.
        locked: joint (index) to the position [rad or m] at which an equality holds it.
        meshes: geom (index) to what it shows.
        warnings: what MuJoCo said.
        states_gravity: whether the text, or a file that it includes, says what gravity is.
    """

    model: Any
    spec: Any
    links: list[list[str]]
    joints: list[list[str]]
    locked: dict[int, float]
    meshes: dict[int, MeshGeom]
    warnings: list[str]
    states_gravity: bool


def compiled(text: str, path: Path | None, where: str, shown: bool = False) -> Compiled:
    """Return a model as MuJoCo compiles it, without meshes that give no mass.

    Args:
        text: of the main file.
        path: the file, beside which included ones and meshes are found; None for text.
        where: how messages name it.
        shown: whether the model is made for what is shown: no mesh gives a mass.

    Raises:
        MissingExtraError: MuJoCo is not installed.
        ModelError: MuJoCo refuses the text, or an included file cannot be read.
    """
    try:
        import mujoco
    except ImportError as error:
        raise MissingExtraError(
            f'{where}: MJCF is read by MuJoCo: pip install "cardan-dyn[mjcf]"'
        ) from error
    least = float(np.nextafter(mujoco.mjMINVAL, 1.0))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        try:
            included = dict(_included(text, path, where))
            spec = mujoco.MjSpec.from_string(text, include=included)
            if path is not None:
                spec.modelfiledir = str(path.parent)
            _check_masses(spec, least, where)
            settings = spec.compiler
            settings.fusestatic = settings.discardvisual = False
            settings.boundmass = max(settings.boundmass, least)
            settings.boundinertia = max(settings.boundinertia, least)
            meshes = list(_without_meshes(spec, shown))
            model = spec.compile()
        except (ValueError, TypeError, UnicodeDecodeError) as error:
            raise ModelError(f"{where}: MuJoCo: {' '.join(str(error).split())}") from error
    _switch_off(model)
    return Compiled(
        *(model, spec, *_names(model), dict(_locked(model))),
        {geom.id: shape for geom, shape in meshes},
        [f"{where}: MuJoCo: {item.message}" for item in said if _RUNNING not in str(item.message)],
        any(
            option.get("gravity") is not None
            for part in (text, *(content.decode() for content in included.values()))
            for option in xml_root(part, where)[0].iter("option")
        ),
    )


def _included(text: str, path: Path | None, where: str) -> Iterator[tuple[str, bytes]]:
    """Yield included files, and those that they include, in the encoding that MuJoCo reads."""
    main = None if path is None else path.parent
    waiting, seen = [(text, main)], set()
    while waiting:
        content, folder = waiting.pop()
        root = xml_root(content, where)[0]
        # MuJoCo would accept it, and write a log beside the caller.
        if any(
            "nan" in value.lower().split() for it in root.iter() for value in it.attrib.values()
        ):
            raise ModelError(f"{where}: a number is not finite: nan")
        for element in root.iter("include"):
            name = element.get("file", "")
            at = f"{where}: <include file={name!r}>"
            if main is None or folder is None:
                raise ModelError(
                    f"{at}: text has no directory to find it in; load the file by its path"
                )
            if not name or name in seen:
                continue  # MuJoCo says so.
            seen.add(name)
            try:
                # As in MuJoCo, beside the main file, or else beside the including one.
                file = next((it for it in (main / name, folder / name) if it.is_file()), None)
            except (OSError, ValueError):  # A name that is too long, or has a null character.
                file = None
            if file is None:
                raise ModelError(f"{at}: there is no file {str(main / name)!r}")
            part = xml_root(file_text(file, at).strip(), at)[1]
            yield name, part.encode()
            waiting.append((part, file.parent))


def _check_masses(spec: Any, least: float, where: str) -> None:
    """Refuse masses that are stated and that no body has, before they become the least ones."""
    for body in spec.bodies:
        moments = [*body.inertia, *np.nan_to_num(body.fullinertia)[:3]]
        is_none = body.mass == 0.0 and not np.any(moments)
        if body.explicitinertial and not is_none and (body.mass < least or min(moments) < 0.0):
            raise ModelError(
                f"{where}: body {body.name!r}: no body has the mass {body.mass:g} kg and moments "
                f"of inertia {max(moments, key=abs):g} kg·m²; the least mass that MuJoCo knows is "
                f"{least:g} kg, a massless body has neither"
            )


def _without_meshes(spec: Any, shown: bool) -> Iterator[tuple[Any, MeshGeom]]:
    """Put balls without mass where meshes give none, and yield what they showed.

    Nothing else is asked of them, and their files need not exist.
    """
    import mujoco

    always = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    never = mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_FALSE
    assets = {mesh.name: mesh for mesh in spec.meshes}
    weighed = spec.compiler.inertiafromgeom
    first, last = spec.compiler.inertiagrouprange
    kept = set()
    for geom in spec.geoms:
        asset = assets.get(geom.meshname)
        if asset is None:
            continue
        has_mass = geom.mass > 0.0 if np.isfinite(geom.mass) else geom.density > 0.0
        is_asked = weighed == always or (weighed != never and not geom.parent.explicitinertial)
        is_asked &= geom.parent.name != "world"  # It never moves.
        if not shown and has_mass and is_asked and first <= geom.group <= last:
            kept.add(asset.name)
            continue
        reference = placement(asset.refpos, asset.refquat)
        yield geom, MeshGeom(asset.file, np.array(asset.scale), reference)
        geom.meshname, geom.type, geom.mass = "", mujoco.mjtGeom.mjGEOM_SPHERE, 0.0
        geom.size = [1.0, 0.0, 0.0]
    for name, asset in assets.items():
        if name not in kept:
            spec.delete(asset)


def _names(model: Any) -> tuple[list[list[str]], list[list[str]]]:
    """Return names of links and joints, see `Compiled`; what has none gets one."""
    bodies = [model.body(index).name for index in range(model.nbody)]
    joints = [model.joint(index).name for index in range(model.njnt)]
    of_links, of_joints = {*bodies}, {*joints}
    links, carrying = [], []
    for body, given in enumerate(bodies):
        own = given or unique(f"body_{body}", of_links)
        count, start = model.body_jntnum[body], model.body_jntadr[body]
        between = [unique(f"{own}_{index}", of_links) for index in range(1, count)]
        links.append([*between, own])
        carrying.append(
            [joints[k] or unique(f"joint_{k + 1}", of_joints) for k in range(start, start + count)]
            or ([unique(f"{own}_fixed", of_joints)] if body else [])
        )
    return links, carrying


def _switch_off(model: Any) -> None:
    """Take away what the file's flags switch off."""
    import mujoco

    bits, flags = mujoco.mjtDisableBit, model.opt.disableflags
    every = flags & bits.mjDSBL_CONSTRAINT
    for is_off, *arrays in (
        (flags & bits.mjDSBL_GRAVITY, model.opt.gravity),
        (every or flags & bits.mjDSBL_EQUALITY, model.eq_active0),
        (every or flags & bits.mjDSBL_FRICTIONLOSS, model.dof_frictionloss),
        (every or flags & bits.mjDSBL_FRICTIONLOSS, model.tendon_frictionloss),
        (flags & bits.mjDSBL_SPRING, model.jnt_stiffness, model.jnt_stiffnesspoly),
        (flags & bits.mjDSBL_SPRING, model.tendon_stiffness, model.tendon_stiffnesspoly),
        (flags & bits.mjDSBL_DAMPER, model.dof_damping, model.dof_dampingpoly),
        (flags & bits.mjDSBL_DAMPER, model.tendon_damping, model.tendon_dampingpoly),
    ):
        for array in arrays if is_off else ():
            array[:] = 0


def _locked(model: Any) -> Iterator[tuple[int, float]]:
    """Yield joints that an active equality of one joint holds, and where."""
    import mujoco

    for index in np.flatnonzero(model.eq_type == mujoco.mjtEq.mjEQ_JOINT):
        if model.eq_active0[index] and model.eq_obj2id[index] < 0:
            yield int(model.eq_obj1id[index]), float(model.eq_data[index][0])


def placement(position: Array, quaternion: Array) -> Array:
    """Return the `(4, 4)` placement of a position and a quaternion w x y z."""
    result = at_point(position)
    result[:3, :3] = rotation_of_quaternion(quaternion, "quaternion")
    return result
