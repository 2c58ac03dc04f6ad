"""A whole person comes in from every format, in any unit, on any axis, and out of any clutter."""

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.people.person_input import PersonFiles, read_person_input
from garmentq.core.run.errors import BadInput
from garmentq.core.scan.clean import _stands_beside
from garmentq.core.scan.limits import Limits
from garmentq.core.scan.load_raw import load_raw
from garmentq.core.scan.open3d_library import load_open3d
from garmentq.core.scan.parse import parse
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

INSIDE = Limits(is_confined=True)
"""Parsing here: a process for each file would take most of the time."""
BODY = builtin_body("builtin:female,height=1.70")
V, F = BODY.vertices, BODY.faces
P, _FACE = trimesh.sample.sample_surface(trimesh.Trimesh(V, F, process=False), 8000, seed=0)
COLOURS = np.random.default_rng(5).integers(0, 256, P.shape).astype(np.uint8)
NORMALS = np.array(trimesh.Trimesh(V, F, process=False).face_normals[_FACE])
FLOOR = float(V[:, 1].min())

BACK = {
    "y": lambda x, y, z: (x, y, z),
    "z": lambda x, y, z: (x, -z, y),
    "-y": lambda x, y, z: (x, -y, -z),
    "-z": lambda x, y, z: (x, z, -y),
    "x": lambda x, y, z: (y, -x, z),
    "-x": lambda x, y, z: (-y, x, z),
}
"""From y up to a file's axes."""


def place_in_file(points, up="y", scale=1.0):
    """Return points as a file with that axis up and so many units in a metre holds them."""
    return np.stack(BACK[up](*points.T), axis=1) * scale


def read(path, **how):
    """Read a file in this process."""
    return load_raw(path, limits=INSIDE, **how)


def write_cloud(path, points=P, colours=COLOURS, normals=NORMALS, **how):
    """Write a cloud by open3d."""
    open3d = load_open3d()
    cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector(points))
    if colours is not None:
        cloud.colors = open3d.utility.Vector3dVector(colours / 255.0)
    if normals is not None:
        cloud.normals = open3d.utility.Vector3dVector(normals)
    assert open3d.io.write_point_cloud(str(path), cloud, **how)
    return path


@pytest.mark.parametrize("how", [{"write_ascii": True}, {}, {"compressed": True}], ids=["ascii", "binary", "lzf"])
@pytest.mark.parametrize("extension", ["pcd", "ply"])
def test_clouds_of_open3d(tmp_path, extension, how):
    """Broken where one of the encodings is misread, or colours and normals lose their points."""
    raw = read(write_cloud(tmp_path / f"person.{extension}", **how))
    assert raw.is_cloud and (raw.units, raw.up_axis, raw.name) == ("m", "y", "person")
    assert np.allclose(raw.points, P[raw.origin], atol=1e-5) and len(raw.points) > 0.99 * len(P)
    assert np.abs(raw.colours - COLOURS[raw.origin] / 255.0).max() < 1.01 / 255.0
    assert raw.is_oriented and np.einsum("ij,ij->i", raw.normals, NORMALS[raw.origin]).min() > 0.999


@pytest.mark.parametrize("name", ["xyz", "xyzn", "xyzrgb"])
def test_rows_of_numbers(tmp_path, name):
    """Broken where a colour in a row is taken for a normal, or the other way round."""
    path = write_cloud(tmp_path / f"p.{name}").rename(tmp_path / "p.xyz")
    raw = read(path)
    assert np.allclose(raw.points, P[raw.origin], atol=1e-5)
    assert (raw.colours is not None) == (name == "xyzrgb") and raw.is_oriented == (name == "xyzn")
    if name == "xyzrgb":
        assert np.abs(raw.colours - COLOURS[raw.origin] / 255.0).max() < 1.01 / 255.0


