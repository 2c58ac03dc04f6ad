"""Metrics in space against shapes whose answer is known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from garmentq.cli.bench.truth import transfer_contours
from garmentq.core.body.exposed import ExposedSurface, penetration_depth
from garmentq.core.garment.meshes import Meshes
from garmentq.core.geometry.curves import Curve
from garmentq.core.geometry.geometry import corner_angles, deformation_gradients, principal_stretches, vertex_normals
from garmentq.core.geometry.surface import TriangleSurface
from garmentq.core.judge.chamfer import MAX_QUERY_VERTEX_COUNT, VertexCloud, chamfer_and_normals, meshing_floor
from garmentq.core.judge.contours import contour_rms, curve_rms
from garmentq.core.judge.fit import Reference, count_flipped, measure_distance, measure_fit
from garmentq.core.judge.penetration import measure_penetration
from garmentq.core.scan.contours.loop import find_loops
from garmentq.core.scan.contours.target import Contour


def grid(count: int = 20, width: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Return a flat square in z = 0, facing +z."""
    x, y = np.meshgrid(np.linspace(0.0, width, count), np.linspace(0.0, 1.0, count))
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(x.size)], axis=1)
    corner = (np.arange(count - 1)[:, None] * count + np.arange(count - 1)).ravel()
    lower = np.stack([corner, corner + 1, corner + count + 1], axis=1)
    upper = np.stack([corner, corner + count + 1, corner + count], axis=1)
    return vertices, np.concatenate([lower, upper]).astype(np.int64)


def sphere(radius: float, subdivisions: int = 4) -> tuple[np.ndarray, np.ndarray]:
    """Return a fine icosphere."""
    mesh = trimesh.creation.icosphere(subdivisions=subdivisions, radius=radius)
    return np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)


def turn(seed: int) -> np.ndarray:
    """Return a random rotation."""
    rotation, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return rotation * np.sign(np.linalg.det(rotation))


def test_concentric_spheres_lie_their_difference_apart() -> None:
    """Fails if a distance were squared, in metres, halved or measured to vertices: 5 mm between radii is 5 mm."""
    found = measure_distance(*sphere(0.100), *sphere(0.105), samples=5000)
    for name in ("surface_rms_mm.s2t", "surface_rms_mm.t2s", "surface_p95_mm.s2t", "hausdorff_mm"):
        assert found[name] == pytest.approx(5.0, rel=0.01), name


def test_moved_plane_is_exactly_as_far_as_it_moved() -> None:
    """Fails if distances lost precision: a plane moved along its normal lies at one exact distance, both ways."""
    vertices, faces = grid()
    found = measure_distance(vertices + [0.0, 0.0, 0.002], faces, vertices, faces, samples=1000)
    assert found["surface_rms_mm.s2t"] == pytest.approx(2.0, abs=1e-9)
    assert found["surface_rms_mm.t2s"] == pytest.approx(2.0, abs=1e-9)


def test_a_missing_half_shows_only_from_the_truth() -> None:
    """Fails if s2t and t2s were swapped or averaged: ours is half of the truth; the RMS is sqrt(1/24)."""
    found = measure_distance(*grid(width=0.5), *grid(), samples=20000)
    assert found["surface_rms_mm.s2t"] == pytest.approx(0.0, abs=1e-9)
    assert found["surface_rms_mm.t2s"] == pytest.approx(1e3 * np.sqrt(1.0 / 24.0), rel=0.005)
    assert found["hausdorff_mm"] == pytest.approx(500.0, rel=0.01)


def test_chamfer_sums_both_directions_of_squares() -> None:
    """Fails if Chamfer were a mean of the two directions or not squared: a small shift d gives 2 d^2."""
    vertices, faces = grid()
    normals = vertex_normals(vertices, faces)
    shifted = VertexCloud(vertices + [0.0, 0.0, 0.01], normals)
    chamfer, cosine = chamfer_and_normals(shifted, VertexCloud(vertices, normals))
    assert chamfer == pytest.approx(2e-4, rel=1e-9)
    assert cosine == pytest.approx(0.0, abs=1e-12)


