"""The proof is one text: with floats, with arrays and traced it finds the same, of any claim."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from compare import scene_of
from scenes import draw
from testkit.ball_rods import as_a_floating_rod, as_balls
from testkit.bundled import EVERY_KIND
from testkit.calls import calls
from testkit.claims import RATES, SCENES, bent, claimed, coupled_wheels, positions, universal
from testkit.compiled_functions import without_kernel
from testkit.linkages import coupling, gears
from testkit.mixed_chain import MIXED, rows

import cardan_dyn as cd
from cardan_dyn.core.description.second_reading import reread
from cardan_dyn.core.elements.link_loads import LinkLoad
from cardan_dyn.core.mechanism.frames import Frames
from cardan_dyn.core.mechanism.kept import MOST
from cardan_dyn.core.proof.constraints import Motion
from cardan_dyn.core.proof.free_bodies import FreeBodies, Setup
from cardan_dyn.core.proof.named_motions import named_motions
from cardan_dyn.core.proof.residuals import BALANCE_TOLERANCE, Claim, Residuals
from cardan_dyn.core.proof.traced import Programs
from cardan_dyn.core.tape import Program
from cardan_dyn.scene.usual_motion import usual_motion

pytestmark = pytest.mark.usefixtures("loaded_once")

ROUNDING = 1e-13
NAMES = Residuals._fields[:9]
FIELDS = (*Claim._fields[:13], "gravity")
"""Arrays of a claim."""
MECHANISMS: dict[str, Callable[[], cd.Mechanism]] = {
    **{name: lambda name=name: cd.load(name) for name in cd.bundled_names()},
    "every kind of joint": lambda: cd.load(MIXED),
    "balls": lambda: cd.load(as_balls()),
    "floating": lambda: cd.load(as_a_floating_rod()),
    "balls by angles": lambda: cd.load(as_balls()).variant(cardan={"b"}),
    "gears": lambda: coupled_wheels().mechanism,
    "teeth": lambda: cd.load(gears(coupling("t", "a", "b", -2.5, 'forces="mesh" helix_angle="1"'))),
    "many drives": lambda: SCENES["arms"]().mechanism,
}


Way = Callable[[FreeBodies, Claim], Residuals]


def sample_of(claim: Claim, sample: int) -> Claim:
    """Return one sample of a claim."""
    span = slice(sample, sample + 1)

    def part(array: np.ndarray) -> np.ndarray:
        return array if len(array) == 1 else array[span]

    return claim._replace(
        **{field: part(getattr(claim, field)) for field in (*FIELDS, "time")},
        link_loads={link: load.of_samples(span) for link, load in claim.link_loads.items()},
        inertia={link: part(factor) for link, factor in claim.inertia.items()},
    )


def as_text(bodies: FreeBodies, claim: Claim) -> Residuals:
    """Return the residuals as the text gives them: as where there is no machine."""
    with without_kernel():
        return bodies.check(claim)


def one_by_one(bodies: FreeBodies, claim: Claim) -> Residuals:
    singles = [sample_of(claim, sample) for sample in range(len(claim.x))]
    return Residuals.joined([as_text(bodies, single) for single in singles])


def traced(bodies: FreeBodies, claim: Claim) -> Residuals:
    """Return what a program gives of them."""
    return bodies.check(claim)


def programs(bodies: FreeBodies) -> list[Program]:
    return [known.program for known in bodies._programs._of_kinds.values()]


def sizes(residuals: Residuals) -> list[np.ndarray]:
    """Return `(N,)` per residual what rounding of it is in proportion to."""
    one = np.ones_like(residuals.wrench)
    wrench = residuals.wrench + residuals.applied + residuals.inertia
    power = residuals.power_scale + wrench * residuals.speed_scale
    error = one + residuals.loop_error, one + residuals.rate_error
    return [wrench, power, *error, wrench, wrench, wrench, power, one + residuals.speed_scale]


def every_way(bodies: FreeBodies, claim: Claim) -> list[Residuals]:
    """Return the residuals with arrays, with floats and traced."""
    return [as_text(bodies, claim), one_by_one(bodies, claim), traced(bodies, claim)]


def assert_same(bodies: FreeBodies, claim: Claim) -> Residuals:
    """Return the residuals with arrays, after the others were found to be the same."""
    expected, *others = every_way(bodies, claim)
    for found in others:
        assert found[9:11] == expected[9:11]
        for name, size in zip(NAMES, sizes(expected), strict=True):
            one, other = getattr(found, name), getattr(expected, name)
            assert one.shape == other.shape
            is_finite = np.isfinite(other)
            assert np.array_equal(np.isfinite(one), is_finite), name
            with np.errstate(all="ignore"):
                apart = np.abs(one - other)[is_finite & np.isfinite(size)]
            allowed = ROUNDING * size[is_finite & np.isfinite(size)] + 1e-300
            assert np.all(apart <= allowed), (name, np.max(apart / allowed))
        assert proven(found) == proven(expected)
    return expected


def proven(residuals: Residuals) -> bool:
    with np.errstate(all="ignore"):
        return residuals.is_proven()


def random_bodies(mechanism: cd.Mechanism, seed: int) -> FreeBodies:
    """Return the proof of a scene with random drives, held, known and claimed joints."""
    rng = np.random.default_rng(seed)
    description, coordinates = reread(mechanism.description), mechanism.coordinates
    frames = Frames(description, coordinates)
    names = rng.permutation(list(named_motions(frames))).tolist()
    drives = rng.integers(1, min(4, len(names) + 1))
    held = names[drives : drives + rng.integers(0, 3)]
    known, joints = np.ones(mechanism.model.nv, dtype=bool), rng.permutation(frames.joints).tolist()
    if seed % 2:
        known = rng.random(len(known)) < 0.9
        joints = joints[: rng.integers(0, len(joints) + 1)]
    motion = Motion(tuple(names[:drives]), tuple(held), known)
    return FreeBodies(description, coordinates, rng.uniform(0.2, 3.0), Setup(motion, joints))


def random_claim(mechanism: cd.Mechanism, bodies: FreeBodies, seed: int, count: int = 5) -> Claim:
    """Return a claim that is false in everything: each of its numbers counts."""
    rng = np.random.default_rng(100 + seed)
    x, nv = rows(mechanism, count, seed), mechanism.model.nv
    for motion in bodies.frames.motions:
        if motion.kind == "turn":  # By more than a right angle, too.
            x[:, motion.column] *= 3.0
    constraints, has_rates = bodies._constraints, seed % 3 > 0
    drives, held = len(constraints.driven), len(constraints.held)
    every = [1, count]

    def some(*shape: int, at: int | None = None) -> np.ndarray:
        return rng.normal(size=(rng.choice(every) if at is None else at, *shape))

    v, a = has_rates * some(2, nv, at=count).transpose(1, 0, 2)
    loads, inertia = {}, {}
    for link, (body, placement) in bodies.frames.links.items():
        if body >= 0 and rng.random() < 0.3:
            force, moment = some(3), some(3)
            rotation, translation = placement[:3, :3], placement[:3, 3]
            in_world, point = bool(rng.random() < 0.5), rng.normal(size=3)
            loads[link] = LinkLoad(body, rotation, translation, force, moment, in_world, point)
        if body >= 0 and rng.random() < 0.2:
            inertia[link] = some(1)[:, 0]
    return Claim(
        x=x,
        turns=rng.integers(-3, 4, x.shape).astype(float),
        v=v,
        a=a,
        positions=some(drives, at=count),
        speeds=some(drives),
        accelerations=some(drives),
        held=some(held),
        velocity_ratios=some(nv, drives, at=count),
        wrenches=some(len(bodies.claimed), 6, at=count),
        exerted=some(nv, at=count),
        couplings=some(len(constraints.every_coupling), at=count),
        loads=some(nv),
        link_loads=loads,
        gravity=some(3) * (seed % 4 > 0),
        inertia=inertia,
        has_rates=has_rates,
    )


def entries(claim: Claim, most: int, seed: int = 0) -> list[tuple[str, tuple[int, ...]]]:
    """Return fields of a claim with indices of some of their numbers, those of a middle sample."""
    rng, found = np.random.default_rng(seed), []
    for field in FIELDS:
        array = getattr(claim, field)
        for index in rng.permutation(array[0].size)[:most]:
            at = np.unravel_index(index, array.shape[1:])
            found.append((field, (len(array) // 2, *map(int, at))))
    return found


@pytest.mark.parametrize(
    "seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 25))]
)
@pytest.mark.parametrize("name", MECHANISMS)
def test_random_claims(name: str, seed: int) -> None:
    """Their residuals are great, so that nothing is lost in rounding."""
    mechanism = MECHANISMS[name]()
    bodies = random_bodies(mechanism, seed)
    claim = random_claim(mechanism, bodies, seed)
    found = assert_same(bodies, claim)
    assert not found.is_proven()
    moved = 0
    for field, index in entries(claim, 1, seed):
        bended = bent(getattr(claim, field), index, 0.3)
        false = assert_same(bodies, claim._replace(**{field: bended}))
        moved += any(np.any(getattr(false, of) != getattr(found, of)) for of in NAMES)
    assert moved


@pytest.mark.parametrize("rates", [{}, RATES], ids=["at rest", "moving"])
@pytest.mark.parametrize("name", SCENES)
def test_any_false_number_raises_the_same_residuals(name: str, rates: dict[str, float]) -> None:
    bodies, claim, _ = claimed(SCENES[name](), positions(SCENES[name]())[:5], **rates)
    right = assert_same(bodies, claim)
    assert right.is_proven()
    raised = set()
    for field, index in entries(claim, 200):
        array = getattr(claim, field)
        false = bodies.check(claim._replace(**{field: bent(array, index, 1e-6)}))
        rises = [
            np.max((getattr(false, of) - getattr(right, of)) / (size + 1e-300))
            for of, size in zip(NAMES[:4], sizes(right)[:4], strict=True)
        ]
        if max(rises) > 1e-9:
            raised.add(field)
            assert max(rises) < 2.0 * BALANCE_TOLERANCE or not false.is_proven()
    zero_at_rest = {"v", "a", "speeds", "accelerations"}
    expected = {field for field in FIELDS if getattr(claim, field).size} - {"turns", "exerted"}
    assert raised >= (expected if rates else expected - zero_at_rest) - (
        set() if claim.loads.any() else {"loads"}
    )


@pytest.mark.parametrize(
    ("name", "speed"), [*((name, 3.0) for name in EVERY_KIND), ("slider_crank", 0.0)]
)
def test_claims_of_bundled_mechanisms(name: str, speed: float) -> None:
    usual = usual_motion(cd.load(name), gravity=(1.0, -2.0, -9.0), samples=5)
    bodies, claim, _ = claimed(usual.scene, usual.positions, speed=speed, acceleration=speed)
    assert assert_same(bodies, claim).is_proven()
    for field, index in entries(claim, 2):
        false = claim._replace(**{field: bent(getattr(claim, field), index, 1e-6)})
        assert_same(bodies, false)


@pytest.mark.parametrize("seed", [0, 3, 7, 8, 9, 11, 13, 15])
def test_claims_of_random_chains(seed: int) -> None:
    case = draw(seed)
    where, speeds = case.positions[:5], case.speeds[:5]
    bodies, claim, _ = claimed(
        scene_of(case), where, speed=speeds, acceleration=case.accelerations[:5]
    )
    assert assert_same(bodies, claim).is_proven()
    for field, index in entries(claim, 2):
        false = claim._replace(**{field: bent(getattr(claim, field), index, 1e-6)})
        assert_same(bodies, false)


@pytest.mark.parametrize("outputs", [[], ["bearing_in"], ["cross_out"]])
def test_claims_that_leave_joints_out(outputs: list[str]) -> None:
    scene = universal(outputs=[name for name in outputs if name in universal().mechanism.joints])
    bodies, claim, _ = claimed(scene, positions(scene)[:5], **RATES)
    assert assert_same(bodies, claim).is_proven()
    for field, index in entries(claim, 5):
        false = claim._replace(**{field: bent(getattr(claim, field), index, 1e-6)})
        assert_same(bodies, false)


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES)
def test_no_claim_with_what_is_not_a_number_is_proven(name: str) -> None:
    bodies, claim, _ = claimed(SCENES[name](), positions(SCENES[name]())[:5], **RATES)
    for field, index in entries(claim, 20):
        if field == "turns" and not claim.couplings.size:
            continue  # Whole turns count where couplings do.
        for value in (np.nan, np.inf):
            array = getattr(claim, field).copy()
            array[index] = value
            false = claim._replace(**{field: array})
            right = field == "turns" and not is_coupled(bodies, index[1])
            verdicts = [proven(found) for found in every_way(bodies, false)]
            assert verdicts == [right] * 3, (field, index)
    for link, load in claim.link_loads.items():
        for part in ("force", "moment"):
            array = np.array(getattr(load, part))
            array[0, 1] = np.nan
            false = claim._replace(link_loads={link: replace(load, **{part: array})})
            assert not any(map(proven, every_way(bodies, false)))


def is_coupled(bodies: FreeBodies, column: int) -> bool:
    return any(column in item.columns for item in bodies._constraints.every_coupling)


@pytest.mark.parametrize("name", ["every kind of joint", "gears", "universal_joint"])
@pytest.mark.parametrize("exponent", [-1000, -600, -340, 340, 500, 600, 1000])
def test_huge_and_tiny_wrenches(name: str, exponent: int) -> None:
    """Squares of which overflow or vanish, at one of the samples."""
    mechanism = MECHANISMS[name]()
    bodies = random_bodies(mechanism, 0)
    claim = random_claim(mechanism, bodies, 0)._replace(link_loads={})
    for names in (("wrenches",), ("wrenches", "loads", "exerted", "couplings", "gravity")):
        for samples in (slice(2, 3), slice(None)):
            changes = {}
            for field in names:
                array = np.array(getattr(claim, field))
                array[samples] = np.ldexp(array[samples], exponent)
                changes[field] = array
            assert_same(bodies, claim._replace(**changes))


def test_a_huge_sample_hides_no_imbalance_of_another_one() -> None:
    mechanism = MECHANISMS["universal_joint"]()
    bodies = random_bodies(mechanism, 0)
    claim = random_claim(mechanism, bodies, 0)
    alone = bodies.check(claim)
    huge = claim.wrenches.copy()
    huge[2] *= 1e250
    at_once = claim._replace(wrenches=huge)
    for beside in (bodies.check(at_once), traced(bodies, at_once)):
        for sample in (0, 1, 3, 4):
            np.testing.assert_allclose(beside.imbalance[sample], alone.imbalance[sample])
            np.testing.assert_allclose(beside.wrench[sample], alone.wrench[sample])


@pytest.mark.parametrize("way", [as_text, traced], ids=["arrays", "traced"])
@pytest.mark.parametrize("count", [2, 3, 4, 5, 8, 9])
@pytest.mark.parametrize("name", ["every kind of joint", "gears", "many drives"])
def test_a_sample_comes_out_alike_wherever_it_stands(name: str, count: int, way: Way) -> None:
    """To the last bit, and however the arrays lie in memory."""
    mechanism = MECHANISMS[name]()
    for seed in range(2):
        bodies = random_bodies(mechanism, seed)
        claim = random_claim(mechanism, bodies, seed, count)
        together = way(bodies, claim)
        arrays = {field: getattr(claim, field) for field in FIELDS}
        spread = {
            field: np.asfortranarray(np.repeat(array, 2, axis=-1))[..., ::2]
            for field, array in arrays.items()
        }
        backwards = {field: array[::-1].copy()[::-1] for field, array in arrays.items()}
        for other in (spread, backwards):
            again = way(bodies, claim._replace(**other))
            for name_, one in zip(NAMES, together, strict=False):
                assert np.array_equal(one, getattr(again, name_)), name_
        singles = [sample_of(claim, sample) for sample in range(count)]
        if way is traced:
            alone = Residuals.joined([way(bodies, single) for single in singles])
            for name_, one in zip(NAMES, together, strict=False):
                assert np.array_equal(one, getattr(alone, name_)), name_


def test_a_program_gives_the_same_where_nothing_is_compiled() -> None:
    mechanism = MECHANISMS["every kind of joint"]()
    bodies = random_bodies(mechanism, 2)
    claim = random_claim(mechanism, bodies, 2)
    found = traced(bodies, claim)
    with without_kernel():
        alone = traced(bodies, claim)
    for one, other in zip(found[:9], alone, strict=False):
        np.testing.assert_allclose(one, other, rtol=1e-13)


SWITCHED: dict[str, Callable[[Claim], dict[str, Any]]] = {
    "loads": lambda claim: {"loads": np.zeros_like(claim.loads)},
    "gravity": lambda claim: {"gravity": np.zeros((1, 3))},
    "rates": lambda claim: {
        "speeds": np.zeros_like(claim.speeds),
        "accelerations": np.zeros_like(claim.accelerations),
        "v": np.zeros_like(claim.v),
        "a": np.zeros_like(claim.a),
        "has_rates": False,
    },
    "accelerations": lambda claim: {"a": 0.0 * claim.a, "accelerations": 0.0 * claim.accelerations},
    "velocity ratios": lambda claim: {"velocity_ratios": np.zeros_like(claim.velocity_ratios)},
    "exerted": lambda claim: {"exerted": np.zeros_like(claim.exerted)},
    "couplings": lambda claim: {"couplings": np.zeros_like(claim.couplings)},
    "load on a link": lambda claim: {
        "link_loads": {
            name: replace(load, force=0.0 * load.force, moment=0.0 * load.moment)
            for name, load in claim.link_loads.items()
        }
    },
    "point of a load": lambda claim: {
        "link_loads": {
            name: replace(load, point=np.zeros(3)) for name, load in claim.link_loads.items()
        }
    },
    "no loads on links": lambda claim: {"link_loads": {}},
    "axes of a load": lambda claim: {
        "link_loads": {
            name: replace(load, in_world=not load.in_world)
            for name, load in claim.link_loads.items()
        }
    },
    "no factors": lambda claim: {"inertia": {}},
}
"""What does not act in some calls, and does in others."""


@pytest.mark.parametrize("what", SWITCHED)
@pytest.mark.parametrize("name", ["gears", "every kind of joint", "many drives"])
def test_what_is_switched_on_between_calls_counts(name: str, what: str) -> None:
    """A program that was traced without it does not hide it: neither once, nor ever after."""
    mechanism = MECHANISMS[name]()
    bodies = random_bodies(mechanism, 0)
    claim = random_claim(mechanism, bodies, 4)
    assert claim.has_rates
    without = claim._replace(**SWITCHED[what](claim))
    for _ in range(2):
        assert_same(bodies, without)
        for count in range(1, 3):  # A few claims, too few for another program.
            some = sample_of(claim, count)
            found, expected = bodies.check(some), as_text(bodies, some)
            for field in NAMES:
                np.testing.assert_allclose(
                    getattr(found, field), getattr(expected, field), rtol=1e-9
                )
        assert_same(bodies, claim)


@pytest.mark.parametrize("field", ["speeds", "accelerations", "held", "loads", "gravity"])
def test_what_was_the_same_for_all_may_differ_from_sample_to_sample(field: str) -> None:
    """And the other way round, from call to call."""
    mechanism = MECHANISMS["gears"]()
    bodies = random_bodies(mechanism, 2)
    claim = random_claim(mechanism, bodies, 4)
    one = getattr(claim, field)[:1]
    spread = one * np.linspace(1.0, 2.0, len(claim.x))[:, None]
    for values in (one, spread, one, spread[:1]):
        assert_same(bodies, claim._replace(**{field: values}))


def test_one_program_serves_all_claims_of_a_kind() -> None:
    """What acts later is taken into the program, which goes on to serve what is without it."""
    bodies, weightless, _ = claimed(universal(), positions(universal())[:5], **RATES)
    weightless = weightless._replace(gravity=np.zeros((1, 3)))
    claim = weightless._replace(gravity=np.array([[1.0, -2.0, -9.0]]))
    bodies._programs = Programs()
    traced(bodies, weightless)
    (light,) = programs(bodies)
    traced(bodies, weightless._replace(x=claim.x + 0.1, wrenches=0.0 * claim.wrenches))
    assert programs(bodies) == [light]
    traced(bodies, claim._replace(loads=0.0 * claim.loads))
    (heavy,) = programs(bodies)
    assert len(heavy.graph.operations) > len(light.graph.operations)
    for changes in ({"loads": 3.0 * claim.loads}, {"gravity": weightless.gravity}):
        assert_same(bodies, claim._replace(**changes))
        assert programs(bodies) == [heavy]


def test_a_force_acts_at_its_point() -> None:
    """It is the same as at the link's origin with its moment about it."""
    mechanism = MECHANISMS["every kind of joint"]()
    bodies = random_bodies(mechanism, 0)
    claim = random_claim(mechanism, bodies, 4)
    loads = {name: replace(load, in_world=False) for name, load in claim.link_loads.items()}
    at_origin = {
        name: replace(
            load, point=np.zeros(3), moment=load.moment + np.cross(load.point, load.force)
        )
        for name, load in loads.items()
    }
    assert loads
    claim = claim._replace(link_loads=loads)
    for way in (as_text, one_by_one, traced):
        found, expected = way(bodies, claim), way(bodies, claim._replace(link_loads=at_origin))
        for field in NAMES:
            np.testing.assert_allclose(getattr(found, field), getattr(expected, field), rtol=1e-12)
    elsewhere = {name: replace(load, point=2.0 * load.point) for name, load in loads.items()}
    moved = traced(bodies, claim._replace(link_loads=elsewhere))
    assert np.all(moved.power_imbalance != found.power_imbalance)


