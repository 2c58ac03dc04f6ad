"""Distinguish cloth in motion from cloth at rest: the drape at rest misses the scan, and a rotation explains it."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...body.body import Body
from ...cloth.fabric import Fabric
from ...cloth.outcome import Outcome
from ...cloth.scene import SteadyRotation
from ...cloth.statics import Drape, StopCallback
from ...garment.garment import Garment
from ...geometry.surface import TriangleSurface
from ...run.best import choose_best
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.contours.target import Target
from .stage import DrapeSettings, drape_graded, remesh
from .wearer import WearerGeometry


@dataclass(frozen=True)
class MotionSettings:
    """Describe when a scan counts as cloth in motion.

    Attributes:
        missed: Distance between drape and scan (RMS, the worse way) above which motion is considered [m]. Folds in
            other places cost garments at rest 6 to 17 mm; 25 mm is half as much again.
        rates: Angular velocities tried [rad/s], from a slow turn to two turns a second; the centrifugal force at 30 cm
            is 0.8, 2.0 and 4.4 times the weight. Beyond, only the stretch grows.
        explained: Share of the distance at rest above which a rotation does not explain it; 0.7 halves the squares.
        tolerance: Share by which rotations' distances may differ for the slowest to be taken: more speed pulls on a
            flounce that stands out without changing its shape.
        vertices: Number of vertices of the meshes on which rotations are compared; 1000 come to rest in 1 to 2 s.
        patience: Number of factorisations after which a drape is stopped that misses the scan by `stop_ratio`: of eight
            garments seven were at rest by then or nearer than 20 mm; the skirt in motion was 40 mm away.
        stop_ratio: Ratio of that distance to `missed`: cloth that still moves may come nearer by some millimetres.
    """

    missed: float = 0.025
    rates: tuple[float, ...] = (5.0, 8.0, 12.0)
    explained: float = 0.7
    tolerance: float = 0.1
    vertices: int = 1000
    patience: int = 40
    stop_ratio: float = 1.2


def drape_as_scanned(
    graded: Garment,
    wearer: WearerGeometry,
    fabric: Fabric,
    target: Target,
    *,
    vertex_count: int = 4000,
    settings: DrapeSettings = DrapeSettings(),  # noqa: B008 - frozen
    motion: MotionSettings = MotionSettings(),
    hooks: Hooks = SILENT_HOOKS,
) -> tuple[Garment, Drape]:
    """Drape a graded pattern at rest; in rotation where only that comes near the scan.

    Cloth that turns steadily with its wearer is at rest in the rotating frame, under its weight and omega^2 r outwards.
    The axis is vertical, through the wearer's pelvis, so omega is the only parameter. A garment at rest takes one
    drape, and its result is exactly that of `drape_graded`.

    Args:
        graded: The graded pattern's coarse mesh, nodes near the target.
        wearer: The wearer's geometry.
        fabric: The cloth.
        target: The scan.
        vertex_count: Vertices of the mesh.
        settings: Steps of each drape.
        motion: When a scan counts as cloth in motion.
        hooks: Progress and cancellation.

    Returns:
        The garment with named contours, and the drape; its `rotation` is set where one was accepted.
    """
    mesh = remesh(graded, vertex_count)
    coarse = replace(motion, vertices=min(motion.vertices, vertex_count))
    found: list[SteadyRotation | None] = []

    def drape_at(rotation: SteadyRotation | None, stop: StopCallback | None = None) -> tuple[Garment, Drape]:
        quiet = hooks if rotation is None else hooks.quiet()
        return drape_graded(mesh, wearer, fabric, target, rotation=rotation, stop=stop, settings=settings, hooks=quiet)

    def moves(legs: int, nodes: np.ndarray) -> bool:
        if legs != motion.patience or (rms := surface_rms(mesh.at(nodes), target)) <= motion.stop_ratio * motion.missed:
            return False
        found.append(find_rotation(graded, wearer, fabric, target, rms, settings, coarse, hooks))
        return found[-1] is not None

    garment, drape = drape_at(None, moves)
    rest = surface_rms(garment, target)
    if rest <= motion.missed:
        return garment, drape
    if not found:
        found.append(find_rotation(graded, wearer, fabric, target, rest, settings, coarse, hooks))
    if found[0] is None:
        return garment, drape
    turning = drape_at(found[0])

    def score(one: tuple[Garment, Drape]) -> float:
        """Return a drape's distance from the scan [m]; at rest, the distance that a rotation has to beat."""
        if one is not turning:
            return motion.explained * rest
        return surface_rms(one[0], target) if one[1].converged else float("inf")

    taken = choose_best("motion", {"turning": turning, "at rest": (garment, drape)}, score, hooks)
    return drape_at(None) if taken is not turning and drape.outcome is Outcome.STOPPED else taken


def find_rotation(
    graded: Garment,
    wearer: WearerGeometry,
    fabric: Fabric,
    target: Target,
    rest: float,
    settings: DrapeSettings,
    motion: MotionSettings,
    hooks: Hooks,
) -> SteadyRotation | None:
    """Find the slowest rotation that explains a scan which the drape at rest misses by a distance [m], or None."""
    mesh, found = remesh(graded, motion.vertices), []
    for rate in motion.rates:
        rotation = rotation_of(wearer.body, rate)
        quiet = hooks.quiet()
        coarse, _ = drape_graded(mesh, wearer, fabric, target, rotation=rotation, settings=settings, hooks=quiet)
        found.append((surface_rms(coarse, target), rotation))
    best = min(distance for distance, _ in found)
    if best > motion.explained * rest:
        return None
    return next(rotation for distance, rotation in found if distance <= (1.0 + motion.tolerance) * best)


def rotation_of(body: Body, rate: float) -> SteadyRotation:
    """Return the rotation of a wearer about a vertical axis through the pelvis at a rate [rad/s]."""
    x, y, z = (float(value) for value in body.joint("pelvis"))
    return SteadyRotation(rate, (x, y, z))


def describe_motion(rotation: SteadyRotation) -> str:
    """Return the note on a drape that was found in rotation."""
    return (
        "the cloth was in motion: at rest this pattern hangs far from the scan, turning at "
        f"{rotation.rate:.0f} rad/s it does not; the graded drape turns too, and the fabric cannot be estimated from "
        "cloth in motion."
    )


def surface_rms(garment: Garment, target: Target) -> float:
    """Return the root mean square distance [m] between two surfaces by their vertices, the worse of both ways."""
    ways = ((garment.nodes, target.vertices, target.faces), (target.vertices, garment.nodes, garment.faces))
    squares = [(TriangleSurface(nodes, faces).distance(points) ** 2).mean() for points, nodes, faces in ways]
    return float(np.sqrt(max(squares)))