def test_rows_with_bytes_commas_and_a_count(tmp_path):
    """Broken where the first line's count is a point, commas do not part, or colours of 0 to 255 are scaled."""
    rows = [f"{x:.6f}, {y:.6f}, {z:.6f}, {r}, {g}, {b}" for (x, y, z), (r, g, b) in zip(P, COLOURS, strict=True)]
    path = tmp_path / "p.xyz"
    path.write_text("# by hand\n" + f"{len(P)}\n" + "\n".join(rows) + "\n")
    raw = read(path)
    assert np.allclose(raw.points, P[raw.origin], atol=1e-5)
    assert np.allclose(raw.colours, COLOURS[raw.origin] / 255.0)


@pytest.mark.parametrize(
    ("order", "scale", "strength"),
    [(order, 255, strength) for order in ("icn", "cin", "cni", "inc", "ic", "ci", "in", "ni", "i")
     for strength in ((0.0, 1.0), (-2048.0, 2047.0))]
    + [("ic", 1, (0.0, 1.0)), ("ci", 1, (-2048.0, 2047.0))],
)  # fmt: skip
def test_an_intensity_is_found_by_the_values(tmp_path, order, scale, strength):
    """Broken where an intensity after or between colour and normal shifts their channels, or is taken for one."""
    intensity = np.linspace(*strength, len(P)).round(3)[:, None]
    blocks = {"i": intensity, "c": COLOURS if scale == 255 else (COLOURS / 255).round(5), "n": NORMALS.round(5)}
    path = tmp_path / "p.xyz"
    np.savetxt(path, np.hstack([P, *(blocks[word] for word in order)]), fmt="%.6g")
    arrays = parse(path, "xyz")
    assert ("colours" in arrays) == ("c" in order) and ("normals" in arrays) == ("n" in order)
    assert np.array_equal(arrays.get("colours", COLOURS), COLOURS)
    assert np.allclose(arrays.get("normals", NORMALS), NORMALS, atol=1e-5)


