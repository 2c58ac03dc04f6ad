"""Raw packs: labels, contours, body and garments measured against truths that are known by construction."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from garmentq.cli.bench.packs import read_mesh_file, read_packs
from garmentq.cli.bench.raw_borders import find_edges, measure_borders
from garmentq.cli.bench.raw_file import RawFile, read_raw_file, write_raw_file
from garmentq.cli.bench.raw_frame import find_frame
from garmentq.cli.bench.raw_labels import measure_calibration, measure_labels
from garmentq.cli.bench.raw_outcome import Outcome, judge_outcome
from garmentq.cli.bench.raw_packs import (
    read_cover,
    read_garment_pattern,
    read_raw_packs,
    read_true_labels,
    read_visible,
)
from garmentq.cli.bench.raw_shape import measure_true_body, measure_visible
from garmentq.cli.bench.raw_states import SCAN_STATES, degrade_scan
from garmentq.core.people.part import Part
from garmentq.core.run.errors import BadInput
from garmentq.core.scan.raw import RawScan
from garmentq_raw_pack import dress, make_raw_pack, sheet


def test_overlaps_are_counted_as_defined() -> None:
    """Broken where clutter counted, a part that only one side has were passed over, or a union counted twice."""
    truth = np.array([0, 0, 1, 10, 10, 11, 11, 20], np.uint8)
    found = np.array([0, 10, 1, 10, 11, 11, 11, 10], np.uint8)
    score = measure_labels(truth, found)
    assert score.accuracy == pytest.approx(5 / 7)
    assert score.cloth_iou == pytest.approx(4 / 5)
    expected = {"skin": 1 / 2, "hair": 1.0, "upper": 1 / 3, "lower": 2 / 3}
    assert score.part_iou == pytest.approx(expected)
    assert score.mean_iou == pytest.approx(np.mean(list(expected.values())))
    assert measure_labels(truth, np.where(found == 1, 2, found)).part_iou["shoes"] == 0.0
    assert measure_labels(truth, truth).mean_iou == 1.0


def test_calibration_of_known_confidences() -> None:
    """Broken where the bins were not weighted by their points, or the sure ones were drawn otherwise."""
    right = np.repeat([True, False, True, False], [80, 20, 30, 70])
    truth = np.zeros(200, np.uint8)
    found = np.where(right, 0, 10)
    confidence = np.repeat([0.95, 0.3], 100)
    score = measure_calibration(truth, found, confidence)
    assert score.error == pytest.approx(0.5 * 0.15 + 0.5 * 0.0)
    assert score.sure == 0.5 and score.sure_right == pytest.approx(0.8)
    assert score.least_sure_right == pytest.approx(0.3)
    assert measure_calibration(truth, found, np.full(200, 0.1)).sure_right is None


@pytest.mark.parametrize("is_cloud", [False, True])
def test_a_contour_that_is_shifted_by_two_centimetres(is_cloud: bool) -> None:
    """Broken where the border were measured to the wrong garment, in one direction only, or not in metres."""
    points, faces = sheet()
    edges = find_edges(points, np.zeros((0, 3), np.int64) if is_cloud else faces)
    truth = dress(points, 0.1, 0.5, 0.9)
    assert measure_borders(points, edges, truth, truth).p95 == 0.0
    moved = measure_borders(points, edges, truth, dress(points, 0.12, 0.5, 0.9))
    assert moved.by_part["upper"] == 0.0
    assert moved.p95 == pytest.approx(0.02, abs=0.001)
    every = measure_borders(points, edges, truth, dress(points, 0.12, 0.52, 0.92))
    assert every.median == pytest.approx(0.02, abs=0.001)


def test_hair_over_a_garment_is_no_contour() -> None:
    """Broken where a lock of hair that was missed counted as a contour of the shirt a decimetre off."""
    points, faces = sheet()
    edges = find_edges(points, faces)
    truth = dress(points, 0.1, 0.5, 0.9)
    lock = (points[:, 0] > 0.2) & (points[:, 0] < 0.3) & (points[:, 1] > 0.65)
    hairy = np.where(lock & (points[:, 1] < 0.9), Part.HAIR, truth)
    assert measure_borders(points, edges, hairy, hairy).p95 == 0.0
    # Found or missed, the lock leaves the neckline beside it where it is.
    assert measure_borders(points, edges, hairy, truth).median == 0.0
    assert measure_borders(points, edges, truth, hairy).median == 0.0


def test_a_missing_garment_is_infinitely_far() -> None:
    """Broken where a garment that was not found left the border measured by the other one alone."""
    points, faces = sheet()
    edges = find_edges(points, faces)
    truth = dress(points, 0.1, 0.5, 0.9)
    bare = np.where(truth == Part.LOWER, Part.SKIN, truth)
    score = measure_borders(points, edges, truth, bare)
    assert score.by_part["lower"] == np.inf and score.p95 == np.inf
    assert measure_borders(points, edges, truth, np.zeros_like(truth)).median == np.inf


def test_a_body_that_is_thicker_below_the_cloth() -> None:
    """Broken where bare and covered parts were mixed up, or vertices counted instead of area."""
    import trimesh

    ball = trimesh.creation.icosphere(3, 0.2)
    truth = (np.array(ball.vertices), np.array(ball.faces))
    above = truth[0][:, 1] > 0.0
    ours = (truth[0] * np.where(above, 1.05, 1.0)[:, None], truth[1])
    score = measure_true_body(truth, np.where(truth[0][:, 1] > 0.02, Part.UPPER, 0), ours)
    assert score["covered"].mean == pytest.approx(0.01, abs=0.001)
    assert score["bare"].mean < 0.001
    assert score["covered"].mean < score["covered"].p95 < 0.011
    assert 0.004 < score["all"].mean < 0.006 and "hidden" not in score


def test_only_the_visible_half_of_a_garment_counts() -> None:
    """Broken where what the scan hides were held against the recovery, or one direction meant the other."""
    points, faces = sheet(30, 60)
    visible = points[:, 1] <= 0.3
    detail = points + [0.0, 0.0, 0.004]
    detail[:, 2] += np.where(visible, 0.0, 0.05)
    score = measure_visible((detail, faces), (points, faces), visible, samples=4000)
    assert score.s2t == pytest.approx(0.004, rel=0.1) and score.t2s == pytest.approx(0.004, rel=0.1)
    shown = points[faces].max(axis=1)[:, 1] <= 0.2
    short = measure_visible((points, faces[shown]), (points, faces), visible, samples=4000)
    assert short.s2t < 1e-9 and short.t2s > 0.02
    assert measure_visible((detail, faces), (points, faces), np.zeros(len(points), bool)).s2t == np.inf


def test_the_frame_is_found_whatever_the_reader_did() -> None:
    """Broken where another axis or heading, or points that were dropped, shifted everything that is measured."""
    points, faces = sheet(10, 10)
    turn = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    place = np.arange(len(points)) - 3
    place[:3] = -1
    truth = points @ turn.T + [1.0, 2.0, 3.0]
    raw = RawScan(points[3:], faces[:0], None, False, None, None, np.arange(3, len(points)), place)
    frame = find_frame(raw, truth)
    assert np.abs(frame.apply(points) - truth).max() < 1e-9 and frame.error < 1e-9


def test_outcomes() -> None:
    """Broken where a wrong answer without any doubt counted as anything else."""
    worn, good = {Part.UPPER: "tshirt", Part.LOWER: "skirt"}, {"upper": 0.9, "lower": 0.8}
    assert judge_outcome(worn, worn, good, None, False) is Outcome.RIGHT
    assert judge_outcome(worn, {Part.ONE_PIECE: "dress"}, good, None, False) is Outcome.WRONG
    assert judge_outcome(worn, worn | {Part.LOWER: "shorts"}, good, None, False) is Outcome.WRONG
    assert judge_outcome(worn, worn, good | {"lower": 0.3}, None, False) is Outcome.WRONG
    assert judge_outcome(worn, {}, good, "segment.unsure", False) is Outcome.DOUBTFUL
    assert judge_outcome(worn, {}, {}, "body.half", True) is Outcome.REFUSED


def make_file(with_faces: bool = True) -> tuple[RawFile, np.ndarray]:
    """Roll a sheet of 12 000 points into a tube; labels by height."""
    points, faces = sheet(80, 150)
    angle = points[:, 0] / points[:, 0].max() * 6.0
    rolled = np.stack([0.16 * np.sin(angle), points[:, 1], 0.16 * np.cos(angle)], axis=1)
    normals = np.stack([np.sin(angle), np.zeros_like(angle), np.cos(angle)], axis=1)
    colours = np.stack([points[:, 1] * 100, angle * 40, angle * 0.0], axis=1).astype(np.uint8)
    labels = dress(points, 0.3, 0.8, 1.3)
    return RawFile(rolled, faces if with_faces else faces[:0], normals, colours), labels


@pytest.mark.parametrize("with_faces", [True, False])
@pytest.mark.parametrize("state", SCAN_STATES, ids=lambda state: state.name)
def test_states_keep_labels_in_place(state, with_faces: bool) -> None:
    """Broken where a state left labels of other points, drew otherwise each time, or forgot the file's unit."""
    raw, labels = make_file(with_faces)
    once, kept = degrade_scan(raw, labels, state, 1.0)
    again, _ = degrade_scan(raw, labels, state, 1.0)
    assert len(once.points) == len(kept) and np.array_equal(once.points, again.points)
    assert not len(once.faces) or once.faces.max() < len(once.points)
    assert np.mean(kept == dress(once.points, 0.3, 0.8, 1.3)) > 0.97
    large, _ = degrade_scan(RawFile(2.0 * raw.points, raw.faces, raw.normals, raw.colours), labels, state, 0.5)
    assert np.array_equal(large.points, 2.0 * once.points)  # 2 is exact, so that no tie falls another way


