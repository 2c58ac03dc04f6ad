"""Order in which the seams of a garment are sewn: flat as long as possible, tubes last."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product

import numpy as np

from ..curves import edge_length
from ..orientation import place_points
from ..parts.hoods import HOOD_LABEL
from ..pattern import EdgeRef, Pattern, Seam
from .closure import find_closure
from .naming import say_name
from .piece import Piece, PieceSide, SeamWalk
from .seam_names import SeamName, is_dart, name_seam

ARMHOLE_SEAM = "armhole seam"
"""Name of the seam that is sewn in the round where the sleeve's cap is eased in, else flat."""

Copy = tuple[int, bool]
Joint = tuple[str, int]
Sides = Mapping[EdgeRef, tuple[PieceSide, ...]]


@dataclass(frozen=True)
class Run:
    """Describe seams that are sewn in one go: those of one name that continue each other.

    Attributes:
        seams: Indices in the pattern's seams, in order.
        before: Indices of the seams that cross the run, and so are sewn before it.
    """

    name: SeamName
    seams: tuple[int, ...]
    before: frozenset[int]


def order_seams(pattern: Pattern, pieces: tuple[Piece, ...], mirror: Mapping[EdgeRef, EdgeRef]) -> tuple[SeamWalk, ...]:
    """Return the seams to be sewn, in order, without those inside a joined piece. Seams of one name that continue each
    other are one step, and so are their mirror images. Darts come first, then the seams of a hood, which is sewn on as
    a whole. Then, from the top of the garment down, seams that join pieces which are not connected yet: they are sewn
    flat. Then, from the top down, those that close the connected pieces to tubes, and last those with a zip or buttons.
    A seam waits for those that it crosses.

    Args:
        pattern: The pattern.
        pieces: Its pieces.
        mirror: For each edge its mirror image.
    """
    homes = find_sides(pieces)
    runs = find_runs(pattern, pieces, homes)
    steps = _pair_runs(pattern, runs, mirror)
    first = {key: runs[numbers[0]].seams[0] for key, numbers in steps.items()}
    waiting = sorted(steps, key=lambda key: (-_height(pattern, runs[steps[key][0]]), key))
    ordered = [key for key in waiting if is_dart(pattern, pattern.seams[first[key]])]
    ordered += [key for key in waiting if key not in ordered and _is_in_hood(pattern, pattern.seams[first[key]])]
    closures = [key for key in waiting if find_closure(pattern, pattern.seams[first[key]].a) is not None]
    waiting = [key for key in waiting if key not in ordered and key not in closures]
    cloth = {
        number: [_seam_pieces(pieces, homes, pattern.seams[seam]) for seam in runs[number].seams]
        for numbers in steps.values()
        for number in numbers
    }
    connected = {copy: copy for parts in cloth.values() for copies in parts for copy in copies}
    done: set[int] = set()
    for key in ordered:
        connected, done = _sew(runs, steps[key], cloth, connected, done)
    open_seams = {seam for key in closures for number in steps[key] for seam in runs[number].seams}
    while waiting:
        ready = [key for key in waiting if all(runs[n].before <= done | open_seams for n in steps[key])] or waiting
        joins = [key for key in ready if _joins(steps[key], cloth, connected)]
        chosen = (joins or ready)[0]
        waiting.remove(chosen)
        ordered.append(chosen)
        connected, done = _sew(runs, steps[chosen], cloth, connected, done)
    listed = [[runs[number] for number in steps[key]] for key in (*ordered, *closures)]
    return tuple(
        _walk(pieces, homes, pattern.seams[seam], (name, step, len(found) > 1))
        for step, (found, name) in enumerate(zip(listed, _name_steps(pattern, pieces, homes, listed), strict=True), 1)
        for run in found
        for seam in run.seams
    )


