"""Read one label per vertex from an untrusted file beside the scan: .npz, .npy, .json or .txt, never a pickle."""

from __future__ import annotations

import zipfile
from pathlib import Path
from typing import IO, Any

import numpy as np

from ..run.npy import read_array
from ..run.text import has_unstorable_text, read_json
from . import refusal
from .columns import LABELS
from .limits import Limits

MAX_LABEL_WORD_LENGTH = 64
"""Longest label that is a word [characters]."""


def read_labels(path: Path, key: str | None = None, limits: Limits | None = None) -> np.ndarray:
    """Read the labels in a file: int64 or texts, shape [label_count].

    Args:
        path: `.npz`, `.npy` (integers, booleans, texts), `.json` (list or object of lists), `.txt` (a label a line).
        key: The array's name in an `.npz` or `.json`; None: the only one, or the first of the usual names.
        limits: What reading may cost.

    Raises:
        LabelsUnreadable: where the file cannot be read as labels; it is never unpickled.
    """
    limits = limits or Limits()
    path = Path(path)
    if not path.is_file():
        raise refusal.LabelsUnreadable(f"there is no label file '{path.name}'; check the path.")
    if path.stat().st_size > limits.file_bytes:
        raise refusal.LabelsUnreadable(f"{path.name} is larger than {limits.file_bytes >> 20} MiB.")
    readers = {".npz": _read_npz, ".npy": _read_npy, ".json": _read_json, ".txt": _read_text}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise refusal.LabelsUnreadable(f"{path.name} is no .npz, .npy, .json or .txt; save the labels as one of these.")
    try:
        return _check(reader(path, key, limits), path.name)
    except refusal.LabelsUnreadable:
        raise
    except zipfile.BadZipFile as error:
        raise refusal.LabelsUnreadable(f"{path.name} is no .npz archive; save the labels again.") from error
    except Exception as error:  # zipfile, zlib, lzma and numpy's header reader fail in any way on a hostile file
        words = (str(error) or type(error).__name__).splitlines()[0][:120]
        raise refusal.LabelsUnreadable(f"{path.name} cannot be read as labels: {words}; save them again.") from error


def _read_npz(path: Path, key: str | None, limits: Limits) -> np.ndarray:
    with zipfile.ZipFile(path) as archive:
        names = {name.removesuffix(".npy"): name for name in archive.namelist() if name.endswith(".npy")}
        with archive.open(names[_choose(list(names), key, path.name)]) as entry:
            return _read_array(entry, limits, path.name)


def _read_npy(path: Path, key: str | None, limits: Limits) -> np.ndarray:
    with path.open("rb") as file:
        return _read_array(file, limits, path.name)


def _read_array(file: IO[bytes], limits: Limits, name: str) -> np.ndarray:
    def judge(shape: tuple[int, ...], kind: np.dtype) -> None:
        count = int(np.prod(shape, dtype=object))
        if kind.hasobject or kind.kind not in "iubU" or kind.itemsize > 4 * MAX_LABEL_WORD_LENGTH:
            raise refusal.LabelsUnreadable(f"{name} holds {kind}; labels are integers or short words, never objects.")
        if len([side for side in shape if side != 1]) > 1 or not 0 < count <= limits.count:
            raise refusal.LabelsUnreadable(f"{name} has the shape {shape}; give one label per vertex of the scan.")
        if count * kind.itemsize > limits.file_bytes:
            raise refusal.LabelsUnreadable(f"{name} holds more than {limits.file_bytes >> 20} MiB; number the labels.")

    return read_array(file, judge).ravel()


def _read_json(path: Path, key: str | None, limits: Limits) -> np.ndarray:
    data: Any = read_json(path.read_text(encoding="utf-8"))
    if isinstance(data, dict):
        data = data[_choose([name for name, value in data.items() if isinstance(value, list)], key, path.name)]
    if not isinstance(data, list):
        raise refusal.LabelsUnreadable(f"{path.name} holds no list; give one label per vertex of the scan.")
    return _as_array(data, path.name, limits)


def _read_text(path: Path, key: str | None, limits: Limits) -> np.ndarray:
    words: list[Any] = path.read_text(encoding="utf-8").split()
    if words and all(word.lstrip("+-").isdecimal() for word in words):
        words = [int(word) for word in words]
    return _as_array(words, path.name, limits)


def _as_array(values: list[Any], name: str, limits: Limits) -> np.ndarray:
    whole = all(type(value) in (int, bool) for value in values)
    word = all(type(value) is str and 0 < len(value) <= MAX_LABEL_WORD_LENGTH for value in values)
    if not (whole or word) or not 0 < len(values) <= limits.count:
        raise refusal.LabelsUnreadable(
            f"{name}: labels are all integers or all words of at most {MAX_LABEL_WORD_LENGTH} letters."
        )
    return np.array(values, dtype=np.int64 if whole else np.str_)


def _choose(names: list[str], key: str | None, file: str) -> str:
    """Return the array to read: the named one, the only one, or the first of the usual names."""
    if key is not None and key in names:
        return key
    shown = ", ".join(sorted(names)[:12]) or "none"
    if key is not None:
        raise refusal.LabelsUnreadable(f"{file} has no array '{key}', but {shown}; correct --labels-key.")
    if len(names) == 1:
        return names[0]
    usual = [name for name in LABELS if name in names]
    if not usual:
        raise refusal.LabelsUnreadable(f"{file} has the arrays {shown}; say with --labels-key which holds the labels.")
    return usual[0]


def _check(labels: np.ndarray, name: str) -> np.ndarray:
    if labels.dtype.kind == "U":
        if has_unstorable_text(list(set(labels.tolist()))):
            raise refusal.LabelsUnreadable(f"{name} holds words that are no text; save the labels again.")
        return labels
    if labels.dtype.kind == "u" and labels.size and int(labels.max()) > np.iinfo(np.int64).max:
        raise refusal.LabelsUnreadable(f"{name} holds labels beyond 64 bits; number them from 0.")
    return labels.astype(np.int64)