def test_states_do_what_their_names_say() -> None:
    """Broken where a state were a name only."""
    raw, labels = make_file()
    found = {state.name: degrade_scan(raw, labels, state, 1.0)[0] for state in SCAN_STATES}
    assert found["as_is"] is not None and np.array_equal(found["as_is"].points, raw.points)
    shift = found["noise_5mm"].points - raw.points
    assert np.std(shift) == pytest.approx(0.005, rel=0.05) and found["noise_5mm"].normals is None
    assert len(found["holes_10"].faces) == pytest.approx(0.89 * len(raw.faces), rel=0.02)
    assert found["no_colours"].colours is None and raw.colours is not None
    assert len(found["decimated_10k"].points) == pytest.approx(10_000, rel=0.05)
    cloud = found["cloud_50k"]
    assert cloud.points.shape == (50_000, 3) and not len(cloud.faces) and cloud.normals is None
    assert cloud.colours is not None and len(cloud.colours) == 50_000


@pytest.mark.parametrize("with_faces", [True, False])
def test_files_come_back_as_they_were(with_faces: bool, tmp_path: Path) -> None:
    """Broken where points were merged or reordered, or normals and colours lost."""
    import trimesh

    raw, _ = make_file(with_faces)
    path = write_raw_file(raw, tmp_path / "scan.ply")
    back = read_raw_file(path)
    assert np.allclose(back.points, raw.points, atol=1e-6) and np.array_equal(back.faces, raw.faces)
    assert back.normals is not None and np.allclose(back.normals, raw.normals, atol=1e-6)
    assert np.array_equal(back.colours, raw.colours)
    bare = read_raw_file(write_raw_file(RawFile(raw.points, raw.faces), path))
    assert bare.normals is None and bare.colours is None
    assert len(trimesh.load(path, process=False).vertices) == len(raw.points)
    path.write_text("ply\n")
    with pytest.raises(BadInput):
        read_raw_file(path)