def test_normals_are_voted_on_and_keep_their_angle() -> None:
    """Fails if an inside-out mesh were punished, or if |cos| hid a tilt: a tilt by a gives 2 (1 - cos a)."""
    vertices, faces = grid()
    normals = vertex_normals(vertices, faces)
    truth = VertexCloud(vertices, normals)
    tilted = np.tile([0.0, np.sin(0.3), np.cos(0.3)], (len(vertices), 1))
    assert chamfer_and_normals(VertexCloud(vertices, -normals), truth)[1] == pytest.approx(0.0, abs=1e-12)
    assert chamfer_and_normals(VertexCloud(vertices, tilted), truth)[1] == pytest.approx(2 - 2 * np.cos(0.3), rel=1e-9)
    half = normals.copy()
    half[: len(half) // 4] *= -1.0
    assert chamfer_and_normals(VertexCloud(vertices, half), truth)[1] == pytest.approx(1.0, rel=1e-9)


def test_some_vertices_of_a_dense_mesh_stand_for_all() -> None:
    """Fails if the sampled mean were of one side of the mesh, or divided by the number of all its vertices."""
    rng = np.random.default_rng(0)
    dense = rng.random((int(2.5 * MAX_QUERY_VERTEX_COUNT), 3)) * [1.0, 1.0, 0.0]
    dense = dense[np.argsort(dense[:, 0])]  # as files are: neighbours follow each other
    ours = rng.random((500, 3)) * [1.0, 1.0, 0.0]
    up = VertexCloud(ours, np.tile([0.0, 0.0, 1.0], (500, 1)))
    cloud = VertexCloud(dense, np.tile([0.0, 0.0, 1.0], (len(dense), 1)))
    exact = np.mean(cloud.tree.query(ours)[0] ** 2) + np.mean(up.tree.query(dense)[0] ** 2)
    assert chamfer_and_normals(up, cloud)[0] == pytest.approx(exact, rel=0.01)


def test_the_floor_is_that_of_a_hexagonal_lattice() -> None:
    """Fails if the floor were counted once, or spread unevenly: on a plane it is 2 (5 / 36) h^2."""
    count = 800
    floor, cosine = meshing_floor(TriangleSurface(*grid()), count, np.random.default_rng(0))
    lattice = 2.0 * 5.0 / 36.0 * 2.0 / (np.sqrt(3.0) * count)
    assert 0.95 * lattice < floor < 1.15 * lattice
    assert cosine == pytest.approx(0.0, abs=1e-9)


def test_concentric_loops_lie_their_difference_apart() -> None:
    """Fails if contours were compared vertex by vertex: loops with other vertex counts, 4 mm apart."""
    small, large = (
        np.linspace(0, 2 * np.pi, 150, endpoint=False),
        np.linspace(0.01, 2 * np.pi + 0.01, 471, endpoint=False),
    )
    first = 0.100 * np.stack([np.cos(small), np.sin(small), 0 * small], axis=1)
    second = 0.104 * np.stack([np.cos(large), np.sin(large), 0 * large], axis=1)
    assert curve_rms(Curve(first), Curve(second)) == pytest.approx(0.004, rel=0.01)


def test_untrusted_and_missing_contours_are_left_out() -> None:
    """Fails if a cut-off hem counted as an error, or a name without counterpart raised."""
    loop = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], dtype=float)
    ours = [Contour("hem", np.arange(3), 1.0), Contour("neck", np.arange(3), 1.0)]
    truth = [Contour("hem", np.arange(3), 1.0, trusted=False), Contour("neck", np.arange(3), 1.0)]
    truth.append(Contour("waist", np.arange(3), 1.0))
    assert contour_rms(loop, ours, loop, truth) == {"neck": pytest.approx(0.0, abs=1e-12)}