@pytest.mark.parametrize("extension", ["obj", "off", "glb"])
def test_vertices_without_faces(tmp_path, extension):
    """Broken where a mesh format without a face is refused, though the points are a person."""
    path = tmp_path / f"p.{extension}"
    if extension == "obj":
        path.write_text("".join(f"v {x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in P))
    elif extension == "off":
        path.write_text(f"OFF\n{len(P)} 0 0\n" + "".join(f"{x:.6f} {y:.6f} {z:.6f}\n" for x, y, z in P))
    else:
        trimesh.Scene(trimesh.PointCloud(P, colors=COLOURS)).export(path)
    raw = read(path)
    assert raw.is_cloud and not raw.is_oriented
    assert np.allclose(raw.points, P[raw.origin], atol=1e-5) and len(raw.points) > 0.99 * len(P)
    assert (raw.colours is not None) == (extension == "glb")


@pytest.mark.parametrize("kind", ["whole", "share", "plain"])
def test_colours_of_coff(tmp_path, kind):
    """Broken where the colours of a COFF go, are scaled twice, or numbers of an OFF are taken for colours."""
    colours = np.clip(V / np.ptp(V, axis=0).max() + 0.5, 0.0, 1.0)
    rows = (255 * colours).round().astype(int) if kind == "whole" else colours.round(5)
    path = tmp_path / "p.off"
    lines = ["OFF" if kind == "plain" else "COFF # scanner", f"{len(V)} {len(F)} 0"]
    lines += [" ".join(f"{x:.6f}" for x in v) + f" {r} {g} {b} 1" for v, (r, g, b) in zip(V, rows, strict=True)]
    path.write_text("\n".join([*lines, *(f"3 {a} {b} {c}" for a, b, c in F)]))
    arrays = parse(path, "off")
    assert len(arrays["vertices"]) == len(V) and ("colours" in arrays) == (kind != "plain")
    assert np.abs(arrays.get("colours", 255 * colours) - 255 * colours).max() < 0.51


@pytest.mark.parametrize(
    "extension", ["ply", "glb", *(pytest.param(name, marks=pytest.mark.nightly) for name in ("obj", "stl"))]
)
def test_meshes_keep_faces_and_places(tmp_path, extension):
    """Broken where a face goes, or `place` does not lead a point of the file to where it is now."""
    path = tmp_path / f"p.{extension}"
    trimesh.Trimesh(V, F, process=False).export(path)
    raw = read(path)
    assert len(raw.faces) == len(F) and len(raw.points) == len(V)
    there = trimesh.load(path, process=False).vertices if extension == "stl" else V
    assert len(raw.place) == len(there) and (raw.place >= 0).all()
    assert np.allclose(raw.points[raw.place], there, atol=1e-5)
    assert trimesh.Trimesh(raw.points, raw.faces, process=False).volume > 0.03


def test_labels_of_a_file_beside_the_scan(tmp_path):
    """Broken where labels are taken for the order of the merged points, and not of the file's."""
    path = tmp_path / "p.ply"
    corners = F.ravel()
    trimesh.Trimesh(V[corners], np.arange(len(corners)).reshape(-1, 3), process=False).export(path)
    np.savez(tmp_path / "l.npz", label=corners % 7)
    raw = read(path, labels=tmp_path / "l.npz")
    assert len(raw.points) == len(V)
    assert np.array_equal(raw.labels[raw.place], corners % 7)
    np.savez(tmp_path / "short.npz", label=corners[:-1])
    with pytest.raises(BadInput) as caught:
        read(path, labels=tmp_path / "short.npz")
    assert caught.value.code == "scan.labels_mismatch"


@pytest.mark.parametrize(
    ("up", "unit", "metres"),
    [("y", "m", 1.0), ("z", "cm", 0.01), ("-y", "mm", 0.001), ("-z", "inch", 0.0254), ("x", "foot", 0.3048),
     ("-x", "unknown", 0.137), ("z", "unknown", 33.0)],
)  # fmt: skip
def test_any_axis_and_unit(tmp_path, up, unit, metres):
    """Broken where a person lies, stands on the head or is a giant; a guess that is not told is broken too."""
    turn = trimesh.transformations.rotation_matrix(0.7, (0, 1, 0))[:3, :3]
    path = write_cloud(tmp_path / "p.ply", place_in_file(P @ turn.T, up, 1.0 / metres))
    raw = read(path)
    assert (raw.up_axis, raw.units) == (up, unit)
    assert np.allclose(raw.points, P[raw.origin] @ turn.T, atol=1e-4 if unit != "unknown" else 0.03)
    told = " ".join(raw.notes)
    assert ("unit" in told) == (unit in ("inch", "foot", "unknown")) and ("--up" in told) == (up not in ("y", "z"))


@pytest.mark.parametrize("size", [1.0, 2.0])
def test_a_normalised_person_has_no_unit(tmp_path, size):
    """Broken where a person scaled into a box is taken for a child of 1 m or an adult of 2 m, or --height is unused."""
    path = write_cloud(tmp_path / "p.ply", P * size / np.ptp(P, axis=0).max())
    assert read(path).units == "unknown"
    with pytest.raises(BadInput) as caught:
        read_person_input(PersonFiles(path), INSIDE)
    assert caught.value.code == "scan.stature_unknown" and "--height" in str(caught.value)
    told = read_person_input(PersonFiles(path, height=1.7), INSIDE).raw
    assert np.allclose(np.ptp(told.points, axis=0), np.ptp(P, axis=0), rtol=0.02)
    assert read_person_input(PersonFiles(path, units="m"), INSIDE).raw.units == "m"


@pytest.mark.parametrize(
    "names", [("red", "green", "blue"), ("r", "g", "b"), ("diffuse_red", "diffuse_green", "diffuse_blue")]
)
def test_colours_by_other_names(tmp_path, names):
    """Broken where the colours of a PLY are read under one exporter's names only."""
    path = tmp_path / "p.ply"
    write_columns(path, dict(zip(("x", "y", "z"), P.T, strict=True)), dict(zip(names, COLOURS.T, strict=True)))
    raw = read(path)
    assert np.array_equal(np.round(255 * raw.colours), COLOURS[raw.origin])


def test_a_splat_is_its_opaque_centres(tmp_path):
    """Broken where transparent floaters of a Gaussian splat stay, or its colours go."""
    floaters = np.random.default_rng(2).uniform(-0.9, 0.9, (900, 3)) + [0.0, 0.9, 0.0]
    points = np.concatenate([P, floaters])
    colours = np.concatenate([COLOURS / 255.0, np.ones_like(floaters)])
    columns = dict(zip(("x", "y", "z"), points.T, strict=True))
    columns |= {f"f_dc_{k}": (colours[:, k] - 0.5) / 0.28209479177387814 for k in range(3)}
    columns["opacity"] = np.where(np.arange(len(points)) < len(P), 3.0, -4.0)
    write_columns(tmp_path / "p.ply", columns, {})
    raw = read(tmp_path / "p.ply")
    assert set(raw.origin) <= set(range(len(P))) and len(raw.points) > 0.99 * len(P)
    assert np.abs(255 * raw.colours - COLOURS[raw.origin]).max() <= 0.51
    assert "Dropped 900 transparent splats." in raw.notes


def write_columns(path, numbers, bytes_):
    """Write a cloud's PLY of columns of numbers, which hold its places, and of bytes by their names."""
    kinds = [(name, "<f4") for name in numbers] + [(name, "u1") for name in bytes_]
    rows = np.zeros(len(numbers["x"]), kinds)
    for name, column in (numbers | bytes_).items():
        rows[name] = column
    words = [f"property {'float' if kind == '<f4' else 'uchar'} {name}" for name, kind in kinds]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(rows)}", *words, "end_header", ""]
    path.write_bytes("\n".join(head).encode() + rows.tobytes())


@pytest.mark.parametrize("up", ["y", "-y", pytest.param("-z", marks=pytest.mark.nightly)])
def test_a_gown_stands_on_its_hem(tmp_path, up):
    """Broken where a wide hem is taken for spread arms, and a person in a gown stands on the head."""
    rng = np.random.default_rng(0)
    share, angle = rng.random(6000), rng.uniform(0.0, 6.3, 6000)
    radius = 0.45 - 0.3 * share
    gown = np.stack([radius * np.cos(angle), FLOOR + 0.02 + 1.03 * share, radius * np.sin(angle)], axis=1)
    path = write_cloud(tmp_path / "p.ply", place_in_file(np.concatenate([P, gown]), up), None, None)
    assert read(path).up_axis == up


def test_loose_vertices_are_stood_for(tmp_path):
    """Broken where vertices that no face has, as around a hole, are without a label later, or far ones get one."""
    far = np.array([[3.0, 1.0, 0.0]])
    trimesh.Trimesh(np.concatenate([V, V + 0.002, far]), F, process=False).export(tmp_path / "p.ply")
    raw = read(tmp_path / "p.ply")
    count = len(V)
    assert len(raw.points) == count and raw.place[-1] == -1
    moved = np.linalg.norm(raw.points[raw.place[count:-1]] - raw.points[raw.place[:count]], axis=1)
    assert (raw.place[:-1] >= 0).all() and moved.max() < 0.02


def test_what_the_user_says_goes(tmp_path):
    """Broken where a guess overrules --units or --up, or a word that is none is taken."""
    path = write_cloud(tmp_path / "p.ply", place_in_file(P, "z", 100.0))
    raw = read(path, units="mm", up="-z")
    assert (raw.units, raw.up_axis) == ("mm", "-z") and np.isclose(np.ptp(raw.points[:, 1]), 0.17, atol=0.01)
    for how in ({"units": "mile"}, {"up": "w"}):
        with pytest.raises(BadInput) as caught:
            read(path, **how)
        assert caught.value.code == "scan.choice"


def sheet(low, high, step, rng):
    """Return points of an axis-aligned rectangle, with a millimetre of noise."""
    axes = [np.arange(a, b, step) if b > a else np.array([a]) for a, b in zip(low, high, strict=True)]
    points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)
    return points + rng.normal(0.0, 0.001, points.shape)


