"""Make `anny_reference.json`: persons by Anny's parameters, with vertices and bone heads as the `anny` package has.

Run it after `pip install garmentq[develop]` as `python tests/body/anny_reference.py`.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

REFERENCE = Path(__file__).with_name("anny_reference.json")
VERTEX_STEP = 400
"""Every so many vertices of the skin are kept in the file."""


def make_persons() -> list[dict[str, Any]]:
    """Return arguments of Anny's: an average adult, a child, one with all phenotypes, and two who are posed."""
    rng = np.random.default_rng(3)
    every = {
        "gender": 0.9, "age": 0.85, "muscle": 0.3, "weight": 0.8, "height": 0.35, "proportions": 0.7, "cupsize": 0.8,
        "firmness": 0.2, "african": 0.6, "asian": 0.1, "caucasian": 0.3,
    }  # fmt: skip
    persons: list[dict[str, Any]] = [
        {"phenotype_kwargs": {"gender": 0.0, "age": 0.7}},
        {"phenotype_kwargs": {"age": 0.15, "height": 0.6}},
        {"phenotype_kwargs": every},
    ]
    bones = ("root", "upperarm01.L", "upperarm01.R", "lowerarm01.L", "upperleg01.R", "spine03", "neck02", "finger2-1.L")
    for parameterization in ("local-ref", "local-bone"):
        moves = np.tile(np.eye(4), (len(bones), 1, 1))
        moves[:, :3, :3] = Rotation.from_rotvec(rng.normal(0.0, 0.3, (len(bones), 3))).as_matrix()
        moves[0, :3, 3] = rng.normal(0.0, 0.3, 3)
        persons.append(
            {
                "phenotype_kwargs": {"gender": 1.0, "age": 0.66, "weight": 0.65},
                "pose_parameterization": parameterization,
                "pose_parameters": {bone: move.tolist() for bone, move in zip(bones, moves, strict=True)},
            }
        )
    return persons


def compute_with_anny(model: Any, person: dict[str, Any]) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and bone heads [m] as the `anny` package computes them, in our axes."""
    import torch

    moves = {
        bone: torch.tensor([move], dtype=torch.float64) for bone, move in person.get("pose_parameters", {}).items()
    }
    found = model(
        pose_parameters=moves or None,
        phenotype_kwargs={
            name: torch.tensor([value], dtype=torch.float64) for name, value in person["phenotype_kwargs"].items()
        },
        pose_parameterization=person.get("pose_parameterization"),
    )
    vertices, heads = found["vertices"][0].numpy(), found["bone_poses"][0, :, :3, 3].numpy()
    return vertices[:, [0, 2, 1]] * (1, 1, -1), heads[:, [0, 2, 1]] * (1, 1, -1)


def make_model() -> Any:
    """Return Anny's model as its users make it, with all phenotypes."""
    import anny
    import torch

    return anny.Anny(skinning_method="lbs", phenotypes="all").to(torch.float64)


if __name__ == "__main__":
    from garmentq.core.body.models.anny import load_anny_model

    own, chosen = make_model(), load_anny_model().vertex_numbers[::VERTEX_STEP]
    found = []
    for one in make_persons():
        vertices, heads = compute_with_anny(own, one)
        found.append({"person": one, "vertices": vertices[chosen].round(9).tolist(), "heads": heads.round(9).tolist()})
    REFERENCE.write_text(json.dumps(found) + "\n")
