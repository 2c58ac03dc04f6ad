"""Symmetry of a T-shirt, and seams made equal."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.control import map_controls
from garmentq.core.garment.curves import chord
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.pattern import EdgeRef
from garmentq.core.garment.seams import equalise_seams, seam_constraints, seam_lengths, seam_mismatch, seam_ratios
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.symmetry import find_symmetry
from garmentq.core.garment.templates import load_template


def _pairs(pattern):
    names = [panel.name for panel in pattern.panels]
    return {(names[m.source], names[m.target]) for m in find_symmetry(pattern).mirrors}


def test_tee_pairs_and_halves(tee_file):
    """Breaks where sleeves are not paired or a body panel's own mirror is missed."""
    pattern = read_pattern(tee_file)
    assert _pairs(pattern) == {("front", "front"), ("back", "back"), ("sleeve_left", "sleeve_right")}
    symmetry = find_symmetry(pattern)
    # Eight points of each body panel fall into four pairs; one sleeve's four stand for both.
    assert len(symmetry.effective) == 4 + 4 + 4
    assert symmetry.expand(symmetry.reduce(pattern.points)) == pytest.approx(pattern.points, abs=1e-14)


def test_expand_moves_images_as_mirrors(tee_file):
    """Breaks where a reflection is a rotation: moving effective points must keep left and right seams equal."""
    pattern = read_pattern(tee_file)
    symmetry = find_symmetry(pattern)
    rng = np.random.default_rng(0)
    base = symmetry.reduce(pattern.points)
    moved = pattern.with_points(symmetry.expand(base + rng.normal(scale=0.01, size=base.shape)))
    lengths = seam_lengths(moved)
    assert lengths[0] == pytest.approx(lengths[1][::1], abs=1e-12)
    assert lengths[2] == pytest.approx(lengths[3], abs=1e-12)
    assert lengths[4] == pytest.approx(lengths[5], abs=1e-12)


def test_points_on_the_axis_stay_on_it(tee_file):
    """Breaks where an axis point may move sideways: the neck's middle is one."""
    front = tee_file["pattern"]["panels"]["front"]
    front["vertices"].append([0, 52])
    front["edges"][4] = {"endpoints": [4, 8]}
    front["edges"].insert(5, {"endpoints": [8, 5]})
    for stitch in tee_file["pattern"]["stitches"]:
        for side in stitch:
            if side["panel"] == "front" and side["edge"] > 4:
                side["edge"] += 1
    pattern = read_pattern(tee_file)
    symmetry = find_symmetry(pattern)
    assert ("front", "front") in _pairs(pattern)
    moved = symmetry.expand(symmetry.reduce(pattern.points) + 0.03)
    assert moved[5] == pytest.approx([0.0, 0.55], abs=1e-12)


def test_asymmetric_handle_is_no_symmetry(tee_file):
    """Breaks where only control points are compared: one armhole is cut deeper."""
    tee_file["pattern"]["panels"]["front"]["edges"][2]["curvature"] = [0.4, 0.3]
    assert ("front", "front") not in _pairs(read_pattern(tee_file))


def test_congruent_front_and_back_are_not_tied(tee_file):
    """Breaks where the placement is ignored: front and back of this T-shirt have the same outline."""
    assert ("front", "back") not in _pairs(read_pattern(tee_file))


def test_unplaced_panels_fall_back_to_shapes(tee_file):
    """Breaks where a file without placement finds no symmetry."""
    for panel in tee_file["pattern"]["panels"].values():
        panel["translation"] = [0, 0, 0]
    assert ("sleeve_left", "sleeve_right") in _pairs(read_pattern(tee_file))


