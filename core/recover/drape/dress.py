"""Dress a body in its T-pose: from flat placed panels to a garment that hangs on it."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy import sparse

from ...body.body import Body
from ...body.girths import TapeMeasure, armpit_height
from ...body.signed_distance import SignedDistance
from ...body.skinning import rest_body
from ...cloth.settings import STANDARD_GRAVITY
from ...garment.creases import find_turned_panels
from ...garment.garment import Garment
from ...garment.panel_selection import select_panels
from ...garment.parts.tops import STRAPLESS_DROP
from ...garment.parts.wraps import WRAP_LABEL
from ...run.hooks import SILENT_HOOKS, Hooks
from .gores import fan_out, find_sides
from .harmonic import extend_harmonically
from .hoods import HoodSettings, take_off_hood, wear_hood
from .layer_contact import LayerContact
from .leg_alignment import align_legs
from .obstacles import FlatObstacle, SquashedBody, TwoSidedObstacle
from .pbd import DistanceConstraints, PbdSettings, PbdState, build_distance_constraints, simulate_pbd
from .sleeves import turn_sleeves
from .turning import turn_over
from .unfolding import unfold_crossings
from .waist import flat_length, waist_loop

SHOULDER_LIFT_HEIGHT = 0.03
"""Height above the body's shoulders at which a garment is placed [m]: the upper seam of a drooping sleeve then still
starts above the middle of the stretched arm and is pushed up; what is too high sinks under its weight."""


@dataclass(frozen=True)
class DressSettings:
    """Describe the procedure of the first drape.

    Attributes:
        flatten: Distance of the flattened panels from the body's middle plane [m]; more than half the thickness of the
            squashed body with its contact layer, so that it starts between them.
        squash: Depth of the squashed body as a share of its own; 4 % leaves a torso 1 cm thick.
        frames: Number of frames in which it is inflated; 40 move its surface by about 3 mm a frame.
        relax: Number of steps that relax the welded panels' edges in their planes; 60 suffice from 5 times too long.
        settle: Number of steps under gravity at the end.
        turn: Number of steps in which what is turned over along creases falls.
        outline: Keep the seams between front and back outside the body's outline in the middle plane.
        unfold: Smooth cloth that crosses itself. Off before a graded drape, which has no layer contact: with it
            crotches came out with half as many crossing faces again.
        hood: How a hood is put on.
        follow: The position-based steps.
    """

    flatten: float = 0.012
    squash: float = 0.04
    frames: int = 40
    relax: int = 60
    settle: int = 60
    turn: int = 60
    outline: bool = True
    unfold: bool = True
    hood: HoodSettings = field(default_factory=HoodSettings)
    follow: PbdSettings = field(default_factory=PbdSettings)


def place_panels(
    garment: Garment, body: Body, *, waist_height: float | None = None, flatten: float = 0.012
) -> np.ndarray:
    """Flatten the placed panels to both sides of the body's middle plane and shift them to where they are worn.

    Files disagree about the origin (feet at y = 0, or 1.1 m up), so the shift in y is computed: a waist is placed at
    `waist_height`, any other garment with its shoulder line on the body's. Legs are aligned with the body's. A hood is
    placed on the neckline.

    Args:
        garment: The sewn garment, nodes where its file places them.
        body: The body in its T-pose, facing +z.
        waist_height: Height of the waist contour [m]; if None, where the body has the girth of the contour.
        flatten: Distance from the middle plane [m].

    Returns:
        Nodes [m], shape [node_count, 3].
    """
    hooded = take_off_hood(garment)
    if hooded is not None:
        below = place_panels(hooded.below, body, waist_height=waist_height, flatten=flatten)
        return hooded.put_on(below, body)
    nodes = _weld_flat(garment, body)
    pelvis = body.joint("pelvis")
    nodes[:, 0] += pelvis[0] - 0.5 * (nodes[:, 0].min() + nodes[:, 0].max())
    middle = _middle_plane(body)
    nodes[:, 2] = middle + flatten * _find_node_sides(garment) * _find_node_layers(garment)
    waist = waist_loop(garment)
    if waist is not None:
        height = waist_height if waist_height is not None else _upper_edge_height(garment, waist, body)
        nodes[:, 1] += height - nodes[waist, 1].mean()
    else:
        nodes[:, 1] += _shoulder_shift(nodes, garment.faces, body)
    return align_legs(nodes, garment.faces, body)


def _upper_edge_height(garment: Garment, loop: np.ndarray, body: Body) -> float:
    """Return the height of a garment's upper edge [m]: below the arms if the pattern calls it a neck, not a waist."""
    edges = [
        garment.pattern.panel(ref.panel).edges[ref.edge].contour
        for ref, line in garment.edge_uv.items()
        if np.isin(garment.uv_node[line], loop).all()
    ]
    if "neck" in edges:
        return armpit_height(rest_body(body)) - STRAPLESS_DROP
    return waistband_height(flat_length(garment, loop), body)


