"""Labels mended on the cleaned scan come back as they were given, whatever the file's mesh had to be mended of."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.deliver.export.person import write_segmented
from garmentq.core.people.labels import read_parts, write_labels
from garmentq.core.people.mend import LabelsOld, apply_corrected_labels
from garmentq.core.people.part import PARTS
from garmentq.core.people.separate import expand_to_file
from garmentq.core.scan.limits import Limits
from garmentq.core.scan.load_raw import load_raw
from garmentq.core.scan.refusal import LabelsMismatch
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree
from shells import dress_in_shells

INSIDE = Limits(is_confined=True)
"""Parsing here: a process for each file would take most of the time."""
SHELLS = dress_in_shells(0)
WORDS = np.array([int(part) for part in PARTS], np.uint8)
DEFECTS = ("pinched", "loose", "doubled", "crumbs", "crowded")
MESHES, CLOUDS = ("ply", "obj", "glb", "off", "stl"), ("xyz", "pcd", "ply")


def spoil(defects: set[str], rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Return the shells' mesh with defects that scanners leave, its vertices in another order."""
    points, faces = SHELLS.points.copy(), SHELLS.faces.copy()
    if "pinched" in defects:  # a vertex is two that do not touch: it is non-manifold, and is split in two
        _, near = cKDTree(points).query(points[rng.choice(len(points), 30, replace=False)], 40)
        free = np.ones(len(points), bool)
        for one, other in near[:, [0, -1]]:
            around = faces[np.isin(faces, [one, other]).any(axis=1)]
            if not free[around].all() or (np.isin(around, one).any(axis=1) & np.isin(around, other).any(axis=1)).any():
                continue
            free[around] = False
            points[one] = 0.5 * (points[one] + points[other])
            faces[faces == other] = one
    if "doubled" in defects:
        twice = rng.choice(len(points), 200, replace=False)
        index = np.arange(len(points))
        index[twice] = len(points) + np.arange(len(twice))
        second = rng.random(len(faces)) < 0.5
        faces = np.where(second[:, None], index[faces], faces)
        points = np.concatenate([points, points[twice]])
    if "crumbs" in defects:
        away = points[rng.choice(len(points), 5)] + [0.0, 0.0, 0.3]
        corners = np.concatenate([away, away + [0.004, 0, 0], away + [0, 0.004, 0]])
        faces = np.concatenate([faces, len(points) + np.arange(15).reshape(3, 5).T])
        points = np.concatenate([points, corners])
    if "crowded" in defects:  # a third face at an edge
        edge = faces[rng.choice(len(faces), 5), :2]
        tip = points[edge].mean(axis=1) + 0.01 * rng.standard_normal((5, 3))
        faces = np.concatenate([faces, np.column_stack([edge, len(points) + np.arange(5)])])
        points = np.concatenate([points, tip])
    if "loose" in defects:
        points = np.concatenate([points, points[:50] + 0.002, np.full((3, 3), 4.0)])
    order = rng.permutation(len(points))
    place = np.argsort(order)
    return points[order], place[faces]


def write_scan(path: Path, points: np.ndarray, faces: np.ndarray) -> None:
    """Write a mesh or, without faces, a cloud."""
    rows = "".join(f"{x!r} {y!r} {z!r}\n" for x, y, z in points.tolist())
    if path.suffix == ".pcd":
        head = f"FIELDS x y z\nSIZE 8 8 8\nTYPE F F F\nCOUNT 1 1 1\nWIDTH {len(points)}\nHEIGHT 1\nDATA ascii\n"
        path.write_text(head + rows)
    elif path.suffix == ".xyz":
        path.write_text(rows)
    elif len(faces) == 0:
        trimesh.PointCloud(points).export(path)
    else:
        trimesh.Trimesh(points, faces, process=False).export(path)


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    form=st.sampled_from([*((name, True) for name in MESHES), *((name, False) for name in CLOUDS)]),
    defects=st.sets(st.sampled_from(DEFECTS)),
    seed=st.integers(0, 2**32 - 1),
)
def test_any_scan_takes_back_mended_labels(tmp_path, form, defects, seed):
    """Broken where copies of a split vertex, loose, doubled or dropped points make labels be refused or shift them."""
    check_mending(tmp_path, *form, defects, seed)


@pytest.mark.parametrize("form", MESHES)
def test_each_format_of_a_mesh_takes_them_back(tmp_path, form):
    """Broken where the points of one format's mesh with all defects are counted by those that the file has."""
    check_mending(tmp_path, form, True, set(DEFECTS), 7)


def check_mending(folder: Path, form: str, has_faces: bool, defects: set[str], seed: int) -> None:
    """Take a scan apart by made-up labels, and mend some."""
    rng = np.random.default_rng(seed)
    points, faces = spoil(defects, rng)
    scan = folder / f"scan.{form}"
    write_scan(scan, points, faces if has_faces else faces[:0])
    raw = load_raw(scan, "m", "y", INSIDE)
    assert raw.is_cloud != has_faces
    assert not has_faces or "pinched" not in defects or any("non-manifold vert" in note for note in raw.notes)
    label, sure = expand_to_file(raw, rng.choice(WORDS, len(raw.points)), np.ones(len(raw.points), np.float32))
    stored = write_labels(label, sure, folder / "labels.npz", raw.place, raw.origin)
    shown = label[raw.origin]
    segmented = write_segmented(raw, shown, sure[raw.origin], folder / "segmented.ply")
    assert f"element vertex {len(shown)}\n".encode() in segmented.read_bytes()[:400]
    _, where = np.unique(raw.points, axis=0, return_inverse=True)
    for painted in (np.isin(where, rng.choice(where.max() + 1, 500)), rng.random(len(shown)) < 0.02):
        mended = np.where(painted, rng.choice(WORDS, len(shown)), shown)
        asked = apply_corrected_labels(stored, mended, folder / "mended.npz")
        given_back = read_parts(asked)[raw.origin]
        changed = mended != shown
        alone = np.bincount(where, changed)[where.ravel()] == 1  # of a split vertex one copy was painted
        assert np.array_equal(given_back[changed & alone], mended[changed & alone])
        untouched = np.bincount(where, changed)[where.ravel()] == 0
        assert np.array_equal(given_back[untouched], shown[untouched])
        dropped = raw.place < 0
        assert np.array_equal(read_parts(asked)[dropped], label[dropped])
    with pytest.raises(LabelsMismatch):
        apply_corrected_labels(stored, shown[1:], folder / "mended.npz")


def test_labels_stored_without_the_way_back(tmp_path):
    """Broken where what an earlier version stored is mended by the wrong points, or no longer mended at all."""
    place = np.array([1, -1, 0, 2])
    stored = write_labels(np.array([0, 20, 10, 0], np.uint8), np.ones(4), tmp_path / "labels.npz", place)
    asked = apply_corrected_labels(stored, np.array([11, 0, 1], np.uint8), tmp_path / "mended.npz")
    assert read_parts(asked).tolist() == [0, 20, 11, 1]
    with pytest.raises(LabelsOld):
        apply_corrected_labels(stored, np.array([11, 0, 1, 1], np.uint8), tmp_path / "mended.npz")