@pytest.mark.parametrize("symmetric", [True, False])
def test_seams_become_equal(tee_file, symmetric):
    """Breaks where Gauss-Newton has a wrong derivative, or walks far from where it started."""
    pattern = read_pattern(tee_file)
    symmetry = find_symmetry(pattern)
    rng = np.random.default_rng(3)
    if symmetric:
        base = symmetry.reduce(pattern.points)
        points = symmetry.expand(base + rng.normal(scale=0.008, size=base.shape))
    else:
        points = pattern.points + rng.normal(scale=0.008, size=pattern.points.shape)
    moved = pattern.with_points(points)
    before = seam_mismatch(moved)
    equal = equalise_seams(moved, base=pattern)
    assert before > 1e-3 and seam_mismatch(equal) < 1e-4
    assert np.abs(equal.points - points).max() < 1.5 * before
    if symmetric:
        assert symmetry.expand(symmetry.reduce(equal.points)) == pytest.approx(equal.points, abs=1e-9)


def test_fixed_points_and_gathers_stay(skirt_file):
    """Breaks where a fixed point moves or a gathered seam loses its ratio."""
    pattern = read_pattern(skirt_file)
    ratio = np.divide(*seam_lengths(pattern)[2])
    moved = pattern.panel("front").points * [1.0, 1.1]
    longer = pattern.with_points({"front": moved})
    equal = equalise_seams(longer, fixed=[("front", 0), ("front", 1)], base=pattern)
    assert seam_mismatch(equal) < 1e-4
    assert equal.panel("front").points[:2] == pytest.approx(moved[:2], abs=1e-12)
    assert np.divide(*seam_lengths(equal)[2]) == pytest.approx(ratio, rel=1e-4)


def test_equal_seams_are_left_alone(tee_file):
    """Breaks where equalising drifts on a pattern that needs nothing."""
    even = equalise_seams(read_pattern(tee_file))
    assert equalise_seams(even).points == pytest.approx(even.points, abs=1e-6)


def test_mirrored_file_has_the_same_symmetry(tee_file):
    """Breaks where symmetry depends on which side the author drew."""
    mirrored = copy.deepcopy(tee_file)
    for panel in mirrored["pattern"]["panels"].values():
        panel["vertices"] = [[-x, y] for x, y in panel["vertices"]]
        panel["translation"][0] *= -1
        panel["rotation"][1] *= -1
        for edge in panel["edges"]:
            if "curvature" in edge:
                edge["curvature"][1] *= -1
    assert len(find_symmetry(read_pattern(mirrored)).effective) == 12


@pytest.mark.parametrize("name", ["skirt", "tshirt", "sleeved_dress"])
def test_derivatives_of_the_seams(name: str) -> None:
    """Breaks if a seam's row has a wrong point, sign, factor or ratio: against central differences."""
    pattern = load_template(name)
    rng = np.random.default_rng(0)
    points = pattern.points + 5e-3 * rng.normal(size=pattern.points.shape)
    way = rng.normal(size=points.shape)
    ends = [seam_constraints(pattern, points + sign * 1e-6 * way)[0] for sign in (1.0, -1.0)]
    missing, rates = seam_constraints(pattern, points)
    np.testing.assert_allclose(rates @ way.ravel(), (ends[0] - ends[1]) / 2e-6, rtol=1e-6, atol=1e-8)
    lengths = seam_lengths(pattern.with_points(points))
    np.testing.assert_allclose(missing, lengths[:, 0] - seam_ratios(pattern) * lengths[:, 1], atol=1e-12)


def test_a_pattern_knows_where_its_edges_end_and_what_was_found_of_it() -> None:
    """Breaks if an edge's ends are another panel's, or if a moved pattern has what was found of the one before."""
    pattern = load_template("tshirt")
    for panel in pattern.panels:
        for index in range(len(panel.edges)):
            start, end = pattern.ends_of(EdgeRef(panel.name, index))
            np.testing.assert_array_equal(pattern.points[[start, end]], chord(panel, index))
    moved = pattern.with_points(pattern.points * 1.5)
    assert find_symmetry(pattern) is find_symmetry(pattern)
    assert find_symmetry(moved) is not find_symmetry(pattern)
    garment = mesh_pattern(pattern, 200)
    assert map_controls(garment) is map_controls(garment) is not map_controls(replace(garment, uv=2.0 * garment.uv))
