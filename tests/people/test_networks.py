"""The networks that ship: which file, what they may change, and what they know."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass
from hashlib import sha256

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.people.features import Features, describe_points
from garmentq.core.people.networks import (
    KINDS,
    NETWORK_FILE,
    WrongWeights,
    kinds_to_parts,
    limit_log_odds_change,
    load_ensemble,
    parts_to_kinds,
    predict_by_networks,
)
from garmentq.core.people.part import PARTS, Part
from garmentq.core.people.points import PersonPoints, sample_person
from garmentq.core.people.rules import tell_by_rules
from garmentq.core.scan.raw import RawScan
from scipy.spatial import cKDTree
from shells import BODY, dress_in_shells

GARMENT = slice(PARTS.index(Part.UPPER), PARTS.index(Part.ONE_PIECE) + 1)


@dataclass(frozen=True)
class Person:
    """A person in a T-shirt over trousers, sampled and described; the body is known."""

    body: Body
    points: PersonPoints
    features: Features
    label: np.ndarray


@pytest.fixture(scope="module")
def person() -> Person:
    """Dress the built-in body in shells."""
    body, shells = builtin_body(BODY), dress_in_shells()
    count = np.arange(len(shells.points))
    fit = Person(body, None, None, shells.label)
    points = sample_person(RawScan(shells.points, shells.faces, None, False, None, None, count, count), fit)
    return Person(body, points, describe_points(points, fit), shells.label)


def test_the_file_is_the_one_that_was_measured():
    """Broken where the weights were exchanged without what is known of them, or are too large to ship."""
    known = json.loads(NETWORK_FILE.with_suffix(".json").read_text())
    assert sha256(NETWORK_FILE.read_bytes()).hexdigest() == known["sha256"]
    assert NETWORK_FILE.stat().st_size <= 1_000_000
    assert len(known["seeds"]) == len(load_ensemble().networks)
    assert {"generator", "persons", "scans", "epochs", "kept"} <= set(known)


@pytest.mark.parametrize("how", ["cut", "other", "layout"])
def test_a_wrong_file_is_refused(tmp_path, how):
    """Broken where a damaged file, another training's, or one of another layout of features is run all the same."""
    path = tmp_path / "kinds.npz"
    known = json.loads(NETWORK_FILE.with_suffix(".json").read_text())
    with np.load(NETWORK_FILE) as kept:
        arrays = dict(kept)
    if how == "cut":
        path.write_bytes(NETWORK_FILE.read_bytes()[:-1])
    elif how == "other":
        np.savez(path, **arrays | {"0.part.bias": arrays["0.part.bias"] + 1})
    else:
        np.savez(path, **arrays | {"version": -1})
        known["sha256"] = sha256(path.read_bytes()).hexdigest()
    path.with_suffix(".json").write_text(json.dumps(known))
    with pytest.raises(WrongWeights):
        load_ensemble(path)


def test_it_tells_the_same_twice(person, tmp_path):
    """Broken where a run of the same samples, or the same file elsewhere, gives other parts."""
    for suffix in (".npz", ".json"):
        shutil.copy(NETWORK_FILE.with_suffix(suffix), tmp_path / f"kinds{suffix}")
    again = load_ensemble(tmp_path / "kinds.npz")
    first, second = (
        predict_by_networks(person.points, person.features, person, None, each) for each in (load_ensemble(), again)
    )
    assert (first == second).all()
    assert first.sum(axis=1) == pytest.approx(np.ones(len(first)))


def test_which_garment_is_left_to_the_rules(person):
    """Broken where the networks, which saw no jumpsuit, have a say in whether there is a waist, or make coats."""
    found = predict_by_networks(person.points, person.features, person, None, load_ensemble())
    rules = tell_by_rules(person.points, person.features, person)
    told = found[:, GARMENT] / found[:, GARMENT].sum(axis=1, keepdims=True)
    assert told == pytest.approx(rules.share[:, GARMENT])
    assert not found[:, PARTS.index(Part.OUTER)].any()
    assert np.abs(parts_to_kinds(found) - parts_to_kinds(rules.posterior)).max() > 0.2  # but the kinds are theirs, too


@pytest.mark.parametrize("kind", [Part.SKIN, Part.SHOES])
def test_sure_cloth_is_not_called_bare(kind):
    """Broken where networks outdo the rules where these are sure of cloth, or cannot where these are in doubt."""
    place = [next(k for k, parts in enumerate(KINDS) if part in parts) for part in (kind, Part.LOWER)]
    told = np.full((2, len(KINDS)), 1e-6)
    told[:, place[0]] = 1.0
    rules = np.full((2, len(KINDS)), 0.005)
    rules[0, place] = 0.005, 0.98
    rules[1, place] = 0.2, 0.785
    kept = limit_log_odds_change(told / told.sum(axis=1, keepdims=True), rules / rules.sum(axis=1, keepdims=True))
    assert list(kept.argmax(axis=1)) == [place[1], place[0]]
    assert kept[0, place[0]] / kept[0, place[1]] == pytest.approx(50 * 0.005 / 0.98)
    free = np.full((1, len(KINDS)), 0.2)
    assert limit_log_odds_change(free, np.array([[0.4, 0.1, 0.1, 0.3, 0.1]])) == pytest.approx(free)


def test_kinds_are_shared_out():
    """Broken where a kind's probability is lost or goes to another kind's parts."""
    rng = np.random.default_rng(4)
    share = np.zeros((5, len(PARTS)))
    share[:, GARMENT] = rng.dirichlet(np.ones(3), 5)
    kinds = rng.dirichlet(np.ones(len(KINDS)), 5)
    parts = kinds_to_parts(kinds, share)
    assert parts.sum(axis=1) == pytest.approx(np.ones(5))
    assert parts_to_kinds(parts) == pytest.approx(kinds)


def test_cloth_is_told_from_skin(person):
    """Broken where weights are run on inputs in another order: shells 2 cm from the body would be skin."""
    found = predict_by_networks(person.points, person.features, person, None, load_ensemble())
    cloth = found[:, GARMENT].sum(axis=1) > 0.5
    shells = dress_in_shells()
    true = np.isin(person.label[cKDTree(shells.points).query(person.points.positions)[1]], [10, 11])
    assert (cloth == true).mean() > 0.9
