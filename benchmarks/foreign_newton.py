"""Drape a garment by NVIDIA Newton's vertex block descent, beside Blender's cloth: what `unseen_packs.py` calls.

Newton 1.8.0 (Apache-2.0, with Warp) is for development only and lives in an environment of its own, whose interpreter
runs this file:

    python benchmarks/foreign_newton.py GIVEN.npz FOUND.npy
"""

from __future__ import annotations

import itertools
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

MARGIN = 3e-3
"""Distance at which cloth begins to touch [m]: that of Blender's drapes."""

FPS, SUBSTEPS, ITERATIONS = 30.0, 8, 8

HANG, MOVE, REST = 15, 20, 30
"""Frames in which cloth falls, is moved with its wearer into the pose, and comes to rest."""

CONTACT, CONTACT_DAMPING, FRICTION = 4e4, 1e-2, 0.4
"""Of cloth on skin [N/m, s, 1]: the tightest dress tried stays 2 mm out of it; with 1e3 N/m it sank 4 mm in."""

CALMED = 0.9
"""Share of the velocity that a frame at rest leaves: air, which the solver has none of."""

STRETCH, BENDING, DENSITY = 3000.0, 0.01, 0.2
"""Of a cloth that is drawn as Blender's default [Newton's units, kg/m2]; a drawn one has its ratios to that."""


def drape(garment: Any, held: np.ndarray, poses: Sequence[Any], python: str, ratios: Sequence[float]) -> np.ndarray:
    """Return the nodes at rest in the last pose [m], shape [node_count, 3].

    Args:
        garment: As dressed, in the first pose.
        held: Nodes that stay where they are.
        poses: The wearer's skin on the way into the pose, as meshes.
        python: Newton's interpreter.
        ratios: Of the cloth's mass, stiffness and bending to the default's.
    """
    with tempfile.TemporaryDirectory() as folder:
        given, found = Path(folder) / "given.npz", Path(folder) / "found.npy"
        skins = np.stack([np.asarray(pose.vertices) for pose in poses])
        np.savez(
            given, nodes=garment.nodes, faces=garment.faces, rest=garment.rest, held=held, skins=skins,
            body_faces=poses[0].faces, ratios=ratios,
        )  # fmt: skip
        subprocess.run([python, __file__, str(given), str(found)], check=True, stdout=subprocess.DEVNULL)
        return np.asarray(np.load(found), dtype=np.float64)


def list_skins(skins: np.ndarray) -> list[np.ndarray]:
    """Return the skin at each frame, straight between the poses."""
    if len(skins) == 1:
        return [skins[0]] * (HANG + REST)
    at = np.linspace(0.0, len(skins) - 1.0, MOVE + 1)[1:]
    low = np.minimum(at.astype(int), len(skins) - 2)
    moved = [(1.0 - (a - n)) * skins[n] + (a - n) * skins[n + 1] for a, n in zip(at, low, strict=True)]
    return [skins[0]] * HANG + moved + [skins[-1]] * REST


def solve(path: Path, out: Path) -> None:
    """Solve the problem of a file and write the nodes at its end."""
    import newton  # type: ignore[import-not-found]
    import warp as wp  # type: ignore[import-not-found]

    wp.set_device("cpu")
    given = np.load(path)
    nodes, faces, skins = given["nodes"], given["faces"], list_skins(given["skins"])
    mass, stiffness, bending = (float(ratio) for ratio in given["ratios"])
    skin = newton.Mesh(skins[0], given["body_faces"].ravel(), compute_inertia=False)
    builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
    builder.add_shape_mesh(-1, mesh=skin)
    builder.add_cloth_mesh(
        pos=wp.vec3(0.0), rot=wp.quat_identity(), scale=1.0, vel=wp.vec3(0.0), vertices=[wp.vec3(*at) for at in nodes],
        indices=faces.ravel().tolist(), density=DENSITY * mass, tri_ke=STRETCH * stiffness, tri_ka=STRETCH * stiffness,
        tri_kd=1e-4, edge_ke=BENDING * bending, edge_kd=1e-3, particle_radius=MARGIN,
    )  # fmt: skip
    builder.color(include_bending=True)
    model = builder.finalize()
    take_flat(model, given["rest"])
    flags = model.particle_flags.numpy()
    flags[given["held"].astype(int)] &= ~int(newton.ParticleFlags.ACTIVE)
    model.particle_flags = wp.array(flags)
    model.soft_contact_ke, model.soft_contact_kd, model.soft_contact_mu = CONTACT, CONTACT_DAMPING, FRICTION
    reach = np.concatenate(skins)
    model.shape_collision_aabb_lower = wp.array(reach.min(axis=0, keepdims=True), dtype=wp.vec3)
    model.shape_collision_aabb_upper = wp.array(reach.max(axis=0, keepdims=True), dtype=wp.vec3)
    solver = newton.solvers.SolverVBD(
        model, iterations=ITERATIONS, particle_enable_self_contact=True, particle_self_contact_margin=MARGIN,
        particle_self_contact_gap=MARGIN,
    )  # fmt: skip
    pipeline = newton.CollisionPipeline(model, soft_contact_gap=MARGIN)
    states, control, contacts = [model.state(), model.state()], model.control(), pipeline.contacts()
    for before, after in itertools.pairwise([skins[0], *skins]):
        skin.mesh.velocities.assign(FPS * (after - before))
        for n in range(1, SUBSTEPS + 1):
            skin.mesh.points.assign((1.0 - n / SUBSTEPS) * before + n / SUBSTEPS * after)
            skin.mesh.refit()
            pipeline.collide(states[0], contacts)
            solver.step(states[0], states[1], control, contacts, 1.0 / FPS / SUBSTEPS)
            states.reverse()
        if before is after:
            states[0].particle_qd.assign(CALMED * states[0].particle_qd.numpy())
    np.save(out, states[0].particle_q.numpy())


def take_flat(model: Any, rest: np.ndarray) -> None:
    """Compute the rest shape of Newton's cloth from the flat pattern, with flat hinges, and set it in the model."""
    import warp as wp

    frame = np.stack([rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]], axis=2)
    poses, areas = model.tri_poses.numpy(), model.tri_areas.numpy()
    poses[: len(rest)] = np.linalg.inv(frame)
    areas[: len(rest)] = 0.5 * np.abs(np.linalg.det(frame))
    model.tri_poses = wp.array(poses, dtype=wp.mat22)
    model.tri_areas = wp.array(areas, dtype=float)
    model.edge_rest_angle.zero_()


if __name__ == "__main__":
    solve(Path(sys.argv[1]), Path(sys.argv[2]))
