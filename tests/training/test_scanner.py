"""The simulated scanner: what is seen of layers, and the truth it keeps."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh
from garmentq.core.people.part import Part
from garmentq.training.scanner import KINDS, POINTS, SPACING, border_distance, draw_scanner, scan_person, see
from garmentq.training.shards import Shard, load_shard, save_shard
from garmentq.training.wardrobe import Layer


def ball(radius, centre=(0.0, 0.0, 0.0)):
    """Return a ball's surface."""
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    return np.asarray(mesh.vertices) + centre, np.asarray(mesh.faces, np.int64)


def test_only_the_outermost_layer_is_seen():
    """Broken where covered skin is in the scan, or points face inward, or lie beside the surface."""
    layers = [Layer(Part.SKIN, ball(0.2)), Layer(Part.UPPER, ball(0.21))]
    points, normals, surface = see(layers, np.random.default_rng(0))
    assert set(surface.tolist()) == {1}
    assert np.linalg.norm(points, axis=1) == pytest.approx(0.21, abs=1e-3)
    assert (np.einsum("na,na->n", points, normals) > 0).all()
    whole = 4 * np.pi * 0.21**2 / SPACING**2
    assert 0.8 * whole < len(points) < 1.05 * whole


def test_what_stands_before_hides():
    """Broken where occlusion is not looked at: the small ball inside the large one's shadow from every side."""
    shell = ball(0.3)
    gap = shell[1][shell[0][shell[1]].mean(axis=1)[:, 1] < 0.27]  # open at the top
    layers = [Layer(Part.OTHER, ball(0.02, (0.0, -0.25, 0.0))), Layer(Part.LOWER, (shell[0], gap))]
    _, _, surface = see(layers, np.random.default_rng(0))
    assert (surface == 0).mean() < 0.01


def test_distance_to_a_border_on_a_line():
    """Broken where the distance is to the nearest point and not to the nearest of another label."""
    points = np.column_stack([np.arange(10) * 0.01, np.zeros(10), np.zeros(10)])
    label = np.array([0] * 4 + [10] * 6)
    assert border_distance(points, label) == pytest.approx([0.04, 0.03, 0.02, 0.01, 0.01, 0.02, 0.03, 0.04, 0.05, 0.06])
    assert border_distance(points, np.zeros(10)) == pytest.approx(0.1)


def test_a_shard_comes_back(tmp_path):
    """Broken where a file loses what a trainer reads, or a scan is no scan that a separation would take."""
    vertices, faces = ball(0.9)
    normals = vertices / 0.9
    label = np.where(vertices[:, 1] > 0, 10, 0).astype(np.uint8)
    kept = Shard(
        vertices, normals, faces, label, (label > 0).astype(np.uint8), np.full(len(vertices), 0.01),
        border_distance(vertices, label), vertices, {"shape": np.zeros(3)}, {"seed": 4},
    )  # fmt: skip
    save_shard(kept, tmp_path / "one.npz")
    found = load_shard(tmp_path / "one.npz")
    assert found.points == pytest.approx(kept.points, abs=1e-6)
    assert (np.einsum("na,na->n", found.normals, kept.normals) > 0.9999).all()
    assert (found.label == label).all() and (found.surface == (label > 0)).all()
    assert found.tightness == pytest.approx(0.01, rel=1e-3)
    assert found.about == {"seed": 4}
    raw = found.raw_scan()
    assert not raw.is_cloud
    assert (raw.place == np.arange(len(vertices))).all()


RECONSTRUCTED = ("depth", "image", "watertight")
"""Kinds whose surface is reconstructed as a fused one's is, for ten seconds each."""


@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=pytest.mark.nightly) if kind in RECONSTRUCTED else kind for kind in KINDS]
)
def test_every_scanner_keeps_the_truth(kind):
    """Broken where a kind of scanner loses labels, moves the surface by more than its faults, or gives no normals."""
    rng = np.random.default_rng(0)
    upper, lower = (body_half(sign) for sign in (1.0, -1.0))
    layers = [Layer(Part.UPPER, upper), Layer(Part.LOWER, lower)]
    scanner = replace(draw_scanner(rng), kind=kind, noise=0.001, bumps=0.0, holes=(), floor=False, soles=True)
    body = SimpleNamespace(vertices=ball(0.5)[0], faces=ball(0.5)[1], parameters={})
    shard = scan_person(layers, body, scanner, rng)
    assert {int(part) for part in (Part.UPPER, Part.LOWER)} == set(shard.label.tolist())
    assert len(shard.faces) > 1000 or kind in POINTS
    assert np.median(np.abs(np.linalg.norm(shard.points, axis=1) - 0.5)) < 0.012
    assert ((shard.points[:, 1] > 0) == (shard.label == Part.UPPER)).mean() > 0.97
    size = np.linalg.norm(shard.normals, axis=1)
    assert (np.abs(size - 1.0) < 1e-6).mean() > 0.99
    assert (np.einsum("na,na->n", shard.normals, shard.points) > 0).mean() > 0.95


def body_half(sign):
    """Return the upper or the lower half of a ball's surface."""
    vertices, faces = ball(0.5)
    return vertices, faces[sign * vertices[faces].mean(axis=1)[:, 1] > 0]