@settings(max_examples=3, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    side=st.floats(0.6, 2.0), wall=st.booleans(), flyers=st.integers(0, 500), box=st.booleans(),
    up=st.sampled_from(["y", "z", "-y"]), turn=st.floats(0.0, 6.3), seed=st.integers(0, 99),
)  # fmt: skip
def test_what_is_no_person_goes(tmp_path, side, wall, flyers, box, up, turn, seed):
    """Broken where a floor, a wall, a box or flyers stay, the person loses more than the soles, or nothing is told."""
    rng = np.random.default_rng(seed)
    extra = [sheet((-side, FLOOR, -side), (side, FLOOR, side), 0.02, rng)]
    if wall:
        extra.append(sheet((-side, FLOOR, -side), (side, FLOOR + 2.2, -side), 0.02, rng))
    if box:
        crate = trimesh.sample.sample_surface(trimesh.creation.box((0.3, 0.4, 0.3)), 2000, seed=1)[0]
        extra.append(crate + (1.35, FLOOR + 0.2, 0.3))
    extra.append(rng.uniform((-1.5, FLOOR + 0.1, -1.0), (1.5, FLOOR + 2.0, 1.0), (flyers, 3)))
    rotation = trimesh.transformations.rotation_matrix(turn, (0, 1, 0))[:3, :3]
    points = np.concatenate([P @ rotation.T, *extra])
    raw = read(write_cloud(tmp_path / "p.ply", place_in_file(points, up, 100.0), None, None))
    kept = raw.place >= 0
    person = np.arange(len(points)) < len(P)
    beside = np.hypot(*points[:, [0, 2]].T) > 0.25
    assert (raw.up_axis, raw.units, raw.pieces) == (up, "cm", 1)
    assert kept[person & (points[:, 1] > FLOOR + 0.02)].mean() > 0.999
    assert kept[~person & beside].mean() < 0.03
    assert any("floor" in note for note in raw.notes)


