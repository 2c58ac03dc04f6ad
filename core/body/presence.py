"""Check that a scan is of one whole person, by how a fit as if bare covers it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ..run.errors import BadInput
from .body import JOINTS
from .fit import FitState, OrientedPoints
from .registration import NotHuman, pose_model
from .template import Template

MIN_SCAN_CELL_COUNT = 2500
"""Smallest number of cells of 12 mm with a point in them; a scan with fewer is too sparse: 27 mm between points on a
person's 1.9 m2, more than a cuff's hem."""
MIN_WHOLE_PERSON_HEIGHT = 1.05
"""Height [m] below which half of a scan is no second person: a seated one is 1.2 m high, half a standing one 0.8 to
1.0."""
MIN_WHOLE_PERSON_REACH = 0.85
"""Least extent of a scan along each axis as a share of the body's that was fitted to it [1]: hands and feet of small
people lie beyond the scan, and of half a person half of the body does."""

MAX_SCAN_MATCH_DISTANCE = 0.02
"""Distance [m] up to which a point of the body is found in the scan if the normals agree."""
MIN_SCAN_MATCH_COSINE = 0.7
"""Smallest cosine between the normals of body and scan at which they agree: 45 degrees."""
COVER_SEARCH_HEIGHTS = (0.0, 0.05, 0.10, 0.15, 0.20, 0.25)
"""Heights over the skin [m] at which the scan is sought: a coat or a skirt hides the body below it."""
STRAY_POINT_DISTANCE = 0.2
"""Distance from the body [m] beyond which there is only a wide skirt, a thing or another person."""
MAX_UNSEEN_BODY_SHARE = 0.08
"""Largest share of a whole person's body without scan over it."""


@dataclass(frozen=True)
class Presence:
    """Describe how a body and a scan cover each other.

    Attributes:
        unseen: Share of the body's vertices without scan on or over them: people 0.00 to 0.03, also in coats and wide
            skirts; left halves of people 0.10 to 0.20, others up to 0.41, chairs 0.09 to 0.24.
        found: Share of the body's vertices with scan of similar normal within `MAX_SCAN_MATCH_DISTANCE`: people 0.53 to
            0.82 (in coats too), chairs 0.29 to 0.38, animals 0.20 to 0.34, rooms 0.02 to 0.05.
        head: The same of the head, or the face if more: people 0.64 to 0.90, chairs <= 0.10, animals 0.25, headless 0.
        upper: The same of trunk and arms: people 0.52 to 0.86, a dog on its hind legs as a crouching child 0.46.
        far_share: Share of the scan further than 10 cm from the body: half a person at most 0.04, a chair 0.18.
        stray: Share of the scan beyond `STRAY_POINT_DISTANCE`: people 0.00 to 0.12 (wide skirts), pairs 0.29 to 0.45.
        reach: Smallest extent of the scan along an axis as a share of the body's.
    """

    unseen: float
    found: float
    head: float
    upper: float
    far_share: float
    stray: float
    reach: float = 1.0

    @property
    def is_person(self) -> bool:
        """Check whether the scan shows a person: all of the body, or its head and upper part over a wide skirt."""
        return self.unseen < MAX_UNSEEN_BODY_SHARE and self._is_like_one

    @property
    def may_be_whole(self) -> bool:
        """Check whether the scan may show a whole person, given the error of a fit as if bare."""
        return self.unseen < 2.0 * MAX_UNSEEN_BODY_SHARE and self._is_like_one

    @property
    def _is_like_one(self) -> bool:
        return self.found > 0.48 or (self.head > 0.35 and self.upper > 0.50)


class ScanPartial(BadInput):
    """Only a part of a person is in the scan; scan all of the person, from head to feet and all around."""

    code = "scan.partial"


class SeveralPersons(BadInput):
    """There is more than one person in the scan; cut it apart and submit each of them alone."""

    code = "scan.several_persons"


