"""Fit the control points whose flat panels stretch as the draped template did when registered to the target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from ...garment.control import map_controls
from ...garment.curves import edge_length, panel_area
from ...garment.garment import Garment
from ...garment.pattern import Panel, Pattern
from ...garment.seams import MIN_SINGULAR_VALUE_SHARE
from ...garment.symmetry import find_symmetry
from ...geometry.geometry import deformation_gradients, gradient_operator, right_stretch
from ...geometry.linear import Factor, factor_symmetric

MIN_GRADED_EDGE_LENGTH = 0.01
"""Length of an edge below which it is a gap that a drawing program leaves between two corners, and keeps its vector
[m]: half a mesh edge, so no cloth shows its size. Free edges of 1 mm between darts turn over and grading fails."""

SHORT_EDGE_STD = 1e-4
"""Standard deviation of the vector along a short edge [m]: it is practically not graded."""

DART_WIDTH_STD = 0.1
"""Standard deviation of the vector across the mouth of a dart, as a share of its width: darts are drawn for the body,
and graded published patterns keep theirs to the millimetre. If free, a narrow one closes and its sides cross."""


@dataclass(frozen=True)
class FlatteningSettings:
    """Describe the fit of the control points.

    Attributes:
        rounds: Number of alternations of rotations and control points; panels turn little, so that 12 settle to 0.1 mm.
        damping: Weight that keeps the control points in place, as a share of the panels' stiffness; it only fixes what
            the stretch leaves free (a panel's place and rotation).
        vector_damping: The same for `kept_vectors` [m2]: a standard deviation costs as a square metre strained by 1 %.
        stretch_limit: Factor beyond which stretches, either way, come from bad triangles and are clipped.
        least_strain, most_strain: Principal stretches of the template's cloth are clipped to these [1]: woven cloth
            hangs within 3 %; a coarse mesh hides up to a tenth in wrinkles, on both garments alike.
        band_width: Narrower panels, such as waistbands, keep the template's strain unclipped [m]: they are cut shorter
            than what they hold, and the place of their long seams on the target is not visible.
    """

    rounds: int = 12
    damping: float = 1e-4
    vector_damping: float = 1e-4
    stretch_limit: float = 4.0
    least_strain: float = 0.90
    most_strain: float = 1.03
    band_width: float = 0.12


@dataclass(frozen=True)
class FlatPanels:
    """Describe the energy of all flat panels with the inner vertices eliminated.

    The energy int |J - W|^2 dA of wanted maps W is quadratic in inner vertices u and control points c (thesis eq. 3.1
    ties the rim to them): L u + B c = b_u. So u = L^-1 b_u - C c, and c has the Schur complement S.

    Attributes:
        gradient: From values at uv vertices to (d/dx, d/dy) of each face, shape [2 face_count, uv_count].
        weight: Area of each face twice [m2], shape [2 face_count].
        inner: The free uv vertices, shape [inner_count].
        factor: Of L.
        follow: The rim's part of the control map, zero rows inside, shape [2 uv_count, 2 control_count].
        border: B, shape [2 inner_count, 2 control_count].
        carried: C, shape [2 inner_count, 2 control_count].
        reduced: S, shape [2 control_count, 2 control_count].
    """

    gradient: sp.csr_matrix
    weight: np.ndarray
    inner: np.ndarray
    factor: Factor
    follow: sp.csr_matrix
    border: np.ndarray
    carried: np.ndarray
    reduced: np.ndarray


def assemble_flat_energy(garment: Garment) -> FlatPanels:
    """Assemble the energy of a garment's flat panels."""
    rim = np.zeros(len(garment.uv), dtype=bool)
    for line in garment.edge_uv.values():
        rim[line] = True
    inner = np.flatnonzero(~rim)
    follow = sp.csr_matrix(sp.diags(np.repeat(rim, 2).astype(float)) @ map_controls(garment).matrix)
    gradient, area = gradient_operator(garment.rest, garment.uv_faces, len(garment.uv))
    weight = np.repeat(area, 2)
    stiffness = sp.csr_matrix(gradient.T @ sp.diags(weight) @ gradient)
    factor = factor_symmetric(stiffness[inner][:, inner])
    loaded = sp.csr_matrix(sp.kron(stiffness, sp.eye(2)) @ follow)
    pairs = (2 * inner[:, None] + np.arange(2)).ravel()
    border = loaded[pairs].toarray()
    carried = factor.solve(border.reshape(len(inner), -1)).reshape(border.shape)
    reduced = (follow.T @ loaded).toarray() - border.T @ carried
    return FlatPanels(gradient, weight, inner, factor, follow, border, carried, reduced)


def stretch_between(garment: Garment, moved: np.ndarray, settings: FlatteningSettings | None = None) -> np.ndarray:
    """Return the stretch of each flat face that carries the moved nodes, shape [face_count, 2, 2].

    With F the map from the flat face to 3D and U = sqrt(F^T F), A = U_before^-1 U_after: then F_after A^-1 has the
    strain of F_before, and where nothing moved A is the identity. The principal values of U_before are first clipped to
    the strain that the target's cloth can have too: a template stretched by half would yield too small a pattern.

    Args:
        garment: The garment before.
        moved: Its nodes after [m], shape [node_count, 3].
        settings: Bounds of strain, and the limit of A's singular values.
    """
    settings = settings or FlatteningSettings()
    before, after = garment_stretch(garment, garment.nodes), garment_stretch(garment, moved)
    values, axes = np.linalg.eigh(before)
    clipped = np.clip(values, settings.least_strain, settings.most_strain)
    narrow = narrow_panels(garment.pattern, settings)
    clipped = np.where(narrow[garment.panel_of_face][:, None], values, clipped)
    stretch = np.linalg.solve((axes * clipped[:, None, :]) @ np.swapaxes(axes, 1, 2), after)
    left, values, right = np.linalg.svd(stretch)
    values = np.clip(values, 1.0 / settings.stretch_limit, settings.stretch_limit)
    return np.asarray((left * values[:, None, :]) @ right)


def narrow_panels(pattern: Pattern, settings: FlatteningSettings | None = None) -> np.ndarray:
    """Return which panels are bands, narrower than `band_width`, shape [panel_count]."""
    settings = settings or FlatteningSettings()
    return np.array([mean_width(panel) < settings.band_width for panel in pattern.panels])


def mean_width(panel: Panel) -> float:
    """Return a panel's mean width across its longest extent [m]."""
    corners = panel.points
    return panel_area(panel) / float(np.linalg.norm(corners[:, None] - corners[None], axis=2).max())


def fit_control_points(garment: Garment, stretch: np.ndarray, settings: FlatteningSettings | None = None) -> np.ndarray:
    """Fit the control points to a wanted stretch of every flat face [m], shape [control_count, 2].

    Minimises sum_f area_f |J_f - R_f A_f|^2 over control points, inner vertices and rotations R_f in turns, within the
    pattern's symmetry and with both sides of every ungathered seam equal (to first order: `equalise_seams` is exact).

    Notation: J_f the map of face f from its old flat shape to the new, A_f `stretch`, shape [face_count, 2, 2].
    """
    settings = settings or FlatteningSettings()
    pattern, flat = garment.pattern, assemble_flat_energy(garment)
    symmetry = find_symmetry(pattern)
    free, offset = symmetry.matrix.toarray(), symmetry.offset
    start = pattern.points
    vectors, stiff = kept_vectors(pattern), float(np.trace(flat.reduced)) / start.size
    damping = stiff * (settings.damping * np.eye(start.size) + settings.vector_damping * vectors.T @ vectors)
    system = flat.reduced + damping
    points, turned = start, stretch
    for _ in range(settings.rounds):
        # The wanted map's rows are the images of x and y; the gradient needs d/dx and d/dy of both.
        load = flat.gradient.T @ (flat.weight[:, None] * np.swapaxes(turned, 1, 2).reshape(-1, 2))
        inner = flat.factor.solve(load[flat.inner])
        right = flat.follow.T @ load.ravel() - flat.border.T @ inner.ravel() + damping @ start.ravel()
        rows = seam_rows(pattern, points)
        effective = solve_with_seams(
            free.T @ system @ free, free.T @ (right - system @ offset), rows @ free, -rows @ offset
        )
        points = symmetry.expand(effective)
        placed = (flat.follow @ points.ravel()).reshape(-1, 2)
        placed[flat.inner] = inner - (flat.carried @ points.ravel()).reshape(-1, 2)
        slope = np.swapaxes((flat.gradient @ placed).reshape(-1, 2, 2), 1, 2)
        turned = _turn_towards(stretch, slope)
    return points


def seam_rows(pattern: Pattern, points: np.ndarray) -> np.ndarray:
    """Return the difference in length of each ungathered seam's sides, linear in the points, [count, 2 point_count].

    An edge follows its chord by a similarity, so its length is proportional to the chord's, which is the scalar product
    of the chord with its own direction at `points`.
    """
    rows = []
    for seam in pattern.seams:
        if seam.gathered:
            continue
        row = np.zeros_like(points)
        for ref, sign in ((seam.a, 1.0), (seam.b, -1.0)):
            a, b = pattern.ends_of(ref)
            chord = np.linalg.norm(pattern.points[b] - pattern.points[a])
            along = points[b] - points[a]
            pull = sign * edge_length(pattern.panel(ref.panel), ref.edge) / chord * along / np.linalg.norm(along)
            row[b] += pull
            row[a] -= pull
        rows.append(row.ravel())
    return np.array(rows).reshape(-1, points.size)


def kept_vectors(pattern: Pattern) -> np.ndarray:
    """Return vectors that grading keeps, x and y, in standard deviations, by points [1/m], [2 count, 2 point_count].

    Along edges shorter than `MIN_GRADED_EDGE_LENGTH`, and across darts: consecutive edges sewn to each other.
    """
    rows = []
    for panel, first in zip(pattern.panels, pattern.point_starts, strict=False):
        count = len(panel.points)
        ends = [
            (i, (i + 1) % count, SHORT_EDGE_STD) for i in range(count) if edge_length(panel, i) < MIN_GRADED_EDGE_LENGTH
        ]
        for seam in pattern.seams:
            for one, other in ((seam.a, seam.b), (seam.b, seam.a)):
                if one.panel == other.panel == panel.name and other.edge == (one.edge + 1) % count:
                    start, end = one.edge, (one.edge + 2) % count
                    width = float(np.linalg.norm(panel.points[end] - panel.points[start]))
                    ends.append((start, end, max(DART_WIDTH_STD * width, SHORT_EDGE_STD)))
        for start, end, spread in ends:
            for axis in range(2):
                row = np.zeros((len(pattern.points), 2))
                row[first + end, axis], row[first + start, axis] = 1.0 / spread, -1.0 / spread
                rows.append(row.ravel())
    return np.array(rows).reshape(-1, 2 * len(pattern.points))


def solve_with_seams(system: np.ndarray, right: np.ndarray, rows: np.ndarray, sums: np.ndarray) -> np.ndarray:
    """Minimise x.(system x)/2 - right.x under rows @ x = sums.

    Rows that repeat others up to a thousandth count once (`MIN_SINGULAR_VALUE_SHARE`): both sides of a wearer are cut
    alike, up to rounding in the file. As separate constraints, such remainders moved points by 11 cm.
    """
    size = len(system)
    scale = float(np.trace(system)) / size
    left, values, directions = np.linalg.svd(rows, full_matrices=False)
    kept = values > MIN_SINGULAR_VALUE_SHARE * values.max(initial=0.0)
    sewn, sums = directions[kept], (left[:, kept].T @ sums) / values[kept]
    whole = np.block([[system / scale, sewn.T], [sewn, np.zeros((len(sewn), len(sewn)))]])
    return np.asarray(np.linalg.lstsq(whole, np.concatenate([right / scale, sums]), rcond=1e-12)[0][:size])


def _turn_towards(stretch: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Rotate each wanted stretch as near as possible to its map, shape [face_count, 2, 2]."""
    product = slope @ np.swapaxes(stretch, 1, 2)
    cosine, sine = product[:, 0, 0] + product[:, 1, 1], product[:, 1, 0] - product[:, 0, 1]
    size = np.maximum(np.hypot(cosine, sine), 1e-12)
    rotation = np.stack([np.stack([cosine, -sine], 1), np.stack([sine, cosine], 1)], 1) / size[:, None, None]
    return np.asarray(rotation @ stretch)


def garment_stretch(garment: Garment, nodes: np.ndarray) -> np.ndarray:
    """Compute the right stretch U of every face from flat to nodes [m], [face_count, 2, 2], at least 1e-3 in width."""
    return right_stretch(deformation_gradients(nodes, garment.faces, garment.rest), least=1e-3)