def test_raw_packs_are_told_by_their_files(tmp_path: Path) -> None:
    """Broken where a raw pack were taken for a garment's, or the other way round, or its truth misread."""
    make_raw_pack(tmp_path / "raw")
    other = tmp_path / "garment"
    other.mkdir()
    (other / "meta.json").write_text("{}")
    (other / "garment.ply").write_text("ply")
    assert [pack.name for pack in read_packs(tmp_path)] == ["garment"]
    (pack,) = read_raw_packs(tmp_path)
    assert pack.name == "raw" and read_raw_packs(tmp_path, ("garment",)) == ()
    assert [(each.part, each.category) for each in pack.garments] == [(Part.UPPER, "tshirt"), (Part.LOWER, "skirt")]
    assert pack.garments[0].template is None
    pattern = read_garment_pattern(pack.garments[0])
    assert pattern is not None and pattern.panels[0].name == "a"
    assert len(read_true_labels(pack)) == len(read_cover(pack)) == 6000
    assert read_visible(pack.garments[1]).all()
    points = read_raw_file(pack.scan).points @ pack.to_truth[:3, :3].T + pack.to_truth[:3, 3]
    assert np.allclose(points, sheet()[0], atol=1e-6)
    assert len(read_mesh_file(pack.garments[0].mesh)[1])
    with pytest.raises(BadInput):
        np.savez(pack.labels, other=np.zeros(3))
        read_true_labels(pack)
    (pack.folder / "truth" / "garments.json").write_text("[{}]")
    with pytest.raises(BadInput):
        read_raw_packs(tmp_path)


