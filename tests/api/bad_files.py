"""The bad files that a service must refuse: counts that lie, indices out of range, references elsewhere, pickles."""

from __future__ import annotations

import io
import json
import pickle
import struct
import zipfile

import numpy as np
from api_work import FACES, HEADER

POINTS = "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
TRIANGLES = "3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"
BINARY = HEADER.replace("ascii", "binary_little_endian")


def glb(document: dict) -> bytes:
    """Pack a glTF document without a binary part."""
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    return struct.pack("<4sII", b"glTF", 2, 20 + len(text)) + struct.pack("<I4s", len(text), b"JSON") + text


TETRAHEDRON = (HEADER + FACES).format(4, 4)
FILES = {
    "binary_4e9_vertices.ply": (BINARY.format(4_000_000_000) + FACES.format(1)).encode() + bytes(48),
    "binary_2e8_faces.ply": (BINARY.format(3) + FACES.format(200_000_000)).encode() + bytes(49),
    "ascii_4e9_vertices.ply": (HEADER.format(4_000_000_000) + FACES.format(4) + POINTS + TRIANGLES).encode(),
    "index_too_large.ply": (TETRAHEDRON + POINTS + TRIANGLES.replace("1 2 3", "1 2 999999999")).encode(),
    "index_negative.ply": (TETRAHEDRON + POINTS + TRIANGLES.replace("1 2 3", "1 2 -7")).encode(),
    "not_finite.ply": (TETRAHEDRON + POINTS.replace("0 0 1", "nan inf 1e38") + TRIANGLES).encode(),
    "truncated.ply": (BINARY.format(1000) + FACES.format(1000)).encode() + bytes(600),
    "count_ffffffff.stl": bytes(80) + b"\xff\xff\xff\xff" + bytes(50),
    "index_out_of_range.obj": b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 99\n",
    "accessor_4e9.glb": glb(
        {"asset": {"version": "2.0"}, "accessors": [{"count": 4 * 10**9, "type": "VEC3", "componentType": 5126}]}
    ),
    "outside.glb": glb({"asset": {"version": "2.0"}, "buffers": [{"uri": "../../secret", "byteLength": 36}]}),
    "outside.gltf": b'{"asset": {"version": "2.0"}, "buffers": [{"uri": "../../secret", "byteLength": 36}]}',
    "4e9_vertices.off": b"OFF\n4000000000 1 0\n0 0 0\n3 0 0 0\n",
    "bomb.3mf": b"PK\x03\x04" + bytes(60),
    "entity.dae": b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY x SYSTEM "file:///etc/passwd">]><a>&x;</a>',
    "entity.svg": b'<!DOCTYPE s [<!ENTITY x SYSTEM "file:///etc/passwd">]><svg>&x;</svg>',
    "wrong_content.stl": b"ply\nformat ascii 1.0\n",
    "empty.ply": b"",
    "pickle.npz": b"\x80\x04cos\nsystem\n",
    "none": b"nothing",
}  # fmt: skip


class Touch:
    """Make a file where it is unpickled."""

    def __reduce__(self):
        """Tell pickle to run `open`."""
        return open, ("pickled", "w")


def pack_npz(content: bytes) -> bytes:
    """Pack one member of an .npz."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        archive.writestr("labels.npy", content)
    return out.getvalue()


def save_object(value: object) -> bytes:
    """Save an array of one Python object."""
    out = io.BytesIO()
    np.save(out, np.array([value], dtype=object), allow_pickle=True)
    return out.getvalue()


PICKLES = {
    "bare.npy": pickle.dumps(Touch()),
    "bare.npz": pickle.dumps(Touch()),
    "object.npy": save_object(Touch()),
    "object.npz": pack_npz(save_object(Touch())),
}
"""Label files that would run a program if they were unpickled."""
