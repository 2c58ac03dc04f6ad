"""Outfits that were modelled by hand, from the CC0 MakeHuman assets: half are trained on, half kept for measuring."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import trimesh

from ..core.body.body import Body
from ..core.body.template import Template
from ..core.geometry.connectivity import find_components
from ..core.people.part import Part
from .accessories import worn_asset
from .base_mesh import read_base_mesh, read_worn
from .cloth import Mesh, clear, refine, tuck_under
from .wardrobe import Layer, grid_of

TRAINED_OUTFITS = ("female_casualsuit02", "female_sportsuit01", "male_casualsuit03", "male_casualsuit06")
"""Every second one of those of two clear garments; in others jacket, shirt and tie, or a hood and jeans, are one."""

HELD_OUT_OUTFITS = ("female_casualsuit01", "female_elegantsuit01", "male_casualsuit02", "male_casualsuit04")
"""The others of two clear garments."""

WAIST = 1.06
"""Height [m] on the mean body that a lower garment ends below: waistbands end at 0.99, tops at 1.47."""

SMALLEST = 300
"""Vertices of the smallest piece that is a garment; buttons and buckles have less."""

Outfit = list[tuple[Part, Mesh]]


def load_outfits(folder: Path, names: tuple[str, ...]) -> dict[str, Outfit]:
    """Return outfits around the mean body's T-pose, the lower garment first.

    Args:
        folder: Holds `base.obj` and `clothes`.
        names: Folders of `clothes`.
    """
    base = read_base_mesh(folder / "base.obj")
    return {name: _pieces(read_worn(folder / "clothes" / name, name, base)) for name in names}


def wear_outfit(template: Template, body: Body, outfit: Outfit) -> list[Layer]:
    """Return an outfit on a wearer in his pose."""
    grid = grid_of(body)
    layers = []
    for part, mesh in outfit:
        worn = refine(*worn_asset(template, body, mesh, 1.0))
        layers.append(Layer(part, clear(worn, grid, 0.002)))
    if len(layers) > 1:
        layers[0] = Layer(layers[0].part, tuck_under(layers[0].mesh, layers[1].mesh))
    return layers


def _pieces(worn: Mesh) -> Outfit:
    """Split a mesh into its garments by what hangs together."""
    places, index = np.unique(np.round(worn[0], 5), axis=0, return_inverse=True)
    faces = index.reshape(-1)[worn[1]]
    ends = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]]])
    _, piece = find_components(len(places), ends[:, 0], ends[:, 1])
    found = []
    for number in np.flatnonzero(np.bincount(piece) >= SMALLEST):
        own = faces[piece[faces[:, 0]] == number]
        own = own[(own != np.roll(own, 1, axis=1)).all(axis=1)]
        used, corner = np.unique(own, return_inverse=True)
        part = Part.LOWER if places[used, 1].max() < WAIST else Part.UPPER
        found.append((part, (places[used], wind_alike(places[used], corner.reshape(-1, 3)))))
    return sorted(found, key=lambda one: -int(one[0]))


def wind_alike(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the faces of a piece wound as most of them are, shape [face_count, 3]; subdivision needs one side."""
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    trimesh.repair.fix_winding(mesh)
    found = np.asarray(mesh.faces, np.int64)
    normals = (np.cross(*np.diff(vertices[each], axis=1).transpose(1, 0, 2)) for each in (faces, found))
    alike = np.einsum("fa,fa->f", *normals) > 0.0
    return found if alike.mean() > 0.5 else found[:, ::-1]
