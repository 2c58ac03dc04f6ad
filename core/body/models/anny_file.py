"""Read and write a person by Anny's parameters: JSON as Anny's demo saves it, or an `.npz` of plain arrays."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...run.errors import NotFound, keep_printable
from ...run.text import read_json
from ..body import Body
from ..model_arrays import BodyModelBad, BodyModelUnsupported, read_arrays
from .anny import PHENOTYPES, USUAL_PHENOTYPE, AnnyPerson, load_anny_model, local_ref_of, make_anny_body

MAX_ANNY_FILE_BYTES = 1 << 20
"""Largest size of a file of Anny's parameters [bytes]: five times that of one with all bones."""

PHENOTYPE_KEY, POSE_KEY, PARAMETERIZATION_KEY = "phenotype_kwargs", "pose_parameters", "pose_parameterization"
"""Names of Anny's own arguments."""

UNREAD_KEYS = ("local_changes_kwargs", "facial_actions")
"""Names of Anny's arguments whose blend shapes the asset does not have."""

PARAMETERIZATIONS = ("local-ref", "local-bone")
"""The parameterizations of a pose that are read; the first is Anny's usual one."""

SHOWN_PHENOTYPES = ("gender", "age", "muscle", "weight", "height", "proportions")
"""Phenotypes that are always written; a model of Anny's with its usual ones refuses others."""

ROTATION_TOLERANCE = 1e-3
"""Largest difference of a pose's transform from a rigid one, in any entry [1]: values in float32 and rounded JSON."""


def load_anny(path: Path) -> Body:
    """Read a body by Anny's parameters.

    Args:
        path: `.json`: phenotypes by name, or `phenotype_kwargs` with them, `pose_parameters` (bone: 4 x 4) and
            `pose_parameterization`. `.npz`: one array a phenotype, and `pose_parameters` [b, 4, 4].

    Raises:
        BodyModelBad: where a name, a value or a form is not Anny's, or outside its range.
        BodyModelUnsupported: where it has what the data lack.
    """
    found = _read_npz(path) if path.suffix.lower() == ".npz" else _read_json(path)
    return make_anny_body(read_person(found, path.name), f"anny:{path.stem}")


def is_anny_file(path: Path) -> bool:
    """Check whether a file is JSON with a name of Anny's phenotypes, and not for instance a pattern."""
    try:
        return not {PHENOTYPE_KEY, *PHENOTYPES}.isdisjoint(_read_json(path))
    except BodyModelBad:
        return False


def read_person(found: Mapping[str, Any], name: str = "it") -> AnnyPerson:
    """Read Anny's arguments by name; phenotypes may lie among them or below `phenotype_kwargs`.

    Raises:
        BodyModelBad: where a name, a value or a form is not Anny's, or outside its range.
        BodyModelUnsupported: where the data lack it.
    """
    for key in UNREAD_KEYS:
        changes = _object(found.get(key) or {}, key)
        used = [keep_printable(str(one)[:40]) for one, value in changes.items() if _number(value, str(one)) != 0.0]
        if used:
            raise BodyModelUnsupported(f"{name} has {key} ({', '.join(used[:3])}), which is not read; set them to 0.")
    known = (PHENOTYPE_KEY, POSE_KEY, PARAMETERIZATION_KEY, *UNREAD_KEYS)
    values = {key: value for key, value in found.items() if key not in known}
    values |= _object(found.get(PHENOTYPE_KEY) or {}, PHENOTYPE_KEY)
    if not values:
        raise BodyModelBad(f"{name} has none of Anny's phenotypes: {', '.join(PHENOTYPES)}. {BodyModelBad().message}")
    for key in values:
        if key not in PHENOTYPES:
            known_names = ", ".join(PHENOTYPES)
            raise BodyModelBad(f"'{keep_printable(str(key)[:40])}' is no phenotype of Anny's; they are {known_names}.")
    phenotypes = np.full(len(PHENOTYPES), USUAL_PHENOTYPE)
    for at, (key, (low, high)) in enumerate(PHENOTYPES.items()):
        if key in values:
            phenotypes[at] = value = _number(values[key], key)
            if key == "age" and -1 / 3 <= value < 0.0:
                raise BodyModelUnsupported(f"{name} is below one year (age {value:g}); garments begin at age 0.")
            if not low <= value <= high:
                raise BodyModelBad(f"{key} is {value:g}, and lies between {low:g} and {high:g} in Anny; correct it.")
    return AnnyPerson(phenotypes, _read_pose(found.get(POSE_KEY), str(found.get(PARAMETERIZATION_KEY, "local-ref"))))


