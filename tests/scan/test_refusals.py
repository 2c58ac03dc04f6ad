"""Files that must be refused: each with one clear line and its stable code, never a traceback or a wrong mesh."""

import io
import json
import struct
import zipfile

import numpy as np
import pytest
import trimesh
from garmentq.core.run.errors import BadInput
from garmentq.core.scan.limits import Limits
from garmentq.core.scan.load import load_pair, load_scan


def tube(radius=0.2, height=0.6, around=24, rows=13):
    """Return an open tube around y: a garment as simple as can be."""
    angle = 2 * np.pi * np.arange(around) / around
    y = np.linspace(0.0, height, rows)
    vertices = np.stack(
        [
            np.tile(radius * np.sin(angle), rows),
            np.repeat(y, around),
            np.tile(radius * np.cos(angle), rows),
        ],
        axis=1,
    )
    i, j = np.meshgrid(np.arange(rows - 1), np.arange(around), indexing="ij")
    a, b = i * around + j, i * around + (j + 1) % around
    c, d = a + around, b + around
    return vertices, np.stack([a, b, d, a, d, c], axis=-1).reshape(-1, 3)


def ascii_ply(vertices, faces, vertex_count=None, face_count=None):
    """Write an ASCII PLY by hand, with true or false counts."""
    rows = [" ".join(map(repr, map(float, v))) for v in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
    return (
        f"ply\nformat ascii 1.0\nelement vertex {vertex_count or len(vertices)}\n"
        "property float x\nproperty float y\nproperty float z\n"
        f"element face {len(faces) if face_count is None else face_count}\n"
        "property list uchar int vertex_indices\nend_header\n" + "\n".join(rows) + "\n"
    ).encode()


def binary_ply(vertices, faces):
    """Write a binary PLY with trimesh."""
    return trimesh.Trimesh(vertices, faces, process=False).export(file_type="ply")


def glb(tree, binary=b"\0" * 64):
    """Write a GLB around a JSON tree."""
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    total = 12 + 8 + len(text) + 8 + len(binary)
    head = b"glTF" + struct.pack("<II", 2, total) + struct.pack("<I", len(text)) + b"JSON"
    return head + text + struct.pack("<I", len(binary)) + b"BIN\0" + binary


def zipped():
    """Return the bytes of a zip archive."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("3D/3dmodel.model", "<model/>")
    return stream.getvalue()


def gltf_tree(**changes):
    """Return a small glTF tree with one triangle."""
    tree = {
        "asset": {"version": "2.0"},
        "buffers": [{"byteLength": 64}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6},
        ],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
    }
    return {**tree, **changes}


V, F = tube()
NAN = V.copy()
NAN[5, 1] = np.nan
HUGE = F.copy()
HUGE[7, 1] = len(V)
NEGATIVE = F.copy()
NEGATIVE[7, 1] = -1
POINTS = ascii_ply(V, F[:0])
FLAT = V * [1, 1, 0]
STL = trimesh.Trimesh(V, F, process=False).export(file_type="stl")
OBJ = "".join(f"v {x} {y} {z}\n" for x, y, z in V) + "".join(f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in F)

QUICK = {
    "missing": ("absent.ply", None, "scan.missing"),
    "empty file": ("a.ply", b"", "scan.empty"),
    "text named ply": ("a.ply", b"Dear sir or madam,\nplease find attached my scan.\n", "scan.magic"),
    "text named stl": ("a.stl", b"Dear sir or madam,\n" * 20, "scan.magic"),
    "text named glb": ("a.glb", b"Dear sir or madam,\n" * 20, "scan.magic"),
    "text named off": ("a.off", b"Dear sir or madam,\n" * 20, "scan.magic"),
    "text named obj": ("a.obj", b"Dear sir or madam,\n" * 20, "scan.magic"),
    "zip": ("a.zip", zipped(), "scan.archive"),
    "3mf": ("a.3mf", zipped(), "scan.archive"),
    "zip named ply": ("a.ply", zipped(), "scan.archive"),
    "gzip named obj": ("a.obj", b"\x1f\x8b\x08\x00" + b"\0" * 50, "scan.archive"),
    "unknown extension": ("a.fbx", b"Kaydara", "scan.format"),
    "no extension": ("scan", b"ply\n", "scan.format"),
    "gltf without data": ("a.gltf", json.dumps(gltf_tree()).encode(), "scan.truncated"),
    "gltf of two files": (
        "a.gltf",
        json.dumps(gltf_tree(buffers=[{"byteLength": 64, "uri": "a.bin"}])).encode(),
        "scan.outside_uri",
    ),
    "gltf of too little data": (
        "a.gltf",
        json.dumps(gltf_tree(buffers=[{"byteLength": 64, "uri": "data:;base64,AAAA"}])).encode(),
        "scan.truncated",
    ),
    "gltf of an address": (
        "a.gltf",
        json.dumps(gltf_tree(buffers=[{"byteLength": 1, "uri": "http://x/base64,AAAA"}])).encode(),
        "scan.outside_uri",
    ),
    "text named gltf": ("a.gltf", b"Dear sir or madam,\n" * 20, "scan.magic"),
    "text named xyz": ("a.xyz", b"Dear sir or madam,\n" * 20, "scan.magic"),
    "comments named obj": ("a.obj", b"# v 1 2 3\n" * 9000, "scan.magic"),
    "ascii ply of 4e9": ("a.ply", ascii_ply(V, F, vertex_count=4_000_000_000), "scan.too_many"),
    "ply of negative count": ("a.ply", ascii_ply(V, F, vertex_count=-4), "scan.header"),
    "ascii ply of 1e7": ("a.ply", ascii_ply(V, F, vertex_count=10_000_000), "scan.truncated"),
    "ascii ply cut off": ("a.ply", ascii_ply(V, F)[:-2000], "scan.truncated"),
    "binary ply cut off": ("a.ply", binary_ply(V, F)[:-2000], "scan.truncated"),
    "ply header cut off": ("a.ply", ascii_ply(V, F)[:80], "scan.header"),
    "ply of unknown type": ("a.ply", ascii_ply(V, F).replace(b"float x", b"quad x"), "scan.header"),
    "points only": ("a.ply", POINTS, "scan.no_faces"),
    "ply without vertices": ("a.ply", ascii_ply(V, F).replace(b"vertex 312", b"vertex 0"), "scan.empty"),
    "stl of 4e9": ("a.stl", STL[:80] + struct.pack("<I", 4_000_000_000) + STL[84:], "scan.too_many"),
    "stl cut off": ("a.stl", STL[:-2000], "scan.truncated"),
    "ascii stl cut off": ("a.stl", b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", "scan.truncated"),
    "off of 4e9": ("a.off", b"OFF\n4000000000 1 0\n0 0 0\n", "scan.too_many"),
    "off cut off": ("a.off", b"OFF\n300 100 0\n0 0 0\n", "scan.truncated"),
    "obj without faces": ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "scan.no_faces"),
    "glb with an outside buffer": (
        "a.glb",
        glb(gltf_tree(buffers=[{"byteLength": 64, "uri": "../../etc/passwd"}])),
        "scan.outside_uri",
    ),
    "glb with an outside image": ("a.glb", glb(gltf_tree(images=[{"uri": "http://x/y.png"}])), "scan.outside_uri"),
    "glb with draco": (
        "a.glb",
        glb(gltf_tree(extensionsRequired=["KHR_draco_mesh_compression"])),
        "scan.gltf_extension",
    ),
    "glb of 4e9": (
        "a.glb",
        glb(gltf_tree(accessors=[{"componentType": 5126, "count": 4_000_000_000, "type": "VEC3"}])),
        "scan.too_many",
    ),
    "glb accessor beyond its data": (
        "a.glb",
        glb(gltf_tree(accessors=[{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}])),
        "scan.truncated",
    ),
    "glb cut off": ("a.glb", glb(gltf_tree())[:-40], "scan.truncated"),
    "glb with broken json": ("a.glb", glb(gltf_tree()).replace(b'{"asset', b'["asset'), "scan.header"),
    "glb without meshes": ("a.glb", glb(gltf_tree(meshes=[])), "scan.no_faces"),
    "compressed splat": (
        "a.ply",
        ascii_ply(V, F).replace(b"float z\n", b"float z\nproperty uint packed_position\n"),
        "scan.format",
    ),
}

PARSED = {
    "index out of range": ("a.ply", ascii_ply(V, HUGE), "scan.indices"),
    "negative index": ("a.ply", binary_ply(V, F).replace(*[np.int32(n).tobytes() for n in (311, -7)]), "scan.indices"),
    "obj index out of range": ("a.obj", OBJ.replace("f 1 2 ", "f 1 9999 ", 1).encode(), "scan.indices"),
    "obj index zero": ("a.obj", OBJ.replace("f 1 2 ", "f 0 2 ", 1).encode(), "scan.indices"),
    "nan": ("a.ply", ascii_ply(NAN, F), "scan.not_finite"),
    "garbage rows": ("a.ply", ascii_ply(V, F).replace(b"0.2 ", b"x.2 ", 1), "scan.unreadable"),
    "flat": ("a.ply", ascii_ply(FLAT, F), "scan.extent"),
    "inches": ("a.ply", ascii_ply(V / 0.0254, F), "scan.units_unknown"),
    "a thimble": ("a.ply", ascii_ply(V / 20, F), "scan.units_unknown"),
}


def refuse(tmp_path, name, content):
    """Load a file and give the refusal."""
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(BadInput) as caught:
        load_scan(path)
    return caught.value


@pytest.mark.parametrize("case", QUICK)
def test_header_refuses(tmp_path, monkeypatch, case):
    """A file that its header, size or magic already gives away must never reach the parser."""

    def never(*_, **__):
        raise AssertionError("the parser was started")

    monkeypatch.setattr("subprocess.run", never)
    name, content, code = QUICK[case]
    error = refuse(tmp_path, name, content)
    assert error.code == code
    assert "\n" not in str(error) and len(str(error)) > 20


@pytest.mark.parametrize("case", PARSED)
def test_checks_after_parsing_refuse(tmp_path, case):
    """What only shows in the arrays must be refused by its own code, not passed on as a wrong mesh."""
    name, content, code = PARSED[case]
    error = refuse(tmp_path, name, content)
    assert error.code == code
    assert "\n" not in str(error) and "Traceback" not in str(error)


@pytest.mark.parametrize(
    ("limits", "code"),
    [
        (Limits(memory_bytes=48 * 1024**2), "input.too_large"),
        (Limits(output_bytes=100), "input.too_large"),
        (Limits(wall_seconds=0.01), "input.took_too_long"),
    ],
    ids=["memory", "written", "wall clock"],
)
def test_parser_is_stopped_at_its_limits(tmp_path, limits, code):
    """A parser that needs too much must end in a refusal, not take the machine with it."""
    path = tmp_path / "a.ply"
    path.write_bytes(ascii_ply(V, F))
    with pytest.raises(BadInput) as caught:
        load_scan(path, limits=limits)
    assert caught.value.code == code


def test_file_size_is_capped(tmp_path):
    """A file above the cap must be refused before its content is looked at."""
    path = tmp_path / "a.ply"
    path.write_bytes(ascii_ply(V, F))
    with pytest.raises(BadInput) as caught:
        load_scan(path, limits=Limits(file_bytes=1000))
    assert caught.value.code == "scan.too_large"


def test_choices_are_checked(tmp_path):
    """A wrong word for units or axis must be refused before anything is read."""
    for choice in ({"units": "in"}, {"up": "x"}):
        with pytest.raises(BadInput) as caught:
            load_scan(tmp_path / "a.ply", **choice)
        assert caught.value.code == "scan.choice"


def test_garment_away_from_its_body_is_refused(tmp_path):
    """A garment that hangs beside its body must be refused: nothing after it could be right."""
    body, faces = tube(radius=0.15, height=1.7)
    (tmp_path / "body.ply").write_bytes(ascii_ply(body, faces))
    (tmp_path / "skirt.ply").write_bytes(ascii_ply(V + [2.0, 0.8, 0.0], F))
    with pytest.raises(BadInput) as caught:
        load_pair(tmp_path / "skirt.ply", tmp_path / "body.ply", up="y")
    assert caught.value.code == "scan.body_apart"
