"""Colours of what is worn are told from those that show the scan's own geometry."""

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.scan.colour_meaning import find_shown_geometry

BODY = builtin_body("builtin:female,height=1.70,pose=A")
POINTS, NORMALS = BODY.vertices, vertex_normals(BODY.vertices, BODY.faces)
HEIGHT = (POINTS[:, 1] - POINTS[:, 1].min()) / np.ptp(POINTS[:, 1])
RNG = np.random.default_rng(3)


def dress(noise: float = 0.04) -> np.ndarray:
    """Colour a person in a white top, black trousers and skin, with a light from the front above."""
    colours = np.full((len(POINTS), 3), 0.9)
    colours[HEIGHT < 0.55] = 0.1
    colours[(HEIGHT > 0.85) | (np.abs(POINTS[:, 0]) > 0.42)] = (0.8, 0.6, 0.5)
    light = 0.75 + 0.25 * np.clip(NORMALS @ np.array([0.0, 0.6, 0.8]), 0.0, 1.0)
    return np.clip(colours * light[:, None] + RNG.normal(0.0, noise, colours.shape), 0.0, 1.0)


def normals_as_colours(noise: float = 0.0) -> np.ndarray:
    """Colour each point by its normal, as PIFuHD does."""
    return np.clip(0.5 + 0.5 * NORMALS + RNG.normal(0.0, noise, NORMALS.shape), 0.0, 1.0)


def test_clothes_are_colours() -> None:
    """Breaks where a white top over black trousers, lit from one side, is taken for a map of heights or directions."""
    assert find_shown_geometry(POINTS, NORMALS, dress()) is None
    assert find_shown_geometry(POINTS, None, dress(noise=0.0)) is None


@pytest.mark.parametrize("noise", [0.0, 0.05])
def test_normals_are_no_colours(noise: float) -> None:
    """Breaks where a map of normals, of the whole person or behind only, is believed to show cloth."""
    shown = normals_as_colours(noise)
    assert find_shown_geometry(POINTS, NORMALS, shown) == "the directions of the surface"
    behind = np.where(NORMALS[:, 2:] < 0.0, shown, dress())
    assert find_shown_geometry(POINTS, NORMALS, behind) == "the directions of the surface"
    turned = np.stack([NORMALS[:, 2], NORMALS[:, 0], -NORMALS[:, 1]], axis=1)  # a file with another axis up
    assert find_shown_geometry(POINTS, NORMALS, 0.5 + 0.5 * turned) == "the directions of the surface"


def test_maps_of_heights_and_one_colour_are_no_colours() -> None:
    """Breaks where a colour map of heights or depths, or the grey of a viewer, is believed to show cloth."""
    rainbow = np.stack([np.clip(np.abs(4.0 * HEIGHT - k) - 0.5, 0.0, 1.0) for k in (3.0, 2.0, 1.0)], axis=1)
    assert find_shown_geometry(POINTS, NORMALS, rainbow) == "the place along an axis"
    assert find_shown_geometry(POINTS, None, np.full((len(POINTS), 3), 0.7)) == "one colour"
