"""Darts of a piece: wedges of its outline that are sewn to themselves."""

from __future__ import annotations

import numpy as np

from ...geometry.geometry import unit
from ..curves import edge_points
from ..outline import PLACKET_CONTOUR
from ..pattern import Panel

Span = tuple[int, int]


def find_darts(net: Panel, sewn_to: dict[int, int]) -> tuple[Span, ...]:
    """Return first and last edge of every dart; the last is counted on past the number of edges. Two neighbouring edges
    that are sewn to each other, and between which the outline turns into the cloth, are a dart; so are those around it
    that are sewn to each other too.

    Args:
        net: The piece.
        sewn_to: For each edge that is sewn to another one of the piece, that one.
    """
    count, spans = len(net.edges), []
    for i in range(count):
        if sewn_to.get(i) != (i + 1) % count or not _turns_inward(net, i):
            continue
        first, last = i, i + 1
        while last - first + 3 < count and sewn_to.get((first - 1) % count) == (last + 1) % count:
            first, last = first - 1, last + 1
        spans.append((first, last))
    return tuple(spans)


def find_slits(net: Panel) -> tuple[Span, ...]:
    """Return first and last edge of every slit within a piece: two neighbouring edges of a placket's contour, between
    which the outline turns into the cloth. They are marked as a dart is, and cut open between."""
    count = len(net.edges)
    is_placket = [edge.contour.startswith(PLACKET_CONTOUR) for edge in net.edges]
    return tuple(
        (i, i + 1) for i in range(count) if is_placket[i] and is_placket[(i + 1) % count] and _turns_inward(net, i)
    )


def _turns_inward(net: Panel, edge: int) -> bool:
    count = len(net.points)
    a, b, c = (net.points[(edge + k) % count] for k in range(3))
    return bool((b - a)[0] * (c - b)[1] - (b - a)[1] * (c - b)[0] < 0.0)


def fold_mouth(net: Panel, span: Span, is_laid_back: bool) -> np.ndarray:
    """Return the cut edge of a dart's mouth [m], shape [3, 2]: the edge beside it, seen through the folded dart. The
    half of the intake beside a leg lies under the cloth beyond that leg, so its edge is the mirror image of the edge
    there, up to the fold in the middle; the other half is the mirror image of the first.

    Args:
        net: The piece.
        span: The dart's first and last edge.
        is_laid_back: True where the intake is laid on the side of the edge before the dart, False on that of the next.
    """
    count = len(net.points)
    first, last = net.points[span[0] % count], net.points[(span[1] + 1) % count]
    if is_laid_back:
        mouth, leg, beside = (
            first,
            edge_points(net, span[0] % count, 64)[1],
            edge_points(net, (span[0] - 1) % count, 64)[-2],
        )
    else:
        mouth, leg, beside = (
            last,
            edge_points(net, span[1] % count, 64)[-2],
            edge_points(net, (span[1] + 1) % count, 64)[1],
        )
    along, axis = beside - mouth, unit(leg - mouth)
    along = 2.0 * float(along @ axis) * axis - along
    middle = (first + last) / 2.0
    fold = middle - net.points[(span[0] + span[1] + 1) // 2 % count]
    reach = np.linalg.lstsq(np.stack([along, -fold], axis=1), middle - mouth, rcond=None)[0][0]
    return np.array([first, mouth + reach * along, last]) if reach > 0.0 else np.array([first, last])


def dart_lines(
    net: Panel, spans: tuple[Span, ...], lines: list[np.ndarray]
) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
    """Return the sew line of each dart [m], shape [n, 2] each, and the tips [m], shape [dart_count, 2].

    Args:
        net: The piece.
        spans: Its darts.
        lines: Each edge as a polygon [m].
    """
    count = len(net.edges)
    legs = []
    for first, last in spans:
        parts = [lines[k % count] for k in range(first, last + 1)]
        legs.append(np.concatenate([part[:-1] for part in parts] + [parts[-1][-1:]]))
    tips = [net.points[(first + last + 1) // 2 % count] for first, last in spans]
    return tuple(legs), np.array(tips).reshape(-1, 2)
