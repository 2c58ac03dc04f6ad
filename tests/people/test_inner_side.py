"""The inner side of cloth that is seen through an opening is found, and the outer side is not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from garmentq.core.people.inner_side import find_inner_side


def tube(radius, low, high, inward=False, around=48, rows=25):
    """Return an open tube about the y axis, its normals outward or inward."""
    turn = 2 * np.pi * np.arange(around) / around
    up = np.linspace(low, high, rows)
    vertices = np.stack(
        [np.tile(radius * np.cos(turn), rows), np.repeat(up, around), np.tile(radius * np.sin(turn), rows)], axis=1
    )
    first = np.arange(around * (rows - 1))
    right = first - first % around + (first + 1) % around
    lower, upper = [first, first + around, right], [right, first + around, right + around]
    faces = np.concatenate([np.stack(lower, 1), np.stack(upper, 1)])
    return vertices, faces[:, ::-1] if inward else faces


def sleeve(inner_height):
    """Return a sleeve of 4 mm cloth around an arm, its inner side seen up to a height, and the two counts."""
    outer, inner = tube(0.09, 0.0, 0.3), tube(0.086, 0.0, inner_height, inward=True)
    vertices = np.concatenate([outer[0], inner[0]])
    faces = np.concatenate([outer[1], inner[1] + len(outer[0])])
    return SimpleNamespace(vertices=vertices, faces=faces), len(outer[0])


@pytest.fixture
def arm():
    vertices, faces = tube(0.05, -0.2, 0.5, rows=40)
    return SimpleNamespace(vertices=vertices, faces=faces)


def test_the_inner_side_of_a_sleeve_is_found_whole(arm):
    """Broken where the inner sheet stays in the garment, so that its contour lies up inside the sleeve."""
    whole, outer = sleeve(0.08)
    found = find_inner_side(whole, np.ones(len(whole.vertices), bool), arm)
    assert found[outer:].all() and not found[:outer].any()


def test_what_does_not_face_the_skin_stays(arm):
    """Broken where a second layer of cloth close outside the first is taken for an inner side."""
    first, second = tube(0.09, 0.0, 0.3), tube(0.098, 0.0, 0.3)
    whole = SimpleNamespace(
        vertices=np.concatenate([first[0], second[0]]), faces=np.concatenate([first[1], second[1] + len(first[0])])
    )
    assert not find_inner_side(whole, np.ones(len(whole.vertices), bool), arm).any()


def test_a_fold_without_an_outer_side_near_stays(arm):
    """Broken where cloth that only faces the skin, as the underside of a wide fold, is cut out of the garment."""
    outer, inner = tube(0.12, 0.0, 0.3), tube(0.08, 0.0, 0.08, inward=True)
    whole = SimpleNamespace(
        vertices=np.concatenate([outer[0], inner[0]]), faces=np.concatenate([outer[1], inner[1] + len(outer[0])])
    )
    assert not find_inner_side(whole, np.ones(len(whole.vertices), bool), arm).any()


def test_the_back_of_a_pleat_stays(arm):
    """Broken where one side of a pleat, which faces the skin before the pleat's other side, is cut out of a skirt."""
    whole, outer = sleeve(0.08)
    back = np.flatnonzero(whole.vertices[:, 0] > 0.06)  # an eighth to either side: it faces one way
    faces = whole.faces[np.isin(whole.faces, back).all(axis=1) | (whole.faces < outer).all(axis=1)]
    whole = SimpleNamespace(vertices=whole.vertices, faces=faces)
    own = np.isin(np.arange(len(whole.vertices)), faces)
    assert not find_inner_side(whole, own, arm).any()


def test_an_inner_side_of_which_a_part_is_nothing_known_is_found(arm):
    """Broken where patches of an inner side stay in the garment, for what lies between them was taken for no cloth."""
    whole, outer = sleeve(0.08)
    inner = np.arange(len(whole.vertices)) >= outer
    told = inner & (np.abs(whole.vertices[:, 0]) < 0.06)
    own = told | ~inner
    assert not find_inner_side(whole, own & (inner <= (whole.vertices[:, 2] > 0.0)), arm).any()
    found = find_inner_side(whole, own, arm, inner & ~told)
    np.testing.assert_array_equal(found, told)
