"""Dress wearers in true patterns by the code that re-drapes recovered ones, and compare the distances from the scan.

What another simulator draped cannot be met exactly by ours, whatever the pattern: its folds fall elsewhere. The true
pattern, dressed from its flat panels on the same wearer in the cloth that was recovered, says how near one can come.

Takes the packs that have their own base pattern, whose panels and edges are those of the truth, and the results that
`garmentq bench PACKS --json --out RESULTS` kept. Run with one thread:
OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/redrape_truth.py PACKS RESULTS
"""

from __future__ import annotations

import argparse
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
from garmentq.cli.bench.packs import Pack, read_packs, read_true_mesh, read_true_pattern
from garmentq.core.garment.curves import unit_points
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.judge.crossings import count_crossings
from garmentq.core.judge.fit import measure_distance
from garmentq.core.judge.true_pattern import TruePanel
from garmentq.core.recover.drape.stage import redrape
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.recover.start import choose_base, read_case
from garmentq.core.recover.state import RecoveryState
from garmentq.core.reuse.wear.worn import load_worn
from garmentq.core.run.clock import Clock
from garmentq.core.run.hooks import SILENT_HOOKS

HANDLE_SAMPLES = 64
"""Points of a true edge that its cubic curve is fitted to."""


def draw_truth(base: Pattern, panels: tuple[TruePanel, ...]) -> Pattern:
    """Return the base pattern with the truth's panels drawn in it; placement and seams stay.

    Raises:
        ValueError: where the truth has other panels or edges.
    """
    true = {panel.name: panel for panel in panels}
    return replace(base, panels=tuple(_draw_panel(panel, true[panel.name]) for panel in base.panels))


def _draw_panel(panel: Panel, true: TruePanel) -> Panel:
    """Return a panel with a true one's edges, each as the cubic curve nearest to it, laid where the base panel lies.

    Of a clockwise panel the other side is drawn, as it is of a base pattern's when it is read.
    """
    if len(true.edges) != len(panel.edges):
        raise ValueError(f"panel '{panel.name}' has other edges in the truth")
    outline = np.concatenate([edge[:-1] for edge in true.edges])
    x, y = outline.T
    side = np.array([np.sign(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))), 1.0])
    lines = [edge * side for edge in true.edges]
    points = np.array([line[0] for line in lines])
    edges = tuple(_fit_edge(edge, line) for edge, line in zip(panel.edges, lines, strict=True))
    return replace(panel, points=points + panel.points.mean(axis=0) - points.mean(axis=0), edges=edges)


def _fit_edge(edge: Edge, line: np.ndarray) -> Edge:
    """Return an edge whose two handles bring a cubic curve nearest to a polyline [m], shape [n, 2]."""
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    places = np.linspace(0.0, along[-1], HANDLE_SAMPLES)
    line = np.stack([np.interp(places, along, line[:, k]) for k in range(2)], axis=1)
    chord = line[-1] - line[0]
    across = np.array([-chord[1], chord[0]])
    relative = (line - line[0]) @ np.stack([chord, across], axis=1) / (chord @ chord)
    if np.abs(relative[:, 1]).max() < 1e-4:
        return replace(edge, kind="line", handles=np.zeros((0, 2)))
    parameter = places / along[-1]
    for _ in range(10):  # the parameter of the nearest point changes with the curve
        t = parameter[:, None]
        weights = np.concatenate([3.0 * t * (1.0 - t) ** 2, 3.0 * t**2 * (1.0 - t)], axis=1)
        handles = np.linalg.lstsq(weights, relative - t**3 * np.array([1.0, 0.0]), rcond=None)[0]
        fitted = replace(edge, kind="cubic", handles=handles)
        dense = unit_points(fitted, 8 * HANDLE_SAMPLES)
        parameter = np.argmin(np.linalg.norm(dense[None] - relative[:, None], axis=2), axis=1) / (len(dense) - 1.0)
    return fitted


def dress_truth(pack: Pack, state: RecoveryState, vertices: int, result: Path) -> dict[str, float | str | None]:
    """Dress the wearer in the true pattern and in the recovered one, and measure both against the scan."""
    truth = read_true_pattern(pack)
    assert truth is not None
    worn = load_worn(result)
    surface = read_true_mesh(pack)
    line: dict[str, float | str | None] = {"target": pack.name}
    for name, pattern in (("true", draw_truth(state.base, truth.panels)), ("recovered", worn.pattern)):
        garment = mesh_pattern(pattern, vertices)
        draped, drape = redrape(garment, state.wearer, worn.fabric, state.target)
        nodes = draped.nodes
        distance = measure_distance(nodes, garment.faces, *surface)
        line[f"{name} [mm]"] = distance["surface_rms_mm.s2t"]
        line[f"{name} t2s [mm]"] = distance["surface_rms_mm.t2s"]
        line[f"{name} crossings"] = count_crossings(nodes, garment.faces, state.wearer.exposed)[
            "self_intersecting_faces"
        ]
        line[f"{name} outcome"] = drape.outcome.name
    return line


def main() -> None:
    """Print a line of JSON for each pack."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("packs", type=Path)
    parser.add_argument("results", type=Path)
    parser.add_argument("--only", action="append", default=[])
    options = parser.parse_args()
    for pack in read_packs(options.packs, tuple(options.only)):
        if pack.template is None or pack.scan is not None:
            continue
        request = Request(pack.garment, pack.body, pack.template, RecoverySettings())
        state, vertices = choose_base(read_case(request, Clock(SILENT_HOOKS))), request.settings.vertex_count
        print(json.dumps(dress_truth(pack, state, vertices, options.results / pack.name)), flush=True)


if __name__ == "__main__":
    main()
