"""Draw triangle meshes as shaded pictures: a small z-buffer with smooth normals, without a window system."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter

from ...geometry.geometry import vertex_normals
from ...run.kernels import kernel

OVERSAMPLING_FACTOR = 2
"""Number of pixels drawn per pixel shown, each way, which smooths edges."""

STUDIO_LIGHTS = (
    ((-0.55, 0.55, 0.62), 0.66),
    ((0.75, 0.10, 0.45), 0.22),
    ((0.10, -0.60, 0.55), 0.08),
)
"""Directions (right, up, towards the eye) and strengths [1] of the key, fill and floor lights, as in a studio."""

AMBIENT_LIGHT_STRENGTH = 0.27
"""Strength of the light from all directions, as a share of a surface's colour. With the three lights a surface that
faces the key light is just below white."""

RIM_LIGHT_STRENGTH = 0.10
"""Strength of the light along the outline [RGB, 0 to 1], which is added and separates the picture from its ground."""

CAVITY_SHADING_STRENGTH = 14.0
"""Darkening of a point per depth below its surroundings [1/m]; it makes folds visible."""


CAVITY_RADIUS = 0.015
"""Standard deviation of the weights by which a point's surroundings are averaged [m]."""

PNG_COMPRESSION_LEVEL = 3
"""Level of compression [1 to 9, as zlib]: half the time of 6, the default, for files that are a fifth larger."""


@dataclass(frozen=True)
class ColouredMesh:
    """Describe a mesh: vertices [m], shape [n, 3], faces, shape [m, 3], and RGB in 0..1, one or one per vertex, [n,
    3]."""

    vertices: np.ndarray
    faces: np.ndarray
    colours: np.ndarray


@dataclass(frozen=True)
class Camera:
    """Describe an orthographic camera.

    Attributes:
        rotation: World to (right, up, towards the eye), shape [3, 3].
        centre: Middle of the picture [m] in those axes, shape [2].
        pixels_per_metre: Scale.
        width: Picture's width [pixel].
        height: Picture's height [pixel].
    """

    rotation: np.ndarray
    centre: np.ndarray
    pixels_per_metre: float
    width: int
    height: int


def aim_camera(points: np.ndarray, rotation: np.ndarray, width: int, height: int, margin: float = 0.06) -> Camera:
    """Aim a camera so that all points [m], shape [n, 3], are in the picture with a margin (fraction of its size)."""
    seen = points @ rotation.T
    low, high = seen[:, :2].min(axis=0), seen[:, :2].max(axis=0)
    extent = np.maximum(high - low, 1e-6)
    scale = (1.0 - 2.0 * margin) * min(width / extent[0], height / extent[1])
    return Camera(rotation, 0.5 * (low + high), float(scale), width, height)


def rotate_view(rotation: np.ndarray, angle: float) -> np.ndarray:
    """Rotate a camera's rotation, shape [3, 3], so that the view turns by an angle about the vertical [rad]."""
    around = np.array([[np.cos(angle), 0.0, np.sin(angle)], [0.0, 1.0, 0.0], [-np.sin(angle), 0.0, np.cos(angle)]])
    found: np.ndarray = around @ rotation
    return found


@dataclass(frozen=True)
class Canvas:
    """Describe what is drawn so far, in fine pixels: depth [m], colour and normal of the nearest surface.

    Attributes:
        camera: Its camera.
        depth: Towards the eye [m], minus infinity where nothing is, shape [height, width].
        colour: RGB in 0..1, shape [height, width, 3].
        normal: In the camera's axes, not of unit length, shape [height, width, 3].
    """

    camera: Camera
    depth: np.ndarray
    colour: np.ndarray
    normal: np.ndarray

    @classmethod
    def empty(cls, camera: Camera) -> Canvas:
        """Return a canvas with nothing on it."""
        height, width = camera.height * OVERSAMPLING_FACTOR, camera.width * OVERSAMPLING_FACTOR
        return cls(
            camera, np.full((height, width), -np.inf), np.zeros((height, width, 3)), np.zeros((height, width, 3))
        )

    def with_meshes(self, surfaces: Sequence[ColouredMesh]) -> Canvas:
        """Return a canvas with surfaces drawn, too; nearer ones hide others."""
        found = Canvas(self.camera, self.depth.copy(), self.colour.copy(), self.normal.copy())
        for surface in surfaces:
            if len(surface.faces):
                _rasterise_mesh(surface, self.camera, found.depth, found.colour, found.normal)
        return found

    def shade(self) -> np.ndarray:
        """Return the picture, shaded from both sides: RGBA in 0..255, transparent where nothing is, uint8, shape
        [height, width, 4]."""
        lights = np.array([np.asarray(d) / np.linalg.norm(d) * strength for d, strength in STUDIO_LIGHTS])
        rgb, cover, nearest = _resolve(
            self.depth,
            self.colour,
            self.normal,
            lights,
            AMBIENT_LIGHT_STRENGTH,
            RIM_LIGHT_STRENGTH,
            OVERSAMPLING_FACTOR,
        )
        rgb *= _cavity(nearest, cover > 0.0, self.camera)[..., None]
        return (np.concatenate([np.clip(rgb, 0.0, 1.0), cover[..., None]], axis=2) * 255.0 + 0.5).astype(np.uint8)


def render_meshes(surfaces: Sequence[ColouredMesh], camera: Camera) -> np.ndarray:
    """Draw surfaces together; nearer ones hide others. Return the picture as `Canvas.shade` does."""
    return Canvas.empty(camera).with_meshes(surfaces).shade()