def test_boundary_loops_and_names_carried_over(tube, tube_pattern) -> None:
    """Fails if a rim were cut in two, or a name went to the other rim of a finer mesh."""
    coarse, fine = tube(tube_pattern(), 0.04), tube(tube_pattern(), 0.015)
    loops = find_loops(fine.faces)
    assert sorted(len(loop) for loop in loops) == sorted(len(contour.vertices) for contour in fine.contours)
    carried = transfer_contours(coarse.contours, coarse.nodes, fine.nodes, fine.faces)
    heights = {contour.name: set(np.round(fine.nodes[contour.vertices, 1], 9)) for contour in carried}
    assert heights == {"hem": {0.8}, "waist": {1.1}}


def test_stretch_is_the_singular_values_of_the_map() -> None:
    """Fails if pattern and space were swapped or a rotation counted: 1.3 along x, 0.8 along y, turned in space."""
    vertices, faces = grid(6)
    rest = vertices[faces][:, :, :2]
    nodes = (vertices * [1.3, 0.8, 1.0]) @ turn(4).T + [3.0, 1.0, 2.0]
    found = principal_stretches(deformation_gradients(nodes, faces, rest))
    assert found[:, 0] == pytest.approx(1.3)
    assert found[:, 1] == pytest.approx(0.8)
    shear = principal_stretches(
        deformation_gradients(vertices @ np.array([[1, 0, 0], [0.5, 1, 0], [0, 0, 1.0]]), faces, rest)
    )
    expected = np.linalg.svd(np.array([[1.0, 0.5], [0.0, 1.0]]), compute_uv=False)
    assert shear == pytest.approx(np.tile(expected, (len(faces), 1)))


def test_angles_of_known_triangles() -> None:
    """Fails if an angle were given in degrees, or of the wrong corner."""
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, np.sqrt(3.0), 0]])
    assert np.degrees(corner_angles(vertices, np.array([[0, 1, 2]]))[0]) == pytest.approx([90.0, 60.0, 30.0])


def test_flipped_faces_are_counted_but_not_a_mesh_turned_inside_out() -> None:
    """Fails if the vote were taken face by face, or not at all."""
    vertices, faces = sphere(0.1, 2)
    wrong = faces.copy()
    wrong[[3, 50, 70]] = wrong[[3, 50, 70]][:, ::-1]
    assert count_flipped(vertices, wrong, Reference(TriangleSurface(vertices, faces))) == 3
    assert count_flipped(vertices, wrong[:, ::-1], Reference(TriangleSurface(vertices, faces))) == 3


def test_where_the_scan_passes_through_itself_no_side_is_wrong() -> None:
    """Fails if two layers are wrong that lie apart where the scan's lie in each other, or the rest is not judged.

    Two layers, the upper one facing up, 4 mm apart; in a band of 2 cm the scan's have changed places.
    """
    x, y = np.meshgrid(np.linspace(-0.1, 0.1, 41), np.linspace(0.0, 0.1, 21))
    at = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (at[:-1, :-1].ravel(), at[:-1, 1:].ravel(), at[1:, 1:].ravel(), at[1:, :-1].ravel())
    up = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    faces = np.concatenate([up, up[:, ::-1] + x.size])

    def layers(height: np.ndarray) -> np.ndarray:
        upper, lower = (np.stack([x, y, z], 2).reshape(-1, 3) for z in (height, -height))
        return np.concatenate([upper, lower + [7e-4, 13e-4, 0.0]])  # else edges meet edges, which is no crossing

    inside = np.abs(x) < 0.009
    scan, ours = layers(np.where(inside, -2e-3, 2e-3)), layers(np.full(x.shape, 1e-3))
    cloth = Reference(TriangleSurface(scan, faces))
    band = np.abs(ours[faces][:, :, 0]).max(axis=1) < 0.009
    assert band.sum() > 100 and count_flipped(ours, faces, cloth) < 0.2 * band.sum()
    aside = faces.copy()
    aside[:5] = aside[:5, ::-1]  # at the edge, where layers are apart
    assert count_flipped(ours, aside, cloth) == count_flipped(ours, faces, cloth) + 5


