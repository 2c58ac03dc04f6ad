"""Cloth that moves with its wearer: what rests stays, what flies evenly rests too, and killed runs end the same."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.exposed import ExposedSurface, penetration_depth
from garmentq.core.body.motion.recording import Recording
from garmentq.core.body.motion.track import LeadIn, Pose, Track
from garmentq.core.cloth.bending_friction import measure_angles
from garmentq.core.cloth.carry_step import move_collision_free
from garmentq.core.cloth.collision.barrier import find_coincident_nodes
from garmentq.core.cloth.collision.near_pairs import find_near_pairs
from garmentq.core.cloth.collision.self_contact import SelfContact
from garmentq.core.cloth.dynamics import ClothState
from garmentq.core.cloth.energy import Energy
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.motion_step import StepSettings
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.topology import Topology
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.reuse.animate.animation import animate, list_times
from garmentq.core.reuse.animate.measured import judge_animation, judge_motion, measure_animation
from garmentq.core.reuse.animate.moving_skin import MovingSkin
from garmentq.core.reuse.animate.settings import AnimateBad, AnimateSettings, StepLimits
from garmentq.core.reuse.animate.stage import AnimationScene, Cloth
from garmentq.core.run.errors import Cancelled
from garmentq.core.run.hooks import Hooks
from scipy.spatial.transform import Rotation


def stand(worn, seconds=10.0):
    """Return a wearer who does not move."""
    own = Pose.of(worn.body)
    count = int(seconds * 30) + 1
    track = Track(30.0, np.tile(own.turns, (count, 1, 1, 1)), np.tile(own.pelvis, (count, 1)))
    return LeadIn(own, track, 0.0, 0.0)


def step_aside(worn, frames=12, degrees=20.0):
    """Return a wearer who lifts a leg ahead within some frames."""
    start = stand(worn)
    turns = np.tile(start.start.turns, (frames, 1, 1, 1))
    for n in range(frames):
        angle = -degrees * n / (frames - 1)
        turns[n, JOINTS.index("left_hip")] = Rotation.from_euler("x", angle, degrees=True).as_matrix()
    return replace(start, track=Track(30.0, turns, np.tile(start.start.pelvis, (frames, 1))))


def drift(animation):
    """Return how far the farthest node comes from the first frame [m]."""
    return float(np.linalg.norm(animation.frames - animation.frames[0], axis=2).max())


def rest(worn, frames):
    return animate(worn, stand(worn), AnimateSettings(end=(frames - 1) / 30.0, lead=0.0))


def test_cloth_on_a_still_body_stays(worn):
    """Broken where friction creeps, contact trembles, or the start is out of balance."""
    found = rest(worn, 5)
    assert drift(found) < 1e-3
    creep = np.linalg.norm(found.frames[3:] - found.frames[2:-1], axis=2).max()
    assert creep < 5e-5  # after two frames nothing moves at all
    assert all(verdict.converged for verdict in found.verdicts)


@pytest.mark.nightly
def test_cloth_on_a_still_body_stays_for_a_hundred_frames(worn):
    """Broken where it creeps slowly."""
    assert drift(rest(worn, 100)) < 1e-3


def test_the_moving_skin_measures_as_the_skin_does():
    """Broken where a point inside the body passes for one outside, or the other way round."""
    skin = ExposedSurface.of(builtin_body("builtin:female,height=1.70,pose=A"), splits=0)
    generator = np.random.default_rng(4)
    points = skin.vertices[generator.integers(len(skin.vertices), size=4000)] + generator.normal(0, 0.02, (4000, 3))
    (found, way), (wanted, gradient) = MovingSkin(skin).measure(points), skin.measure(points)
    assert 1000 < (wanted < 0).sum() < 3000
    np.testing.assert_allclose(found, wanted, atol=1e-14)  # faces in another order are searched
    np.testing.assert_allclose(way, gradient, atol=1e-9)


def test_only_what_meets_is_held_back():
    """Broken where all of the cloth stays behind because two parts of it meet, or these pass through each other."""
    side = 12
    grid = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), axis=-1).reshape(-1, 2) * 0.015
    low = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    sheet = np.concatenate(
        [np.stack([low, low + 1, low + side], 1), np.stack([low + 1, low + side + 1, low + side], 1)]
    )
    faces = np.concatenate([sheet, sheet + side**2])
    topology = Topology.from_mesh(faces, np.concatenate([grid[sheet]] * 2))
    flat = np.insert(grid, 1, 0.0, axis=1)
    nodes = np.concatenate([flat, flat + [0.0, 0.004, 0.0]])
    goal = nodes + [0.03, 0.0, 0.0]
    corner = side**2 + np.flatnonzero((grid < 0.04).all(axis=1))
    goal[corner, 1] -= 0.02
    energy = Energy(Scene(topology, get_fabric("cotton_poplin"), self_contact=SelfContact.of(topology)))
    assert energy.free_share(nodes, goal - nodes)[1] < 0.3
    found = move_collision_free(energy, nodes, goal)[1]
    assert len(self_intersections(found, faces)) == 0
    reached = np.linalg.norm(goal - found, axis=1) < 1e-12
    assert reached[side**2 :][(grid > 0.12).any(axis=1)].all()
    assert not reached[corner].any()
    assert (found[corner, 1] < 0.004).all()


def test_a_frame_is_taken_out_of_the_wearer_and_not_through_itself(worn):
    """Broken where what is inside stays there, or layers that go out to one place pass through each other."""
    stage = AnimationScene(worn, stand(worn), AnimateSettings())
    moment, faces = stage.at(0.0, worn.garment.nodes), worn.garment.faces
    pressed = worn.garment.nodes + [0.0, 0.0, 0.006]
    assert penetration_depth(pressed, faces, moment.surface) > 4e-3
    found = stage.deliver(pressed, moment)
    assert penetration_depth(found, faces, moment.surface) < 2e-4
    assert len(self_intersections(found, faces)) == 0
    far = moment.surface.measure(pressed)[0] > 0.03
    np.testing.assert_array_equal(found[far], pressed[far])


def test_cloth_without_room_is_let_go_and_what_is_stuck_has_not_converged(worn):
    """Broken where two nodes in one place hold all of the cloth, or a step that was cut short passes for converged."""
    stage = AnimationScene(worn, stand(worn), AnimateSettings(lead=0.0))
    now, nodes = stage.at(0.0, worn.garment.nodes), np.array(worn.garment.nodes)
    faces = worn.garment.faces
    ring = np.unique(faces[(faces == 40).any(axis=1)])
    other = int(np.unique(faces[np.isin(faces, ring).any(axis=1)][:, 0])[-1])
    assert other not in ring
    nodes[other] = nodes[40]
    velocities = np.tile([0.0, 0.0, 0.3], (len(nodes), 1))
    step = stage.step(Cloth(ClothState(nodes, velocities, nodes), stage.layout), now, now, 1 / 30.0)
    assert step.converged and step.residual < 1.0
    held = stage.scene.self_contact
    pairs = find_near_pairs(held, nodes).pairs
    assert {40, other} <= set(find_coincident_nodes(nodes, pairs).tolist())
    assert not len(find_coincident_nodes(np.array(worn.garment.nodes), find_near_pairs(held, worn.garment.nodes).pairs))


def test_forces_that_are_no_numbers_end_a_step_where_they_were(worn, monkeypatch):
    """Broken where positions that are none go on into the next step, or pass for converged."""
    settings = AnimateSettings(end=1 / 30.0, lead=0.0, halvings=0)
    stage = AnimationScene(worn, step_aside(worn), settings)
    now, then = (stage.at(time, worn.garment.nodes) for time in (0.0, 1 / 30.0))
    nodes = np.array(worn.garment.nodes)
    real, turn = Energy.hessian, []

    def spoiled(self, nodes, exact=True, stress=None):
        turn.append(nodes)
        energy, gradient, blocks = real(self, nodes, exact, stress)
        return energy, gradient * (np.nan if len(turn) == 3 else 1.0), blocks

    monkeypatch.setattr(Energy, "hessian", spoiled)
    step = stage.step(Cloth(ClothState(nodes, np.zeros_like(nodes), nodes), stage.layout), now, then, 1 / 30.0)
    assert len(turn) == 3
    assert not step.converged
    np.testing.assert_array_equal(step.state.nodes, turn[1])
    assert np.isfinite(step.state.anchors).all()


def test_a_step_starts_from_the_folds_of_the_step_before(worn):
    """Broken where cloth in motion is pulled back for ever to the folds of the drape it began with."""
    settings = AnimateSettings(lead=0.0)
    stage = AnimationScene(worn, step_aside(worn), settings)
    moments = [stage.at(n / 30.0, worn.garment.nodes) for n in range(5)]
    cloth, folds, topology = Cloth(stage.start, stage.layout), stage.start.folds, stage.scene.topology
    for now, then in pairwise(moments):
        step = stage.step(cloth, now, then, 1 / 30.0)
        held = step.layout.energy.scene.bending_friction
        np.testing.assert_array_equal(held.angles, folds)
        angles = measure_angles(topology, step.state.nodes)
        np.testing.assert_array_equal(step.state.folds, held.slide(angles))
        cloth, folds = Cloth(step.state, step.layout), step.state.folds
    assert (folds != stage.start.folds).any()


def test_even_flight_is_rest(worn, monkeypatch):
    """Broken where friction, damping or contact see the world and not the skin: at a constant velocity, in air that
    moves along, the result is the resting one moved."""
    still = stand(worn)
    velocity = np.array([1.5, 0.0, -0.6])
    track = still.track
    way = np.arange(len(track.turns))[:, None] / track.rate * velocity
    flying = replace(still, track=replace(track, pelvis=track.pelvis + way))
    wind = StepSettings(wind=(1.5, 0.0, -0.6))
    settings = AnimateSettings(end=5 / 30.0, lead=0.0, step=wind)
    resting = animate(worn, still, replace(settings, step=StepSettings()))
    before = AnimationScene.start.fget

    def flying_start(stage):
        return replace(before(stage), velocities=np.tile(velocity, (len(worn.garment.nodes), 1)))

    monkeypatch.setattr(AnimationScene, "start", property(flying_start))  # the cloth flies from the beginning on
    moved = animate(worn, flying, settings)
    np.testing.assert_allclose(moved.frames - way[:6, None], resting.frames, atol=1e-3)


def test_cloth_goes_with_the_leg(worn):
    """Broken where the cloth stays behind, the body comes through it, or a frame is not delivered outside of it."""
    found = animate(worn, step_aside(worn), AnimateSettings(lead=0.0))
    metrics = measure_animation(found)
    assert metrics["frames"] == 12.0
    assert metrics["max_depth_mm"] < 2.0
    assert metrics["crossings"] == 0.0
    assert metrics["frames_not_converged"] == 0.0
    assert drift(found) > 0.03
    assert [gate.verdict for gate in judge_animation(metrics)] == ["pass"] * 4


def test_a_motion_has_one_beginning(worn):
    """Broken where the lead-in's steps, and with them where cloth folds, follow the rate of frames or the steps."""
    motion = replace(step_aside(worn), seconds=0.2)
    settings = AnimateSettings(lead=0.2, end=1 / 30.0)
    first = animate(worn, motion, settings).frames[0]
    finer = replace(settings, fps=48.0, pace=StepLimits(0.005, 1 / 60))
    np.testing.assert_array_equal(animate(worn, motion, finer).frames[0], first)
    slower = replace(settings, lead_pace=StepLimits(0.06, 1 / 15))
    assert not np.array_equal(animate(worn, motion, slower).frames[0], first)


