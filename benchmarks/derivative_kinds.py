"""Describe the simulator's derivatives against central differences, one figure for each kind of parameter.

Run with one thread: OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/derivative_kinds.py
"""

from __future__ import annotations

import sys
import time

import numpy as np
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.cloth.contact import contact_forces
from garmentq.core.cloth.derivative import Derivative, ImplicitDerivative
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.parameters import Parameters, list_gathers
from garmentq.core.cloth.rest import NotAtRest
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.sensitivity import FABRIC_PARAMETERS
from garmentq.core.cloth.solver import make_solver
from garmentq.core.cloth.topology import Topology
from garmentq.core.cloth.unrolled import UnrolledSteps
from garmentq.core.garment.control import map_controls
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.symmetry import find_symmetry
from sheet import Laid

SIZES = {"1K": 1000, "3K": 3000, "8K": 8000}
"""Vertices of the mesh."""

STEPS = (1e-7, 5e-8, 2.5e-8)
"""Steps of control points [m] and gathers that are tried, of the fabric a hundred times as much: from where the
quotient's error begins to fall with the square of the step down to where round-off begins to grow."""

WAVES = (5.0, 7.0, 9.0, 13.0)
"""Waves a metre [rad/m] of the losses up . x, up = sin(wave x): of one loss a parameter's derivative may happen to be
nearly nothing, and round-off is then held against it; of four together it is not."""


def draw_pattern() -> Pattern:
    """Draw a yoke and a ruffle that is gathered to it by a tenth, with a curved hem: 60 cm wide, 60 cm long."""
    line, hem = Edge(), Edge("quadratic", np.array([[0.5, -0.08]]))
    yoke = np.array([[-0.3, 0.0], [0.3, 0.0], [0.3, 0.28], [-0.3, 0.28]])
    ruffle = np.array([[-0.33, -0.3], [0.33, -0.3], [0.33, 0.0], [-0.33, 0.0]])
    panels = (Panel("yoke", yoke, (line,) * 4), Panel("ruffle", ruffle, (hem, line, line, line)))
    return Pattern("apron", panels, (Seam(EdgeRef("yoke", 0), EdgeRef("ruffle", 2), gathered=True),))


def drape(count: int) -> tuple[Laid, dict[str, slice]]:
    """Lay the apron off-centre over a ball of 15 cm, bring it to rest, and name its parameters by kind."""
    garment = mesh_pattern(draw_pattern(), count)
    cells = np.arange(-0.45, 0.455, 0.01)
    points = np.stack(np.meshgrid(cells, cells, cells, indexing="ij"), axis=-1)
    ball = DistanceGrid.from_values(np.full(3, -0.45), 0.01, np.linalg.norm(points, axis=-1) - 0.15)
    # A flat sheet that is pressed in its plane does not know which way to fold: half a millimetre tells it.
    height = 0.153 + 5e-4 * np.random.default_rng(0).random(len(garment.nodes))
    nodes = np.column_stack([garment.nodes[:, 0] + 0.02, height, 0.01 - garment.nodes[:, 1]])
    scene = Scene(Topology.from_garment(garment), get_fabric("cotton_poplin"), ball)
    gathers = list_gathers(garment.pattern, find_symmetry(garment.pattern))
    parameters = Parameters.of_garment(garment, map_controls(garment), fabric=FABRIC_PARAMETERS, gathers=gathers)
    points_end = 2 * len(garment.pattern.points)
    first = points_end + len(gathers)
    kinds = {"control points": slice(0, points_end), "gather ratios": slice(points_end, first)}
    kinds |= {name: slice(first + n, first + n + 1) for n, name in enumerate(FABRIC_PARAMETERS)}
    return Laid.at_rest(scene, nodes, parameters), kinds


def differ(laid: Laid, start: np.ndarray, derivative: Derivative, ups: np.ndarray, step: float) -> np.ndarray:
    """Return the central differences of every up . x by every parameter, shape [count, losses]; nan if not at rest."""
    solver, parameters = make_solver(laid.scene.topology.pattern), laid.parameters
    found = np.full((parameters.count, len(ups)), np.nan)
    for n in range(parameters.count):
        way = np.zeros(parameters.count)
        way[n] = step if n < parameters.shape.shape[1] else 100.0 * step
        try:
            ends = laid.ends(derivative, way, start, solver)
        except NotAtRest:
            continue
        found[n] = (ups * (ends[0] - ends[1])).sum(axis=(1, 2)) / (2 * way[n])
    return found


def extrapolate(quotients: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Extrapolate central differences of halved steps to none, and give how far off that may be, shape [count].

    Richardson's table, in which each column takes out another even power of the step; of its entries that one counts
    which differs least from those it was made of (Ridders 1982). The derivative under test has no say in it.
    """
    row, best = [quotients[0]], quotients[0]
    least = np.full(len(best), np.inf)
    for quotient in quotients[1:]:
        before, row = row, [quotient]
        for column, coarse in enumerate(before):
            row.append(row[-1] + (row[-1] - coarse) / (4.0 ** (column + 1) - 1.0))
            off = np.maximum(np.linalg.norm(row[-1] - row[-2], axis=1), np.linalg.norm(row[-1] - coarse, axis=1))
            best = np.where((off < least)[:, None], row[-1], best)
            least = np.fmin(off, least)
    return best, least


def measure(count: int, derivative: Derivative) -> dict[str, str]:
    """Measure one size: for each kind the largest relative error of a parameter, and the difference quotient's own."""
    laid, kinds = drape(count)
    scene, start, solver = laid.scene, laid.nodes, make_solver(laid.scene.topology.pattern)
    if isinstance(derivative, ImplicitDerivative):
        start = derivative.solve(scene, start, solver, friction=laid.friction).nodes
    at = derivative.solve(scene, start, solver, friction=laid.friction)
    ups = np.stack([np.sin(wave * at.nodes[:, [1, 2, 0]] + [0.3, 0.5, 0.7]) for wave in WAVES])
    found = np.stack([laid.parameters.pull(scene, at.pull(up)) for up in ups], axis=1)
    expected, doubt = extrapolate([differ(laid, start, derivative, ups, step) for step in STEPS])
    size = np.linalg.norm(expected, axis=1)
    off, doubt = np.linalg.norm(found - expected, axis=1) / size, doubt / size
    touching = int((contact_forces(scene, at.nodes)[0] > 0).sum())
    rows = {kind: f"{off[part].max():.1e} ({doubt[part].max():.0e})" for kind, part in kinds.items()}
    return rows | {"touching": str(touching)}


def main(names: list[str]) -> None:
    """Print a row for each size and way; in brackets how far off the difference quotient itself may be."""
    for name in names:
        ways: dict[str, Derivative] = {"Implicit": ImplicitDerivative(tolerance=0.0)}
        if name == "1K":
            ways["Unrolled"] = UnrolledSteps(steps=6, tolerance=0.0)
        for way, derivative in ways.items():
            begun = time.process_time()
            print(name, way, measure(SIZES[name], derivative), flush=True)
            print(f"  {time.process_time() - begun:.0f} s of CPU", flush=True)


if __name__ == "__main__":
    main(sys.argv[1:] or list(SIZES))