def test_a_floor_in_the_mesh_goes(tmp_path):
    """Broken where a mesh's floor of two triangles has no points to be found by, or the person's faces go with it."""
    floor = np.array([[-1.0, FLOOR, -1.0], [1.0, FLOOR, -1.0], [1.0, FLOOR, 1.0], [-1.0, FLOOR, 1.0]])
    faces = np.concatenate([F, np.array([[0, 2, 1], [0, 3, 2]]) + len(V)])
    trimesh.Trimesh(np.concatenate([V, floor]), faces, process=False).export(tmp_path / "p.ply")
    raw = read(tmp_path / "p.ply")
    assert (raw.place[-4:] == -1).all() and (raw.place[: len(V)] >= 0).mean() > 0.97
    assert np.ptp(raw.points[:, 0]) < 1.9 and any("floor" in note for note in raw.notes)


def test_a_bare_person_loses_nothing(tmp_path):
    """Broken where a flat back, a chest or the soles pass for a floor or a wall."""
    raw = read(write_cloud(tmp_path / "p.ply", P, None, None))
    assert (raw.place >= 0).mean() > 0.999 and not any("floor" in note for note in raw.notes)


def test_two_people_are_not_made_one(tmp_path):
    """Broken where the second person is dropped as clutter, so that nobody can refuse the scan."""
    raw = read(write_cloud(tmp_path / "p.ply", np.concatenate([P, P + (1.9, 0.0, 0.1)]), None, None))
    assert raw.pieces == 2 and (raw.place >= 0).mean() > 0.999
    assert any("2 separate pieces" in note for note in raw.notes)


def test_panels_of_a_garment_are_not_two_people(tmp_path):
    """Broken where front and back of a shirt that are not sewn are refused as two persons, and nothing names --body."""
    rng = np.random.default_rng(4)
    angle, height = rng.uniform(0.0, np.pi, 6000), rng.uniform(0.0, 0.7, 6000)
    half = np.stack([0.25 * np.cos(angle), height, 0.14 * np.sin(angle) + 0.02], axis=1)
    path = write_cloud(tmp_path / "p.ply", np.concatenate([half, half * (1.0, 1.0, -1.0)]), None, None)
    assert read(path).pieces == 1


def test_halves_of_one_person_are_not_two():
    """Broken where a gap at the waist makes two persons of one: they stand over each other, not beside."""
    low, high = P[P[:, 1] < P[:, 1].mean()], P[P[:, 1] > P[:, 1].mean()]
    assert not _stands_beside(high, low, "y")
    assert _stands_beside(P + (1.9, 0.2, 0.1), P, "y")
    lying = (high[:, [0, 2, 1]], low[:, [0, 2, 1]])
    assert not _stands_beside(*lying, "z")


