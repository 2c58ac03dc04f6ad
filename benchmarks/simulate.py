"""Time the simulator's kernels and solvers against a naive assembly, SuperLU and the thesis' table 3.1.

Run with one thread: OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/simulate.py
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
import scipy.sparse as sparse
from garmentq.core.body import DistanceGrid
from garmentq.core.simulate import Energy, Inertia, SuperLU, Topology, get_fabric, make_solver, settle

SIDES = {"1K": 32, "3K": 55, "8K": 90}
"""Nodes along each side of a square sheet of 60 cm."""

GOALS = {"1K": (2.5, 50.0), "3K": (12.0, 250.0), "8K": (35.0, 1100.0)}
"""Milliseconds to stay under: gradient, exact Hessian and assembly; factor and solve (scipy)."""

THESIS = {"1K": (59.4, 60.0), "3K": (228.6, 186.3)}
"""Thesis table 3.1: seconds for assembly and linear solve of 20 steps, forward and reverse, on an RTX 3090."""


def cpu_ms(work: Callable[[], object], repeats: int = 7) -> float:
    """Give the smallest CPU time of a few runs [ms], after one that compiles and warms up."""
    work()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return 1e3 * min(times)


def sheet_on_sphere(count: int) -> tuple[Energy, np.ndarray]:
    """Lay a square sheet over a sphere of 15 cm, so that contact is on for a good part of it."""
    axis = np.linspace(-0.3, 0.3, count)
    u, v = np.meshgrid(axis, axis, indexing="ij")
    flat = np.stack([u.ravel(), v.ravel()], axis=1)
    i = np.arange(count * count).reshape(count, count)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    faces = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    cells = np.arange(-0.3, 0.305, 0.01)
    points = np.stack(np.meshgrid(cells, cells, cells, indexing="ij"), axis=-1)
    grid = DistanceGrid.from_values(np.full(3, -0.3), 0.01, np.linalg.norm(points, axis=-1) - 0.15)
    topology, fabric = Topology.from_mesh(faces, flat[faces]), get_fabric("cotton_poplin")
    nodes = np.column_stack([flat[:, 0], np.full(len(flat), 0.153), -flat[:, 1]])
    nodes = settle(topology, fabric, nodes, grid=grid, steps=4).nodes
    return Energy(topology, fabric, grid, inertia=Inertia(nodes, 400.0)), nodes


def assemble_naively(topology: Topology, elements: tuple[np.ndarray, np.ndarray, np.ndarray]) -> sparse.csc_matrix:
    """Assemble element blocks as coordinates, summed by scipy in every step: what the static map replaces."""
    rows, columns, values = elements
    count = 3 * topology.node_count
    return sparse.coo_matrix((values, (rows, columns)), shape=(count, count)).tocsc()


def spread_elements(topology: Topology) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """List the coordinates of all 9 entries of every element's node pairs, with stand-in values."""
    rows, columns = [], []
    for nodes in (topology.faces, topology.hinges):
        k = nodes.shape[1]
        rows.append(np.repeat(nodes, k, axis=1).ravel())
        columns.append(np.tile(nodes, (1, k)).ravel())
    i, j = np.concatenate(rows), np.concatenate(columns)
    scalar_rows = (3 * i[:, None] + np.repeat(np.arange(3), 3)).ravel()
    scalar_columns = (3 * j[:, None] + np.tile(np.arange(3), 3)).ravel()
    return scalar_rows, scalar_columns, np.ones(len(scalar_rows))


def measure(name: str) -> dict[str, float]:
    """Measure one size; times in CPU ms."""
    energy, nodes = sheet_on_sphere(SIDES[name])
    topology, fixed = energy.topology, energy.fixed

    def full() -> np.ndarray:
        return topology.assemble(energy.hessian(nodes)[2], fixed)

    found = {"kernels": cpu_ms(full), "gradient": cpu_ms(lambda: energy.gradient(nodes))}
    blocks = energy.hessian(nodes, exact=False)[2]
    data = topology.assemble(blocks, fixed)
    found["assembly"] = cpu_ms(lambda: topology.assemble(blocks, fixed))
    elements = spread_elements(topology)
    found["naive assembly"] = cpu_ms(lambda: assemble_naively(topology, elements), 3)
    right = energy.gradient(nodes)[1].ravel()
    lu = SuperLU(topology.indptr, topology.indices)
    fronts = make_solver(topology)
    for key, solver in (("fronts", fronts), ("superlu", lu)):
        found[f"{key} factor"] = cpu_ms(lambda s=solver: s.factor(data), 5)
        found[f"{key} solve"] = cpu_ms(lambda s=solver: s.solve(right))
    found["step"] = cpu_ms(lambda: step(energy, nodes, fronts), 5)
    return found


def step(energy: Energy, nodes: np.ndarray, solver) -> np.ndarray:  # type: ignore[no-untyped-def]
    """Take one linearised implicit step: what the thesis counts 20 of."""
    _, gradient, blocks = energy.hessian(nodes, exact=False)
    solver.factor(energy.topology.assemble(blocks, energy.fixed))
    return nodes - solver.solve(gradient.ravel()).reshape(-1, 3)


def main() -> None:
    """Print the table."""
    found = {name: measure(name) for name in SIDES}
    print("CPU ms, one thread" + "".join(f"{name:>12}" for name in SIDES))
    for key in next(iter(found.values())):
        print(f"{key:18}" + "".join(f"{found[name][key]:12.2f}" for name in SIDES))
    print("-- against the goals (below 1 is met) and the alternatives")
    lines = {
        "kernels / goal": lambda n: found[n]["kernels"] / GOALS[n][0],
        "factor+solve/goal": lambda n: (found[n]["fronts factor"] + found[n]["fronts solve"]) / GOALS[n][1],
        "naive / assembly": lambda n: found[n]["naive assembly"] / found[n]["assembly"],
        "superlu / fronts": lambda n: (
            (found[n]["superlu factor"] + found[n]["superlu solve"])
            / (found[n]["fronts factor"] + found[n]["fronts solve"])
        ),
        "thesis / 20 steps": lambda n: THESIS[n][0] / (20e-3 * found[n]["step"]) if n in THESIS else float("nan"),
    }
    for title, ratio in lines.items():
        print(f"{title:18}" + "".join(f"{ratio(name):12.2f}" for name in SIDES))
    print("thesis: assembly and solve alone on an RTX 3090 (table 3.1); ours: everything on one CPU core.")


if __name__ == "__main__":
    main()