@pytest.mark.nightly
def test_half_the_step_changes_little(worn):
    """Broken where the steps are too coarse for what they show."""
    motion = step_aside(worn)
    coarse = animate(worn, motion, AnimateSettings(lead=0.0))
    fine = animate(worn, motion, AnimateSettings(lead=0.0, pace=StepLimits(0.015, 1 / 60)))
    rms = np.sqrt(((coarse.frames - fine.frames) ** 2).sum(axis=2).mean(axis=1)).max()
    assert rms < 5e-3


def test_a_killed_run_ends_bit_for_bit_the_same(worn):
    """Broken where a checkpoint lacks what the next step depends on, or belongs to another motion."""
    motion, settings = step_aside(worn, 7, 10.0), AnimateSettings(lead=0.0)
    whole = animate(worn, motion, settings)
    kept = {}
    hooks = Hooks(is_cancelled=lambda: len(kept) == 1, save_checkpoint=kept.__setitem__, load_checkpoint=kept.get)
    with pytest.raises(Cancelled):
        animate(worn, motion, settings, hooks)
    assert len(kept) == 1
    stages = []
    again = animate(
        worn, motion, settings,
        Hooks(on_progress=lambda *at: stages.append(at[2]), save_checkpoint=kept.__setitem__, load_checkpoint=kept.get),
    )  # fmt: skip
    np.testing.assert_array_equal(again.frames, whole.frames)
    assert stages[0] == "frame 6 of 7"
    other = animate(worn, step_aside(worn, 7, 5.0), settings, Hooks(load_checkpoint=kept.get))
    assert not np.array_equal(other.frames[-1], whole.frames[-1])
    heavy = replace(settings, step=StepSettings(damping=90.0))
    damped = animate(worn, motion, heavy, Hooks(load_checkpoint=kept.get))
    assert not np.array_equal(damped.frames[1], whole.frames[1])