HEADER = b"VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 9\nHEIGHT 1\nPOINTS 9\n"
HOSTILE = {
    "no pcd": ("a.pcd", b"hello\n", "scan.magic"),
    "no data": ("a.pcd", HEADER, "scan.magic"),
    "short": ("a.pcd", HEADER + b"DATA binary\n" + bytes(40), "scan.truncated"),
    "short text": ("a.pcd", HEADER + b"DATA ascii\n1 2 3\n", "scan.truncated"),
    "words": ("a.pcd", HEADER + b"DATA ascii\n" + b"a b c\n" * 9, "scan.unreadable"),
    "rows too many": ("a.pcd", HEADER + b"DATA ascii\n" + b"1 2 3 4\n" * 9, "scan.counts"),
    "count lies": ("a.pcd", HEADER.replace(b"POINTS 9", b"POINTS 99") + b"DATA binary\n" + bytes(1188), "scan.header"),
    "count huge": (
        "a.pcd", HEADER.replace(b" 9\n", b" 99999999999\n") + b"DATA binary\n" + bytes(64), "scan.truncated",
    ),
    "count negative": ("a.pcd", HEADER.replace(b" 9\n", b" -9\n") + b"DATA binary\n", "scan.header"),
    "size unknown": ("a.pcd", HEADER.replace(b"SIZE 4", b"SIZE 3") + b"DATA binary\n" + bytes(99), "scan.header"),
    "no z": ("a.pcd", HEADER.replace(b"x y z", b"x y w") + b"DATA binary\n" + bytes(108), "scan.header"),
    "wide": ("a.pcd", HEADER.replace(b"COUNT 1 1 1", b"COUNT 1 1 99999") + b"DATA binary\n", "scan.header"),
    "bomb": (
        "a.pcd",
        HEADER.replace(b" 9\n", b" 9999999\n") + b"DATA binary_compressed\n" + (4).to_bytes(4, "little")
        + (9999999 * 12).to_bytes(4, "little") + bytes(4),
        "scan.header",
    ),
    "lzf before its start": (
        "a.pcd",
        HEADER + b"DATA binary_compressed\n" + bytes((3, 0, 0, 0, 108, 0, 0, 0)) + b"\xe0\xff\x20",
        "scan.unreadable",
    ),
    "nan": ("a.pcd", HEADER + b"DATA ascii\n" + b"nan nan nan\n" * 9, "scan.empty"),
    "few": ("a.xyz", b"1 2 3\n" * 9, "scan.empty"),
    "no numbers": ("a.xyz", b"what is this\n", "scan.magic"),
    "two numbers": ("a.xyz", b"1 2\n" * 200, "scan.magic"),
    "uneven": ("a.xyz", b"1 2 3\n" * 200 + b"1 2 3 4\n", "scan.unreadable"),
    "eight numbers": ("a.xyz", b"1 2 3 4 5 6 7 8\n" * 200, "scan.unreadable"),
    "binary": ("a.xyz", bytes(range(256)) * 20, "scan.magic"),
    "one place": ("a.xyz", b"1 2 3\n" * 200, "scan.extent"),
    "an archive": ("a.pcd", b"PK\x03\x04" + bytes(99), "scan.archive"),
}  # fmt: skip


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_clouds_are_refused(tmp_path, case):
    """Broken where a file of points that is none ends in a traceback, another code, or a scan."""
    name, content, code = HOSTILE[case]
    (tmp_path / name).write_bytes(content)
    with pytest.raises(BadInput) as caught:
        read(tmp_path / name)
    assert caught.value.code == code and "\n" not in caught.value.message


def test_a_cloud_is_parsed_in_a_limited_process(tmp_path):
    """Broken where a file of points is parsed in the caller's process, or a limit of it is not kept."""
    path = write_cloud(tmp_path / "p.pcd")
    raw = load_raw(path)
    assert np.allclose(raw.points, P[raw.origin], atol=1e-5)
    with pytest.raises(BadInput) as caught:
        load_raw(path, limits=Limits(output_bytes=1000))
    assert caught.value.code == "input.too_large"