def test_few_programs_are_kept() -> None:
    mechanism = MECHANISMS["gears"]()
    bodies = random_bodies(mechanism, 0)
    for seed in range(40):
        traced(bodies, random_claim(mechanism, bodies, seed))
    assert 1 < len(programs(bodies)) <= MOST < 40


def test_rates_at_rest_are_no_proof() -> None:
    bodies, claim, _ = claimed(SCENES["four-bar"](), positions(SCENES["four-bar"]())[:5])
    for field in ("v", "a"):
        for value in (1e-30, np.nan):
            array = np.zeros_like(claim.v)
            array[3, 1] = value
            false = claim._replace(**{field: array})
            for residuals in every_way(bodies, false):
                is_wrong = ~(residuals.rate_error < 1.0)
                assert is_wrong.tolist() == [False] * 3 + [True, False]


def test_no_input_is_changed() -> None:
    mechanism = MECHANISMS["gears"]()
    bodies = random_bodies(mechanism, 0)
    claim = random_claim(mechanism, bodies, 1)
    for field in FIELDS:
        getattr(claim, field).setflags(write=False)
    before = pickle.dumps(claim)
    assert_same(bodies, claim)
    assert pickle.dumps(claim) == before


def test_no_samples_have_no_residuals() -> None:
    mechanism = MECHANISMS["gears"]()
    bodies = random_bodies(mechanism, 0)
    claim = random_claim(mechanism, bodies, 0)
    nothing = {field: getattr(claim, field)[:0] for field in FIELDS}
    for way in (as_text, traced):
        residuals = way(bodies, claim._replace(**nothing, link_loads={}, inertia={}))
        assert all(array.shape == (0,) for array in residuals[:9])


def test_the_proof_can_be_copied_and_sent() -> None:
    mechanism = MECHANISMS["gears"]()
    bodies = random_bodies(mechanism, 0)
    claim = random_claim(mechanism, bodies, 1)
    expected = traced(bodies, claim)
    for other in (copy.deepcopy(bodies), pickle.loads(pickle.dumps(bodies))):
        for one, again in zip(expected[:9], traced(other, claim), strict=False):
            assert np.array_equal(one, again)


def test_what_a_proof_of_one_sample_calls() -> None:
    """Those of floats grow with the mechanism; those of arrays and programs, of the text alone."""
    bodies, claim, where = claimed(
        SCENES["four-bar"](), positions(SCENES["four-bar"]())[:1], **RATES
    )
    assert calls(lambda: as_text(bodies, claim).prove(where, np.ones(1))) < 1000
    traced(bodies, claim)
    assert calls(lambda: traced(bodies, claim).prove(where, np.ones(1))) < 80
    bodies, claim, where = claimed(SCENES["four-bar"](), np.linspace(0.2, 1.4, 300), **RATES)
    traced(bodies, claim)
    assert calls(lambda: traced(bodies, claim)) < 80
