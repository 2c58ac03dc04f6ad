"""A raw pack that is a flat sheet: what every measure finds on it is known by construction."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
from garmentq.cli.bench.raw_file import RawFile, write_raw_file
from garmentq.core.people.part import Part

SPACING = 0.01
"""Between neighbours [m]."""


def sheet(width: int = 60, height: int = 100) -> tuple[np.ndarray, np.ndarray]:
    """Triangulate a flat sheet of SPACING, y up."""
    x, y = np.meshgrid(np.arange(width) * SPACING, np.arange(height) * SPACING)
    points = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    first = (np.arange(height - 1)[:, None] * width + np.arange(width - 1)).ravel()
    lower = np.stack([first, first + 1, first + width], axis=1)
    upper = np.stack([first + 1, first + width + 1, first + width], axis=1)
    return points, np.concatenate([lower, upper])


def dress(points: np.ndarray, hem: float, waist: float, neck: float) -> np.ndarray:
    """Label a sheet by height: skin below the hem, trousers, shirt, skin above the neck."""
    levels = np.digitize(points[:, 1], [hem, waist, neck])
    return np.array([Part.SKIN, Part.LOWER, Part.UPPER, Part.SKIN], np.uint8)[levels]


def make_raw_pack(folder: Path) -> Path:
    """Write a raw pack of a sheet in centimetres, z up; the truth is the sheet itself."""
    points, faces = sheet()
    truth = folder / "truth"
    truth.mkdir(parents=True)
    swapped = 100.0 * np.stack([points[:, 0], -points[:, 2], points[:, 1]], axis=1)
    write_raw_file(RawFile(swapped, faces), folder / "scan.ply")
    to_truth = [[0.01, 0, 0, 0], [0, 0, 0.01, 0], [0, -0.01, 0, 0], [0, 0, 0, 1]]
    (folder / "meta.json").write_text(json.dumps({"name": folder.name, "scan_to_truth": to_truth}))
    worn = [{"role": "upper", "category": "tshirt"}, {"role": "lower", "category": "skirt"}]
    (truth / "garments.json").write_text(json.dumps(worn))
    labels = dress(points, 0.1, 0.5, 0.9)
    np.savez(truth / "labels.npz", label=labels)
    np.savez(truth / "body_cover.npz", cover=labels)
    write_raw_file(RawFile(points - [0.0, 0.0, 0.01], faces), truth / "body.ply")
    square = {"unit": "m", "panels": {"a": {"outline": [[0, 0], [1, 0], [1, 1], [0, 1]]}}}
    for role, part in (("upper", Part.UPPER), ("lower", Part.LOWER)):
        kept = np.flatnonzero(labels == part)
        write_raw_file(RawFile(points, faces).take(kept), truth / f"garment_{role}.ply")
        np.savez(truth / f"garment_{role}_aux.npz", visible=np.ones(len(kept), bool))
        (truth / f"pattern_{role}.json").write_text(json.dumps(square))
    return folder