def _name_steps(pattern: Pattern, pieces: tuple[Piece, ...], homes: Sides, steps: list[list[Run]]) -> list[str]:
    """Return a name for each step, no two alike: that of its seam, with the side of the wearer where the other side has
    none like it, and a number where there are several."""
    names = []
    for step in steps:
        name, side = step[0].name.name, "" if len(step) > 1 else step[0].name.side
        seam = pattern.seams[step[0].seams[0]]
        between = " to ".join(dict.fromkeys(say_name(pieces[homes[ref][0].piece].name) for ref in (seam.a, seam.b)))
        names.append(f"{side} {name or f'{between} seam'}".strip())
    return [f"{name} {names[: k + 1].count(name)}" if names.count(name) > 1 else name for k, name in enumerate(names)]


def find_runs(pattern: Pattern, pieces: Sequence[Piece], homes: Sides) -> list[Run]:
    """Return the seams of pieces in runs: of one name and side of the wearer, and meeting each other. Darts are runs of
    their own. What crosses a run where its seams meet is sewn before it; a flat armhole is left open under the arm."""
    numbers = [n for n, seam in enumerate(pattern.seams) if seam.a in homes and seam.b in homes]
    names = {n: name_seam(pattern, pattern.seams[n]) for n in numbers}
    joints = find_joints(pattern)
    ends = {n: frozenset(joints[end] for end in _edge_ends(pattern, pattern.seams[n].a)) for n in numbers}
    whole, met = {n: n for n in numbers}, {n: frozenset[Joint]() for n in numbers}
    for one, other in combinations(numbers, 2):
        seams = pattern.seams[one], pattern.seams[other]
        if names[one] != names[other] or not names[one].name or any(is_dart(pattern, seam) for seam in seams):
            continue
        shared = ends[one] & ends[other]
        if names[one].name == ARMHOLE_SEAM and not any(seam.gathered for seam in seams):
            shared &= _find_passed(pattern, pieces, homes, joints, seams)
        if shared:
            kept, moved = sorted((whole[one], whole[other]))
            whole = {n: kept if root == moved else root for n, root in whole.items()}
            met[one] |= shared
    runs = []
    for root in sorted(set(whole.values())):
        members = [n for n in numbers if whole[n] == root]
        crossed = frozenset[Joint]().union(*(met[n] for n in members))
        before = frozenset(n for n in numbers if whole[n] != root and ends[n] & crossed)
        runs.append(Run(names[root], _sort_run(members, ends), before))
    return runs


def _sort_run(members: list[int], ends: Mapping[int, frozenset[Joint]]) -> tuple[int, ...]:
    """Return the seams of a run from one end to the other."""
    linked = {n: [m for m in members if m != n and ends[n] & ends[m]] for n in members}
    found: list[int] = []
    for start in sorted(members, key=lambda n: (len(linked[n]), n)):
        stack = [start]
        while stack:
            n = stack.pop()
            if n not in found:
                found.append(n)
                stack += sorted(linked[n], reverse=True)
    return tuple(found)


def find_joints(pattern: Pattern) -> dict[Joint, Joint]:
    """Return for each end of a sewn edge, a panel and the index of its control point, the first of those that lie upon
    each other when the garment is sewn."""
    joints: dict[Joint, Joint] = {}
    for seam in pattern.seams:
        (a0, a1), (b0, b1) = (_edge_ends(pattern, ref) for ref in (seam.a, seam.b))
        for one, other in ((a0, b1), (a1, b0)) if seam.reversed else ((a0, b0), (a1, b1)):
            kept, moved = sorted((joints.setdefault(one, one), joints.setdefault(other, other)))
            joints = {end: kept if root == moved else root for end, root in joints.items()}
    return joints


def _edge_ends(pattern: Pattern, ref: EdgeRef) -> tuple[Joint, Joint]:
    return (ref.panel, ref.edge), (ref.panel, (ref.edge + 1) % len(pattern.panel(ref.panel).points))


def _find_passed(
    pattern: Pattern, pieces: Sequence[Piece], homes: Sides, joints: dict[Joint, Joint], seams: tuple[Seam, Seam]
) -> frozenset[Joint]:
    """Return the joints at which two seams follow each other along a piece."""
    found = set()
    one, other = seams
    for ref, next_ref in product((one.a, one.b), (other.a, other.b)):
        for side, after in product(homes[ref], homes[next_ref]):
            count = len(pieces[side.piece].edges)
            if (side.piece, side.mirrored) != (after.piece, after.mirrored):
                continue
            for first, (last, last_ref) in ((side, (after, next_ref)), (after, (side, ref))):
                if (first.edge + 1) % count == last.edge:
                    found.add(joints[_edge_ends(pattern, last_ref)[1 if last.mirrored else 0]])
    return frozenset(found)


