"""Make the example's scan: a T-shirt draped on a body by a simulator that is not ours; a developer's script.

Run it after `pip install garmentq[develop]` as `python examples/make_example.py` (a quarter of an hour on one core);
the demo itself needs nothing of it. It writes `pattern.json` (the truth), `body.ply` and `garment.ply` into
`examples/data`.

What it does: draft a boxy V-neck T-shirt by other measures and lines than the shipped template's, dress a built-in
body in it, let the VBD solver of the `newton` package (a vertex at a time, in float32, with its own contact and
friction) drape it while the arms sink and for two seconds more, and give the surface a mesh that is not the pattern's,
as a scanner would.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import newton
import numpy as np
import trimesh
import warp as wp
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import ARM_DROPS, arm_pose, builtin_body
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.body.projection import project_outside
from garmentq.core.body.skinning import skin
from garmentq.core.body.template import articulate, rotations_of, transforms_of
from garmentq.core.body.untangling import untangle_outside
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.outline import Outline, Stroke, mirror, place_panel, sew_by_label, unfold
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.resampling import resample
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry

DATA = Path(__file__).parent / "data"

BODY = "builtin:female,height=1.66"
"""The wearer; the templates are sized to the same model's woman of 1.70 m."""

NODES = 4000
"""Nodes of the simulated mesh: edges of about 1.5 cm, on which folds of 5 cm form."""
START_NODES = 1500
"""Nodes of the quick first drape, whose recipe was made for this resolution."""

SCAN_VERTICES = 9000
"""Vertices of the written mesh: twice the simulated mesh's, so that its triangles are others and no fold is lost."""
NOISE = 2.0e-4
"""Standard deviation of the written surface along its normals [m]: a good structured-light scanner's."""

DENSITY = 0.18
"""Weight of the cloth [kg/m2]: a jersey for T-shirts."""
STRETCH = 1.0e3
"""Both Lame coefficients of the membrane [N/m]: the cloth yields about 0.1 % under its own weight."""
BENDING = 2.0e-3
"""Stiffness of a hinge over its length [N]; on edges of 1.5 cm about a rigidity of 1e-5 N m, a soft cotton's."""
FRICTION = 0.4
"""Coulomb's coefficient, cloth on skin and on cloth."""
SLIP = 0.1
"""The same while the arms sink: shaking a shirt into place lets go of the stretch of the quick first drape."""
THICKNESS = 4.0e-3
"""Distance that the nodes keep from the skin [m]; less would let the flat triangles between cut it."""
CONTACT = 1.0e4
"""Stiffness of a node's contact [N/m]: where the shirt hangs from the shoulders, 2 N on a node sink it by 0.2 mm."""

STEP = 1.0 / 2000.0
"""Time step [s]. A sweep carries a force from a node to the next: where the membrane is stiff beside the nodes' inertia
over a step, few sweeps leave it soft. With steps of 1/200 s and 8 sweeps the neckline came to rest 34 % longer than it
is cut, a hundredth of the faces stretched by as much; so it is 3 %, and 2 %."""
SWEEPS = 6
"""Sweeps of the solver over all nodes in a step."""
REPORT = 0.1
"""Simulated time between two lines of the report [s]."""
LOWERING = 0.8
"""Time in which the arms sink from the T-pose, in which one is dressed, to the A-pose [s]."""
DURATION = 2.8
"""Simulated time [s]: two seconds of rest; then the median node moves at 0.4 mm/s, the fastest at 1 to 3 cm/s."""
CALM = 0.33
"""Time in which still air, and the friction inside the cloth, take the velocity to its e-th part [s]."""


