"""Make production pieces of patterns from elsewhere, and count what a cutting room would send back.

    python benchmarks/foreign_pieces.py FOLDER... [--own 47] [--list]

FOLDERs hold `*specification.json` of any depth (`foreign_sampled.py` draws some); `--own` adds patterns of our own
parts without their names, labels and notes. What is counted is measured here, without the code that places it: the
angle of a sleeve's grainline to its arm, notches along seams of over 12 cm and their distances, mouths of darts, open
edges that neither have a name nor are asked about, and corners of lines across seams.

Prints one JSON object a pattern with a fault (`--list`: each), then the counts.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from foreign_own import draw_cut
from garmentq.core.garment.curves import edge_length
from garmentq.core.garment.fairness import measure_corner
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.garment.grain import place_grains
from garmentq.core.garment.panel_parts import find_arm_panels
from garmentq.core.garment.pattern import EdgeRef, Pattern
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.pieces.piece import EdgeUse, Piece, PieceSet, PieceSide, SeamWalk
from garmentq.core.garment.pieces.trued_joins import find_crossed_joins
from garmentq.core.garment.pieces.trueing import true_pattern
from garmentq.core.garment.seams import find_sewn_partners
from garmentq.core.garment.templates import load_template
from garmentq.core.run.errors import BadInput, GarmentqError
from sizes import forget_names

LONG_SEAM = 0.12
"""Length over which a seam needs a notch to be matched [m]."""

NEAREST_NOTCHES = 0.015
"""Smallest distance of two notches [m]; the two cuts of a double one are 6 mm apart and count as one."""

WIDEST_DART = 0.08
"""Width of a mouth over which a dart is none [m]: a waist dart takes in 2 to 5 cm (W. Aldrich)."""

SMOOTH = np.radians(3.0)
"""Corner up to which a line across a seam is smooth [rad]."""

ACROSS = np.radians(45.0)
"""Angle of a grainline to the arm from which it is across [rad]."""

CATEGORIES = ("tshirt", "long_sleeve_tshirt", "tank", "dress", "skirt", "trousers", "shorts", "jumpsuit")


@dataclass
class Faults:
    """Describe what was found in a pattern: how many of each kind there are, and the faults."""

    counts: Counter[str] = field(default_factory=Counter)
    faults: Counter[str] = field(default_factory=Counter)
    notes: list[str] = field(default_factory=list)

    def add(self, kind: str, is_fault: bool, note: str = "") -> None:
        """Count one case."""
        self.counts[kind] += 1
        if is_fault:
            self.faults[kind] += 1
            self.notes.append(f"{kind}: {note}")


def main() -> None:
    """Count all."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--own", type=int, default=0)
    parser.add_argument("--list", action="store_true")
    given = parser.parse_args()
    counts, faults, made, refused = Counter(), Counter(), 0, Counter()
    for name, read in list_patterns(given.folders, given.own):
        try:
            pattern = read()
            found = examine(pattern, make_pieces(pattern))
        except (BadInput, GarmentqError) as error:
            refused[error.code] += 1
            print(json.dumps({"pattern": name, "refused": error.code, "message": error.message[:160]}), flush=True)
            continue
        made += 1
        counts += found.counts
        faults += found.faults
        if given.list or found.notes:
            print(json.dumps({"pattern": name, "faults": found.faults, "notes": found.notes[:6]}), flush=True)
    print(f"{made} patterns made into pieces, {sum(refused.values())} refused: {dict(refused)}")
    for kind in sorted(counts):
        print(f"{kind}: {faults[kind]} of {counts[kind]}")


def list_patterns(folders: list[Path], own: int):
    """Yield the name of each pattern, and what reads it."""
    for folder in folders:
        for path in sorted(folder.rglob("*specification.json")):
            yield f"{path.parent.name}/{path.name}", lambda path=path: load_pattern(path)
    for n in range(own):
        rng = np.random.default_rng([7300, n])
        cut = draw_cut(CATEGORIES[n % len(CATEGORIES)], rng)
        yield f"own {n} {cut}", lambda cut=cut: place_grains(forget_names(load_template(cut)))


def examine(pattern: Pattern, made: PieceSet) -> Faults:
    """Return the faults of a pattern's pieces."""
    found = Faults()
    _examine_grains(pattern, made, found)
    _examine_notches(made, found)
    _examine_darts(pattern, made, found)
    is_asked = any("unnamed open edges" in line for line in made.missing)
    for piece in made.pieces:
        for edge in piece.edges:
            found.add("open edges", edge.use is EdgeUse.OPEN and not is_asked, piece.name)
    trueing = true_pattern(pattern)
    told = [line for line in made.trued if not line.is_trued]
    for join in find_crossed_joins(pattern):
        corner = abs(measure_corner(trueing.pattern, join))
        found.add("corners across seams, left and not told", corner > SMOOTH and not told, f"{corner:.3f}")
        found.counts["corners across seams, left and told"] += 1
        if corner > SMOOTH:
            found.faults["corners across seams, left and told"] += 1
    return found