def test_times_are_those_asked_for(worn):
    """Broken where a frame is lost or added at the end, or an empty range is an empty animation."""
    motion = stand(worn, 2.0)
    np.testing.assert_allclose(list_times(motion, AnimateSettings(begin=0.5, fps=10.0)), np.arange(5, 21) / 10)
    assert len(list_times(motion, AnimateSettings(end=1.0))) == 31
    looping = replace(motion, track=replace(motion.track, loops=True))
    assert len(list_times(looping, AnimateSettings())) == 120
    with pytest.raises(AnimateBad):
        list_times(motion, AnimateSettings(begin=3.0))
    for bad in ({"fps": 0.0}, {"begin": 2.0, "end": 1.0}, {"fps": float("nan")}, {"lead": -1.0}):
        with pytest.raises(AnimateBad):
            AnimateSettings(**bad)


@pytest.mark.parametrize(
    ("lacking", "verdict"),
    [
        ((), "pass"),
        (("left_collar", "right_foot", "left_hand", "neck"), "pass"),
        (("left_elbow", "left_wrist"), "doubtful"),
        (("head",), "doubtful"),
        (("right_shoulder", "right_elbow", "right_wrist"), "fail"),
        (("spine1", "spine2", "spine3"), "fail"),
    ],
)
def test_a_motion_that_lacks_a_limb_does_not_pass(lacking, verdict):
    """Broken where a limb or a trunk that stays stiff passes, or a skeleton without collars or toes does not."""
    known = np.array([name not in lacking for name in JOINTS])
    turns = np.tile(np.eye(3), (2, 24, 1, 1))
    gate = judge_motion(Recording(30.0, turns, known, np.zeros((24, 3)), None))
    assert (gate.name, gate.verdict) == ("motion", verdict)
    assert verdict == "pass" or all(name in gate.message for name in lacking)
