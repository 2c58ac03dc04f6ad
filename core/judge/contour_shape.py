"""Compare the shape of a drape's open contours with the scan's, which shows wrong parts of a cut."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..body.body import JOINT_PARENTS, JOINTS, Body
from ..garment.creases import find_turned_panels
from ..garment.curves import panel_area
from ..garment.garment import Garment
from ..garment.neckline_fit import NecklineFit, fit_necklines
from ..garment.parts.cut import Neckline
from ..garment.parts.hoods import HOOD_LABEL
from ..garment.parts.necklines import corner_turn
from ..geometry.curves import Curve, resample_polyline
from ..geometry.geometry import face_areas, rim_turns
from ..run.units import MM_PER_M
from ..scan.contours.edge_turn import EdgeTurn
from ..scan.contours.loop import smooth_loop
from ..scan.contours.neck import unroll_neck
from ..scan.contours.target import Contour, Target
from ..scan.contours.turned import find_turned_faces

CORNER_SPAN = 0.012
"""Length at each side of the middle within which a pattern's edge may turn for its corner [m]: less than an edge of a
coarse mesh. A round neckline of 7 cm radius turns by 20 degrees there."""

MAX_CORNER_LATERAL_OFFSET = 0.015
"""Largest distance from the median plane at which a pattern's corner is sought [m]: the lateral error of a drape, an
edge of a coarse mesh. The corners of a square neckline are further away."""

NECKLINE_SEGMENT_COUNT = 400
"""Number of segments of half a neckline between which distances are measured: less than 1 mm each."""

LIMB_DIRECTION_COUNT = 72
"""Number of directions around a limb in which an edge's position along the limb is measured."""

EDGE_AVERAGING_ANGLE = np.radians(60.0)
"""Width of the window over which such positions are averaged [rad]: wider than the folds of a hem, which differ between
drapes, and narrower than a dip of front, back or side."""

CORNER_SEARCH_RADIUS = 0.04
"""Distance from a corner of the scan's edge within which the drape's corner is sought [m]: the lateral error of a
drape. Corners of one edge are twice as far apart."""


def measure_contour_shapes(garment: Garment, nodes: np.ndarray, target: Target, body: Body) -> dict[str, float | None]:
    """Measure the differences between a drape's open contours and the scan's, each unrolled into the plane.

    Args:
        garment: The recovered pattern, meshed and sewn; gives the contours, not the nodes.
        nodes: Its drape [m], shape [node_count, 3].
        target: The scan's surface; only its trusted contours count.
        body: The wearer.

    Returns:
        `shape.neck_corner_deg`: difference of the corners in the middle of the pattern's neckline and of the scan's,
            the larger of front and back. The pattern's is measured in the flat cloth, independent of the drape. The
            scan's is that of the straight V of its width and depth where its line is nearest to a V, since worn cloth
            bows what was cut straight, and 0 where it is nearest to another neckline.
        `shape.neck_mm`: largest distance of the two unrolled neck lines. `shape.NAME_mm` of any other contour: the
            largest distance along its limb or trunk; the two edges of an open front have none, since they are free to
            hang closed or wide open.
        `shape.edge_corner_deg`: largest lack of turning of the pattern's edge within `CORNER_SEARCH_RADIUS` of a corner
            of the scan's other edges, in their cloth; 0 where these have no corners. Edges that also turn elsewhere, as
            cut and noisy ones do, are not evaluated, nor are the parts of an open front's border, which end in corners.
        `shape.collar_cm2`: area that is turned over at the scan's neck beyond that of the pattern's collar or hood,
            whose edge is then compared as a hem.
        Contours that either lacks are left out.
    """
    found: dict[str, float | None] = {}
    names = find_turned_panels(garment.pattern)
    names |= {panel.name for panel in garment.pattern.panels if panel.label == HOOD_LABEL}
    turned = sum(panel_area(panel) for panel in garment.pattern.panels if panel.name in names)
    missed: list[float] = []
    ours = {contour.name: contour for contour in garment.contours if not contour.name.startswith("front")}
    for contour in target.contours:
        if not contour.trusted or contour.name not in ours:
            continue
        loop, true_loop = nodes[ours[contour.name].vertices], target.vertices[contour.vertices]
        if not (contour.is_closed and ours[contour.name].is_closed):
            curves = ours[contour.name].curve(nodes), contour.curve(target.vertices)
            found[f"shape.{contour.name}_mm"] = MM_PER_M * _compare_arcs(*curves, _axis(contour, body))
        elif contour.name == "neck" and not names:
            found |= _compare_necks(loop, true_loop, body)
            found |= _compare_corners(garment, nodes, target, body)
        else:
            found[f"shape.{contour.name}_mm"] = MM_PER_M * _compare_edges(loop, true_loop, _axis(contour, body))
            missed += _missed_corners(garment, nodes, target, contour)
    neck = target.contour("neck")
    if neck is not None and neck.trusted:
        faces = target.faces[find_turned_faces(target.vertices, target.faces, neck, body)]
        found["shape.collar_cm2"] = 1e4 * max(0.0, float(face_areas(target.vertices, faces).sum()) - turned)
    if missed:
        found["shape.edge_corner_deg"] = float(np.degrees(max(missed)))
    return found


