"""The renderer: what is seen where."""

from __future__ import annotations

import base64
import io

import numpy as np
import pytest
import trimesh
from garmentq.core.deliver.export.picture import ColouredMesh, aim_camera, png_base64, render_meshes
from garmentq.core.deliver.export.views import ERROR_COLOUR_STOPS, error_colours
from PIL import Image

FRONT = np.eye(3)
RED, BLUE = np.array([0.9, 0.1, 0.1]), np.array([0.1, 0.1, 0.9])


def ball(centre: tuple[float, float, float], colour: np.ndarray, radius: float = 0.2) -> ColouredMesh:
    """Return a ball."""
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    return ColouredMesh(np.array(mesh.vertices) + centre, np.array(mesh.faces, dtype=np.int64), colour)


def test_a_ball_covers_its_disk() -> None:
    """Fails if scale, centre or margin were wrong: the picture of a ball is a disk of its radius, in the middle."""
    one = ball((1.0, 2.0, 3.0), RED)
    camera = aim_camera(one.vertices, FRONT, 120, 160, margin=0.1)
    assert camera.pixels_per_metre == pytest.approx(0.8 * 120 / 0.4, rel=1e-3)
    alpha = render_meshes([one], camera)[..., 3] / 255.0
    assert alpha.sum() == pytest.approx(np.pi * 48.0**2, rel=0.01)
    rows, columns = np.nonzero(alpha > 0.5)
    assert (rows.mean(), columns.mean()) == pytest.approx((79.5, 59.5), abs=0.3)


def test_nearer_hides_farther_whatever_the_order() -> None:
    """Fails if the later surface won: the red ball stands in front of the blue one, and behind it from the back."""
    near, far = ball((0.0, 0.0, 1.0), RED), ball((0.0, 0.0, 0.0), BLUE)
    camera = aim_camera(near.vertices, FRONT, 60, 60)
    for surfaces in ([near, far], [far, near]):
        middle = render_meshes(surfaces, camera)[30, 30]
        assert middle[0] > 2 * middle[2]
    behind = aim_camera(near.vertices, np.diag([-1.0, 1.0, -1.0]), 60, 60)
    middle = render_meshes([near, far], behind)[30, 30]
    assert middle[2] > 2 * middle[0]


def test_cloth_is_lit_from_both_sides_and_up_is_up() -> None:
    """Fails if a face seen from behind were black, or the picture stood on its head."""
    one = ball((0.0, 0.0, 0.0), np.array([0.5, 0.5, 0.5]))
    camera = aim_camera(one.vertices, FRONT, 80, 80)
    picture = render_meshes([one], camera)
    turned = render_meshes([ColouredMesh(one.vertices, one.faces[:, ::-1], one.colours)], camera)
    assert np.abs(picture.astype(int) - turned.astype(int)).max() <= 1
    assert picture[20, 30, :3].mean() > picture[60, 50, :3].mean() + 40  # the key light stands above, at the left


def test_a_png_comes_back_as_it_was() -> None:
    """Fails if the picture were encoded lossily or without its transparency."""
    picture = render_meshes(
        [ball((0.0, 0.0, 0.0), BLUE)], aim_camera(ball((0.0, 0.0, 0.0), BLUE).vertices, FRONT, 40, 50)
    )
    back = np.asarray(Image.open(io.BytesIO(base64.b64decode(png_base64(picture)))))
    assert np.array_equal(back, picture)


def test_the_colour_bar_gets_darker_all_the_way() -> None:
    """Fails if a large error looked like a small one in a black and white print."""
    light = error_colours(np.linspace(0.0, 1.0, 50)) @ [0.2126, 0.7152, 0.0722]
    assert (np.diff(light) < 0.0).all()
    assert error_colours(np.array([1.0]))[0] == pytest.approx(ERROR_COLOUR_STOPS[-1][1])