def test_penetration_sees_vertices_and_face_centres() -> None:
    """Fails if only vertices were tested, or depth were measured outside: depths 4 mm and centre of a wide face."""
    body = ExposedSurface(*sphere(0.1, 5))
    outside, faces = sphere(0.12, 2)
    assert penetration_depth(outside, faces, body) == 0.0
    inside = outside.copy()
    inside[7] *= 0.096 / 0.12
    assert penetration_depth(inside, faces, body) == pytest.approx(0.004, rel=0.02)
    angle = np.array([0.0, 2.0, 4.0]) * np.pi / 3.0
    wide = np.stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), np.full(3, 0.08)], axis=1)
    assert penetration_depth(wide, np.array([[0, 1, 2]]), body) == pytest.approx(0.02, rel=0.02)


@pytest.fixture(scope="module")
def swollen(tube, tube_pattern):
    """A tube whose detail mesh is 3 mm too wide, and its truth, sampled sparsely."""
    garment = tube(tube_pattern(), 0.03)
    truth = tube(tube_pattern(), 0.025)
    post = trimesh.creation.cylinder(radius=0.14, height=1.2, sections=64)
    body = ExposedSurface(post.vertices[:, [1, 2, 0]] + [0.0, 0.95, 0.0], np.array(post.faces, dtype=np.int64))
    detail = garment.nodes * [1.02, 1.0, 1.02]
    graded = garment.nodes * [0.9, 1.0, 0.9]
    reference = Reference(TriangleSurface(truth.nodes, truth.faces), truth.contours, body, samples=4000)
    return garment, Meshes(graded, detail, garment.nodes), reference


def test_measure_fit_names_every_metric(swollen) -> None:
    """Fails if a metric of the specification were renamed, or the simulation and graded meshes were left out."""
    found = measure_fit(*swollen)
    both = {
        "chamfer_vertex_m2e3", "surface_rms_mm.s2t", "surface_rms_mm.t2s", "surface_p95_mm.s2t", "surface_p95_mm.t2s",
        "hausdorff_mm", "normal_cosine", "contour_rms_mm.hem", "contour_rms_mm.waist", "stretch_p001", "stretch_p999",
        "flipped_faces", "self_intersecting_faces", "min_angle_deg", "body_penetration_mm",
    }  # fmt: skip
    expected = both | {f"sim.{name}" for name in both} | {"chamfer_vertex_floor_m2e3", "normal_cosine_floor"}
    assert expected <= set(found)
    assert {"graded.surface_rms_mm.s2t", "graded.self_intersecting_faces", "graded.body_penetration_mm"} <= set(found)
    assert found["surface_rms_mm.s2t"] == pytest.approx(3.0, rel=0.08)
    assert found["contour_rms_mm.hem"] == pytest.approx(3.0, rel=0.08)
    assert found["sim.surface_rms_mm.s2t"] < 0.4
    assert found["graded.surface_rms_mm.s2t"] == pytest.approx(15.0, rel=0.05)
    assert found["graded.body_penetration_mm"] == pytest.approx(5.0, rel=0.15)
    assert found["stretch_p999"] == pytest.approx(1.02, abs=0.005)
    assert found["flipped_faces"] == found["self_intersecting_faces"] == 0.0


def test_no_body_and_no_simulation_leave_gaps_not_zeros(swollen) -> None:
    """Fails if a metric without its input were reported as a good value."""
    garment, meshes, truth = swollen
    found = measure_fit(garment, replace(meshes, simulation=None), replace(truth, skin=None, samples=500))
    assert found["body_penetration_mm"] is None
    assert not any(name.startswith("sim.") for name in found)