def _compare_necks(loop: np.ndarray, true_loop: np.ndarray, body: Body) -> dict[str, float | None]:
    """Return the largest distance of two neck contours, each unrolled in front and behind."""
    lines, others = unroll_neck(loop, body), unroll_neck(true_loop, body)
    if lines is None or others is None:
        return {}
    pairs = ((lines.front, others.front), (lines.back, others.back))
    return {
        "shape.neck_mm": MM_PER_M * max(_largest_gap(one, two) for pair in pairs for one, two in (pair, pair[::-1]))
    }


def _compare_corners(garment: Garment, nodes: np.ndarray, target: Target, body: Body) -> dict[str, float | None]:
    """Return the difference between the corners in the middle of a pattern's neckline and of a scan's."""
    fits = fit_necklines(target, body)
    if fits is None:
        return {}
    loop = next(contour.vertices for contour in garment.contours if contour.name == "neck")
    lateral = body.sideways("shoulder")
    off, ahead = nodes[loop] @ lateral, nodes[loop] @ np.cross(lateral, (0.0, 1.0, 0.0))
    off = np.abs(off - (off.max() + off.min()) / 2) / np.linalg.norm(lateral)
    apart = []
    for side, fit in ((ahead > ahead.mean(), fits.front[0]), (ahead <= ahead.mean(), fits.back[0])):
        candidates = np.flatnonzero(side & (off <= max(MAX_CORNER_LATERAL_OFFSET, off[side].min())))
        turn = max(flat_turn(garment, loop, int(node)) for node in candidates)
        apart.append(abs(turn - _corner_angle(fit)))
    return {"shape.neck_corner_deg": float(np.degrees(max(apart)))}


def _corner_angle(fit: NecklineFit) -> float:
    """Return the corner in the middle of the neckline that is nearest to a contour [rad]."""
    if fit.neckline.kind is not Neckline.V:
        return 0.0
    return corner_turn(replace(fit.neckline, bow=0.0), fit.half_width)


def flat_turn(garment: Garment, loop: np.ndarray, middle: int) -> float:
    """Return the turning angle of an open edge in the flat cloth within `CORNER_SPAN` of one of its nodes [rad], >= 0.

    At a node the edge turns by pi less the sum of the flat triangles' angles, also at a seam's end and in any layout.

    Args:
        garment: The pattern, meshed and sewn.
        loop: Nodes along the edge, closed.
        middle: Index of the node in `loop`.
    """
    order = np.roll(loop, -middle)
    arc = Curve(garment.nodes[order]).arc
    within = np.minimum(arc[:-1], arc[-1] - arc[:-1]) < CORNER_SPAN
    return abs(float(_flat_turns(garment, order)[within].sum()))