def png_base64(pixels: np.ndarray) -> str:
    """Return a picture as base64 text of a PNG file."""
    from PIL import Image

    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG", compress_level=PNG_COMPRESSION_LEVEL)
    return base64.b64encode(buffer.getvalue()).decode("ascii")


def _rasterise_mesh(
    surface: ColouredMesh, camera: Camera, depth: np.ndarray, colour: np.ndarray, normal: np.ndarray
) -> None:
    """Draw one surface's colour and normal into the buffers wherever it is nearest."""
    seen = surface.vertices @ camera.rotation.T
    scale = camera.pixels_per_metre * OVERSAMPLING_FACTOR
    screen = np.stack(
        [
            (seen[:, 0] - camera.centre[0]) * scale + 0.5 * depth.shape[1],
            0.5 * depth.shape[0] - (seen[:, 1] - camera.centre[1]) * scale,
            seen[:, 2],
        ],
        axis=1,
    )
    normals = vertex_normals(surface.vertices, surface.faces) @ camera.rotation.T
    colours = np.broadcast_to(surface.colours, surface.vertices.shape)
    attributes = np.ascontiguousarray(np.concatenate([colours, normals], axis=1), dtype=np.float64)
    faces = np.ascontiguousarray(surface.faces, dtype=np.int64)
    _rasterise(np.ascontiguousarray(screen), faces, attributes, depth, colour, normal)


@kernel()
def _rasterise(
    screen: np.ndarray,
    faces: np.ndarray,
    attributes: np.ndarray,
    depth: np.ndarray,
    colour: np.ndarray,
    normal: np.ndarray,
) -> None:
    """Fill each face's pixels where it is nearest, with colour and normal interpolated between its corners."""
    height, width = depth.shape
    for f in range(faces.shape[0]):
        i, j, k = faces[f, 0], faces[f, 1], faces[f, 2]
        a, b, c = screen[i], screen[j], screen[k]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        if abs(area) < 1e-12:
            continue
        left = max(0, int(np.floor(min(a[0], b[0], c[0]))))
        right = min(width - 1, int(np.ceil(max(a[0], b[0], c[0]))))
        top = max(0, int(np.floor(min(a[1], b[1], c[1]))))
        bottom = min(height - 1, int(np.ceil(max(a[1], b[1], c[1]))))
        for row in range(top, bottom + 1):
            for column in range(left, right + 1):
                x, y = column + 0.5, row + 0.5
                second = ((x - a[0]) * (c[1] - a[1]) - (y - a[1]) * (c[0] - a[0])) / area
                third = ((b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0])) / area
                first = 1.0 - second - third
                if second < 0.0 or third < 0.0 or first < 0.0:
                    continue
                z = first * a[2] + second * b[2] + third * c[2]
                if z > depth[row, column]:
                    depth[row, column] = z
                    for axis in range(3):
                        p, q = axis, axis + 3
                        colour[row, column, axis] = (
                            first * attributes[i, p] + second * attributes[j, p] + third * attributes[k, p]
                        )
                        normal[row, column, axis] = (
                            first * attributes[i, q] + second * attributes[j, q] + third * attributes[k, q]
                        )


@kernel()
def _resolve(
    depth: np.ndarray,
    colour: np.ndarray,
    normal: np.ndarray,
    lights: np.ndarray,
    ambient: float,
    rim: float,
    n: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Light every fine pixel and average n x n of them; return RGB, cover and nearest depth of each pixel shown."""
    height, width = depth.shape[0] // n, depth.shape[1] // n
    rgb = np.zeros((height, width, 3))
    cover = np.zeros((height, width))
    nearest = np.full((height, width), -np.inf)
    for row in range(height * n):
        for column in range(width * n):
            if depth[row, column] == -np.inf:
                continue
            x, y, z = normal[row, column]
            length = max(np.sqrt(x * x + y * y + z * z), 1e-9)
            if z < 0.0:  # cloth is seen from both sides
                length = -length
            x, y, z = x / length, y / length, z / length
            light = ambient
            for m in range(lights.shape[0]):
                light += max(lights[m, 0] * x + lights[m, 1] * y + lights[m, 2] * z, 0.0)
            edge = rim * (1.0 - z) ** 3
            r, c = row // n, column // n
            cover[r, c] += 1.0
            nearest[r, c] = max(nearest[r, c], depth[row, column])
            for axis in range(3):
                rgb[r, c, axis] += colour[row, column, axis] * light + edge
    for r in range(height):
        for c in range(width):
            if cover[r, c] > 0.0:
                for axis in range(3):
                    rgb[r, c, axis] /= cover[r, c]
                cover[r, c] /= n * n
    return rgb, cover, nearest


def _cavity(depth: np.ndarray, seen: np.ndarray, camera: Camera) -> np.ndarray:
    """Darken points that are deeper than their surroundings within 1.5 cm; factor of shape [height, width]."""
    radius = CAVITY_RADIUS * camera.pixels_per_metre
    weight = gaussian_filter(seen.astype(np.float32), radius, truncate=3.0)
    total = gaussian_filter(np.where(seen, depth, 0.0).astype(np.float32), radius, truncate=3.0)
    around = total / np.maximum(weight, 1e-6)
    # A step to something far behind is an outline and not a fold: the darkening is clamped at 2 cm.
    return 1.0 - np.clip(CAVITY_SHADING_STRENGTH * np.where(seen, around - depth, 0.0), -0.06, 0.28)
