"""Search the place in a panel where a dart takes most strain that no flat shape takes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...garment.curves import edge_length
from ...garment.garment import Garment
from ...garment.mirrors import Mirror
from ...garment.pattern import EdgeRef
from ...garment.symmetry import find_symmetry
from ...geometry.geometry import signed_areas
from .wedge import FlatPanel, Wedge


@dataclass(frozen=True)
class DartSearchSettings:
    """Describe which darts are searched.

    Attributes:
        min_length, max_length: Smallest and largest length of a dart [m]: skirt darts are 9 to 13 cm long, those of a
            bodice, from the waist to 2.5 cm below the bust point, 16 to 18 cm; a shorter one is a tuck.
        warp_angle: Largest angle between the axis of a dart and the warp [rad]. Cloth shows where a dart ends: it can
            be turned about its apex to any edge. Waist and shoulder darts are drawn within 15 degrees of the grain.
        gain_share: Share of the best dart's gain from which those with the same end compete: the nearest to the warp.
        mirror_distance: Least distance of the apexes of a dart and its mirror image in one panel [m]: nearer they would
            be one dart on the middle line, where a panel that is cut on the fold has a seam instead.
        apex_depth: Least distance of an apex from the outline [m]: nearer it is a seam's ease.
        corner_distance: Least distance of a mouth from a corner [m]: nearer the corner itself is cut differently.
        corner_angle: Angle of an outline from which it has a corner [rad].
    """

    min_length: float = 0.06
    max_length: float = 0.22
    warp_angle: float = float(np.radians(25.0))
    gain_share: float = 0.9
    mirror_distance: float = 0.06
    apex_depth: float = 0.025
    corner_distance: float = 0.03
    corner_angle: float = float(np.radians(30.0))


@dataclass(frozen=True)
class DartMouth:
    """Describe a place on a panel's outline: numbers of its edge and of the segment of the edge's mesh whose middle it
    is, and its position [m], shape [2]."""

    edge: int
    segment: int
    place: np.ndarray


@dataclass(frozen=True)
class PlannedDart:
    """Describe a planned dart, with its mirror image in this panel or another one: index of the panel, where it begins,
    mouth and apex in the panel's axes, and the angle at the apex [rad]."""

    panel: int
    mouth: DartMouth
    wedge: Wedge
    angle: float

    @property
    def width(self) -> float:
        """Return its intake [m]."""
        return 2.0 * self.wedge.length * float(np.tan(self.angle / 2.0))


@dataclass(frozen=True)
class DartProposal(PlannedDart):
    """Describe a planned dart with the RMS of the strain that no flat shape takes, without and with it, over panel and
    mirror image."""

    before: float
    after: float

    @property
    def share(self) -> float:
        """Return the share by which it lowers the sum of the squared strain."""
        return 1.0 - (self.after / self.before) ** 2


def relax_panel(garment: Garment, strain: np.ndarray, index: int) -> FlatPanel:
    """Return a panel with the strain that no flat shape of it takes.

    Args:
        garment: The flat panels.
        strain: Wanted strain of each face (`wanted_strain`), shape [face_count, 2, 2].
        index: The panel's index.
    """
    first = int(np.flatnonzero(garment.panel_of_uv == index)[0])
    in_panel, faces = garment.panel_of_uv == index, garment.panel_of_face == index
    return FlatPanel.of(garment.uv[in_panel], garment.uv_faces[faces] - first, strain[faces])


def rms_strain(panels: Sequence[FlatPanel], square: float) -> float:
    """Return the root mean square over panels of a strain, given the integral of its square [m2]."""
    area = sum(float(np.abs(signed_areas(panel.uv[panel.faces])).sum()) for panel in panels)
    return float(np.sqrt(max(square, 0.0) / area))


def propose_dart(
    garment: Garment, strain: np.ndarray, index: int, settings: DartSearchSettings = DartSearchSettings()
) -> DartProposal | None:
    """Find the dart that takes most of a panel's strain, by an exhaustive search over its mesh.

    A panel and its mirror image get darts together, judged by the sum.

    Args:
        garment: The flat panels, fitted to the cloth on the target.
        strain: Wanted strain of each face, shape [face_count, 2, 2].
        index: The panel's index.
        settings: Which darts are searched.

    Returns:
        The best; None where no open dart takes any, or there is no room for one.
    """
    panel = relax_panel(garment, strain, index)
    mouths = list_mouths(garment, index, settings)
    places = [(mouth, wedge) for mouth in mouths for wedge in _wedges(garment, panel, index, mouth, settings)]
    if not places:
        return None
    wedges = [wedge for _, wedge in places]
    loads, panels, is_apart = panel.loads(wedges), [panel], np.ones(len(wedges), dtype=bool)
    mirror = mirror_of(garment, index)
    images = [] if mirror is None else [reflect_wedge(mirror, wedge) for wedge in wedges]
    if mirror is not None and mirror.target == index:
        loads = loads + panel.loads(images)
        between = np.array([image.apex - wedge.apex for image, wedge in zip(images, wedges, strict=True)])
        is_apart = np.linalg.norm(between, axis=1) >= settings.mirror_distance
    pull, stiffness = panel.respond(loads)
    if mirror is not None and mirror.target != index:
        other = relax_panel(garment, strain, mirror.target)
        also = other.respond(other.loads(images))
        panels, pull, stiffness = [panel, other], pull + also[0], stiffness + also[1]
    gains = np.where((pull > 0.0) & is_apart, pull**2 / stiffness, 0.0)
    if gains.max() <= 0.0:
        return None
    apex = wedges[int(np.argmax(gains))].apex
    ends_there = np.array([np.array_equal(wedge.apex, apex) for wedge in wedges])
    turned = np.array([_warp_angle(garment, index, wedge) for wedge in wedges])
    best = int(np.argmin(np.where(ends_there & (gains >= settings.gain_share * gains.max()), turned, np.inf)))
    square = sum(float(each.left @ each.left) for each in panels)
    before, after = rms_strain(panels, square), rms_strain(panels, square - float(gains[best]))
    return DartProposal(index, places[best][0], wedges[best], float(pull[best] / stiffness[best]), before, after)