def test_rigid_motion_and_mirror_change_no_metric(swollen) -> None:
    """Fails if a metric favoured an axis or a hand: everything turned, moved, then mirrored measures the same."""
    garment, meshes, truth = swollen
    truth = replace(truth, samples=20000)
    before = measure_fit(garment, Meshes(meshes.graded, meshes.detail), truth)

    def move(points: np.ndarray) -> np.ndarray:
        return points @ turn(9).T + [1.0, -2.0, 0.5]

    skin = truth.skin
    moved = measure_fit(
        garment,
        Meshes(move(meshes.graded), move(meshes.detail)),
        replace(
            truth,
            surface=TriangleSurface(move(truth.vertices), truth.surface.faces),
            skin=ExposedSurface(move(skin.vertices), skin.faces),
        ),
    )
    mirror = np.array([-1.0, 1.0, 1.0])
    other = replace(garment, faces=garment.faces[:, ::-1], uv_faces=garment.uv_faces[:, ::-1])
    reflected_skin = ExposedSurface(skin.vertices * mirror, skin.faces[:, ::-1])
    reflected = measure_fit(
        other,
        Meshes(meshes.graded * mirror, meshes.detail * mirror),
        replace(
            truth, surface=TriangleSurface(truth.vertices * mirror, truth.surface.faces[:, ::-1]), skin=reflected_skin
        ),
    )
    assert moved.keys() == reflected.keys() == before.keys()
    for name, value in before.items():
        slack = 0.12 if "floor" in name or "hausdorff" in name else 0.01
        if value is None:
            assert moved[name] is reflected[name] is None, name
            continue
        assert moved[name] == pytest.approx(value, rel=slack, abs=1e-6), name
        assert reflected[name] == pytest.approx(value, rel=slack, abs=1e-6), name


POINT = np.zeros((0, 3), dtype=np.int64)
"""The faces of a garment that is one point."""


@pytest.fixture(scope="module")
def two_parts() -> ExposedSurface:
    """Two balls of 10 cm, 15 cm apart: on the axis between them 25 mm inside both, the crease 66 mm away."""
    one = trimesh.creation.icosphere(4, 0.1)
    other = one.copy()
    other.apply_translation([0.15, 0.0, 0.0])
    both = trimesh.util.concatenate([one, other])
    return ExposedSurface(np.array(both.vertices), np.array(both.faces))


def test_depth_where_two_parts_overlap_is_the_way_out_of_both(two_parts) -> None:
    """Breaks if the depth is that to skin which the other part swallows, 25 mm away: the crease is 66 mm away."""
    depth = penetration_depth(np.array([[0.075, 0.0, 0.0]]), POINT, two_parts)
    assert depth == pytest.approx(np.sqrt(0.1**2 - 0.075**2), rel=0.02)


def test_what_two_parts_pinch_is_no_penetration(two_parts) -> None:
    """Breaks if cloth between two parts counts as left inside by its way out, 66 mm, or what is pinched is not told."""
    between = measure_penetration(np.array([[0.075, 0.0, 0.0]]), POINT, two_parts)
    assert between["body_penetration_mm"] == 0.0 and between["pinched_mm"] == pytest.approx(25.0, rel=0.02)
    inside = measure_penetration(np.array([[-0.05, 0.0, 0.0]]), POINT, two_parts)
    assert inside["body_penetration_mm"] == pytest.approx(50.0, rel=0.02) and inside["pinched_mm"] is None


def test_what_the_truth_hides_is_not_measured(tube_recovery) -> None:
    """Fails if cloth beyond a hidden border counted as far from the scan, or cloth beyond any other border did not."""
    recovery = tube_recovery()
    garment, meshes = recovery.garment, recovery.meshes
    low = (meshes.detail[garment.faces][:, :, 1] < 0.8 + 0.2).all(axis=1)
    used, faces = np.unique(garment.faces[low], return_inverse=True)
    vertices, faces = meshes.detail[used], faces.reshape(-1, 3)
    hidden = np.zeros(len(vertices), bool)
    hidden[vertices[:, 1] > vertices[:, 1].max() - 0.03] = True
    whole = measure_fit(garment, meshes, Reference(TriangleSurface(vertices, faces), samples=2000))
    seen = measure_fit(garment, meshes, Reference(TriangleSurface(vertices, faces), samples=2000, hidden=hidden))
    assert whole["surface_rms_mm.s2t"] > 20.0
    assert "hidden_percent" not in whole
    assert seen["surface_rms_mm.s2t"] < 0.01
    assert seen["surface_rms_mm.t2s"] == whole["surface_rms_mm.t2s"]
    assert 25.0 < seen["hidden_percent"] < 45.0