def draft_tee() -> Pattern:
    """Draft a boxy V-neck T-shirt with dropped shoulders and wide sleeves.

    It differs from the shipped template in every line: chest 1.14 m instead of 1.02 m, each shoulder 3.5 cm longer, a
    V 17 cm deep instead of a round neck of 10 cm, sleeves 2 cm longer and 4 cm wider, a hem 5 cm higher and curved.
    """
    height = 1.40  # of the side neck point above the feet
    neck, tip, under, hem = (0.085, 0.0), (0.225, -0.035), (0.285, -0.245), (0.278, -0.545)
    droop = np.deg2rad(8.0)
    along = np.array([np.cos(droop), -np.sin(droop)])
    top = np.array(tip) + 0.21 * along
    low = top + 0.195 * np.array([along[1], -along[0]])
    panels = []
    for side, hollow in (("front", 0.042), ("back", 0.034)):
        scye = ((under[0] - hollow, under[1] + 0.01), (tip[0] - 0.01, tip[1] - 0.07))
        # The V runs nearly straight to its point; the back's neckline is shallow and round.
        point = (0.0, -0.17) if side == "front" else (0.0, -0.022)
        bow = ((0.072, -0.06), (0.028, -0.125)) if side == "front" else ((0.075, -0.014), (0.045, -0.022))
        body = Outline(
            hem,
            (
                Stroke(under, label="side.left", notch=0.5),
                Stroke(tip, scye, label=f"scye.{side}.left"),
                Stroke(neck, label="shoulder.left"),
                Stroke(point, bow, contour="neck"),
            ),
        )
        sleeve = Outline(
            tip,
            (
                Stroke(under, scye[::-1], label=f"scye.{side}.left"),
                Stroke((float(low[0]), float(low[1])), label="undersleeve.left"),
                Stroke((float(top[0]), float(top[1])), contour="cuff.left"),
                Stroke(tip, label="oversleeve.left"),
            ),
        )
        panels.append(place_panel(side, unfold(body, "hem", dip=0.015), height))
        grain = np.pi / 2 - droop if side == "front" else droop - np.pi / 2
        panels.append(place_panel(f"sleeve_{side}_left", sleeve, height, grain, "sleeve"))
        panels.append(place_panel(f"sleeve_{side}_right", mirror(sleeve), height, -grain, "sleeve"))
    return sew_by_label("boxy_tee", "tshirt", panels)


def lower_arms(body: Body, drop: float) -> np.ndarray:
    """Return the body's vertices [m] with its arms `drop` [rad] below the horizontal, shape [n, 3]."""
    world, posed = articulate(rotations_of(arm_pose(drop)), body.rest_joints, np.zeros(3))
    return skin(body.rest_vertices, body.rest_weights, transforms_of(world, posed, body.rest_joints))


def dress_body(pattern: Pattern, body: Body) -> Garment:
    """Dress the body in its T-pose quickly and coarsely, and carry the result to the mesh that is simulated.

    This only says where the simulation starts: nodes outside the skin, most edges near their rest lengths.
    """
    coarse = drape_template(pattern, WearerGeometry(body), settings=DrapeSettings(template_vertices=START_NODES))
    fine = mesh_pattern(pattern, NODES)
    placed = resample(coarse, coarse.nodes, fine)
    return fine.at(project_outside(placed, ExposedSurface.of(body), fine.faces, THICKNESS))


def build_model(garment: Garment, body: Body) -> tuple[newton.Model, newton.Mesh]:
    """Build the cloth, whose rest shape is the flat pattern, and the body's mesh, which `simulate` moves."""
    builder = newton.ModelBuilder(up_axis=newton.Axis.Y, gravity=(0.0, -9.81, 0.0))
    builder.add_cloth_mesh(
        pos=wp.vec3(0.0, 0.0, 0.0),
        rot=wp.quat_identity(),
        scale=1.0,
        vel=wp.vec3(0.0, 0.0, 0.0),
        vertices=garment.nodes.tolist(),
        indices=garment.faces.ravel().tolist(),
        density=DENSITY,
        tri_ke=STRETCH,
        tri_ka=STRETCH,
        tri_kd=1.0e-4,
        edge_ke=BENDING,
        edge_kd=1.0e-3,
        particle_radius=THICKNESS,
    )
    surface = newton.ModelBuilder.ShapeConfig(ke=CONTACT, kd=0.0, mu=FRICTION)
    mesh = newton.Mesh(body.vertices.astype(np.float32), body.faces.astype(np.int32).ravel())
    builder.add_shape_mesh(body=-1, mesh=mesh, cfg=surface)
    builder.color()
    model = builder.finalize()
    lay_flat(model, garment)
    model.soft_contact_ke, model.soft_contact_kd, model.soft_contact_mu = CONTACT, 0.0, FRICTION
    return model, mesh


