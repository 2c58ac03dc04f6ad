"""A person dressed in shells around the built-in body is taken apart by `garmentq segment`, and its files read back."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from garmentq.cli.main import group
from garmentq.core.body.body import JOINTS
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.presence import SeveralPersons
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.people.garments import PartNotWorn, build_person_surface, extract_garment
from garmentq.core.people.hints import Hints
from garmentq.core.people.labels import has_names, read_parts
from garmentq.core.people.part import Part
from garmentq.core.people.person_input import PersonFiles, read_person_input
from garmentq.core.people.separate import label_person
from garmentq.core.people.separation import LabelledPerson
from garmentq.core.scan.contours.garment import segment_garment
from garmentq.core.scan.raw import RawScan
from shells import BODY, dress_in_shells

COLOURS = {
    Part.SKIN: (200, 165, 140), Part.HAIR: (60, 40, 30), Part.SHOES: (120, 30, 30),
    Part.UPPER: (60, 90, 180), Part.LOWER: (70, 75, 60),
}  # fmt: skip


@dataclass(frozen=True)
class Run:
    """The scan's file, the true label of each vertex, the folder that was written, and the printed answer."""

    path: Path
    label: np.ndarray
    out: Path
    found: dict


@pytest.fixture(scope="session")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """Dress the built-in body in a T-shirt over trousers, 20 and 12 mm from the skin, and take it apart once.

    It has hair, 20 mm high from the nape to the brow, and shoes of 12 mm.
    """
    shells, rng = dress_in_shells(), np.random.default_rng(0)
    faces, joint = shells.faces, dict(zip(JOINTS, shells.body.joints, strict=True))
    shod = shells.points[:, 1] < joint["left_ankle"][1] + 0.01
    haired = (shells.points[:, 1] > joint["neck"][1] + 0.04) & (shells.points[:, 2] < joint["neck"][2] + 0.05)
    label = np.select([shod, haired], [Part.SHOES, Part.HAIR], shells.label).astype(np.uint8)
    lift = np.select([shod, haired], [0.012, 0.020], 0.0)
    points = shells.points + lift[:, None] * vertex_normals(shells.points, faces)
    points = points + rng.normal(0.0, 0.001, shells.points.shape)
    colours = np.array([COLOURS[Part(value)] for value in label]) + rng.normal(0.0, 6.0, points.shape)
    folder = tmp_path_factory.mktemp("person")
    mesh = trimesh.Trimesh(points, faces, process=False, vertex_colors=colours.clip(0, 255).astype(np.uint8))
    mesh.export(folder / "person.ply")
    words = ["segment", str(folder / "person.ply"), "--out", str(folder / "out"), "--body", BODY, "--json"]
    answer = CliRunner().invoke(group, words, catch_exceptions=False)
    assert answer.exit_code == 0
    return Run(folder / "person.ply", label, folder / "out", json.loads(answer.stdout))


def test_parts_are_told_apart(run):
    """Broken where a sleeve or a leg is taken for skin, the shirt's hem lies elsewhere, or hair or shoes are lost."""
    label = np.load(run.out / "labels.npz")["label"]
    limits = {Part.SKIN: 0.975, Part.HAIR: 0.975, Part.SHOES: 0.985, Part.UPPER: 0.997, Part.LOWER: 0.975}
    assert set(np.unique(label)) == set(limits)
    for part, least in limits.items():
        both, either = (label == part) & (run.label == part), (label == part) | (run.label == part)
        assert both.sum() > least * either.sum(), part


def test_garments_and_their_hidden_ends(run):
    """Broken where the trousers' waist below the shirt counts as seen, or the shirt's hem on it as hidden."""
    garments = {garment["part"]: garment for garment in run.found["garments"]}
    assert {word: garment["category"] for word, garment in garments.items()} == {
        "upper": "tshirt",
        "lower": "trousers",
    }
    inferred = {
        word: {contour["name"] for contour in garment["contours"] if contour["is_inferred"]}
        for word, garment in garments.items()
    }
    assert "waist" in inferred["lower"] and "hem" not in inferred["upper"]
    assert run.found["outfits"][0]["parts"] == ["upper", "lower"] and run.found["problem"] is None


def test_files_are_read_by_others(run):
    """Broken where labels are not in the file's order, the coloured scan has other vertices, or a picture is empty."""
    with np.load(run.out / "labels.npz", allow_pickle=False) as kept:
        assert set(kept.files) == {"label", "confidence", "names", "origin", "place"}
        assert np.array_equal(kept["place"], np.arange(len(run.label)))
        assert kept["label"].dtype == np.uint8 and kept["label"].shape == kept["confidence"].shape == run.label.shape
        assert kept["names"][Part.ONE_PIECE] == "one-piece"
    mesh = trimesh.load(run.out / "segmented.ply", process=False)
    assert len(mesh.vertices) == len(run.label)
    sure = mesh.metadata["_ply_raw"]["vertex"]["data"]["confidence"]
    assert np.allclose(np.ravel(sure), np.load(run.out / "labels.npz")["confidence"])
    skin = np.flatnonzero(np.load(run.out / "labels.npz")["label"] == Part.SKIN)
    assert len(np.unique(mesh.visual.vertex_colors[skin], axis=0)) == 1
    assert len(trimesh.load(run.out / "body.ply", process=False).vertices) == len(builtin_body(BODY).vertices)
    assert (run.out / "picture.png").read_bytes()[:4] == b"\x89PNG"


@pytest.fixture(scope="session")
def mended(run) -> tuple[RawScan, np.ndarray, LabelledPerson]:
    """Read the labels back with the left hand called something else, and take the person apart by them."""
    raw, label = read_person_input(PersonFiles(run.path)).raw, read_parts(run.out / "labels.npz")
    label = np.where((label == Part.SKIN) & (raw.points[raw.place, 0] > 0.5), int(Part.OTHER), label).astype(np.uint8)
    return raw, label, label_person(raw, Hints(label=label, body=builtin_body(BODY)))


def test_mended_labels_come_back(run, mended):
    """Broken where given labels are changed, or a garment is found where none was given."""
    raw, label, separation = mended
    assert has_names(run.out / "labels.npz") and (label == Part.OTHER).any()
    np.testing.assert_array_equal(separation.label, label)
    assert [garment.part for garment in separation.garments] == [Part.UPPER, Part.LOWER]
    with pytest.raises(PartNotWorn):
        extract_garment(build_person_surface(raw, separation.body), separation, Part.OUTER)


def test_an_inferred_opening_is_not_trusted(mended):
    """Broken where the waist below the shirt's hem is fitted as if the trousers ended there."""
    raw, _, separation = mended
    reading = extract_garment(build_person_surface(raw, separation.body), separation, Part.LOWER)
    assert reading.body is separation.body and reading.category == "trousers"
    trusted = {c.name: c.trusted for c in segment_garment(reading.pieces.garment, reading.body).contours}
    assert trusted == {"leg.left": True, "leg.right": True, "waist": False}


def test_two_who_stand_apart_are_refused_before_any_fit(monkeypatch):
    """Broken where nobody reads how many persons' sizes were found, and two bodies are searched for 8 s."""
    import garmentq.core.people.separate as module

    monkeypatch.setattr(module, "fit_person", None)
    every = np.arange(3)
    raw = RawScan(np.eye(3), np.zeros((0, 3), int), None, False, None, None, every, every, pieces=2)
    with pytest.raises(SeveralPersons):
        label_person(raw)