def waistband_height(girth: float, body: Body) -> float:
    """Return the height at which a waistband of a girth [m] sits on a body in its T-pose [m].

    It slides down from the narrowest place of the trunk, between pelvis and the top of the loins, until the body's
    convex girth equals the band's; a band wider than the hips stays at the pelvis.
    """
    low, high = body.joint("pelvis")[1], body.joint("spine3")[1]
    heights = np.linspace(low, high, 25)
    tape = TapeMeasure(body)
    girths = np.array([tape.trunk(height).value for height in heights])
    narrowest = int(np.argmin(girths))
    narrow = np.nonzero(girths[: narrowest + 1] <= girth)[0]
    first = int(narrow[0]) if len(narrow) else narrowest
    if first == 0 or not len(narrow):
        return float(heights[first])
    return float(np.interp(girth, girths[[first, first - 1]], heights[[first, first - 1]]))


def _weld_flat(garment: Garment, body: Body) -> np.ndarray:
    """Weld the placed panels in the x, y plane without folding them over; return the nodes [m], shape [node_count, 3].

    Sleeves are first turned along the arms (`turn_sleeves`), gores laid side by side (`fan_out`). The panels are then
    shifted so that their seams' gaps are least (least squares over one translation per panel, with a thousandth of the
    weight on staying in place). Each side closes half of the remaining gap by a harmonic displacement of its panel.
    """
    panels = garment.pattern.panels
    rotation, origin = turn_sleeves(garment, body, SHOULDER_LIFT_HEIGHT)
    flat = np.einsum("nij,nj->ni", rotation[garment.panel_of_uv], garment.uv) + origin[garment.panel_of_uv]
    flat = fan_out(garment, flat)
    count = np.bincount(garment.uv_node)
    shared = np.nonzero(count[garment.uv_node] > 1)[0]
    mean = sparse.csr_matrix(
        (1.0 / count[garment.uv_node[shared]], (garment.uv_node[shared], np.arange(len(shared)))),
        shape=(len(count), len(shared)),
    )
    gap = sparse.identity(len(shared)) - mean[garment.uv_node[shared]]
    member = sparse.csr_matrix((np.ones(len(shared)), (np.arange(len(shared)), garment.panel_of_uv[shared])))
    member.resize(len(shared), len(panels))
    rows = (gap @ member).toarray()
    normal = rows.T @ rows + 1e-3 * np.eye(len(panels))
    flat += np.linalg.solve(normal, -rows.T @ (gap @ flat[shared]))[garment.panel_of_uv]
    flat = flat + extend_harmonically(garment.uv_faces, len(flat), shared, -(gap @ flat[shared]))
    nodes = np.zeros((len(count), 3))
    np.add.at(nodes[:, :2], garment.uv_node, flat)
    nodes[:, :2] /= count[:, None]
    return nodes


def _middle_plane(body: Body) -> float:
    """Return z of the plane that halves the body [m]: the mean of the arms' and hips' joints."""
    names = ("left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_hip", "right_hip", "pelvis")
    return float(np.mean([body.joint(name)[2] for name in names]))


def _find_node_sides(garment: Garment) -> np.ndarray:
    """Return the side of every node, front (+1) or back (-1), shape [node_count]; 0 on seams between the two."""
    total = np.zeros(len(garment.nodes))
    count = np.zeros(len(garment.nodes))
    np.add.at(total, garment.uv_node, find_sides(garment))
    np.add.at(count, garment.uv_node, 1.0)
    return total / np.maximum(count, 1.0)