class TooSparse(BadInput):
    """The scan has too few points to show a person's clothes; export it with at least 10,000 points."""

    code = "scan.too_sparse"


def measure_presence(template: Template, surface: OrientedPoints, state: FitState) -> Presence:
    """Measure how a fit as if bare and its points cover each other."""
    model, normals = pose_model(template, state)
    tree = cKDTree(surface.points)
    over = np.zeros(len(model), dtype=bool)
    for height in COVER_SEARCH_HEIGHTS:
        # The search radius grows with the height: 5 cm at the skin, 12 cm at 25 cm.
        over |= tree.query(model + height * normals)[0] < 0.05 + 0.3 * height
    length = 0.05
    tree = cKDTree(surface.stack(length))
    nearest = tree.query(np.hstack([model, length * normals]))[1] % len(surface.points)
    cosine = np.einsum("na,na->n", surface.normals[nearest], normals)
    cosine = cosine if surface.oriented else np.abs(cosine)
    found = (cosine > MIN_SCAN_MATCH_COSINE) & (
        ((surface.points[nearest] - model) ** 2).sum(axis=1) < MAX_SCAN_MATCH_DISTANCE**2
    )
    distance = cKDTree(model).query(surface.points)[0]
    head = _weight_of(template, "head") > 0.5
    face = head & ~find_hair_vertices(template)
    legs = _weight_of(template, "hip", "knee", "ankle", "foot") > 0.5
    return Presence(
        unseen=1.0 - float(over.mean()),
        found=float(found.mean()),
        head=max(float(found[head].mean()), float(found[face].mean())),
        upper=float(found[~legs & ~head].mean()),
        far_share=float((distance > 0.1).mean()),
        stray=float((distance > STRAY_POINT_DISTANCE).mean()),
        reach=float((np.ptp(surface.points, axis=0) / np.ptp(model, axis=0)).min()),
    )


def find_hair_vertices(template: Template) -> np.ndarray:
    """Find the vertices of the head that hair may cover, shape [n]: all but the face below the brow."""
    joint = template.joints[JOINTS.index("head")]
    # The brow is 7 cm above the head's joint (the top of the neck), the ears are 1 cm in front of it.
    up, forward = (template.vertices - joint)[:, 1], (template.vertices - joint)[:, 2]
    return np.asarray((_weight_of(template, "head") > 0.5) & ((up > 0.07) | (forward < 0.03)))


def split_in_two(points: np.ndarray, rounds: int = 10) -> np.ndarray:
    """Split points into two by 2-means of x and z: True for the second cluster, shape [n]."""
    flat = points[:, [0, 2]] - points[:, [0, 2]].mean(axis=0)
    _, vectors = np.linalg.eigh(flat.T @ flat)
    second = flat @ vectors[:, -1] > 0
    for _ in range(rounds):
        if second.all() or not second.any():
            break
        centres = [flat[~second].mean(axis=0), flat[second].mean(axis=0)]
        second = np.linalg.norm(flat - centres[1], axis=1) < np.linalg.norm(flat - centres[0], axis=1)
    return np.asarray(second)


def find_presence_error(presence: Presence) -> BadInput | None:
    """Return why a scan is not one whole person, or None; two persons are not checked here."""
    if presence.is_person and presence.reach >= MIN_WHOLE_PERSON_REACH:
        return None
    if presence.far_share < 0.1 and presence.stray < 0.02:
        return ScanPartial()
    seen = f"Of a person's surface {100 * presence.found:.0f} % are found in the scan"
    return NotHuman(f"{seen}. The scan does not look like a person; scan a whole wearer, head to feet.")


def _weight_of(template: Template, *parts: str) -> np.ndarray:
    """Return the summed skinning weights of the joints with these names, with or without a side; shape [n]."""
    names = [name for name in JOINTS if name in parts or name.split("_")[-1] in parts]
    return np.asarray(template.weights[:, [JOINTS.index(name) for name in names]].sum(axis=1))
