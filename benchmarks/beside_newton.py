"""A shipped garment in motion beside NVIDIA Newton 1.8.0 (Apache-2.0) with Warp 1.19.0: the same start, body and walk.

Newton is no dependency: it lives in a virtual environment of its own. Three steps, the middle one by that interpreter:

    python benchmarks/beside_newton.py write  --out DIR [--template tshirt] [--seconds 1]
    NEWTON_VENV/bin/python benchmarks/beside_newton.py newton --out DIR [--substeps 10] [--iterations 10]
    python benchmarks/beside_newton.py compare --out DIR

`write` moves the garment itself and keeps the problem; `newton` solves it by vertex block descent (`SolverVBD`, the
CPU device, self-contact on, the wearer's skin near the garment as particles that are carried along); `compare`
measures both by our own measures, as they came out of the steps and, of ours, as delivered.
"""

from __future__ import annotations

import argparse
import itertools
import json
import time
from pathlib import Path

import numpy as np
from foreign_newton import take_flat

NEAR = 0.15
"""Distance from the cloth's start within which Newton is given the skin [m]."""

MARGIN = 2e-3
"""Distance at which cloth begins to touch [m]: that of our own self-contact."""

FPS = 30.0


def write(out: Path, template: str, seconds: float) -> None:
    """Move the garment by our own steps, and keep what Newton needs."""
    from garmentq.core.body.motion.read import load_motion
    from garmentq.core.body.motion.retarget import retarget
    from garmentq.core.body.motion.shipped import find_shipped_motion
    from garmentq.core.body.motion.track import LeadIn, Pose
    from garmentq.core.cloth.fabrics import get_fabric
    from garmentq.core.reuse.animate.animation import animate
    from garmentq.core.reuse.animate.measured import measure_animation
    from garmentq.core.reuse.animate.settings import AnimateSettings
    from garmentq.core.reuse.animate.stage import AnimationScene
    from worn_template import load_worn_template

    worn = load_worn_template(template, get_fabric("cotton_poplin"))
    motion = find_shipped_motion("walk")
    if worn is None or motion is None:
        raise SystemExit("the garment's drape or the motion is not shipped")
    settings = AnimateSettings(fps=FPS, end=seconds)
    lead = LeadIn(Pose.of(worn.body), retarget(load_motion(motion), worn.body, 0.0), 0.0, settings.lead)
    begun = time.process_time()
    found = animate(worn, lead, settings)
    spent = time.process_time() - begun
    mover = AnimationScene(worn, lead, settings).mover
    times = np.concatenate([-np.arange(round(settings.lead * FPS), 0, -1) / FPS, found.times])
    skins = np.stack([mover.vertices(lead.at(float(at))) for at in times])
    pins = worn.garment.contour("waist")
    np.savez(
        out / "problem.npz", nodes=worn.garment.nodes, faces=worn.garment.faces, rest=worn.garment.rest, skins=skins,
        body_faces=worn.body.faces, delivered=len(found.times), held=[] if pins is None else pins.vertices,
        density=worn.fabric.density, k=worn.fabric.k, shear=worn.fabric.H22, cross=worn.fabric.H01,
        ours=found.frames,
    )  # fmt: skip
    told = measure_animation(found)
    line = {"by": "ours", "cpu_seconds_with_lead_in": round(spent, 1), "frames_with_lead_in": len(times) - 1}
    print(json.dumps(line | {name: round(value or 0.0, 3) for name, value in told.items()}))


