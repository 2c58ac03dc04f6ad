"""Cut bust darts into a graded library pattern where the scan's cloth has the curvature of their ends."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...garment.editing.darts import find_darts
from ...garment.garment import Garment
from ...garment.pattern import EdgeRef
from ...run.errors import GarmentqError
from ..grade.bust_points import BustPoints, find_bust_points
from ..grade.parts import find_parts
from ..grade.sliding import SlideSettings, can_be_meshed, mesh_coarsely
from ..grade.trunk_curvature import TrunkCurvature
from ..state import RecoveryState, made
from .dart_cutting import cut_darts
from .dart_search import (
    DartMouth,
    DartSearchSettings,
    PlannedDart,
    find_corners,
    find_depths,
    list_mouths,
    mirror_of,
    reflect_point,
)
from .panel_change import MIN_DART_ANGLE, MIN_DART_WIDTH, describe_dart, panel_strains, refit_with_darts
from .wedge import Wedge, wanted_strain

MIN_SEAM_END_DISTANCE = 0.04
"""Least distance of the mouth's middle from the side seam's ends [m]: it is 3 to 7 cm wide, below a seam allowance."""

SIDE_SEAM_WARP_COSINE = np.cos(np.radians(45.0))
"""Cosine between chord and warp above which a seam is a side seam: nearer to the warp than to the weft (45 degrees)."""

MAX_SHARED_APEX_DISTANCE = 0.08
"""Distance from the bust point within which another dart counts as ending there [m]: a waist dart ends 2.5 cm below."""

MIRROR_POINT_TOLERANCE = 0.05
"""Largest distance of one bust point from the mirror image of the other in the panel [m]."""


def add_bust_darts(state: RecoveryState, graded: Garment, settings: SlideSettings) -> RecoveryState:
    """Cut bust darts into a slid pattern where the cloth is pointed, and slide its seams again.

    Without them the side seam moves to the front, until a front as long as the back is wide enough, and a waist seam
    moves up. They are kept if they are wide enough and reduce the front's strain, which other seams change too.

    Args:
        state: Target, wearer and base pattern; the pattern's coarse mesh as `slide_seams` left it on the target.
        graded: The graded pattern's mesh from which it was made.
        settings: How the seams were slid.

    Returns:
        The state with the darts in garment and base pattern, or unchanged.
    """
    slid = made(state.garment)
    points = find_bust_points(TrunkCurvature.of(state.target, state.body))
    plan = None if points is None else plan_bust_darts(slid, points)
    if plan is None or plan.angle < MIN_DART_ANGLE:
        return state
    _, strain = mesh_coarsely(graded, settings.isometry)
    try:
        cut = cut_darts(slid, wanted_strain(slid, strain), state.base, (plan,))
        garment, carried = refit_with_darts(cut, slid, strain, state, settings)
    except (GarmentqError, np.linalg.LinAlgError):  # a front that cannot be meshed or fitted is no better
        return state
    name = slid.pattern.panels[plan.panel].name
    strains = panel_strains(slid, strain)[name], panel_strains(garment, carried)[name]
    widths = [dart.width(garment.pattern) for dart in cut.darts]
    if strains[1] >= strains[0] or min(widths) < MIN_DART_WIDTH or not can_be_meshed(garment):
        return state
    changes = (
        describe_dart(garment.pattern, dart, "added", width, strains)
        for dart, width in zip(cut.darts, widths, strict=True)
    )
    return replace(state, garment=garment, base=cut.base).with_findings(*changes)


def plan_bust_darts(garment: Garment, points: BustPoints) -> PlannedDart | None:
    """Plan a dart from a side seam to the bust, with its mirror image.

    The end of a dart is visible, its beginning is not: it can be turned about its apex to any edge. The usual one
    begins at the side seam below the armhole (W. Aldrich, Metric Pattern Cutting for Women's Wear: underarm dart), and
    the nearest place there is taken. Its angle is the curvature less the angles of other darts that end there.

    Args:
        garment: The slid pattern's mesh, nodes on the target.
        points: Where the cloth is pointed.

    Returns:
        None where the panel there is not its own mirror image, or has no room for it.
    """
    nearest = np.linalg.norm(garment.nodes[garment.uv_node][:, None] - points.places[None], axis=2).argmin(axis=0)
    index, other = (int(each) for each in garment.panel_of_uv[nearest])
    mirror = mirror_of(garment, index)
    if mirror is None or not mirror.source == mirror.target == other:
        return None
    left, right = garment.uv[nearest[0]], reflect_point(mirror, garment.uv[nearest[1]])
    uv = garment.uv[garment.panel_of_uv == index]
    inner = uv[find_depths(garment, index) >= DartSearchSettings.apex_depth]
    mouths = _side_mouths(garment, index)
    if np.linalg.norm(left - right) > MIRROR_POINT_TOLERANCE or not len(inner) or not mouths:
        return None
    middle = 0.5 * (left + right)
    apex = inner[np.linalg.norm(inner - middle, axis=1).argmin()]
    mouth = min(mouths, key=lambda one: float(np.linalg.norm(one.place - apex)))
    others = [dart for dart in find_darts(garment.pattern) if dart.panel == garment.pattern.panels[index].name]
    folded = sum(
        dart.angle(garment.pattern)
        for dart in others
        if float(np.linalg.norm(dart.ends(garment.pattern)[1] - middle)) < MAX_SHARED_APEX_DISTANCE
    )
    return PlannedDart(index, mouth, Wedge(mouth.place, apex), points.angle - folded)


def _side_mouths(garment: Garment, index: int) -> list[DartMouth]:
    """Return the places where a dart may begin at the side seams of a panel: along the warp, sewn to its own part."""
    pattern = garment.pattern
    drawn, part = pattern.panels[index], find_parts(pattern)
    number = {panel.name: i for i, panel in enumerate(pattern.panels)}
    sewn = {ref: other for seam in pattern.seams for ref, other in ((seam.a, seam.b), (seam.b, seam.a))}
    warp = np.array([-np.sin(drawn.grainline), np.cos(drawn.grainline)])
    corners = find_corners(garment, index)

    def is_at_side(mouth: DartMouth) -> bool:
        other = sewn.get(EdgeRef(drawn.name, mouth.edge))
        chord = drawn.points[(mouth.edge + 1) % len(drawn.points)] - drawn.points[mouth.edge]
        return (
            other is not None
            and part[number[other.panel]] == part[index]
            and abs(float(chord @ warp)) > SIDE_SEAM_WARP_COSINE * float(np.linalg.norm(chord))
            and float(np.linalg.norm(corners - mouth.place, axis=1).min(initial=np.inf)) >= MIN_SEAM_END_DISTANCE
        )

    return [mouth for mouth in list_mouths(garment, index) if is_at_side(mouth)]
