"""Good files of every format, unit and axis come back as the same mesh."""

import hashlib

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.connectivity import HalfEdges
from garmentq.core.run.errors import BadInput
from garmentq.core.scan.load import load_pair, load_scan
from garmentq.core.scan.units import find_units, find_up


def shirt():
    """Return the trunk and upper arms of the built-in body as a garment: an open surface with four contours."""
    body = builtin_body("builtin:female,height=1.70")
    parts = [0, 3, 6, 9, 13, 14, 16, 17]
    keep = np.isin(body.weights.argmax(axis=1), parts) & (body.vertices[:, 1] > body.joints[1, 1])
    faces = body.faces[keep[body.faces].all(axis=1)]
    mesh = trimesh.Trimesh(body.vertices, faces, process=False)
    mesh.remove_unreferenced_vertices()
    return np.asarray(mesh.vertices), np.asarray(mesh.faces), body


V, F, BODY = shirt()


def write(path, vertices, faces, scale=1.0, up="y", **looks):
    """Write a mesh in another unit and axis."""
    points = vertices * scale
    if up == "z":
        points = np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)
    trimesh.Trimesh(points, faces, process=False, **looks).export(path)
    return path


@pytest.mark.parametrize(
    "extension,units,up",
    [("ply", "cm", "z"), ("obj", "m", "y"), ("stl", "mm", "z"), ("off", "m", "z"), ("glb", "m", "y")],
)
def test_every_format_gives_the_same_mesh(tmp_path, extension, units, up):
    """A loader that splits, reorders or scales vertices would change the surface."""
    scale = {"m": 1.0, "cm": 100.0, "mm": 1000.0}[units]
    path = write(tmp_path / f"shirt.{extension}", V, F, scale, up)
    scan = load_scan(path)
    assert (scan.units, scan.up_axis, scan.name) == (units, up, "shirt")
    assert len(scan.vertices) == len(V) and len(scan.faces) == len(F)
    mine = trimesh.Trimesh(scan.vertices, scan.faces, process=False)
    true = trimesh.Trimesh(V, F, process=False)
    assert np.allclose(mine.bounds, true.bounds, atol=2e-6)
    assert np.isclose(mine.area, true.area, rtol=1e-5)
    assert np.allclose(mine.triangles_center.mean(axis=0), true.triangles_center.mean(axis=0), atol=1e-5)
    assert scan.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


@pytest.mark.parametrize(
    ("name", "kept"),
    [("scalar_Label", True), ("Segment", True), ("scalar_C2C_distance", False), ("scalar_class", None)],
)
def test_whole_floats_are_labels(tmp_path, name, kept):
    """Broken where CloudCompare's scalar fields are no labels, or a field of fractions is rounded to some."""
    labels = np.arange(len(V)) % 3 + (0.5 if kept is None else 0.0)
    lines = [f"{x} {y} {z} {label}" for (x, y, z), label in zip(V, labels, strict=True)]
    lines += [f"3 {a} {b} {c}" for a, b, c in F]
    head = f"ply\nformat ascii 1.0\nelement vertex {len(V)}\n" + "".join(f"property float {axis}\n" for axis in "xyz")
    head += f"property float {name}\nelement face {len(F)}\nproperty list uchar int vertex_indices\nend_header\n"
    path = tmp_path / "labelled.ply"
    path.write_text(head + "\n".join(lines) + "\n")
    found = load_scan(path).labels
    assert (found is not None) == bool(kept)
    assert found is None or np.array_equal(np.unique(found), [0, 1, 2])


def test_ascii_ply_keeps_colours_and_labels(tmp_path):
    """Colours and labels must stay with their vertices, also when vertices are merged and dropped."""
    rows = [f"{x} {y} {z} {i % 256} 7 9 {i % 3}" for i, (x, y, z) in enumerate(V)]
    header = (
        f"ply\nformat ascii 1.0\ncomment by hand\nelement vertex {len(V) + 1}\n"
        "property double x\nproperty double y\nproperty double z\nproperty uchar red\nproperty uchar green\n"
        f"property uchar blue\nproperty int label\nelement face {len(F)}\n"
        "property list uchar int vertex_indices\nend_header\n"
    )
    unused = "9.5 0 0 1 2 3 5\n"
    body = unused + "\n".join(rows) + "\n" + "\n".join(f"3 {a + 1} {b + 1} {c + 1}" for a, b, c in F) + "\n"
    path = tmp_path / "a.ply"
    path.write_text(header + body)
    scan = load_scan(path)
    order = np.arange(len(V))
    assert np.allclose(scan.vertices, V, atol=1e-12)
    assert np.array_equal(scan.labels, order % 3)
    assert np.allclose(scan.colours, np.stack([order % 256, 0 * order + 7, 0 * order + 9], axis=1) / 255)