def mirror_of(garment: Garment, index: int) -> Mirror | None:
    """Return how a panel is mirrored, to itself or to another one; None where it is not, or is another one's image."""
    return next((mirror for mirror in find_symmetry(garment.pattern).mirrors if mirror.source == index), None)


def is_mirror_image(garment: Garment, index: int) -> bool:
    """Check whether a panel is the mirror image of another one, which represents both."""
    mirrors = find_symmetry(garment.pattern).mirrors
    return any(mirror.target == index != mirror.source for mirror in mirrors)


def reflect_wedge(mirror: Mirror, wedge: Wedge) -> Wedge:
    """Return the mirror image of a wedge."""
    return Wedge(reflect_point(mirror, wedge.mouth), reflect_point(mirror, wedge.apex))


def reflect_point(mirror: Mirror, point: np.ndarray) -> np.ndarray:
    """Return the mirror image of a point of a panel [m], shape [2]."""
    return np.asarray(point @ mirror.rotation.T + mirror.shift)


def list_mouths(garment: Garment, index: int, settings: DartSearchSettings = DartSearchSettings()) -> list[DartMouth]:
    """Return the places where a dart of a panel may begin: on seams with other panels, and on an open waist."""
    panel = garment.pattern.panels[index]
    sewn = {ref for seam in garment.pattern.seams if seam.a.panel != seam.b.panel for ref in (seam.a, seam.b)}
    corners = find_corners(garment, index, settings)
    found = []
    for i, edge in enumerate(panel.edges):
        ref = EdgeRef(panel.name, i)
        if ref not in sewn and edge.contour != "waist":
            continue
        if edge_length(panel, i) < settings.corner_distance:
            continue
        line = garment.uv[garment.edge_uv[ref]]
        for k, place in enumerate(0.5 * (line[1:] + line[:-1])):
            if not len(corners) or np.linalg.norm(corners - place, axis=1).min() >= settings.corner_distance:
                found.append(DartMouth(i, k, place))
    return found


def find_corners(garment: Garment, index: int, settings: DartSearchSettings = DartSearchSettings()) -> np.ndarray:
    """Return the corners of a panel's meshed outline [m], shape [count, 2]."""
    panel, found = garment.pattern.panels[index], []
    for i in range(len(panel.edges)):
        border = garment.uv[garment.edge_uv[EdgeRef(panel.name, i)]]
        before = garment.uv[garment.edge_uv[EdgeRef(panel.name, (i - 1) % len(panel.edges))]]
        (a, b), (c, d) = border[1] - border[0], before[-1] - before[-2]
        if abs(np.arctan2(c * b - d * a, a * c + b * d)) > settings.corner_angle:
            found.append(border[0])
    return np.array(found).reshape(-1, 2)


def _wedges(
    garment: Garment, panel: FlatPanel, index: int, mouth: DartMouth, settings: DartSearchSettings
) -> list[Wedge]:
    """Return the wedges that begin at a place, along the warp into the panel."""
    drawn = garment.pattern.panels[index]
    line = garment.uv[garment.edge_uv[EdgeRef(drawn.name, mouth.edge)]]
    along = line[mouth.segment + 1] - line[mouth.segment]
    inward = np.array([-along[1], along[0]]) / np.linalg.norm(along)
    warp = np.array([-np.sin(drawn.grainline), np.cos(drawn.grainline)])
    offset = panel.uv - mouth.place
    length = np.linalg.norm(offset, axis=1)
    fits = (length >= settings.min_length) & (length <= settings.max_length) & (offset @ inward > 0.5 * length)
    fits &= np.abs(offset @ warp) >= np.cos(settings.warp_angle) * length
    fits &= find_depths(garment, index) >= settings.apex_depth
    return [Wedge(mouth.place, panel.uv[i]) for i in np.flatnonzero(fits)]


def _warp_angle(garment: Garment, index: int, wedge: Wedge) -> float:
    """Return the angle between a wedge's axis and its panel's warp [rad]."""
    grain = garment.pattern.panels[index].grainline
    axis = wedge.apex - wedge.mouth
    along = abs(float(axis @ np.array([-np.sin(grain), np.cos(grain)]))) / wedge.length
    return float(np.arccos(min(along, 1.0)))


def find_depths(garment: Garment, index: int) -> np.ndarray:
    """Return the distance of a panel's vertices from those of its outline [m], shape [vertex_count]."""
    drawn = garment.pattern.panels[index]
    rim = garment.uv[np.concatenate([garment.edge_uv[EdgeRef(drawn.name, i)] for i in range(len(drawn.edges))])]
    uv = garment.uv[garment.panel_of_uv == index]
    return np.asarray(np.linalg.norm(uv[:, None] - rim[None], axis=2).min(axis=1))
