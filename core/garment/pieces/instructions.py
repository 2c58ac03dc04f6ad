"""Instructions for sewing a garment: a step for each named seam, then one for each kind of opening."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from ..curves import edge_length
from .naming import say_name
from .piece import CLOSURE_EDGE_USES, EdgeUse, Piece, PieceSet, SeamWalk

OPEN_EDGE_NAMES: Mapping[EdgeUse, str] = MappingProxyType({
    EdgeUse.FACED: "faced edges", EdgeUse.VENT: "vent edges", EdgeUse.PLACKET: "sleeve slit",
    EdgeUse.FRONT: "front edges",
    EdgeUse.NECK: "neck edge", EdgeUse.ARMHOLE: "armhole edge", EdgeUse.WRAP: "wrap edges",
    EdgeUse.WAIST: "waist edge", EdgeUse.CUFF: "sleeve hem", EdgeUse.LEG: "leg hem", EdgeUse.HEM: "hem",
    EdgeUse.OPEN: "open edges",
})  # fmt: skip
"""Names of the openings of a garment by the use of their edges, in the order in which they are finished."""

PAIRED_EDGE_USES = (EdgeUse.ARMHOLE, EdgeUse.CUFF, EdgeUse.LEG, EdgeUse.PLACKET)
"""Uses of edges around an arm or a leg, of which there are two."""

PRESSING: Mapping[str, str] = MappingProxyType({
    "dart": "press to the middle", "bust dart": "press down", "pleat": "press flat",
    "shoulder seam": "press to the back", "crotch seam": "sew twice", "waistband seam": "press into the band",
    "neck seam": "press into the collar", "cuff seam": "press into the cuff", "hood crown seam": "press to one side",
})  # fmt: skip
"""How the allowances of a seam are pressed, by the end of its name; others are pressed open, or to the back."""


FINISHES: Mapping[str, str] = MappingProxyType({
    "rib seam": "join the ends, fold lengthwise, stretch evenly to fit, overlock",
    "facing seam": "join the facings, sew right sides together, trim, turn in, understitch",
    "binding seam": "fold round the edge, stitch", "casing seam": "sew on, turn in, stitch, draw in the cord",
    "lining seam": "join the lining as the hood, sew right sides together, turn, stitch a channel, draw in the cord",
})  # fmt: skip
"""How a piece that finishes an opening is sewn on, by the end of the seam's name."""

INNER_LAYER_FINISH = "join the inner layer as the outer, sew right sides together, trim, turn, fell its free edge"
"""How the inner layer of a cuff, a waistband or a collar is sewn to the outer one."""


@dataclass(frozen=True)
class SewingStep:
    """Describe one step of sewing.

    Attributes:
        name: Of the seam or the opening; no two steps have one name.
        pieces: Printed names of the pieces on both sides of the seam, equal where it joins a piece to itself or its
            mirror image; of an opening those with its edges, on one side.
        count: How often: 2 for left and right.
        lengths: Of both sides on the sew line, once [m]; equal but for gathers and eased or stretched sides.
        finish: How the allowances are finished and pressed.
    """

    name: str
    pieces: tuple[tuple[str, ...], ...]
    count: int
    lengths: tuple[float, float]
    finish: str

    def describe(self) -> str:
        """Return the step as one line, without its number."""
        short, long = sorted(100.0 * length for length in self.lengths)
        size = f"{short:.1f} cm" if long - short < 0.05 else f"{long:.1f} to {short:.1f} cm"
        often = f", {self.count} x" if self.count > 1 else ""
        sides = " to ".join(dict.fromkeys(", ".join(side) for side in self.pieces))
        return f"{self.name} {size}{often}: {sides}; {self.finish}"


def list_sewing_steps(pieces: PieceSet) -> tuple[SewingStep, ...]:
    """Return the steps of sewing in order: each seam once, then each kind of open edge."""
    steps: dict[int, list[SeamWalk]] = {}
    for seam in (*pieces.seams, *pieces.finishes):
        steps.setdefault(seam.step, []).append(seam)
    return (
        *(_describe_seam(pieces, steps[number]) for number in sorted(steps)),
        *_describe_openings(pieces),
    )


