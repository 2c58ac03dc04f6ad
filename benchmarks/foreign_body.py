"""Draw a wearer by a seed with the package `anny`, and take the measures that GarmentCode's programs draft for.

    python benchmarks/foreign_body.py OUT --seed 1

writes `body.ply`, a T-pose in metres, y up, and `body.yaml`, a body of GarmentCode's in centimetres. `anny`
(Apache-2.0, CC0 assets) is for development only. The built-in body is a linear model of 900 of its bodies, which leaves
2.2 mm of each unexplained; this one is none of them.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
import trimesh
from garmentq.core.body.body import Body
from garmentq.core.body.registration import register_body
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.training import body_assets

HEIGHTS = (1.50, 1.95)
"""Between which a drawn wearer's height lies [m]: 95 of 100 adults."""

LOCAL_SPREAD = 0.15
"""Standard deviation of local changes, of the extremes that were modelled: half as far from the mean as the built-in
body's own examples, which span what a fit may meet rather than whom one meets."""

PROPORTIONS: Mapping[str, float] = {
    "underbust": 0.83, "bust_points": 0.166, "back_width": 0.474, "waist_back_width": 0.47, "hip_back_width": 0.535,
    "bum_points": 0.17, "leg_circ": 0.583,
}  # fmt: skip
"""Widths over the girth beside which they are taken, as GarmentCode's mean woman has them."""

ANGLES: Mapping[str, float] = {"arm_pose_angle": 0.0, "hip_inclination": 9.9, "shoulder_incl": 21.0}
"""Angles [degrees] of a T-pose and of GarmentCode's mean person."""

SIDE = {"underbust": "bust", "bust_points": "bust", "back_width": "bust", "waist_back_width": "waist"}
"""The girth of which a proportion is a share; of the others the hips."""


def draw_body(model: Any, seed: int) -> tuple[np.ndarray, np.ndarray, str]:
    """Return vertices [m], faces and the gender of a drawn adult in T-pose."""
    skin, faces = body_assets.close_surface(model)
    rng = np.random.default_rng(seed)
    body_assets.LOCAL_SPREAD = LOCAL_SPREAD
    while True:
        phenotype, changes, gender = body_assets.draw_phenotype(model, rng)
        vertices = skin @ body_assets.pose_t(model, phenotype, changes)[0]
        if HEIGHTS[0] <= np.ptp(vertices[:, 1]) <= HEIGHTS[1]:
            return vertices, faces, "female" if gender else "male"


def measure_for_garmentcode(body: Body) -> dict[str, float]:
    """Return a body's measures under GarmentCode's names [cm, degrees]."""
    own = measure_wearer(body)
    height = float(np.ptp(body.vertices[:, 1]))
    arm = float(np.linalg.norm(body.joint("left_wrist") - body.joint("left_shoulder")))
    metres = {
        "height": height,
        "head_l": height - own.nape_height,
        "neck_w": 2.0 * own.neck_half_width,
        "shoulder_w": 2.0 * own.shoulder_half_width,
        "armscye_depth": 0.085 * own.bust + 0.045,
        "arm_length": arm,
        "wrist": 0.096 * height,
        "waist": own.waist,
        "waist_line": own.nape_height - own.waist_height,
        "waist_over_bust_line": 1.12 * (own.nape_height - own.waist_height),
        "bust": own.bust,
        "bust_line": 0.715 * (own.nape_height - own.waist_height),
        "vert_bust_line": 0.581 * (own.nape_height - own.waist_height),
        "hips": own.hip,
        "hips_line": own.waist_height - own.hip_height,
        "crotch_hip_diff": max(0.05, own.hip_height - own.crotch_height),
    }
    girths = {"bust": own.bust, "waist": own.waist, "hips": own.hip}
    metres |= {name: share * girths[SIDE.get(name, "hips")] for name, share in PROPORTIONS.items()}
    return {name: 100.0 * value for name, value in metres.items()} | dict(ANGLES)


def main() -> None:
    """Draw one wearer."""
    import anny

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", type=int, required=True)
    given = parser.parse_args()
    model = anny.Anny(skinning_method="lbs", local_changes="all").to(torch.float64)
    vertices, faces, gender = draw_body(model, given.seed)
    given.out.mkdir(parents=True, exist_ok=True)
    trimesh.Trimesh(vertices, faces, process=False).export(given.out / "body.ply")
    measures = measure_for_garmentcode(register_body(vertices, faces, name="body"))
    (given.out / "body.yaml").write_text(json.dumps({"body": measures}, indent=1))  # YAML reads JSON
    print(json.dumps({"seed": given.seed, "gender": gender, **measures}))


if __name__ == "__main__":
    main()