def _pair_runs(pattern: Pattern, runs: list[Run], mirror: Mapping[EdgeRef, EdgeRef]) -> dict[int, list[int]]:
    """Return the runs of each step by the step's first run: a run alone, or with its mirror image."""
    edges = [frozenset(ref for n in run.seams for ref in (pattern.seams[n].a, pattern.seams[n].b)) for run in runs]
    by_edges = {found: number for number, found in enumerate(edges)}
    steps: dict[int, list[int]] = {}
    for number, found in enumerate(edges):
        image = by_edges.get(frozenset(mirror.get(ref, ref) for ref in found), number)
        steps.setdefault(min(number, image), []).append(number)
    return steps


def _sew(
    runs: list[Run],
    numbers: list[int],
    cloth: Mapping[int, list[frozenset[Copy]]],
    connected: dict[Copy, Copy],
    done: set[int],
) -> tuple[dict[Copy, Copy], set[int]]:
    """Return the connected pieces after some runs, each named by one of its pieces of cloth, and the seams sewn."""
    for number in numbers:
        for copies in cloth[number]:
            whole = {connected[copy] for copy in copies}
            connected = {copy: min(whole) if now in whole else now for copy, now in connected.items()}
    return connected, done | {seam for number in numbers for seam in runs[number].seams}


def _joins(numbers: list[int], cloth: Mapping[int, list[frozenset[Copy]]], connected: dict[Copy, Copy]) -> bool:
    return any(len({connected[copy] for copy in copies}) > 1 for number in numbers for copies in cloth[number])


def find_sides(pieces: tuple[Piece, ...]) -> dict[EdgeRef, tuple[PieceSide, ...]]:
    """Return the pieces' edges for each edge of the pattern: its parts in the edge's direction."""
    found: dict[EdgeRef, list[tuple[float, PieceSide]]] = {}
    for number, piece in enumerate(pieces):
        for i, edge in enumerate(piece.edges):
            if edge.source is not None:
                found.setdefault(edge.source, []).append((edge.part[0], PieceSide(number, i, False)))
            if edge.mirror is not None:
                found.setdefault(edge.mirror, []).append((1.0 - edge.part[1], PieceSide(number, i, True)))
    return {ref: tuple(side for _, side in sorted(parts, key=lambda one: one[0])) for ref, parts in found.items()}


def _height(pattern: Pattern, run: Run) -> float:
    heights = []
    for number in run.seams:
        for ref in (pattern.seams[number].a, pattern.seams[number].b):
            panel = pattern.panel(ref.panel)
            ends = panel.points[[ref.edge, (ref.edge + 1) % len(panel.points)]]
            heights.append(float(place_points(panel, ends)[:, 1].mean()))
    return round(float(np.mean(heights)), 4)


def _is_in_hood(pattern: Pattern, seam: Seam) -> bool:
    return all(pattern.panel(ref.panel).label == HOOD_LABEL for ref in (seam.a, seam.b))


def _seam_pieces(pieces: tuple[Piece, ...], homes: Sides, seam: Seam) -> frozenset[Copy]:
    """Return the pieces of cloth on both sides of a seam: number, and whether it is the mirrored copy."""
    sides = (*homes[seam.a], *homes[seam.b])
    return frozenset((side.piece, side.mirrored and pieces[side.piece].pair) for side in sides)


def _walk(pieces: tuple[Piece, ...], homes: Sides, seam: Seam, step: tuple[str, int, bool]) -> SeamWalk:
    """Return a seam as it is sewn in a step: its name, its number, and whether both sides of the wearer have one."""
    name, number, is_paired = step
    sides = homes[seam.a], homes[seam.b][::-1] if seam.reversed else homes[seam.b]
    lengths = [sum(edge_length(pieces[side.piece].net, side.edge) for side in one) for one in sides]
    return SeamWalk(name, number, sides, (lengths[0], lengths[1]), seam.gathered, is_paired)
