"""Read raw packs: the raw scan of a dressed person, with the true garments, labels and body."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...core.judge.true_pattern import TruePattern
from ...core.people.part import Part
from .packs import PackBad, find_packs, is_raw_pack, read_pattern_file

ROLES = {"upper": Part.UPPER, "lower": Part.LOWER, "onepiece": Part.ONE_PIECE, "outer": Part.OUTER}
"""Words for a garment in the file names of a raw pack."""


@dataclass(frozen=True)
class TrueGarment:
    """Describe the files of one true garment.

    Attributes:
        part: The garment's part.
        category: The author's category.
        mesh: Its whole drape, hidden parts included, in the truth's frame.
        visible: Array `visible`: True at the vertices of `mesh` that the scan shows.
        pattern: The true pattern, or None.
        template: The base pattern that a recovery may use, or None.
    """

    part: Part
    category: str
    mesh: Path
    visible: Path
    pattern: Path | None
    template: Path | None


@dataclass(frozen=True)
class RawPack:
    """Describe the files of one raw scan and its truth.

    Attributes:
        name: The folder's name.
        folder: The folder.
        scan: The only file that is passed to a recovery.
        to_truth: Affine map from the scan's coordinates to the truth's (metres, y up), shape [4, 4].
        garments: The worn garments.
        labels: Array `label`: a `Part` of each vertex of the scan.
        body: The naked body in its pose, in the truth's frame.
        cover: Array `cover`: the `Part` that covers each vertex of `body`, 0 where it is bare.
    """

    name: str
    folder: Path
    scan: Path
    to_truth: np.ndarray
    garments: tuple[TrueGarment, ...]
    labels: Path
    body: Path
    cover: Path


def read_raw_packs(folder: Path, only: tuple[str, ...] = ()) -> tuple[RawPack, ...]:
    """Read the raw packs in a folder, in the order of their names; others are skipped.

    Args:
        folder: Folder with one folder per pack; or itself a pack.
        only: Names to keep; empty: all.

    Raises:
        PacksMissing, PackUnknown: as `read_packs`.
        PackBad: if the truth's files are not those of a raw pack.
    """
    return tuple(_read_pack(path) for path in find_packs(folder, only) if is_raw_pack(path))


def read_true_labels(pack: RawPack) -> np.ndarray:
    """Read the true label of each vertex of a pack's scan, uint8, shape [file_count]."""
    return _read_array(pack.labels, "label").astype(np.uint8)


def read_cover(pack: RawPack) -> np.ndarray:
    """Read which part covers each vertex of the true body, uint8, shape [vertex_count]."""
    return _read_array(pack.cover, "cover").astype(np.uint8)


def read_visible(garment: TrueGarment) -> np.ndarray:
    """Read which vertices of a true garment the scan shows, bool, shape [vertex_count]."""
    return _read_array(garment.visible, "visible").astype(bool)


def read_garment_pattern(garment: TrueGarment) -> TruePattern | None:
    """Read the true pattern of a garment, or return None if the pack has none."""
    return None if garment.pattern is None else read_pattern_file(garment.pattern)


def _read_array(path: Path, name: str) -> np.ndarray:
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return np.asarray(arrays[name]).ravel()
    except (OSError, ValueError, KeyError) as error:
        raise PackBad(f"'{path}' has no array '{name}'; see docs/reference/files.md.") from error


def _read_pack(folder: Path) -> RawPack:
    truth = folder / "truth"
    try:
        meta = json.loads((folder / "meta.json").read_text(encoding="utf-8"))
        worn = json.loads((truth / "garments.json").read_text(encoding="utf-8"))
        to_truth = np.asarray(meta["scan_to_truth"], dtype=np.float64).reshape(4, 4)
        garments = tuple(_name_garment(truth, each) for each in worn)
    except (ValueError, KeyError, TypeError, OSError) as error:
        raise PackBad(
            f"'{folder}' is not a raw pack: meta.json, truth/garments.json; docs/reference/files.md."
        ) from error
    return RawPack(
        name=folder.name,
        folder=folder,
        scan=folder / "scan.ply",
        to_truth=to_truth,
        garments=garments,
        labels=truth / "labels.npz",
        body=truth / "body.ply",
        cover=truth / "body_cover.npz",
    )


def _name_garment(truth: Path, described: dict[str, Any]) -> TrueGarment:
    role = str(described["role"])

    def find(name: str) -> Path | None:
        return truth / name if (truth / name).is_file() else None

    return TrueGarment(
        part=ROLES[role],
        category=str(described["category"]),
        mesh=truth / f"garment_{role}.ply",
        visible=truth / f"garment_{role}_aux.npz",
        pattern=find(f"pattern_{role}.json"),
        template=find(f"base_{role}.json"),
    )