def _find_node_layers(garment: Garment) -> np.ndarray:
    """Return the number of the layer that every node is in, shape [node_count]: 1, and 2 for a front that is wrapped
    over another one; between them on seams of both."""
    outer = np.array([panel.label == WRAP_LABEL for panel in garment.pattern.panels])
    total, count = np.zeros(len(garment.nodes)), np.bincount(garment.uv_node, minlength=len(garment.nodes))
    np.add.at(total, garment.uv_node, 1.0 + outer[garment.panel_of_uv])
    return total / count


def _shoulder_shift(nodes: np.ndarray, faces: np.ndarray, body: Body) -> float:
    """Return the shift in y [m] that puts the garment's upper outline above the body's, from neck to shoulder."""
    left, right = body.joint("left_shoulder"), body.joint("right_shoulder")
    centre, half = 0.5 * (left[0] + right[0]), 0.5 * abs(left[0] - right[0])
    gaps = []
    below_head = body.vertices[:, 1] < body.joint("head")[1]
    for share in (0.65, 0.75, 0.85, 0.95):
        for sign in (-1.0, 1.0):
            x = centre + sign * share * half
            skin = below_head & (np.abs(body.vertices[:, 0] - x) < 0.015)
            cloth = _outline_height(nodes, faces, x)
            if skin.any() and cloth is not None:
                gaps.append(body.vertices[skin, 1].max() + SHOULDER_LIFT_HEIGHT - cloth)
    return float(np.max(gaps)) if gaps else float(left[1] - nodes[:, 1].max())


def _outline_height(nodes: np.ndarray, faces: np.ndarray, x: float) -> float | None:
    """Return the highest y of a flattened garment on the line at x [m], or None where it does not extend so far."""
    start, end = (nodes[faces[:, ends]].reshape(-1, 3) for ends in ([0, 1, 2], [1, 2, 0]))
    across = (start[:, 0] - x) * (end[:, 0] - x) < 0
    if not across.any():
        return None
    share = (x - start[across, 0]) / (end[across, 0] - start[across, 0])
    return float((start[across, 1] + share * (end[across, 1] - start[across, 1])).max())


def _find_body_halves(garment: Garment) -> np.ndarray:
    """Return which nodes are on panels of the wearer's left (+1) or right (-1) half alone; 0 for all others.

    A panel belongs to one half if its middle is further out than a quarter of its width.
    """
    total, count = np.zeros(len(garment.nodes)), np.zeros(len(garment.nodes))
    for i, panel in enumerate(garment.pattern.panels):
        x = (panel.points @ panel.rotation[:2, :2].T + panel.translation[:2])[:, 0]
        middle, width = 0.5 * (x.max() + x.min()), x.max() - x.min()
        member = garment.uv_node[garment.panel_of_uv == i]
        np.add.at(total, member, np.sign(middle) if abs(middle) > 0.25 * width else 0.0)
        np.add.at(count, member, 1.0)
    return np.sign(np.where(np.abs(total) == count, total, 0.0))


def relax_flat_panels(
    threads: DistanceConstraints,
    nodes: np.ndarray,
    side: np.ndarray,
    half: np.ndarray,
    layer: np.ndarray,
    distance: SignedDistance,
    middle: float,
    settings: DressSettings,
) -> np.ndarray:
    """Relax the edges of flattened, welded panels in their planes and return the nodes [m], shape [node_count, 3].

    Steps change x and y only: front nodes stay at +flatten, or at twice that where they lie over others, back nodes
    at -flatten from the middle plane, seams between them in it, outside the body's outline (between the legs, under
    the arms). Panels of one half of the wearer stay on it: the crotches of trousers, drafted past the middle but
    worn from front to back, would otherwise overlap.
    """
    apart = 0.5 * settings.flatten
    centre = 0.5 * float(nodes[:, 0].min() + nodes[:, 0].max())
    flat = FlatObstacle(distance, middle, side, settings.flatten)
    for _ in range(settings.relax):
        nodes = simulate_pbd(threads, PbdState.at_rest(nodes), flat, 1, settings=settings.follow).nodes
        nodes[:, 2] = middle + settings.flatten * side * layer
        nodes[half > 0, 0] = np.maximum(nodes[half > 0, 0], centre + apart)
        nodes[half < 0, 0] = np.minimum(nodes[half < 0, 0], centre - apart)
    return nodes


