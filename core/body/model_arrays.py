"""Read the arrays of a body model from an untrusted `.npz` file; nothing is unpickled."""

from __future__ import annotations

import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import IO

import numpy as np

from ..run.errors import BadInput, keep_printable
from ..run.npy import read_array

CENTIMETRE_LENGTH = 0.01
"""Length of one centimetre, the unit of MHR's and SOMA's files [m]."""

PERSON_HEIGHT_RANGE = (0.8, 2.6)
"""Height of a standing person's model [m]; others are in another unit or axis."""

MAX_MODEL_VERTEX_COUNT = 50_000
"""Largest number of vertices. SMPL has 6890, MHR and SOMA 18 000; blend shapes of many more exceed the memory."""

MAX_MODEL_ARRAY_SIZE = MAX_MODEL_VERTEX_COUNT * 3 * 400
"""Largest number of values of an array: 400 blend shapes."""

MAX_MODEL_VALUE = 1e6
"""Largest value of an array [its own unit]: ten kilometres in centimetres."""

MAX_MODEL_ENTRY_COUNT = 1000
"""Largest number of arrays in a file; models have some tens."""

MAX_MODEL_JOINT_COUNT = 512
"""Largest number of joints; MHR has 127."""

TEXT_ARRAYS = ("joint_names", "pose_parameterization")
"""Names of the arrays that hold texts."""

MAX_NAME_LENGTH = 64
"""Largest number of letters of a joint's name."""


class BodyModelBad(BadInput):
    """The file is no body model that is known; give the arrays or parameters that docs/reference/files.md lists."""

    code = "body.model_bad"


class BodyModelUnsupported(BadInput):
    """The file of a body model has what is not read; docs/reference/files.md lists what is."""

    code = "body.model_unsupported"


def list_arrays(path: Path, error: type[BadInput] = BodyModelBad) -> frozenset[str]:
    """Return the names of the arrays of an `.npz` file.

    Raises:
        BadInput: of the class `error`, where it is no archive, or has too many entries.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            names = archive.namelist()
    except Exception as wrong:  # zipfile fails in any way on a hostile file
        raise error(f"{path.name} cannot be read: {str(wrong)[:100]}. {error().message}") from wrong
    if len(names) > MAX_MODEL_ENTRY_COUNT:
        raise error(f"{path.name} has {len(names)} entries. {error().message}")
    return frozenset(name.removesuffix(".npy") for name in names)


def read_arrays(
    path: Path, required: Iterable[str], optional: Iterable[str] = (), error: type[BadInput] = BodyModelBad
) -> dict[str, np.ndarray]:
    """Read arrays of an `.npz` file: numbers as float64, texts as they are.

    Raises:
        BadInput: of the class `error`, where one is missing, too large, or neither numbers nor short texts.
    """
    names = list_arrays(path, error)
    required = tuple(required)
    missing = [name for name in required if name not in names]
    if missing:
        raise error(f"{path.name} lacks {', '.join(missing)}. {error().message}")
    try:
        with zipfile.ZipFile(path) as archive:
            found = {}
            for name in (*required, *(name for name in optional if name in names)):
                with archive.open(f"{name}.npy") as entry:
                    found[name] = _read_array(entry, name, path.name, error)
    except error:
        raise
    except Exception as wrong:  # zipfile, zlib, lzma and numpy's header reader fail in any way on a hostile file
        raise error(f"{path.name} cannot be read: {str(wrong)[:100]}. {error().message}") from wrong
    return found


def check_vertex_count(count: int, name: str) -> None:
    """Check a model's number of vertices.

    Raises:
        BodyModelBad: where it is no body's.
    """
    if not 100 <= count <= MAX_MODEL_VERTEX_COUNT:
        raise BodyModelBad(f"{name} has {count} vertices. {BodyModelBad().message}")


def check_shapes(found: Mapping[str, np.ndarray], shapes: Mapping[str, tuple[int, ...]], name: str) -> None:
    """Check arrays: each has its shape, in which -1 is any number but 0, and values up to `MAX_MODEL_VALUE`.

    Raises:
        BodyModelBad: where one has not.
    """
    for key, shape in shapes.items():
        own = found[key].shape
        is_right = len(own) == len(shape) and all(a == b or (b < 0 < a) for a, b in zip(own, shape, strict=True))
        if not is_right:
            raise BodyModelBad(f"{name}: {key} has the shape {own}, expected {shape}. {BodyModelBad().message}")
        if found[key].dtype.kind == "f" and not (np.abs(found[key]) <= MAX_MODEL_VALUE).all():
            raise BodyModelBad(f"{name}: {key} has no numbers, or too large ones. {BodyModelBad().message}")


def check_indices(found: np.ndarray, count: int, what: str) -> np.ndarray:
    """Return indices as integers.

    Raises:
        BodyModelBad: where one is not from 0 to `count` - 1.
    """
    if not found.size or not np.isfinite(found).all() or found.min() < 0 or found.max() >= count:
        raise BodyModelBad(f"{what} are no indices below {count}. {BodyModelBad().message}")
    return found.astype(np.int64)


def check_parents(found: np.ndarray, what: str) -> tuple[int, ...]:
    """Return the parents of joints, -1 for the root's, which comes first, and any parent before its children.

    Raises:
        BodyModelBad: where they are no such tree, or too many.
    """
    parents = found.astype(np.int64).ravel() if np.isfinite(found).all() else np.zeros(0, dtype=np.int64)
    is_tree = all(0 <= parent < joint for joint, parent in enumerate(parents) if joint)
    if not 0 < len(parents) <= MAX_MODEL_JOINT_COUNT or not is_tree:
        raise BodyModelBad(f"{what} are no tree with each parent before its children. {BodyModelBad().message}")
    return (-1, *(int(parent) for parent in parents[1:]))


def check_weights(weights: np.ndarray, name: str) -> np.ndarray:
    """Return skinning weights whose rows sum to 1.

    Raises:
        BodyModelBad: where they are far from it, or negative.
    """
    total = weights.sum(axis=1, keepdims=True)
    if not np.isfinite(weights).all() or (weights < -1e-6).any() or np.abs(total - 1.0).max() > 1e-2:
        raise BodyModelBad(f"{name}: the rows of the skinning weights do not sum to 1. {BodyModelBad().message}")
    return np.asarray(weights / total)


def _read_array(file: IO[bytes], name: str, of: str, error: type[BadInput]) -> np.ndarray:
    """Read one array after its header; objects and arrays too large for a body are refused."""

    def judge(shape: tuple[int, ...], kind: np.dtype) -> None:
        if kind.hasobject or kind.kind not in ("iufbU" if name in TEXT_ARRAYS else "iufb"):
            raise error(f"{of}: {name} holds {kind}, not numbers (a sparse J_regressor must be saved dense).")
        limit = MAX_MODEL_ARRAY_SIZE if kind.kind != "U" else MAX_MODEL_VERTEX_COUNT
        if int(np.prod(shape, dtype=object)) > limit or (kind.kind == "U" and kind.itemsize > 4 * MAX_NAME_LENGTH):
            raise error(f"{of}: {name} has the shape {shape}, too large for a body.")

    found = read_array(file, judge)
    if found.dtype.kind == "U":
        return np.array([keep_printable(str(one)) for one in found.ravel()], dtype=str).reshape(found.shape)
    return np.ascontiguousarray(found, dtype=np.float64)
