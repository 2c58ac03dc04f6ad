"""Label files: every form that is read, and what is refused before anything is unpickled."""

from __future__ import annotations

import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.run.errors import BadInput
from garmentq.core.scan.labels import read_labels
from garmentq.core.scan.limits import Limits

LABELS = np.array([0, 1, 1, 0, 2])


def write(path: Path, labels: np.ndarray) -> Path:
    """Write labels in the form that the file's name asks for."""
    if path.suffix == ".npz":
        np.savez(path, other=np.zeros(3), label=labels)
    elif path.suffix == ".npy":
        np.save(path, labels)
    elif path.suffix == ".json":
        path.write_text(json.dumps({"made by": "hand", "label": labels.tolist()}))
    else:
        path.write_text("\n".join(map(str, labels.tolist())) + "\n")
    return path


@pytest.mark.parametrize("suffix", ["npz", "npy", "json", "txt"])
@pytest.mark.parametrize("labels", [LABELS, LABELS.astype(np.uint8), np.array(["skin", "top", "top", "x", "y"])])
def test_every_form_gives_the_same_labels(tmp_path: Path, suffix: str, labels: np.ndarray) -> None:
    """Broken where a form drops, reorders or renames labels."""
    found = read_labels(write(tmp_path / f"labels.{suffix}", labels))
    assert found.tolist() == labels.tolist()


def test_the_array_is_chosen_by_key(tmp_path: Path) -> None:
    """Broken where another array than the named one is read, or a doubtful one silently."""
    path = tmp_path / "l.npz"
    np.savez(path, a=LABELS, b=LABELS + 1)
    assert read_labels(path, "b").tolist() == (LABELS + 1).tolist()
    for key in (None, "c"):
        with pytest.raises(BadInput) as caught:
            read_labels(path, key)
        assert caught.value.code == "scan.labels_unreadable" and "a, b" in caught.value.message
    np.savez(path, a=LABELS)
    assert read_labels(path).tolist() == LABELS.tolist()
    np.savez(path, panel=LABELS + 1, is_garment=LABELS)
    assert read_labels(path).tolist() == LABELS.tolist()


def test_unsigned_labels_beyond_64_bits_are_refused(tmp_path: Path) -> None:
    """Broken where a huge label wraps to a negative one."""
    with pytest.raises(BadInput):
        read_labels(write(tmp_path / "l.npy", np.array([0, 2**64 - 1], dtype=np.uint64)))


class Explodes:
    """Fail the test where it is unpickled."""

    def __reduce__(self):
        return (pytest.fail, ("a label file was unpickled",))


def header(shape: str, kind: str = "<i8") -> bytes:
    """Return the start of an .npy file that claims what it likes."""
    text = f"{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}"
    text += " " * (117 - len(text)) + "\n"
    return b"\x93NUMPY\x01\x00" + len(text).to_bytes(2, "little") + text.encode()


def hostile() -> dict[str, bytes]:
    """Return files that want to be unpickled, to fill the memory, or that are not what they are called."""
    pickled = io.BytesIO()
    np.save(pickled, np.array([Explodes(), 1], dtype=object), allow_pickle=True)
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        archive.writestr("label.npy", pickled.getvalue())
    empty = io.BytesIO()
    np.savez(empty)
    bomb = io.BytesIO()
    with zipfile.ZipFile(bomb, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("label.npy", header("(999999999999,)") + b"\0" * 10**6)
    return {
        "objects.npy": pickled.getvalue(),
        "objects.npz": packed.getvalue(),
        "bomb.npz": bomb.getvalue(),
        "short.npy": header("(1000,)") + b"\0" * 16,
        "negative.npy": header("(-1,)"),
        "two.npy": header("(3, 3)") + b"\0" * 72,
        "float.npy": header("(1,)", "<f8") + b"\0" * 8,
        "long_words.npy": header("(1,)", "<U9999") + b"\0" * 40000,
        "empty.npz": empty.getvalue(),
        "none.npy": header("(0,)"),
        "cut.npy": header("(1000,)")[:40],
        "noise.npz": b"PK\x03\x04 no archive",
        "noise.npy": b"no array",
        "mixed.json": b'[0, "a"]',
        "float.json": b"[0.5, 1]",
        "deep.json": b"[" * 200000,
        "number.json": b"7",
        "text.json": b"no json",
        "binary.txt": b"\xff\xfe\x00",
        "nothing.txt": b"",
        "labels.csv": b"0,1",
    }


@pytest.mark.parametrize("name", sorted(hostile()))
def test_hostile_files_are_refused_by_one_line(tmp_path: Path, name: str) -> None:
    """Broken where a file is unpickled, believed about its size, or gives a traceback."""
    path = tmp_path / name
    path.write_bytes(hostile()[name])
    with pytest.raises(BadInput) as caught:
        read_labels(path)
    assert caught.value.code == "scan.labels_unreadable"
    assert "\n" not in caught.value.message and len(caught.value.message) < 300


def test_missing_and_large_files_are_refused(tmp_path: Path) -> None:
    """Broken where a path that does not exist is a traceback, or a file is read before its size is known."""
    with pytest.raises(BadInput) as caught:
        read_labels(tmp_path / "none.npz")
    assert caught.value.code == "scan.labels_unreadable"
    path = write(tmp_path / "l.txt", LABELS)
    for limits in (Limits(file_bytes=4), Limits(count=4)):
        with pytest.raises(BadInput) as caught:
            read_labels(path, limits=limits)
        assert caught.value.code == "scan.labels_unreadable"