def dress(
    garment: Garment,
    body: Body,
    distance: SignedDistance,
    *,
    waist_height: float | None = None,
    settings: DressSettings = DressSettings(),
    hooks: Hooks = SILENT_HOOKS,
    threads: DistanceConstraints | None = None,
) -> np.ndarray:
    """Dress a body in its T-pose and return the nodes of the garment that hangs on it [m], shape [node_count, 3].

    The panels are flattened to both sides of the body's middle plane and welded. Their edges relax around a body
    squashed in depth. The body is inflated to its full size while the cloth follows without weight, its seams between
    front and back in the middle plane, so that no shoulder slips off the thin body's edge. A front that is
    wrapped over another one lies further out, and both keep apart. Crossing cloth is smoothed;
    then gravity acts. The waist of skirts and trousers is fixed in height, as by a waistband's friction. What is turned
    over along creases is put on afterwards: it is turned towards the cloth below, and falls on it. A hood is put on
    last (`wear_hood`).

    Args:
        garment: The sewn garment, nodes where its file places them.
        body: The body in its T-pose, facing +z, feet near y = 0.
        distance: Signed distance to that body.
        waist_height: Height of the waist contour [m]; if None, where the body has the girth of the contour.
        settings: The procedure.
        hooks: Progress and cancellation.
        threads: The constraints of `garment`, or None to compute them.
    """
    threads = build_distance_constraints(garment, settings.follow.bending) if threads is None else threads
    turned = find_turned_panels(garment.pattern)
    if turned:
        worn, numbers = select_panels(garment, frozenset(panel.name for panel in garment.pattern.panels) - turned)
        nodes = dress(worn, body, distance, waist_height=waist_height, settings=settings, hooks=hooks)
        nodes, pins = turn_over(garment, nodes, worn, numbers), waist_loop(garment)
        if settings.unfold:
            nodes = unfold_crossings(threads, nodes, distance, settings=settings.follow, pins=pins)
        return _settle(threads, PbdState.at_rest(nodes), distance, settings.turn, settings, pins)
    hooded = take_off_hood(garment)
    if hooded is not None:
        below = dress(hooded.below, body, distance, waist_height=waist_height, settings=settings, hooks=hooks)
        start = wear_hood(hooded, below, body, distance, threads, follow=settings.follow, settings=settings.hood)
        return _settle(threads, start, distance, settings.settle, settings, None)
    nodes = place_panels(garment, body, waist_height=waist_height, flatten=settings.flatten)
    middle = _middle_plane(body)
    waist = waist_loop(garment)
    height = None if waist is None else float(nodes[waist, 1].mean())
    side = _find_node_sides(garment)
    layer = _find_node_layers(garment)
    nodes = relax_flat_panels(threads, nodes, side, _find_body_halves(garment), layer, distance, middle, settings)
    apart = LayerContact(face_centres=False) if (layer > 1.0).any() else None
    between = np.abs(side) < 0.5
    outline = distance if settings.outline else None
    for frame in range(settings.frames):
        scale = settings.squash + (1.0 - settings.squash) * (frame + 1) / settings.frames
        obstacle = TwoSidedObstacle(SquashedBody(distance, middle, scale), outline, middle, side)
        nodes = simulate_pbd(
            threads, PbdState.at_rest(nodes), obstacle, 3, settings=settings.follow, layers=apart
        ).nodes
        nodes[between, 2] = middle
        if waist is not None and height is not None:
            nodes[waist, 1] += height - nodes[waist, 1].mean()
        hooks.check()
    if settings.unfold:
        nodes = unfold_crossings(threads, nodes, distance, settings=settings.follow, pins=waist)
    return _settle(threads, PbdState.at_rest(nodes), distance, settings.settle, settings, waist)


def _settle(
    threads: DistanceConstraints,
    start: PbdState,
    distance: SignedDistance,
    steps: int,
    settings: DressSettings,
    pins: np.ndarray | None,
) -> np.ndarray:
    """Settle cloth under gravity with its layers kept apart; return the nodes [m], shape [node_count, 3]."""
    weight, layers = -STANDARD_GRAVITY[1], LayerContact()
    return simulate_pbd(
        threads, start, distance, steps, settings=settings.follow, gravity=weight, pins=pins, layers=layers
    ).nodes