def solve(out: Path, substeps: int, iterations: int) -> None:
    """Move the garment by Newton's steps; keep its frames."""
    import newton  # type: ignore[import-not-found]
    import warp as wp  # type: ignore[import-not-found]

    wp.set_device("cpu")
    given = np.load(out / "problem.npz")
    nodes, faces, skins = given["nodes"], given["faces"], given["skins"]
    near = np.linalg.norm(skins[0][:, None] - nodes[None, ::5], axis=2).min(axis=1) < NEAR
    kept = near[given["body_faces"]].all(axis=1)
    used, body_faces = np.unique(given["body_faces"][kept], return_inverse=True)
    builder = newton.ModelBuilder(up_axis=newton.Axis.Y)
    common = {"pos": wp.vec3(0.0), "rot": wp.quat_identity(), "scale": 1.0, "vel": wp.vec3(0.0)}
    law = {"tri_ke": float(given["shear"]), "tri_ka": float(given["cross"]), "tri_kd": 1e-4}
    law |= {"edge_ke": float(given["k"]), "edge_kd": 1e-3}
    for points, triangles, density in (
        (nodes, faces, float(given["density"])), (skins[0][used], body_faces.reshape(-1, 3), 1.0),
    ):  # fmt: skip
        builder.add_cloth_mesh(
            vertices=[wp.vec3(*point) for point in points], indices=triangles.ravel().tolist(), density=density,
            particle_radius=MARGIN, **common, **law,
        )  # fmt: skip
    builder.color(include_bending=True)
    model = builder.finalize()
    take_flat(model, given["rest"])
    carried = np.concatenate([given["held"].astype(int), len(nodes) + np.arange(len(used))])
    flags = model.particle_flags.numpy()
    flags[carried] &= ~int(newton.ParticleFlags.ACTIVE)
    model.particle_flags = wp.array(flags)
    model.soft_contact_ke, model.soft_contact_kd, model.soft_contact_mu = 1e3, 1e-2, 0.3
    solver = newton.solvers.SolverVBD(
        model, iterations=iterations, particle_enable_self_contact=True,
        particle_self_contact_margin=MARGIN, particle_self_contact_gap=MARGIN,
    )  # fmt: skip
    states, control = [model.state(), model.state()], model.control()
    contacts = newton.CollisionPipeline(model).contacts()
    frames, spent, step = [], [], 1.0 / FPS / substeps
    for before, after in itertools.pairwise(skins):
        begun = time.process_time()
        for n in range(1, substeps + 1):
            share = n / substeps
            at = ((1.0 - share) * before + share * after)[used]
            for state in states:
                place = state.particle_q.numpy()
                place[len(nodes) :] = at
                state.particle_q.assign(place)
            solver.step(states[0], states[1], control, contacts, step)
            states.reverse()
        solver.rebuild_bvh(states[0])
        spent.append(time.process_time() - begun)
        frames.append(states[0].particle_q.numpy()[: len(nodes)].astype(float))
        print(f"frame {len(frames)} of {len(skins) - 1}: {spent[-1]:.2f} s", flush=True)
    last = int(given["delivered"])
    line = {"by": f"newton {newton.__version__}, warp {wp.__version__}", "substeps": substeps, "iterations": iterations}
    line |= {"skin_particles": len(used), "seconds_per_frame": round(float(np.mean(spent[1:])), 3)}
    np.savez(out / "newton.npz", frames=np.array(frames)[-last:], line=json.dumps(line))
    print(json.dumps(line))


def compare(out: Path) -> None:
    """Measure both by crossings and depth."""
    from garmentq.core.body.exposed import ExposedSurface, penetration_depth
    from garmentq.core.geometry.intersections import self_intersections

    given, other = np.load(out / "problem.npz"), np.load(out / "newton.npz")
    faces, skins = given["faces"], given["skins"][-int(given["delivered"]) :]
    rest = given["rest"]
    for by, frames in (("ours", given["ours"]), (str(other["line"]), other["frames"])):
        depths, crossed, stretch = [], [], []
        for nodes, skin in zip(frames, skins, strict=True):
            depths.append(1e3 * penetration_depth(nodes, faces, ExposedSurface(skin, given["body_faces"])))
            crossed.append(len(self_intersections(nodes, faces)))
            long = np.linalg.norm(np.roll(nodes[faces], -1, axis=1) - nodes[faces], axis=2)
            stretch.append(float(np.quantile(long / np.linalg.norm(np.roll(rest, -1, axis=1) - rest, axis=2), 0.99)))
        line = {"by": by, "frames": len(frames), "depth_mm": round(max(depths), 2), "crossings": max(crossed)}
        line |= {"frames_crossed": sum(one > 0 for one in crossed), "stretch_p99": round(max(stretch) - 1.0, 3)}
        print(json.dumps(line | {"depth_mean_mm": round(float(np.mean(depths)), 2)}))


def main() -> None:
    """Take one of the three steps."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("step", choices=("write", "newton", "compare"))
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--template", default="tshirt")
    parser.add_argument("--seconds", type=float, default=1.0)
    parser.add_argument("--substeps", type=int, default=10)
    parser.add_argument("--iterations", type=int, default=10)
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    if given.step == "write":
        write(given.out, given.template, given.seconds)
    elif given.step == "newton":
        solve(given.out, given.substeps, given.iterations)
    else:
        compare(given.out)


if __name__ == "__main__":
    main()
