"""Mutated valid files of every kind that is read: each ends with a result or with a code, in bounded memory and time.

One forked child reads them all, for a start of the libraries costs more than a hundred small files.
`make fuzz FUZZ=2000 SEED=7` reads more of them; a file that breaks a reader is named by its seed.
"""

from __future__ import annotations

import io
import json
import multiprocessing
import multiprocessing.connection
import os
import resource
import signal
import traceback
import warnings
from pathlib import Path

import numpy as np
import pytest
import trimesh

COUNT, FIRST = int(os.environ.get("FUZZ", "200")), int(os.environ.get("SEED", "7"))
MEMORY, SECONDS = 4 << 30, 60
"""What one file may cost: the bounds of the limited process are of the same size."""


def make_files() -> dict[str, bytes]:
    """Return one small valid file of each kind, by its name."""
    from garmentq.core.garment.garmentcode_writer import write_pattern
    from garmentq.core.garment.templates import load_template

    from ..body.made_up_rigs import make_mhr, make_soma
    from ..motion.foreign import make_reference, name_plainly, write_bvh

    mesh = trimesh.creation.cylinder(radius=0.2, height=0.6, sections=8)
    faces = mesh.faces[np.abs(mesh.face_normals[:, 2]) < 0.9]
    tube = trimesh.Trimesh(mesh.vertices, faces)
    count = len(tube.vertices)
    files = {f"scan.{kind}": tube.export(file_type=kind) for kind in ("ply", "obj", "stl", "off", "glb")}
    files["ascii.ply"] = tube.export(file_type="ply", encoding="ascii")
    labels = np.arange(count) % 3
    for name, write in {"labels.npz": np.savez_compressed, "labels.npy": None}.items():
        out = io.BytesIO()
        np.save(out, labels) if write is None else write(out, labels=labels)
        files[name] = out.getvalue()
    files["labels.json"] = json.dumps(labels.tolist()).encode()
    files["labels.txt"] = "\n".join(map(str, labels)).encode()
    files["pattern.json"] = json.dumps(write_pattern(load_template("skirt"))).encode()
    body = io.BytesIO()
    np.savez(body, v_template=mesh.vertices, f=mesh.faces, J=np.zeros((24, 3)), weights=np.ones((count, 24)) / 24)
    files["body.npz"] = body.getvalue()
    files["body.json"] = json.dumps({"age": 0.7, "pose_parameters": {"root": np.eye(4).tolist()}}).encode()
    for name, make in {"mhr": make_mhr, "soma": make_soma}.items():
        kept = io.BytesIO()
        np.savez(kept, **make())
        files[f"body_{name}.npz"] = kept.getvalue()
    files["keys.json"] = json.dumps({"fps": 30, "frames": [{"pelvis": [0, 0, 0]}]}).encode()
    files["walk.bvh"] = (
        b"HIERARCHY\nROOT Hips\n{\n OFFSET 0 0 0\n"
        b" CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation\n"
        b" End Site\n {\n  OFFSET 0 1 0\n }\n}\nMOTION\nFrames: 2\nFrame Time: 0.03\n0 0 0 0 0 0\n0 0 0 1 2 3\n"
    )
    files["person.bvh"] = write_bvh(make_reference(), name_plainly())
    files["cloud.xyz"] = "\n".join(" ".join(f"{v:.4f}" for v in p) for p in mesh.vertices).encode()
    return {name: content if isinstance(content, bytes) else content.encode() for name, content in files.items()}


def mutate(content: bytes, random: np.random.Generator) -> bytes:
    """Return a file with some bytes flipped, cut, doubled, or put elsewhere."""
    data = bytearray(content)
    for _ in range(int(random.integers(1, 5))):
        kind, at = int(random.integers(0, 6)), int(random.integers(0, max(1, len(data))))
        span = int(random.integers(1, 40))
        if not data:
            break
        if kind == 0:
            data[at] ^= 1 << int(random.integers(0, 8))
        elif kind == 1:
            del data[at : at + span]
        elif kind == 2:
            data[at:at] = data[at : at + span]
        elif kind == 3:
            data[at : at + span] = random.bytes(span)
        elif kind == 4:
            data[at : at + 4] = bytes([255, 255, 255, int(random.integers(0, 256))])
        else:
            del data[at:]
    return bytes(data)


def read(path: Path) -> None:
    """Read a file as the job's first stage does."""
    from garmentq.core.body.models.model_file import load_body_model
    from garmentq.core.body.motion.read import load_motion
    from garmentq.core.garment.garmentcode import load_pattern
    from garmentq.core.scan.labels import read_labels
    from garmentq.core.scan.limits import Limits
    from garmentq.core.scan.load import load_scan
    from garmentq.core.scan.load_raw import load_raw

    limits = Limits(is_confined=True)
    kind = path.stem.split("-")[0]
    if kind == "labels":
        read_labels(path, None, limits)
    elif kind == "pattern":
        load_pattern(path)
    elif kind.startswith("body"):
        load_body_model(path)
    elif kind in ("keys", "walk", "person"):
        load_motion(path)
    elif kind == "cloud":
        load_raw(path, limits=limits)
    else:
        load_scan(path, units="m", limits=limits)


def read_all(folder: Path, told: multiprocessing.connection.Connection) -> None:
    """Read every mutated file in this forked process; tell of each how it ended."""
    from garmentq.core.run.errors import GarmentqError
    from garmentq.core.run.sandbox import is_memory_short

    warnings.simplefilter("ignore")
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
    files = sorted(make_files().items())
    for seed in range(FIRST, FIRST + COUNT):
        random = np.random.default_rng(seed)
        name, content = files[seed % len(files)]
        path = folder / name.replace(".", f"-{seed}.")
        path.write_bytes(mutate(content, random))
        told.send((seed, path.name, "begun"))
        signal.alarm(SECONDS)
        try:
            read(path)
            end = "read"
        except GarmentqError as error:
            end = error.code
        except Exception as error:
            end = "memory" if is_memory_short(error) else f"traceback: {traceback.format_exc(limit=-3)}"
        signal.alarm(0)
        told.send((seed, path.name, end))
    told.close()


@pytest.mark.slow
def test_mutated_files_end_with_a_code(tmp_path):
    """Broken where a file of a user's makes a reader break off, hang, or take all memory."""
    context = multiprocessing.get_context("fork")
    ours, theirs = context.Pipe(duplex=False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that libraries of this process have threads is no matter to the readers
        child = context.Process(target=read_all, args=(tmp_path, theirs))
        child.start()
    theirs.close()
    ends: dict[str, str] = {}
    try:
        while True:
            _, name, end = ours.recv()
            ends[name] = end
    except EOFError:
        child.join()
    wrong = {name: end for name, end in ends.items() if end in ("begun", "memory") or end.startswith("traceback")}
    assert child.exitcode == 0 and not wrong, "\n".join(f"{name}: {end}" for name, end in wrong.items())
    assert len(ends) == COUNT
    codes = set(ends.values()) - {"read"}
    assert "read" in ends.values() and len(codes) >= min(10, COUNT // 20), "the files must be refused in many ways"
