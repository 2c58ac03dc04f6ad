"""Samples of matched contours and the repair of a target."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.geometry.curves import Curve
from garmentq.core.recover.deform.contour_match import sample_curve
from garmentq.core.recover.deform.target_repair import flatten_spikes, match_contours, prepare_target


def test_curve_samples_are_even():
    """Breaks if the last edge of a closed curve is lost, or samples bunch at its corners."""
    samples = sample_curve(Curve(np.array([[0, 0, 0], [0.3, 0, 0], [0.3, 0.1, 0], [0, 0.1, 0]], dtype=float))).foot
    gap = np.linalg.norm(np.roll(samples, -1, axis=0) - samples, axis=1)
    assert np.median(gap) == pytest.approx(0.8 / len(samples)) and gap.max() < 1.001 * 0.8 / len(samples)


def test_spikes_are_flattened_and_sound_vertices_stay(scene):
    """Breaks if outliers of 5 cm survive, or the median moves a border or a fold."""
    _, target, _ = scene
    generator = np.random.default_rng(0)
    hit = generator.choice(len(target.vertices), 20, replace=False)
    noisy = target.vertices.copy()
    noisy[hit] += 0.05 * np.array([[1, 0, 0]]) * np.sign(target.vertices[hit, :1])
    repaired, moved = flatten_spikes(noisy, target.faces)
    assert set(hit) <= set(np.flatnonzero(moved)) and moved.sum() <= 24
    off = np.linalg.norm(repaired - target.vertices, axis=1)[hit]
    assert np.median(off) < 0.01 and off.max() < 0.04
    assert not flatten_spikes(target.vertices, target.faces)[1].any()


def test_vote_turns_reversed_normals_and_gives_up_on_random_signs(scene):
    """Breaks if an inside-out scan turns the garment over, or random signs are believed."""
    garment, target, _ = scene
    arguments = (garment, True)
    plain = prepare_target(target, *arguments)
    assert not plain.reversed and not plain.unsigned
    turned = prepare_target(replace(target, normals=-target.normals), *arguments)
    assert turned.reversed and np.allclose(turned.normals, plain.normals)
    sign = np.where(np.random.default_rng(0).random(len(target.normals)) < 0.4, -1.0, 1.0)
    assert prepare_target(replace(target, normals=target.normals * sign[:, None]), *arguments).unsigned


def test_contours_match_by_name_and_only_if_trusted(scene):
    """Breaks if a cut-off hem is matched, or contours are matched by order."""
    garment, target, _ = scene
    hem, waist = target.contours
    assert [(a.name, b.name) for a, b in match_contours(garment.contours, (waist, hem))] == [
        ("hem", "hem"),
        ("waist", "waist"),
    ]
    cut = replace(hem, trusted=False)
    assert [a.name for a, _ in match_contours(garment.contours, (cut, waist))] == ["waist"]


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_uneven_mesh_has_no_spikes(seed: int) -> None:
    """Breaks if vertices of a decimated scan are taken for spikes because their rings are lopsided (40 to 51 were)."""
    from scipy.spatial import Delaunay

    rng = np.random.default_rng(seed)
    # densely in one half of the sheet, six times as sparsely in the other
    flat = np.concatenate([rng.random((1500, 2)) * [0.2, 0.4], rng.random((40, 2)) * [0.2, 0.4] + [0.2, 0.0]])
    faces = Delaunay(flat).simplices.astype(np.int64)
    bent = np.column_stack([0.15 * np.sin(flat[:, 0] / 0.15), flat[:, 1], 0.15 * np.cos(flat[:, 0] / 0.15)])
    assert flatten_spikes(bent, faces)[1].sum() <= 2, "slivers along the convex hull may be misread"