def _flat_turns(garment: Garment, loop: np.ndarray) -> np.ndarray:
    """Return the turning angle of an open edge in the flat cloth at each of its nodes [rad], shape [n]."""
    flat = np.c_[garment.uv, np.zeros(len(garment.uv))]
    return rim_turns(flat[garment.uv_faces], garment.faces, loop)


def _missed_corners(garment: Garment, nodes: np.ndarray, target: Target, contour: Contour) -> list[float]:
    """Return the lack of turning of a pattern's edge at each corner of a scan's [rad], and 0; empty if the scan is
    rough."""
    seen = EdgeTurn.of_target(contour, target)
    corners = seen.corners()
    if not seen.is_clear(corners):
        return []
    loop = next(each.vertices for each in garment.contours if each.name == contour.name)
    edge_turn, missed = EdgeTurn.of(nodes[loop], _flat_turns(garment, loop)), [0.0]
    for place in corners:
        turn, distance = float(seen.turn[place]), np.linalg.norm(edge_turn.points - seen.points[place], axis=1)
        alike = np.sign(turn) * edge_turn.turn[distance <= max(CORNER_SEARCH_RADIUS, distance.min())]
        missed.append(abs(turn) - max(0.0, float(alike.max())))
    return missed


def _largest_gap(line: np.ndarray, other: np.ndarray) -> float:
    """Return the largest distance of a line's points from another line [m]."""
    fine = resample_polyline(other, 1 + NECKLINE_SEGMENT_COUNT)
    return float(np.linalg.norm(line[:, None] - fine[None], axis=2).min(axis=1).max())


def _axis(contour: Contour, body: Body) -> np.ndarray:
    """Return the unit direction of the limb around which a contour runs; upwards for trunk, waist and hem."""
    side = contour.name.partition(".")[2]
    bones = [bone for bone in contour.bones if side and bone.startswith(side)]
    if not bones:
        return np.array([0.0, 1.0, 0.0])
    index = JOINTS.index(bones[-1])
    direction = body.joints[JOINT_PARENTS[index]] - body.joints[index]
    return np.asarray(direction / max(float(np.linalg.norm(direction)), 1e-9))


def _compare_edges(mesh_loop: np.ndarray, true_loop: np.ndarray, axis: np.ndarray) -> float:
    """Return the largest distance of two closed edges along an axis, with folds averaged [m]."""
    seen = smooth_loop(true_loop)
    places = [_axial_positions(loop, axis, seen.mean(axis=0)) for loop in (smooth_loop(mesh_loop), seen)]
    return float(np.abs(places[0] - places[1]).max())


def _compare_arcs(one: Curve, other: Curve, axis: np.ndarray) -> float:
    """Return the largest distance along an axis of the points at equal shares of two edges' lengths [m], with folds
    averaged over a sixth of them as on closed edges (`EDGE_AVERAGING_ANGLE`)."""
    shares = np.linspace(0.0, 1.0, LIMB_DIRECTION_COUNT)
    apart = (one.at_shares(shares) - other.at_shares(shares)) @ axis
    weight = np.maximum(0.0, 1.0 - np.abs(shares[:, None] - shares) * 2.0 * np.pi / EDGE_AVERAGING_ANGLE)
    return float(np.abs(weight @ apart / weight.sum(axis=1)).max())


def _axial_positions(loop: np.ndarray, axis: np.ndarray, origin: np.ndarray) -> np.ndarray:
    """Return a closed line's positions along an axis [m] in directions around it, shape [LIMB_DIRECTION_COUNT]."""
    off = loop - origin
    across = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    across /= np.linalg.norm(across)
    angle = np.arctan2(off @ np.cross(axis, across), off @ across)
    directions = np.arange(LIMB_DIRECTION_COUNT) * (2 * np.pi / LIMB_DIRECTION_COUNT)
    apart = np.abs((angle[None] - directions[:, None] + np.pi) % (2 * np.pi) - np.pi)
    weight = np.maximum(0.0, 1.0 - apart / EDGE_AVERAGING_ANGLE) + 1e-9
    return np.asarray(weight @ (off @ axis) / weight.sum(axis=1))
