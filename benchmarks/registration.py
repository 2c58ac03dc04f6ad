"""Measure the registration of bodies: python benchmarks/registration.py [--count 20] [--bodies DIR].

The built-in body in random everyday poses, shapes, headings and places, with other triangles than the model's and 2 mm
of noise, is registered as a mesh that is only a mesh; its true joints are known. With --bodies the body.ply of every
target pack in DIR is registered too: there only the surface can be measured. One thread, CPU seconds.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path

import igl
import numpy as np
import trimesh
from garmentq.core.body import JOINTS, register_body, skin
from garmentq.core.body.template import Template, articulate, load_template, rotations_of, transforms_of
from garmentq.core.scan import load_scan

NOISE = 2e-3
"""Noise of the mesh [m per coordinate]: a hand-held scanner's."""
FACES = 12000
"""Faces after the decimation: none of the model's edges is left where two meet."""
SHAPE = 0.8
"""Spread of the random shapes in standard deviations of the model: nearly all remain within its range."""


def everyday_body(template: Template, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Make a random person in a random everyday pose.

    Returns:
        Vertices [m], faces, true joints [m] of shape [24, 3], and the direction in which the person faces, shape [3].
    """
    rng = np.random.default_rng(seed)
    gender = ("female", "male")[seed % 2]
    count = template.shape_count
    root = np.linalg.cholesky(template.covariances[gender] + 1e-9 * np.eye(count))
    rest, joints = template.shaped(template.means[gender] + SHAPE * root @ rng.standard_normal(count))
    angles = np.zeros((24, 3))
    drop, stride, heading = rng.uniform(-0.2, 1.3), rng.uniform(-0.5, 0.5), rng.uniform(0, 2 * np.pi)
    angles[0] = (0, heading, 0)
    for side, sign in (("left", -1), ("right", 1)):
        shoulder = (rng.normal(0, 0.2), sign * rng.uniform(-0.2, 0.7), sign * (drop + rng.normal(0, 0.15)))
        angles[JOINTS.index(f"{side}_shoulder")] = shoulder
        angles[JOINTS.index(f"{side}_elbow")] = (0, sign * rng.uniform(0, 1.3), 0)
        angles[JOINTS.index(f"{side}_hip")] = (sign * stride, rng.normal(0, 0.1), -sign * rng.uniform(0, 0.15))
        angles[JOINTS.index(f"{side}_knee")] = (rng.uniform(0, 0.5), 0, 0)
    for name in ("spine1", "spine2", "spine3", "neck", "head"):
        angles[JOINTS.index(name)] = rng.normal(0, 0.08, 3)
    world, posed = articulate(rotations_of(angles), joints, rng.uniform(-1, 1, 3))
    skinned = skin(rest, template.weights, transforms_of(world, posed, joints))
    finer = trimesh.Trimesh(skinned, template.faces, process=False).subdivide()
    vertices, faces, *_ = igl.qslim(np.asfortranarray(finer.vertices), np.asfortranarray(finer.faces, np.int32), FACES)
    front = np.array([np.sin(heading), 0.0, np.cos(heading)])
    return vertices + rng.normal(0, NOISE, vertices.shape), faces, posed, front


def swaps(found: np.ndarray, true: np.ndarray) -> int:
    """Count the limbs whose joints lie nearer to the other side's true ones."""
    count = 0
    for part in ("hip", "knee", "ankle", "shoulder", "elbow", "wrist"):
        left, right = JOINTS.index(f"left_{part}"), JOINTS.index(f"right_{part}")
        own = np.linalg.norm(found[[left, right]] - true[[left, right]], axis=1).sum()
        other = np.linalg.norm(found[[left, right]] - true[[right, left]], axis=1).sum()
        count += int(other < own)
    return count


def measure_everyday(count: int) -> None:
    """Register random people and print the errors of their joints."""
    template = load_template()
    means, worst, swapped, backward, seconds, fits = [], [], 0, 0, [], []
    for seed in range(count):
        vertices, faces, joints, front = everyday_body(template, seed)
        started = time.process_time()
        body = register_body(vertices, faces)
        seconds.append(time.process_time() - started)
        error = 1e3 * np.linalg.norm(body.joints - joints, axis=1)
        means.append(error.mean())
        worst.append(error.max())
        fits.append(1e3 * body.fit_rms)
        swapped += swaps(body.joints, joints)
        backward += int((body.heading @ front)[2] < 0)
        print(
            f"{seed:3d}: joints {error.mean():5.1f} mm, worst {error.max():5.1f} ({JOINTS[int(error.argmax())]}), "
            f"surface {fits[-1]:.1f} mm, {seconds[-1]:.1f} s",
            flush=True,
        )
    print(
        f"{count} bodies: mean joint error {np.mean(means):.1f} mm (at most 15), worst body {max(means):.1f}, "
        f"worst joint {max(worst):.1f}; {swapped} left-right swaps, {backward} facing backward; "
        f"surface {np.mean(fits):.1f} mm; "
        f"{np.mean(seconds):.1f} s"
    )


def measure_packs(folder: Path) -> None:
    """Register the bodies of target packs, each once, and print the RMS of their surfaces."""
    seen = set()
    for path in sorted(folder.glob("*/body.ply")):
        scan = load_scan(path, kind="body")
        if scan.sha256 in seen:
            continue
        seen.add(scan.sha256)
        body = register_body(scan.vertices, scan.faces, name=path.parent.name)
        print(f"{path.parent.name}: surface {1e3 * body.fit_rms:.1f} mm (at most 10)", flush=True)


def main() -> None:
    """Print the measurements."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--count", type=int, default=20, help="random people")
    parser.add_argument("--bodies", type=Path, help="folder of target packs")
    options = parser.parse_args()
    measure_everyday(options.count)
    if options.bodies:
        measure_packs(options.bodies)


if __name__ == "__main__":
    main()