def _describe_seam(pieces: PieceSet, seams: list[SeamWalk]) -> SewingStep:
    count = 2 if seams[0].is_paired else 1
    lengths = tuple(sum(seam.lengths[k] for seam in seams) / count for k in (0, 1))
    use = pieces.cut_pieces[seams[0].sides[0][0].piece].edges[seams[0].sides[0][0].edge].use
    return SewingStep(
        seams[0].name, _list_sides(pieces, seams), count, (lengths[0], lengths[1]), _choose_finish(pieces, seams, use)
    )


def _list_sides(pieces: PieceSet, seams: list[SeamWalk]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the names of the pieces on both sides of a step's seams; a piece that is on both is on the first."""
    one: list[str] = []
    other: list[str] = []
    for seam in seams:
        first, second = ([say_name(pieces.cut_pieces[part.piece].name) for part in side] for side in seam.sides)
        if {*first} & {*other} or {*second} & {*one}:
            first, second = second, first
        one += first
        other += second
    return tuple(dict.fromkeys(one)), tuple(dict.fromkeys(other))


def _choose_finish(pieces: PieceSet, seams: list[SeamWalk], use: EdgeUse) -> str:
    if seams[0] in pieces.finishes:
        elastic = any("elastic" in pieces.cut_pieces[side.piece].net.label for side in seams[0].sides[0])
        inner = INNER_LAYER_FINISH + (", draw in the elastic" if elastic else "")
        return next((text for end, text in FINISHES.items() if seams[0].name.endswith(end)), inner)
    if use in CLOSURE_EDGE_USES:
        return "sew in the zip" if use is EdgeUse.ZIP else "turn the button stands, make buttonholes, sew on buttons"
    name = seams[0].name.rstrip(" 0123456789")
    pressing = next((text for end, text in PRESSING.items() if name.endswith(end) and end != "dart"), "")
    if name.endswith("dart"):
        return pressing or PRESSING["dart"]
    if name.endswith("pleat"):
        return pressing
    eased = any(seam.gathered for seam in seams)
    if name == "armhole seam":
        way = "in the round, ease the cap" if eased else "flat"
        return f"{way}; {'overlock' if pieces.is_stretchy else 'neaten'} together, press to the sleeve"
    way = "spread the fullness between the notches; " if eased else ""
    if pieces.is_stretchy:
        return f"{way}overlock together, {pressing or 'press to the back'}"
    if eased or pressing:
        return f"{way}neaten together, {pressing or 'press off the fullness'}"
    return "neaten the edges, press open"


def _describe_openings(pieces: PieceSet) -> list[SewingStep]:
    """Return a step for each kind of open edge."""
    steps = []
    finished = {(side.piece, side.edge) for seam in pieces.finishes for side in seam.sides[0]}
    for use, name in OPEN_EDGE_NAMES.items():
        found = [
            (piece, i)
            for number, piece in enumerate(pieces.pieces)
            for i, edge in enumerate(piece.edges)
            if edge.use == use and (number, i) not in finished
        ]
        if not found:
            continue
        total = sum(_edge_total(piece, i) for piece, i in found)
        count = 2 if use in PAIRED_EDGE_USES else 1
        width = max(piece.edges[i].width for piece, i in found)
        names = tuple(dict.fromkeys(say_name(piece.name) for piece, _ in found))
        steps.append(
            SewingStep(name, (names,), count, (total / count, total / count), _finish_opening(pieces, use, width))
        )
    return steps


def _edge_total(piece: Piece, edge: int) -> float:
    """Return the length of an edge with that of its mirrored copy, or its other half [m]."""
    return edge_length(piece.net, edge) * (1 if piece.edges[edge].mirror is None else 2)


def _finish_opening(pieces: PieceSet, use: EdgeUse, width: float) -> str:
    if use is EdgeUse.FACED:
        return "sew on the inner half, trim, turn, press"
    if width == 0.0:
        return "bind"
    if use in (EdgeUse.HEM, EdgeUse.CUFF, EdgeUse.LEG):
        way = "stitch with a twin needle or a coverstitch" if pieces.is_stretchy else "turn in the edge, stitch"
        return f"turn up {1e3 * width:g} mm, {way}"
    if use is EdgeUse.WAIST:
        return f"turn in {1e3 * width:g} mm as a casing, draw in elastic"
    return f"turn in {1e3 * width:g} mm, stitch"