def lay_flat(model: newton.Model, garment: Garment) -> None:
    """Return the model the flat pattern as rest shape: the builder took the placed mesh's instead."""
    edges = (garment.rest[:, 1:] - garment.rest[:, :1]).transpose(0, 2, 1)
    area = 0.5 * np.abs(np.linalg.det(edges))
    mass = np.bincount(garment.faces.ravel(), np.repeat(DENSITY * area / 3.0, 3), len(garment.nodes))
    model.tri_poses.assign(np.linalg.inv(edges).astype(np.float32))
    model.tri_areas.assign(area.astype(np.float32))
    model.particle_mass.assign(mass.astype(np.float32))
    model.particle_inv_mass.assign((1.0 / mass).astype(np.float32))
    sides = np.sort(garment.faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    flat = np.linalg.norm(garment.rest - np.roll(garment.rest, -1, axis=1), axis=2).ravel()
    length = {(int(a), int(b)): float(size) for (a, b), size in zip(sides, flat, strict=True)}
    ends = np.sort(model.edge_indices.numpy()[:, 2:], axis=1)
    model.edge_rest_length.assign(np.array([length[int(a), int(b)] for a, b in ends], np.float32))
    model.edge_rest_angle.zero_()


def simulate(model: newton.Model, mesh: newton.Mesh, body: Body, duration: float) -> np.ndarray:
    """Lower the arms, let the cloth hang until a time [s] and give its nodes [m], shape [node_count, 3]."""
    solver = newton.solvers.SolverVBD(
        model,
        iterations=SWEEPS,
        particle_enable_self_contact=True,
        particle_self_contact_margin=2.0e-3,
        particle_self_contact_gap=1.5e-3,
        particle_vertex_contact_buffer_size=64,
        particle_edge_contact_buffer_size=128,
    )
    pipeline = newton.CollisionPipeline(model, soft_contact_gap=2 * THICKNESS)
    contacts, control = pipeline.contacts(), model.control()
    now, then = model.state(), model.state()
    kept = np.exp(-STEP / CALM)
    for step in range(round(duration / STEP)):
        share = min((step + 1) * STEP / LOWERING, 1.0)
        if step * STEP < LOWERING:
            mesh.mesh.points.assign(lower_arms(body, share * ARM_DROPS["A"]).astype(np.float32))
            mesh.mesh.refit()
        model.shape_material_mu.fill_(SLIP if share < 1.0 else FRICTION)
        pipeline.collide(now, contacts)
        now.clear_forces()
        solver.step(now, then, control, contacts, STEP)
        now, then = then, now
        velocity = now.particle_qd.numpy()
        now.particle_qd.assign(kept * velocity)
        if step % round(REPORT / STEP) == 0:
            speed = np.linalg.norm(velocity, axis=1)
            print(f"at {step * STEP:.1f} s: median {np.median(speed):.4f}, largest {speed.max():.3f} m/s", flush=True)
    return now.particle_q.numpy().astype(np.float64)


def scan_surface(garment: Garment, nodes: np.ndarray, skin: ExposedSurface) -> trimesh.Trimesh:
    """Return the surface another, finer mesh with a scanner's noise along its normals.

    In the creases under the arms the solver lets a few faces pass through others; they are taken apart.
    """
    fine = mesh_pattern(garment.pattern, SCAN_VERTICES)
    mesh = trimesh.Trimesh(resample(garment, nodes, fine), fine.faces, process=False)
    noise = NOISE * np.random.default_rng(0).standard_normal((len(mesh.vertices), 1))
    seen = mesh.vertices + noise * mesh.vertex_normals
    apart = untangle_outside(seen, skin, fine.faces)
    moved = np.linalg.norm(apart - seen, axis=1)
    print(f"{(moved > 0.0).sum()} nodes moved by up to {1e3 * moved.max():.1f} mm to take crossing faces apart")
    return trimesh.Trimesh(apart, fine.faces, process=False)


def main() -> None:
    """Write the example's files."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=DATA, help="folder for the files")
    parser.add_argument("--duration", type=float, default=DURATION, help="simulated time [s]")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    wp.init()
    with wp.ScopedDevice("cpu"):
        pattern, body = draft_tee(), builtin_body(BODY)
        garment = dress_body(pattern, body)
        model, mesh = build_model(garment, body)
        nodes = simulate(model, mesh, body, options.duration)
    posed = lower_arms(body, ARM_DROPS["A"])
    scan = scan_surface(garment, nodes, ExposedSurface(posed, body.faces))
    save_pattern(pattern, options.out / "pattern.json")
    trimesh.Trimesh(posed, body.faces, process=False).export(options.out / "body.ply")
    scan.export(options.out / "garment.ply")
    print(f"{len(scan.vertices)} vertices, {len(scan.faces)} faces in {options.out / 'garment.ply'}")


if __name__ == "__main__":
    main()