def write_anny(body: Body) -> str:
    """Write a body's parameters of Anny as JSON that Anny and `load_anny` read; numbers keep all digits.

    Raises:
        NotFound: where the body was not made by Anny's parameters, or posed by others since.
    """
    if "phenotypes" not in body.parameters or "pose" in body.parameters:
        raise NotFound(f"{body.source} has no parameters of Anny's; give a file of them, in its own pose.")
    values = dict(zip(PHENOTYPES, body.parameters["phenotypes"].tolist(), strict=True))
    found: dict[str, Any] = {
        PHENOTYPE_KEY: {
            key: value for key, value in values.items() if key in SHOWN_PHENOTYPES or value != USUAL_PHENOTYPE
        },
        PARAMETERIZATION_KEY: PARAMETERIZATIONS[0],
    }
    pose = body.parameters.get(POSE_KEY)
    if pose is not None:
        moved = zip(load_anny_model().bones, pose, strict=True)
        found[POSE_KEY] = {bone: move.tolist() for bone, move in moved if not np.array_equal(move, np.eye(4))}
    return json.dumps(found, indent=1) + "\n"


def _read_json(path: Path) -> Mapping[str, Any]:
    try:
        with path.open("rb") as file:
            content = file.read(MAX_ANNY_FILE_BYTES + 1)
        if len(content) > MAX_ANNY_FILE_BYTES:
            raise BodyModelBad(f"{path.name} is too large for a person's parameters. {BodyModelBad().message}")
        return _object(read_json(content), path.name)
    except (OSError, ValueError, RecursionError) as error:
        raise BodyModelBad(f"{path.name} cannot be read as JSON. {BodyModelBad().message}") from error


def _read_npz(path: Path) -> Mapping[str, Any]:
    found: dict[str, Any] = read_arrays(path, (), (*PHENOTYPES, POSE_KEY, PARAMETERIZATION_KEY))
    if POSE_KEY in found:
        model = load_anny_model()
        moves = found[POSE_KEY]
        moves = moves[0] if moves.ndim == 4 and len(moves) == 1 else moves
        if moves.shape != (len(model.bones), 4, 4):
            raise BodyModelBad(f"{path.name}: {POSE_KEY} has the shape {moves.shape}, not [{len(model.bones)}, 4, 4].")
        found[POSE_KEY] = dict(zip(model.bones, moves, strict=True))
    if PARAMETERIZATION_KEY in found:
        found[PARAMETERIZATION_KEY] = str(found[PARAMETERIZATION_KEY].ravel()[0])
    return found


def _object(value: Any, name: str) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise BodyModelBad(f"{keep_printable(name)} holds no names with values. {BodyModelBad().message}")
    return value


def _number(value: Any, name: str) -> float:
    """Return a number, or that of a list or an array of one."""
    value = value.tolist() if isinstance(value, np.ndarray) else value
    while isinstance(value, list) and len(value) == 1:
        value = value[0]
    if isinstance(value, list):
        raise BodyModelBad(f"{keep_printable(name[:40])} has {len(value)} values; a file has one person.")
    try:
        number = math.nan if isinstance(value, bool) or not isinstance(value, int | float) else float(value)
    except OverflowError:
        number = math.nan
    if not math.isfinite(number):
        raise BodyModelBad(f"{keep_printable(name[:40])} is no finite number; correct it.")
    return number


def _read_pose(found: Any, parameterization: str) -> np.ndarray | None:
    """Return the transforms of all bones in `local-ref`, or None where none is given.

    Raises:
        BodyModelBad: where a bone is unknown, or its transform not rigid.
        BodyModelUnsupported: where the parameterization is not read.
    """
    if found is None or (isinstance(found, Mapping) and not found):
        return None
    if parameterization not in PARAMETERIZATIONS:
        raise BodyModelUnsupported(
            f"a pose in '{keep_printable(parameterization[:40])}' is not read; save it in "
            f"{' or '.join(PARAMETERIZATIONS)} (get_pose_parameterization)."
        )
    model = load_anny_model()
    pose = np.tile(np.eye(4), (len(model.bones), 1, 1))
    for bone, move in _object(found, POSE_KEY).items():
        if bone not in model.bones:
            raise BodyModelUnsupported(f"'{keep_printable(str(bone)[:40])}' is no bone of Anny's usual rig (anny).")
        pose[model.bones.index(bone)] = _read_move(move, bone)
    return pose if parameterization == PARAMETERIZATIONS[0] else local_ref_of(model, pose)


def _read_move(move: Any, bone: str) -> np.ndarray:
    try:
        found = np.array(move, dtype=np.float64)
    except (ValueError, TypeError, OverflowError) as error:
        raise BodyModelBad(f"{POSE_KEY} of {bone} holds no numbers. {BodyModelBad().message}") from error
    found = found[0] if found.shape == (1, 4, 4) else found
    if found.shape != (4, 4) or not np.isfinite(found).all():
        raise BodyModelBad(f"{POSE_KEY} of {bone} is no 4 x 4 transform of numbers.")
    turn = found[:3, :3]
    off = np.abs(np.concatenate([turn @ turn.T - np.eye(3), found[3:, :3], found[3:, 3:] - 1.0], axis=None)).max()
    if off > ROTATION_TOLERANCE or np.linalg.det(turn) < 0.0:
        raise BodyModelBad(f"{POSE_KEY} of {bone} is no rotation with a translation; correct it.")
    return found
