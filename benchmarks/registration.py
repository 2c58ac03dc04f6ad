"""Measure the registration of bodies: python benchmarks/registration.py [--count 20] [--bodies DIR].

The built-in body in random everyday poses, shapes, headings and places, with other triangles than the model's and 2 mm
of noise, is registered as a mesh that is only a mesh; its true joints are known. With --bodies the body.ply of every
target pack in DIR is registered too: there only the surface can be measured. One thread, CPU seconds.
"""

from __future__ import annotations

import argparse
import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "tests" / "standin"))

from everyday_body import everyday_body
from garmentq.core.body.body import JOINTS
from garmentq.core.body.registration import register_body
from garmentq.core.body.template import load_template
from garmentq.core.scan.load import load_scan


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
        vertices, faces, joints, heading = everyday_body(template, seed)
        started = time.process_time()
        body = register_body(vertices, faces)
        seconds.append(time.process_time() - started)
        error = 1e3 * np.linalg.norm(body.joints - joints, axis=1)
        means.append(error.mean())
        worst.append(error.max())
        fits.append(1e3 * body.fit_rms)
        swapped += swaps(body.joints, joints)
        backward += int((body.heading @ [np.sin(heading), 0.0, np.cos(heading)])[2] < 0)
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
