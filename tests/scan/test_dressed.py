"""A dressed person as one surface: the garment is cut out by labels or colour, and the body found below it."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path

import igl
import numpy as np
import pytest
import trimesh
from garmentq.core.body.body import JOINTS, Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.judge.gates import evaluate_gates
from garmentq.core.people.wearer import FoundWearer, fit_wearer
from garmentq.core.recover.inputs import read_files
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings, SettingsBad
from garmentq.core.run.errors import BadInput
from garmentq.core.run.verdict import Verdict
from garmentq.core.scan.contours.garment import segment_garment
from garmentq.core.scan.contours.loop import find_loops, smoothed_length
from garmentq.core.scan.contours.rounded_rims import straighten_scan
from garmentq.core.scan.cut import cut_garment
from garmentq.core.scan.pieces import ScanInput, load_scan_input
from garmentq.core.scan.scan import Scan
from garmentq.core.scan.selection import Selection
from garmentq.core.scan.vertex_selection import select_other_cloth, select_vertices

GAP = 0.015
"""Distance of the cloth from the skin at the waist [m]; on the shoulders, where clothes rest, it is a fifth of that."""
SHIRT = ("pelvis", "spine1", "spine2", "spine3", "left_collar", "right_collar", "left_shoulder", "right_shoulder")
TURN, SHIFT = 0.6, np.array([0.3, 0.05, -0.2])


@dataclass(frozen=True)
class Dressed:
    """Describe a dressed person: the mesh, which vertices are cloth, the body below, its joints, and the file."""

    vertices: np.ndarray
    faces: np.ndarray
    cloth: np.ndarray
    body: np.ndarray
    joints: np.ndarray
    path: Path


def move(points: np.ndarray) -> np.ndarray:
    """Turn and shift points, so that nothing stands where the built-in body stands."""
    c, s = np.cos(TURN), np.sin(TURN)
    return points @ np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]).T + SHIFT


@pytest.fixture(scope="session")
def dressed(tmp_path_factory: pytest.TempPathFactory) -> Dressed:
    """Lift the skin of trunk and upper arms into a T-shirt, fused with the rest; 2 mm noise, labels and colours."""
    body = builtin_body("builtin:male,height=1.78,weight=75,pose=A")
    rng = np.random.default_rng(0)
    part = np.array(JOINTS)[body.weights.argmax(axis=1)]
    finer, faces = trimesh.remesh.subdivide(body.vertices, body.faces)
    nearest = igl.point_mesh_squared_distance(finer, body.vertices, body.faces)[1]
    high = finer[:, 1] > body.joint("left_hip")[1]
    cloth = np.isin(part[body.faces[nearest, 0]], SHIRT) & high
    neck, waist = body.joint("neck")[1], body.joint("spine1")[1]
    gap = GAP * np.clip((neck - finer[:, 1]) / (neck - waist), 0.2, 1.0) * cloth
    lifted = finer + gap[:, None] * vertex_normals(finer, faces) + rng.normal(0, 0.002, finer.shape)
    colours = np.where(cloth[:, None], [70, 95, 170], [200, 170, 145]) + rng.normal(0, 8, finer.shape)
    path = tmp_path_factory.mktemp("dressed") / "person.ply"
    mesh = trimesh.Trimesh(move(lifted), faces, process=False)
    mesh.visual.vertex_colors = np.clip(colours, 0, 255).astype(np.uint8)
    mesh.vertex_attributes["label"] = np.where(cloth, 7, 3).astype(np.int32)
    mesh.export(path)
    return Dressed(np.asarray(mesh.vertices), faces, cloth, move(body.vertices), move(body.joints), path)


@pytest.fixture(scope="session")
def pieces(dressed: Dressed) -> ScanInput:
    """Read the dressed person by the labels in the file."""
    return load_scan_input(dressed.path, None, selection=Selection(keep=("7",)))


@pytest.fixture(scope="session")
def wearer(pieces: ScanInput) -> FoundWearer:
    """Register the body below the cloth."""
    assert pieces.wearer is not None
    return fit_wearer(pieces.wearer, pieces.cloth, labels=pieces.labels)


@pytest.fixture(scope="session")
def found(wearer: FoundWearer) -> Body:
    """Return the body below the cloth."""
    return wearer.body


def test_labels_in_the_scan_are_the_garment(dressed: Dressed, pieces: ScanInput) -> None:
    """Broken where labels are lost on the way through parser and repair, or the cut wanders off their border."""
    assert pieces.cloth is not None and pieces.wearer is not None
    assert np.array_equal(pieces.cloth, dressed.cloth)
    assert (pieces.garment.units, pieces.garment.up_axis) == ("m", "y")
    distance = igl.point_mesh_squared_distance(
        pieces.garment.vertices, dressed.vertices, dressed.faces[dressed.cloth[dressed.faces].any(axis=1)]
    )[0]
    assert np.sqrt(distance).max() < 0.004
    corners = dressed.vertices[dressed.faces]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    ours = trimesh.Trimesh(pieces.garment.vertices, pieces.garment.faces, process=False).area
    assert ours == pytest.approx(area @ dressed.cloth[dressed.faces].mean(axis=1), rel=0.04)


@pytest.mark.parametrize("form", ["npz", "npy", "txt", "colour"])
def test_other_ways_to_tell_cut_the_same(dressed: Dressed, pieces: ScanInput, tmp_path: Path, form: str) -> None:
    """Broken where a file's labels are applied in another order than the file's vertices, or colours are scaled."""
    path = tmp_path / f"labels.{form}"
    if form == "npz":
        np.savez(path, panel=np.zeros(3), is_garment=dressed.cloth)
    elif form == "npy":
        np.save(path, dressed.cloth.astype(np.uint8))
    elif form == "txt":
        path.write_text("\n".join(np.where(dressed.cloth, "shirt", "skin").tolist()))
    keep = ("shirt",) if form == "txt" else ()
    selection = Selection(colour="#465faa") if form == "colour" else Selection(path, keep=keep)
    again = load_scan_input(dressed.path, None, selection=selection)
    assert np.array_equal(again.garment.vertices, pieces.garment.vertices)
    assert np.array_equal(again.garment.faces, pieces.garment.faces)


def refusal(scan: Scan, selection: Selection) -> BadInput:
    """Return what refuses a selection."""
    with pytest.raises(BadInput) as caught:
        select_vertices(scan, scan.labels, selection)
    return caught.value


def test_wrong_labels_are_refused(dressed: Dressed, pieces: ScanInput, tmp_path: Path) -> None:
    """Broken where labels of another scan cut anything at all, or a missing label gives an empty garment."""
    path = tmp_path / "labels.npy"
    np.save(path, dressed.cloth[:-1])
    with pytest.raises(BadInput) as caught:
        load_scan_input(dressed.path, None, selection=Selection(path))
    assert caught.value.code == "scan.labels_mismatch"
    assert str(len(dressed.cloth)) in caught.value.message and str(len(dressed.cloth) - 1) in caught.value.message
    whole = pieces.wearer
    assert whole is not None
    assert refusal(whole, Selection(keep=("8",))).code == "scan.label_unknown"
    assert "3, 7" in refusal(whole, Selection()).message  # which of them is not said
    assert refusal(whole, Selection(keep=("3", "7"))).code == "scan.label_unknown"
    assert refusal(whole, Selection(colour="#00ff00")).code == "scan.label_unknown"
    assert refusal(whole, Selection(colour="blue")).code == "scan.colour"


def test_other_clothes_hide_the_body_too(dressed: Dressed, pieces: ScanInput) -> None:
    """Broken where trousers count as skin while the shirt is recovered, or become part of the shirt."""
    both = load_scan_input(dressed.path, None, selection=Selection(keep=("7",), cloth=("3",)))
    assert both.cloth is not None and both.cloth.all()
    assert np.array_equal(both.garment.faces, pieces.garment.faces)
    assert pieces.wearer is not None
    with pytest.raises(BadInput, match="--cloth") as caught:
        select_other_cloth(pieces.wearer, pieces.wearer.labels, Selection(cloth=("8",)))
    assert caught.value.code == "scan.label_unknown"


def test_labels_taken_for_skin_are_told(dressed: Dressed, tmp_path: Path) -> None:
    """Broken where trousers that nobody named widen the body and nothing says so, or skin alone is remarked on."""
    path = tmp_path / "labels.npy"
    labels = np.where(dressed.cloth, 1, 0)
    np.save(path, np.where(~dressed.cloth & (dressed.vertices[:, 1] < 0.8), 2, labels))
    told = load_scan_input(dressed.path, None, selection=Selection(path, keep=("1",))).garment.repairs
    assert any("labels 0, 2 for skin" in note and "--cloth" in note for note in told)
    for selection in (Selection(path, keep=("1",), cloth=("2",)), Selection(colour="#465faa")):
        assert not any(
            "for skin" in note for note in load_scan_input(dressed.path, None, selection=selection).garment.repairs
        )


def test_a_scan_without_labels_or_colours_is_refused() -> None:
    """Broken where there is nothing to tell the garment by and everything is taken."""
    scan = Scan(np.eye(3), np.array([[0, 1, 2]]))
    for selection in (Selection(keep=("1",)), Selection(colour="#465faa")):
        with pytest.raises(BadInput) as caught:
            select_vertices(scan, None, selection)
        assert caught.value.code == "scan.labels_missing"


def grid(side: int = 60, step: float = 0.005) -> Scan:
    """Return a flat square of triangles."""
    x, y = np.meshgrid(np.arange(side) * step, np.arange(side) * step, indexing="ij")
    vertices = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3)
    i, j = (part.ravel() for part in np.meshgrid(np.arange(side - 1), np.arange(side - 1), indexing="ij"))
    a, b, c, d = i * side + j, (i + 1) * side + j, (i + 1) * side + j + 1, i * side + j + 1
    return Scan(vertices, np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]))


def test_the_cut_is_smooth_and_faces_keep_their_side() -> None:
    """Broken where the cut follows the triangles (a circle then is 20 % too long) or turns faces over."""
    scan = grid()
    inside = np.linalg.norm(scan.vertices[:, :2] - 0.1475, axis=1) < 0.1
    wrong = np.random.default_rng(0).choice(len(inside), 40, replace=False)
    inside[wrong] ^= True  # single vertices with the wrong label
    garment = cut_garment(scan, inside)
    mesh = trimesh.Trimesh(garment.vertices, garment.faces, process=False)
    assert mesh.area == pytest.approx(np.pi * 0.1**2, rel=0.04)
    rim = mesh.edges[trimesh.grouping.group_rows(mesh.edges_sorted, require_count=1)]
    length = np.linalg.norm(np.diff(garment.vertices[rim], axis=1), axis=-1).sum()
    assert length == pytest.approx(2 * np.pi * 0.1, rel=0.05)
    assert (mesh.face_normals[:, 2] > 0.99).all()
    assert garment.unseen is not None and not garment.unseen.any()


def test_what_the_scanner_did_not_see_is_known() -> None:
    """Broken where the border of the scan and a cut through it are told apart no more."""
    scan = grid()
    garment = cut_garment(scan, scan.vertices[:, 0] < 0.15)
    assert garment.unseen is not None
    on_cut = garment.vertices[:, 0] > 0.14
    y = garment.vertices[:, 1]
    on_border = (garment.vertices[:, 0] == 0.0) | (y == 0.0) | (y == y.max())
    assert np.array_equal(garment.unseen, on_border)
    assert (on_cut & ~garment.unseen).sum() > 50


@pytest.mark.slow
def test_body_stays_below_the_cloth(dressed: Dressed, pieces: ScanInput, found: Body) -> None:
    """Broken where cloth counts as skin (the body then fills the shirt) or counts for nothing (it sticks out)."""
    assert np.linalg.norm(found.joints - dressed.joints, axis=1).mean() < 0.015
    assert found.source == "scan:person" and found.fit_rms < 0.006
    assert len(found.vertices) == len(found.rest_vertices) and np.allclose(found.weights.sum(axis=1), 1)
    mesh = (np.ascontiguousarray(found.vertices), np.ascontiguousarray(found.faces))
    skin = dressed.vertices[~dressed.cloth]
    assert np.sqrt(igl.point_mesh_squared_distance(skin, *mesh)[0].mean()) < 0.006
    near = igl.point_mesh_squared_distance(dressed.body, dressed.vertices, dressed.faces)[1]
    below = dressed.body[dressed.cloth[dressed.faces[near]].all(axis=1)]
    assert np.sqrt(igl.point_mesh_squared_distance(below, *mesh)[0].mean()) < 0.005
    signed = igl.signed_distance(pieces.garment.vertices, *mesh)[0]
    assert np.quantile(signed, 0.01) > -0.003
    true = igl.signed_distance(pieces.garment.vertices, np.ascontiguousarray(dressed.body), mesh[1])[0]
    assert np.median(signed) == pytest.approx(np.median(true), abs=0.004)


@pytest.mark.slow
def test_a_garment_that_is_taken_for_skin_is_found(dressed: Dressed, pieces: ScanInput, wearer: FoundWearer) -> None:
    """Broken where a body that was fitted to clothes as if they were skin passes, or one below marked cloth does not.

    The shirt hangs 2 cm wider, and the marks say that the left hand alone is cloth.
    """
    assert wearer.undeclared == ()
    scan, labels = pieces.wearer, pieces.labels
    assert scan is not None and labels is not None
    shirt = labels == 7
    wide = scan.vertices + 0.02 * shirt[:, None] * vertex_normals(scan.vertices, scan.faces)
    hand = np.linalg.norm(scan.vertices - dressed.joints[JOINTS.index("left_hand")], axis=1) < 0.1
    (one,) = fit_wearer(replace(scan, vertices=wide), hand, labels=labels).undeclared or ()
    assert (one.part, one.labels, one.is_whole, one.is_off_body) == ("upper", ("7",), True, True)
    assert "Label 7" in one.describe() and "--cloth 7" in one.describe()
    gate = next(gate for gate in evaluate_gates({"body.undeclared_mm": 1e3 * one.offset}) if gate.name == "undeclared")
    assert gate.verdict == Verdict.DOUBTFUL and "--cloth" in gate.message


@pytest.mark.slow
def test_a_person_who_was_scanned_to_the_knees_is_enough(dressed: Dressed, pieces: ScanInput) -> None:
    """Broken where who marked the clothes is told that the scan shows no whole person, or the trunk goes astray."""
    assert pieces.wearer is not None and pieces.cloth is not None
    vertices, faces = pieces.wearer.vertices, pieces.wearer.faces
    kept = faces[(vertices[faces][:, :, 1] > 0.5).all(axis=1)]
    used, index = np.unique(kept, return_inverse=True)
    body = fit_wearer(Scan(vertices[used], index.reshape(-1, 3)), pieces.cloth[used]).body
    upper = [JOINTS.index(name) for name in ("pelvis", "spine2", "neck", "left_shoulder", "right_elbow")]
    assert np.linalg.norm(body.joints - dressed.joints, axis=1)[upper].max() < 0.03


@pytest.mark.slow
def test_contours_of_the_cut_have_their_names(pieces: ScanInput, found: Body) -> None:
    """Broken where cut, registration and naming do not fit together."""
    target = segment_garment(pieces.garment, found)
    assert target.category == "tshirt"
    assert {contour.name for contour in target.contours} == {"neck", "hem", "cuff.left", "cuff.right"}
    assert all(contour.trusted for contour in target.contours) and not target.holes


@pytest.mark.slow
def test_hole_through_the_neckline_is_bridged(pieces: ScanInput, found: Body) -> None:
    """Broken where a hole of the scan that reaches the neck makes the neckline long, or a design is cut off."""
    whole = segment_garment(pieces.garment, found).contour("neck")
    assert whole is not None and pieces.wearer is not None and pieces.cloth is not None
    vertices, faces = pieces.wearer.vertices, pieces.wearer.faces
    # Outwards along the shoulder from a point of the neckline: a hole of 5 by 9 cm.
    start = pieces.garment.vertices[whole.vertices]
    side = found.joint("left_shoulder") - found.joint("neck")
    start = start[np.argmax(start @ side)]
    along = side * [1, 0, 1] / np.linalg.norm(side * [1, 0, 1])
    offset = vertices - start - 0.03 * along
    across = offset - np.outer(offset @ along, along)
    gone = ((offset @ along) / 0.045) ** 2 + (np.linalg.norm(across, axis=1) / 0.025) ** 2 < 1
    kept = faces[~gone[faces].any(axis=1)]
    used, index = np.unique(kept, return_inverse=True)
    holed = cut_garment(Scan(vertices[used], index.reshape(-1, 3)), pieces.cloth[used])
    target = segment_garment(holed, found)
    neck = target.contour("neck")
    assert neck is not None and neck.trusted
    assert neck.length == pytest.approx(whole.length, rel=0.08)
    assert [smoothed_length(holed.vertices[hole]) > 0.1 for hole in target.holes] == [True]


def test_pipeline_reads_the_pieces(dressed: Dressed, pieces: ScanInput) -> None:
    """Broken where settings do not reach the cut, or a garment alone passes without a body."""
    read = read_files(Request(dressed.path, settings=RecoverySettings(keep="7")))
    assert read.cloth is not None and np.array_equal(read.garment.faces, pieces.garment.faces)
    with pytest.raises(BadInput) as caught:
        read_files(Request(dressed.path))
    assert caught.value.code == "body.missing"


def test_settings_are_plain_values_and_checked() -> None:
    """Broken where a job's settings do not survive the way through the database."""
    settings = RecoverySettings(keep="upper, sleeve", colour_tolerance=40.0)
    assert RecoverySettings(**settings.as_dict()) == settings
    assert settings.kept_labels == ("upper", "sleeve")
    for wrong in ({"keep": ","}, {"keep": "1", "keep_colour": "#000000"}, {"colour_tolerance": 0.0}):
        with pytest.raises(SettingsBad):
            RecoverySettings(**wrong)


def test_inspect_cuts_the_garment_out(dressed: Dressed, pieces: ScanInput) -> None:
    """Broken where `inspect` shows the whole person, or another garment than the job would recover."""
    from click.testing import CliRunner
    from garmentq.cli.main import group

    answer = CliRunner().invoke(group, ["inspect", str(dressed.path), "--keep-colour", "#465faa", "--json"])
    assert answer.exit_code == 0, answer.output
    told = json.loads(answer.stdout)
    assert told["vertex_count"] == len(pieces.garment.vertices)
    assert told["body"]["source"] == "scan:person"
    assert {"neck", "hem"} <= set(told["contours_m"])
    straight = straighten_scan(pieces.garment)  # what the job measures its contours on
    assert not np.array_equal(straight.vertices, pieces.garment.vertices)
    lengths = sorted((smoothed_length(straight.vertices[loop]) for loop in find_loops(straight.faces)), reverse=True)
    assert told["boundaries_m"] == pytest.approx(lengths, abs=1e-4)
