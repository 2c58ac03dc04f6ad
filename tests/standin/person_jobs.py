"""Jobs of kind `person` whose files are written as ever, of a person whose parts are known."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from zlib import crc32

import numpy as np
import trimesh
from garmentq.core.deliver.export.person import write_scan_ply, write_segmented
from garmentq.core.people.labels import write_labels
from garmentq.core.people.part import Part
from garmentq.service.jobs import claim
from garmentq.service.kinds.person import Person
from garmentq.service.kinds.person_found import PersonFound
from garmentq.service.results import store_result
from garmentq.service.services import Services
from garmentq.service.submission import Order, submit
from garmentq.service.terms import JobTerms
from shells import Shells, separate_by_truth

BLUE, PINK = (0.0, 0.0, 1.0), (1.0, 0.6, 0.6)
"""Colours of the clothes and of the skin in the scan."""

EXTRA = 2
"""Points of the file that are no part of the person: they come first, and are dropped."""


READINGS = [
    {"parts": ["upper", "lower"], "score": 0.0},
    {"parts": ["one-piece"], "score": -1.0},
    {"parts": ["upper"], "score": -9.0},
]
"""Readings of the outfit of a kept person, the likeliest first."""


def keep_person(services: Services, folder: Path, shells: Shells, key: str = "", is_cloud: bool = False) -> str:
    """Submit a person's scan and store what it was taken apart into as a worker would; give the job's id."""
    raw, separation = separate_by_truth(shells, EXTRA)
    if is_cloud:
        raw = replace(raw, faces=np.zeros((0, 3), np.int64))
    folder.mkdir(parents=True)
    far = 5.0 + crc32(str(folder).encode()) / 2**32  # no two of these scans are the same file, so none shares a job
    points = np.concatenate([np.full((EXTRA, 3), far), shells.points])
    scan = folder / "shells.ply"
    trimesh.Trimesh(points, shells.faces + EXTRA, process=False).export(scan)
    terms = JobTerms(folder.name, ("spring",), key=key, realm=key, quota=100)
    order = Order(scan, None, given_as="person", terms=terms)
    job = submit(services.database, services.store, order).job
    out = folder / "out"
    out.mkdir()
    write_labels(separation.label, separation.confidence, out / "labels.npz", raw.place, raw.origin)
    write_segmented(raw, shells.label, separation.confidence[raw.origin], out / "segmented.ply")
    worn = np.isin(shells.label, (Part.UPPER, Part.LOWER))[:, None]
    write_scan_ply(replace(raw, colours=np.where(worn, BLUE, PINK)), out / "scan.ply")
    (out / "person.json").write_text(json.dumps({"garments": []}))
    found = PersonFound(shells.body, {"garments": [], "outfits": READINGS, "parts": {}})
    store_result(services.database, services.store, claim(services.database, job, "test", 600.0), Person(), found, out)
    return job
