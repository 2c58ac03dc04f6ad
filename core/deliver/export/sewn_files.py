"""Write a garment's mesh as OBJ and GLB with its flat rest shape, panels, seams and fabric."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from .glb import GL_ARRAY_BUFFER, GL_ELEMENT_ARRAY_BUFFER, GlbBuffer, describe_scene, make_material, pack_glb
from .sewn_mesh import SewnMesh, describe_cloth, panel_colour, sanitise_names, seams_of_uv


def write_sewn_obj(mesh: SewnMesh, path: Path, image: Path | None = None) -> list[Path]:
    """Write a welded OBJ [m] with a material library, and a JSON of what OBJ cannot represent.

    Each panel is a group with a material of its own, and each corner has its flat position [m] for uv. The JSON is
    `describe_cloth`, and the vertices of each seam and contour in order, numbered from 1 as in the OBJ.

    Args:
        mesh: The mesh.
        path: The OBJ; both others have its name.
        image: A texture in the same folder: all panels then share one material, and uv are within 0..1.

    Returns:
        The OBJ, its `.mtl` and its `.json`.
    """
    garment, library, sidecar = mesh.garment, path.with_suffix(".mtl"), path.with_suffix(".json")
    names = sanitise_names([panel.name for panel in garment.pattern.panels])
    flat, scale = (mesh.metre_uv, 1.0) if image is None else mesh.unit_uv
    lines = [f"# metres, y up; 1 unit of uv is {scale:.9g} m of cloth", f"mtllib {library.name}", f"o {mesh.name}"]
    lines += [f"v {x:.7f} {y:.7f} {z:.7f}" for x, y, z in mesh.nodes.tolist()]
    lines += [f"vt {u:.7f} {v:.7f}" for u, v in flat.tolist()]
    lines += [f"vn {x:.5f} {y:.5f} {z:.5f}" for x, y, z in mesh.normals.tolist()]
    for index, name in enumerate(names):
        rows = np.flatnonzero(garment.panel_of_face == index)
        lines += [f"g {name}", f"usemtl {name if image is None else 'cloth'}"]
        corner_nodes, corner_uv = (garment.faces[rows] + 1).tolist(), (garment.uv_faces[rows] + 1).tolist()
        for corners, places in zip(corner_nodes, corner_uv, strict=True):
            lines.append("f " + " ".join(f"{v}/{t}/{v}" for v, t in zip(corners, places, strict=True)))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    if image is None:
        colours = [" ".join(f"{value:.4f}" for value in panel_colour(n, len(names))) for n in range(len(names))]
        materials = [f"newmtl {name}\nKd {kd}\nKs 0 0 0\nillum 1\n" for name, kd in zip(names, colours, strict=True)]
    else:
        materials = [f"newmtl cloth\nKd 1 1 1\nKs 0 0 0\nillum 1\nmap_Kd {image.name}\n"]
    library.write_text("\n".join(materials), encoding="utf-8")
    described = describe_cloth(mesh, image is not None)
    described["metres_per_unit_of_uv"] = [scale]
    for seam, described_seam in zip(garment.pattern.seams, described["seams"], strict=True):
        described_seam["vertices"] = (garment.uv_node[garment.edge_uv[seam.a]] + 1).tolist()
    described["contours"] = {contour.name: (contour.vertices + 1).tolist() for contour in garment.contours}
    sidecar.write_text(json.dumps(described, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    return [path, library, sidecar]


def write_sewn_glb(mesh: SewnMesh, path: Path, image: bytes | None = None) -> Path:
    """Write a GLB [m] of one primitive a panel, each with a material of its own.

    Attributes of its vertices: POSITION, NORMAL; TEXCOORD_0, the flat position [m] (glTF's v runs downwards, so it is 1
    - v); TEXCOORD_1, the same panels within 0..1; `_NODE`, the welded node, so that the panels can be sewn again;
    `_PANEL`; `_SEAM_A` and `_SEAM_B`, up to two seams, -1 for none. Application-specific attributes are float32, since
    32-bit integers are not allowed, and all of one width: Blender 4.5 and 5.0 read those of several widths in an order
    that differs between starts, and then fail. `extras` of the mesh are `describe_cloth`.

    Args:
        mesh: The mesh.
        path: The file.
        image: A texture's PNG, with which the panels then share one material; the two sets of uv are exchanged for
            programs that read only the first.
    """
    garment, buffer = mesh.garment, GlbBuffer()
    split = garment.uv_node
    flat, unit = mesh.metre_uv.copy(), mesh.unit_uv[0].copy()
    flat[:, 1], unit[:, 1] = 1.0 - flat[:, 1], 1.0 - unit[:, 1]
    first, second = (flat, unit) if image is None else (unit, flat)
    seams = seams_of_uv(garment)
    values = {
        "POSITION": mesh.nodes[split], "NORMAL": mesh.normals[split], "TEXCOORD_0": first, "TEXCOORD_1": second,
        "_NODE": split, "_PANEL": garment.panel_of_uv, "_SEAM_A": seams[:, 0], "_SEAM_B": seams[:, 1],
    }  # fmt: skip
    names = sanitise_names([panel.name for panel in garment.pattern.panels])
    primitives: list[dict[str, Any]] = []
    for index, name in enumerate(names):
        rows = np.flatnonzero(garment.panel_of_uv == index)
        place = np.zeros(len(garment.uv), dtype=np.int64)
        place[rows] = np.arange(len(rows))
        corners = place[garment.uv_faces[garment.panel_of_face == index]]
        attributes = {
            key: buffer.add(np.ascontiguousarray(array[rows].astype("<f4")), GL_ARRAY_BUFFER, bounds=key == "POSITION")
            for key, array in values.items()
        }
        primitives.append(
            {
                "attributes": attributes,
                "indices": buffer.add(corners.astype("<u4").ravel(), GL_ELEMENT_ARRAY_BUFFER),
                "material": index if image is None else 0,
                "extras": {"panel": index, "name": name},
            }
        )
    if image is None:
        colours = [{"baseColorFactor": [*panel_colour(n, len(names)), 1.0]} for n in range(len(names))]
        materials = [make_material(name, each) for name, each in zip(names, colours, strict=True)]
    else:
        materials = [make_material("cloth", {"baseColorTexture": {"index": 0}})]
    scene = describe_scene(mesh.name, primitives, materials, {"garmentq": describe_cloth(mesh, image is not None)})
    if image is not None:
        scene["textures"] = [{"source": 0, "sampler": 0}]
        scene["samplers"] = [{"magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071}]
        scene["images"] = [{"bufferView": buffer.add_bytes(image), "mimeType": "image/png", "name": "texture"}]
    path.write_bytes(pack_glb(scene, buffer))
    return path
