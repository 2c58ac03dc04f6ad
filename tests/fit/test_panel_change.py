"""Darts that a scan asks for, and darts that it does not, where the truth is known."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.garment.curves import edge_length
from garmentq.core.garment.editing.darts import close_dart, find_darts, insert_dart
from garmentq.core.garment.examine import Severity, find_faults
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.garmentcode_writer import save_pattern
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.seams import seam_mismatch
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.symmetry import find_symmetry
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.stage import drape_graded, drape_template, remesh
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.fit.dart_closing import close_darts, required_dart_width
from garmentq.core.recover.fit.dart_cutting import cut_darts
from garmentq.core.recover.fit.dart_search import is_mirror_image, propose_dart, relax_panel, rms_strain
from garmentq.core.recover.fit.isometry import fit_isometry
from garmentq.core.recover.fit.panel_change import change_panels
from garmentq.core.recover.fit.wedge import wanted_strain
from garmentq.core.recover.methods import METHODS
from garmentq.core.recover.pipeline import run_steps
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.recover.start import choose_base, read_case
from garmentq.core.recover.state import RecoveryState
from garmentq.core.run.clock import Clock
from garmentq.core.run.finding import FindingKind
from garmentq.core.run.hooks import SILENT_HOOKS
from garmentq.core.scan.contours.target import Target

ANGLE = np.radians(12.0)
"""Of the dart whose cone is laid on a panel without one."""


def two_panels(dart: bool = False) -> Pattern:
    """Return two pieces of 40 by 30 cm sewn along their middle; the upper one with a dart there, or without."""
    corners = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 0.3], [0.0, 0.3]])
    lower = Panel("lower", corners - [0.0, 0.3], tuple(Edge() for _ in range(4)))
    upper = Panel("upper", corners, tuple(Edge() for _ in range(4)))
    pattern = Pattern("two", (lower, upper), (Seam(EdgeRef("lower", 2), EdgeRef("upper", 0)),), symmetric=False)
    if not dart:
        return pattern
    pattern, found = insert_dart(pattern, EdgeRef("upper", 0), 0.45, np.array([0.18, 0.13]))
    points = pattern.panel("upper").points.copy()
    points[: found.first + 1, 0] -= 0.015
    points[-1, 0] -= 0.015
    points[found.first + 2 : -1, 0] += 0.015
    return pattern.with_points({"upper": points})


def lay_on_cone(pattern: Pattern, apex: np.ndarray, angle: float, vertices: int = 900) -> Garment:
    """Return a mesh whose upper panel lies on the cone of a dart of some angle, as near as a panel without one can."""
    garment = mesh_pattern(pattern, vertices)
    away = garment.uv - apex
    radius = np.linalg.norm(away, axis=1)
    turn = np.arctan2(away[:, 0], away[:, 1])  # 0 upwards; the dart opens downwards, at pi
    share = 1.0 - angle / (2.0 * np.pi)
    # the flat panel closes the gap by turning: the cone's surface has 2 pi - angle around its apex, the panel 2 pi
    height = radius * np.sqrt(1.0 - share**2)
    place = np.stack([share * radius * np.sin(turn), share * radius * np.cos(turn), -height], axis=1)
    nodes = np.zeros((len(garment.nodes), 3))
    nodes[garment.uv_node] = place
    return garment.at(nodes)


def test_a_dart_is_cut_into_both_sides_of_a_seam_and_closed_again() -> None:
    """Breaks where a seam loses its partner, a notch its place, or closing leaves a point or an edge behind."""
    plain, pattern = two_panels(), two_panels(dart=True)
    (dart,) = find_darts(pattern)
    assert dart.width(pattern) == pytest.approx(0.03)
    assert dart.length(pattern) == pytest.approx(0.13)
    assert np.abs(seam_mismatch(pattern)).max() < 1e-9
    assert not [fault for fault in find_faults(pattern) if fault.severity is Severity.ERROR]
    assert [len(panel.points) for panel in pattern.panels] == [5, 7]
    assert len(mesh_pattern(pattern, 600).nodes) > 500
    closed = close_dart(pattern, dart)
    assert not find_darts(closed)
    assert [len(panel.points) for panel in closed.panels] == [5, 5]
    assert sum(edge_length(closed.panel("upper"), i) for i in range(5)) > sum(
        edge_length(plain.panel("upper"), i) for i in range(4)
    )
    assert np.abs(seam_mismatch(closed)).max() < 0.016  # the mouth closed at its middle: half its width to either side


def test_the_cone_of_a_dart_is_found_on_a_panel_without_one() -> None:
    """Breaks where the apex is off by more than the mesh's edge, the angle by a sixth, or the sign is turned round."""
    apex = np.array([0.19, 0.12])
    garment = lay_on_cone(two_panels(), apex, ANGLE)
    strain = wanted_strain(garment, np.broadcast_to(np.eye(2), (len(garment.faces), 2, 2)))
    found = propose_dart(garment, strain, 1)
    assert found is not None
    assert np.linalg.norm(found.wedge.apex - apex) < 0.018
    assert found.angle == pytest.approx(ANGLE, rel=1 / 6)
    assert found.share > 0.8
    assert found.mouth.edge == 0, "the seam, and no open edge"
    cut = cut_darts(garment, strain, two_panels(), (found,))
    (dart,) = cut.darts
    assert np.abs(seam_mismatch(cut.pattern)).max() < 1e-6
    assert dart.width(cut.pattern) == pytest.approx(found.width, rel=0.15)
    mesh = mesh_pattern(cut.pattern, 900)
    opened = mesh.at(cut.place(garment, garment.nodes, mesh))
    left = relax_panel(opened, wanted_strain(opened, np.broadcast_to(np.eye(2), (len(mesh.faces), 2, 2))), 1)
    assert rms_strain([left], float(left.left @ left.left)) < 0.6 * found.before