def test_polygons_and_relative_indices_of_obj(tmp_path):
    """Quads and negative indices are legal in an OBJ and must give the right triangles."""
    text = "".join(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in V)
    text += "".join(f"f {a - len(V)}/1 {b - len(V)}/2/3 {c - len(V)}//1\n" for a, b, c in F)
    path = tmp_path / "a.obj"
    path.write_text(text)
    scan = load_scan(path)
    assert np.array_equal(scan.faces, F)


@pytest.mark.parametrize("units,up", [("cm", "z"), ("m", "y")])
def test_pair_takes_unit_and_axis_from_the_body(tmp_path, units, up):
    """A garment of an unclear axis must follow its body, which is clear."""
    scale = {"m": 1.0, "cm": 100.0}[units]
    garment = write(tmp_path / "g.ply", V, F[:, ::-1], scale, up)
    wearer = write(tmp_path / "b.ply", BODY.vertices, BODY.faces, scale, up)
    scan, body = load_pair(garment, wearer)
    assert (scan.units, scan.up_axis, body.units, body.up_axis) == (units, up, units, up)
    assert np.allclose(scan.vertices, V, atol=1e-5)
    assert np.array_equal(scan.faces, F) or np.array_equal(np.sort(scan.faces), np.sort(F))


def test_pair_with_different_units(tmp_path):
    """A garment in cm with z up on a body in m with y up must be brought onto it, and the user told."""
    garment = write(tmp_path / "g.ply", V, F, 100.0, "z")
    wearer = write(tmp_path / "b.ply", BODY.vertices, BODY.faces)
    scan, _ = load_pair(garment, wearer)
    assert np.allclose(scan.vertices, V, atol=1e-5)
    assert any("cm" in sentence for sentence in scan.repairs)


def test_pair_in_inches_is_refused(tmp_path):
    """A garment in inches on a body in metres must not be read as a small one in centimetres."""
    garment = write(tmp_path / "g.ply", V, F, 1 / 0.0254)
    wearer = write(tmp_path / "b.ply", BODY.vertices, BODY.faces)
    with pytest.raises(BadInput) as caught:
        load_pair(garment, wearer)
    assert caught.value.code == "scan.units_unknown" and "--units inch" in str(caught.value)


@pytest.mark.parametrize("unit,scale", [("m", 1.0), ("cm", 100.0), ("mm", 1000.0)])
def test_units_by_size(unit, scale):
    """The size of a person or a worn garment must fit exactly one unit."""
    assert find_units(V * scale) == unit
    assert find_units(V * scale, faces=F) == unit
    assert find_units(BODY.vertices * scale, "body") == unit


@pytest.mark.parametrize("height", [1.5, 1.7, 1.9])
def test_body_in_inches_is_refused(height):
    """No adult's height in inches may pass as a child's in centimetres."""
    with pytest.raises(BadInput) as caught:
        find_units(BODY.vertices * (height / 1.7) / 0.0254, "body")
    assert caught.value.code == "scan.units_unknown"


def test_up_axis_by_openings_and_by_shape():
    """A short wide skirt is deeper than high: its openings must tell the axis, not its box."""
    around = 32
    angle = 2 * np.pi * np.arange(around) / around
    ring = np.stack([np.sin(angle), np.zeros(around), np.cos(angle)], axis=1)
    skirt = np.concatenate([0.3 * ring, 0.12 * ring + [0, 0.25, 0]])
    j = np.arange(around)
    k = (j + 1) % around
    faces = np.concatenate([np.stack([j, k, k + around], 1), np.stack([j, k + around, j + around], 1)])
    assert find_up(skirt, HalfEdges.of(faces)) == "y"
    assert find_up(skirt[:, [0, 2, 1]], HalfEdges.of(faces)) == "z"
    assert find_up(BODY.vertices, HalfEdges.of(BODY.faces), "body") == "y"
    assert find_up(BODY.vertices[:, [0, 2, 1]], HalfEdges.of(BODY.faces), "body") == "z"
    with pytest.raises(BadInput) as caught:
        find_up(skirt @ np.linalg.qr(np.array([[1.0, 0, 0], [0, 1, 1], [0, -1, 1]]))[0], HalfEdges.of(faces))
    assert caught.value.code == "scan.up_ambiguous"