PACKS = Path(__file__).parents[3] / "shared" / "targets_raw"


@pytest.mark.skipif(not (PACKS / "score_raw.py").is_file(), reason="the raw packs and their scorer are not here")
def test_the_packs_own_scorer_finds_the_same(tmp_path: Path) -> None:
    """Broken where our measures are defined otherwise than the packs' scorer has them."""
    from garmentq.core.deliver.export.meshes import write_ply

    pack = read_raw_packs(PACKS, ("raw_tuck_cm_zup",))[0]
    truth, rng = read_true_labels(pack), np.random.default_rng(0)
    found = np.where(rng.random(len(truth)) < 0.1, rng.choice([0, 1, 2, 10, 11, 20], len(truth)), truth)
    names = np.full(21, "", dtype="<U16")
    for part in Part:
        names[part] = part.word
    np.savez(tmp_path / "labels.npz", label=found.astype(np.uint8), names=names)
    vertices, faces = read_mesh_file(pack.body)
    body = (vertices + rng.normal(0.0, 0.004, vertices.shape), faces)
    write_ply(*body, tmp_path / "body.ply")
    garment = pack.garments[1]
    nodes, triangles = read_mesh_file(garment.mesh)
    (tmp_path / "lower").mkdir()
    detail = (nodes * [1.01, 1.0, 1.01], triangles)
    write_ply(*detail, tmp_path / "lower" / "detail.ply")
    (tmp_path / "lower" / "manifest.json").write_text(json.dumps({"category": "skirt"}))
    command = [sys.executable, str(PACKS / "score_raw.py"), str(tmp_path), str(pack.folder), "--frame", "truth"]
    theirs = json.loads(subprocess.run(command, capture_output=True, check=True, text=True).stdout)
    labels = measure_labels(truth, found)
    assert theirs["labels"]["garment_or_not_iou"] == pytest.approx(labels.cloth_iou, abs=1e-4)
    iou = {"onepiece": "one-piece"}
    assert {iou.get(name, name): value for name, value in theirs["labels"]["iou"].items() if name != "not_garment"} == (
        pytest.approx(labels.part_iou, abs=1e-4)
    )
    for name, score in measure_true_body((vertices, faces), read_cover(pack), body).items():
        other = theirs["body"]["under_hair_or_shoes" if name == "hidden" else name]
        assert [other["mean_mm"], other["p95_mm"]] == pytest.approx([1e3 * score.mean, 1e3 * score.p95], abs=0.011)
    score = measure_visible(detail, (nodes, triangles), read_visible(garment))
    (found_one,) = theirs["garments"]
    assert found_one["category_right"] and found_one["role"] == "lower"
    assert found_one["rms_mm_detail_to_truth"] == pytest.approx(1e3 * score.s2t, rel=0.02)
    assert found_one["rms_mm_truth_to_detail"] == pytest.approx(1e3 * score.t2s, rel=0.02)