def mirrored_panels() -> Pattern:
    """Return `two_panels` and their mirror image beside them."""
    right = two_panels()
    panels, seams = [], []
    for side, sign in (("right", 1.0), ("left", -1.0)):
        for panel in right.panels:
            points = panel.points if sign > 0.0 else (panel.points * [-1.0, 1.0])[[1, 0, 3, 2]]
            place = np.array([0.5 * sign, 0.0, 0.0])
            panels.append(Panel(f"{panel.name}_{side}", points, panel.edges, translation=place))
        seams.append(Seam(EdgeRef(f"lower_{side}", 2), EdgeRef(f"upper_{side}", 0)))
    return Pattern("mirrored", tuple(panels), tuple(seams))


def test_a_panel_and_its_mirror_image_get_darts_together() -> None:
    """Breaks where one of them gets a dart alone, or where one side decides for both."""
    pattern, apex = mirrored_panels(), np.array([0.19, 0.12])
    garment = lay_on_cone(pattern, apex, ANGLE, 1800)
    is_left = np.zeros(len(garment.nodes), dtype=bool)
    is_left[garment.uv_node[garment.panel_of_uv >= 2]] = True
    image = lay_on_cone(pattern, apex * [-1.0, 1.0], 0.5 * ANGLE, 1800)
    garment = garment.at(np.where(is_left[:, None], image.nodes, garment.nodes))
    strain = wanted_strain(garment, np.broadcast_to(np.eye(2), (len(garment.faces), 2, 2)))
    index = [panel.name for panel in pattern.panels].index("upper_right")
    assert [is_mirror_image(garment, k) for k in range(4)] == [False, False, True, True]
    found = propose_dart(garment, strain, index)
    assert found is not None
    assert found.angle == pytest.approx(0.75 * ANGLE, rel=1 / 6)
    cut = cut_darts(garment, strain, pattern, (found,))
    assert {dart.panel for dart in cut.darts} == {"upper_right", "upper_left"}
    assert cut.owner == (0, 0)
    right, left = (dart.ends(cut.pattern)[1] for dart in sorted(cut.darts, key=lambda dart: dart.panel, reverse=True))
    assert np.abs(right - left * [-1.0, 1.0]).max() < 1e-6
    assert len(find_symmetry(cut.base).mirrors) == 2


def test_a_flat_panel_gets_no_dart() -> None:
    """Breaks where rounding is taken for strain."""
    garment = mesh_pattern(two_panels(), 900)
    garment = garment.at(np.pad(_flat_nodes(garment), ((0, 0), (0, 1))))
    strain = wanted_strain(garment, np.broadcast_to(np.eye(2), (len(garment.faces), 2, 2)))
    found = propose_dart(garment, strain, 1)
    assert found is None or found.before < 1e-9


def _flat_nodes(garment: Garment) -> np.ndarray:
    nodes = np.zeros((len(garment.nodes), 2))
    nodes[garment.uv_node] = garment.uv
    return nodes