def _examine_grains(pattern: Pattern, made: PieceSet, found: Faults) -> None:
    """Compare the grainlines of sleeves with their arms."""
    arms = find_arm_panels(pattern)
    for piece in made.pieces:
        for place in piece.places:
            if arms.get(place.panel) != 1:
                continue
            along = _find_arm(pattern, place.panel, arms)
            if along is None:
                continue
            warp = (piece.grain[1] - piece.grain[0]) @ place.rotation
            cosine = min(abs(warp @ along) / (np.linalg.norm(warp) * np.linalg.norm(along)), 1.0)
            is_across = piece.is_grain_known and cosine < np.cos(ACROSS)
            found.add("grain of sleeves", bool(is_across), f"{place.panel} {np.degrees(np.arccos(cosine)):.0f} degrees")


def _find_arm(pattern: Pattern, name: str, arms: dict[str, int]) -> np.ndarray | None:
    """Return the direction of an arm in a panel's plane: between the middles of its edges at the trunk and at the hand,
    shape [2]; None where it has none there."""
    panel, partners = pattern.panel(name), find_sewn_partners(pattern)
    near, far = [], []
    for i in range(len(panel.edges)):
        partner = partners.get(EdgeRef(name, i))
        middle = (panel.points[i] + panel.points[(i + 1) % len(panel.points)]) / 2.0
        if partner is not None and partner.panel not in arms:
            near.append(middle)
        elif partner is None or arms[partner.panel] > 1:
            far.append(middle)
    return np.mean(near, axis=0) - np.mean(far, axis=0) if near and far else None


def _examine_notches(made: PieceSet, found: Faults) -> None:
    """Look for long seams without a notch, and for notches that lie too close."""
    for seams in _list_stretches(made):
        first = seams[0].sides[0][0]
        length = min(sum(seam.lengths[k] for seam in seams) for k in (0, 1))
        if made.pieces[first.piece].edges[first.edge].use is EdgeUse.DART or length <= LONG_SEAM:
            continue
        for k in (0, 1):
            edges = {(side.piece, side.edge) for seam in seams for side in seam.sides[k]}
            has = any(_has_notch(made.pieces[piece], edge) for piece, edge in edges)
            found.add("long seams", not has, f"{seams[0].name} {length:.2f} m")
    for piece in made.pieces:
        places = _list_places(piece)
        gaps = np.diff([*places, places[0] + _perimeter(piece)]) if len(places) > 1 else np.zeros(0)
        for gap in gaps:
            found.add("distances of notches", bool(gap < NEAREST_NOTCHES - 1e-6), f"{piece.name} {1e3 * gap:.1f} mm")


def _list_stretches(made: PieceSet) -> list[list[SeamWalk]]:
    """Return the seams in stretches: of one step, one after the other along both pieces. What ends at a cross seam is
    matched there."""
    stretches: list[list[SeamWalk]] = []
    for seam in made.seams:
        last = stretches[-1][-1] if stretches else None
        if (
            last is not None
            and last.step == seam.step
            and all(_follow(made, *(one.sides[k][0] for one in (last, seam))) for k in (0, 1))
        ):
            stretches[-1].append(seam)
        else:
            stretches.append([seam])
    return stretches


def _follow(made: PieceSet, one: PieceSide, other: PieceSide) -> bool:
    """Check whether two edges of one piece are neighbours."""
    count = len(made.pieces[one.piece].edges)
    is_beside = (one.edge - other.edge) % count in (1, count - 1)
    return (one.piece, one.mirrored) == (other.piece, other.mirrored) and is_beside


def _has_notch(piece: Piece, edge: int) -> bool:
    """Check whether an edge has a notch, or one at its start."""
    before = (edge - 1) % len(piece.edges)
    return any(notch.edge == edge or (notch.edge == before and notch.at > 1.0 - 1e-9) for notch in piece.notches)


def _list_places(piece: Piece) -> list[float]:
    """Return the places of a piece's notches along its sew line [m]; the cuts of a double notch are one."""
    starts = np.concatenate([[0.0], np.cumsum([edge_length(piece.net, i) for i in range(len(piece.edges))])])
    places = sorted(
        float(starts[notch.edge] + notch.at * edge_length(piece.net, notch.edge))
        for notch in piece.notches
        if notch.purpose != "hem"
    )
    return [place for k, place in enumerate(places) if k == 0 or place - places[k - 1] > 0.007]


def _perimeter(piece: Piece) -> float:
    return sum(edge_length(piece.net, i) for i in range(len(piece.edges)))


def _examine_darts(pattern: Pattern, made: PieceSet, found: Faults) -> None:
    """Look for darts that are too wide, or lie on a sleeve."""
    arms = find_arm_panels(pattern)
    for piece in made.pieces:
        count = len(piece.edges)
        is_dart = [edge.use is EdgeUse.DART for edge in piece.edges]
        for i in range(count):
            if is_dart[i] and not is_dart[i - 1]:
                length = next((k for k in range(1, count) if not is_dart[(i + k) % count]), count)
                mouth = float(np.linalg.norm(piece.net.points[(i + length) % count] - piece.net.points[i]))
                on_arm = any(place.panel in arms for place in piece.places)
                found.add("darts", mouth > WIDEST_DART or on_arm, f"{piece.name} {100 * mouth:.1f} cm")


if __name__ == "__main__":
    main()