def test_a_dart_on_a_flat_surface_asks_to_be_closed() -> None:
    """Breaks where the width that is asked for has the wrong sign, or closing moves the panel's other edges."""
    pattern = two_panels(dart=True)
    (dart,) = find_darts(pattern)
    garment = mesh_pattern(pattern, 900)
    plain = garment.uv.copy()
    upper, side = garment.panel_of_uv == 1, np.sign(garment.uv[:, 0] - 0.18)
    wedge = np.clip(1.0 - garment.uv[:, 1] / 0.13, 0.0, 1.0)
    plain[upper, 0] -= (side * 0.015 * wedge)[upper]
    nodes = np.zeros((len(garment.nodes), 3))
    nodes[garment.uv_node, :2] = plain
    garment = garment.at(nodes)
    strain = wanted_strain(garment, np.broadcast_to(np.eye(2), (len(garment.faces), 2, 2)))
    assert required_dart_width(garment, strain, dart) < 0.006
    cut = close_darts(garment, strain, pattern, [dart])
    assert not find_darts(cut.pattern) and not find_darts(cut.base)
    mesh = mesh_pattern(cut.pattern, 900)
    assert np.abs(cut.place(garment, nodes, mesh)[:, 2]).max() < 1e-12
    assert np.abs(seam_mismatch(cut.pattern)).max() < 1e-6


DARTED, PLAIN = "pencil_skirt+shaping=darts", "pencil_skirt"


def fit_panels(folder: Path, true: str, base: str, keep_cut: bool | None = None) -> RecoveryState:
    """Drape a cut on the built-in body, and fit another to that drape as a recovery does, up to its panels."""
    wearer, fabric = WearerGeometry(builtin_body("builtin:female,height=1.70")), get_fabric("cotton_poplin")
    worn = drape_template(load_template(true), wearer)
    hangs = Target(worn.nodes, worn.faces, vertex_normals(worn.nodes, worn.faces), worn.contours, (), "skirt")
    garment, _ = drape_graded(remesh(worn, 5000), wearer, fabric, hangs)
    trimesh.Trimesh(garment.nodes, garment.faces, process=False).export(folder / "garment.ply")
    trimesh.Trimesh(wearer.body.vertices, wearer.body.faces, process=False).export(folder / "body.ply")
    save_pattern(load_template(base), folder / "base.json")
    settings = RecoverySettings(method="deform", keep_cut=keep_cut)
    request = Request(folder / "garment.ply", folder / "body.ply", folder / "base.json", settings)
    clock = Clock(SILENT_HOOKS)
    case = read_case(request, clock)
    state = run_steps(METHODS["deform"], case, choose_base(case), clock)
    fitted = fit_isometry(state.graded, state.meshes.detail, state.target, case.body, state.base)
    return change_panels(case, replace(state, garment=fitted))


def list_changes(found: RecoveryState) -> list[dict]:
    """Return the evidence of the darts that were added or closed."""
    return [one.evidence for one in found.findings if one.kind is FindingKind.PANEL_CHANGE]


@pytest.mark.nightly
def test_a_skirt_with_darts_gets_them_back(tmp_path: Path) -> None:
    """Breaks where the back's darts are not found, or further than 2 cm or 5 degrees from where they were sewn."""
    found, true = fit_panels(tmp_path, DARTED, PLAIN), load_template(DARTED)
    sewn = {dart.panel: dart for dart in find_darts(true) if dart.ends(true)[1][0] > 0.0}
    assert {change["kind"] for change in list_changes(found)} == {"added"}
    pattern = found.garment.pattern
    for dart in find_darts(pattern):
        truth = sewn[dart.panel]
        middles = [0.5 * (one.ends(each)[0] + one.ends(each)[2]) for one, each in ((dart, pattern), (truth, true))]
        assert abs(abs(middles[0][0]) - abs(middles[1][0])) < 0.02
        angles = [one.angle(each) for one, each in ((dart, pattern), (truth, true))]
        assert abs(np.degrees(angles[0] - angles[1])) < 5.0
    assert np.abs(seam_mismatch(pattern)).max() < 1e-6
    assert not [fault for fault in find_faults(pattern) if fault.severity is Severity.ERROR]


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("true", "base", "keep_cut"), [(PLAIN, PLAIN, None), (DARTED, PLAIN, True), (PLAIN, DARTED, True)]
)
def test_panels_stay_where_nothing_asks_for_another_cut(
    tmp_path: Path, true: str, base: str, keep_cut: bool | None
) -> None:
    """Breaks where a skirt without darts gets some, or `keep_cut` is not obeyed."""
    found = fit_panels(tmp_path, true, base, keep_cut)
    assert not list_changes(found)
    assert len(find_darts(found.garment.pattern)) == len(find_darts(load_template(base)))


@pytest.mark.nightly
def test_needless_darts_are_closed(tmp_path: Path) -> None:
    """Breaks where a skirt that was sewn without darts keeps those of its base pattern in front."""
    found = fit_panels(tmp_path, PLAIN, DARTED)
    assert {(change["kind"], change["panel"]) for change in list_changes(found)} >= {("closed", "front")}
    assert not [dart for dart in find_darts(found.garment.pattern) if dart.panel == "front"]
    assert np.abs(seam_mismatch(found.garment.pattern)).max() < 1e-6
