"""Time the simulator's kernels and solvers against a naive assembly, SuperLU and the thesis' table 3.1.

Run with one thread: OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/simulate.py
"""

from __future__ import annotations

import numpy as np
import scipy.sparse as sparse
from garmentq.core.cloth.dynamics import take_time_steps
from garmentq.core.cloth.energy import Energy, Inertia
from garmentq.core.cloth.solver import make_solver
from garmentq.core.cloth.topology import Topology
from garmentq.core.geometry.linear import SuperLU
from sheet import SIDES, THESIS, quickest, sheet_on_ball

GOALS = {"1K": (2.5, 50.0), "3K": (12.0, 250.0), "8K": (35.0, 1100.0)}
"""Milliseconds to stay under: gradient, exact Hessian and assembly; factor and solve (scipy)."""


def assemble_naively(topology: Topology, elements: tuple[np.ndarray, np.ndarray, np.ndarray]) -> sparse.csc_matrix:
    """Assemble element blocks as coordinates, summed by scipy in every step: what the static map replaces."""
    rows, columns, values = elements
    count = 3 * topology.node_count
    return sparse.coo_matrix((values, (rows, columns)), shape=(count, count)).tocsc()


def spread_elements(topology: Topology) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """List the coordinates of all 9 entries of every element's node pairs, with stand-in values."""
    rows, columns = [], []
    for nodes in (topology.faces, topology.hinges.nodes):
        k = nodes.shape[1]
        rows.append(np.repeat(nodes, k, axis=1).ravel())
        columns.append(np.tile(nodes, (1, k)).ravel())
    i, j = np.concatenate(rows), np.concatenate(columns)
    scalar_rows = (3 * i[:, None] + np.repeat(np.arange(3), 3)).ravel()
    scalar_columns = (3 * j[:, None] + np.tile(np.arange(3), 3)).ravel()
    return scalar_rows, scalar_columns, np.ones(len(scalar_rows))


def measure(name: str) -> dict[str, float]:
    """Measure one size; times in CPU ms."""
    scene, nodes, _ = sheet_on_ball(SIDES[name])
    topology, fixed = scene.topology, scene.fixed
    nodes = take_time_steps(scene, nodes, steps=4).nodes
    energy = Energy(scene, inertia=Inertia(nodes, 400.0))

    def full() -> np.ndarray:
        return topology.assemble(energy.hessian(nodes)[2], fixed)

    found = {"kernels": quickest(full), "gradient": quickest(lambda: energy.gradient(nodes))}
    blocks = energy.hessian(nodes, exact=False)[2]
    data = topology.assemble(blocks, fixed)
    found["assembly"] = quickest(lambda: topology.assemble(blocks, fixed))
    elements = spread_elements(topology)
    found["naive assembly"] = quickest(lambda: assemble_naively(topology, elements), 3)
    right = energy.gradient(nodes)[1].ravel()
    lu = SuperLU(topology.pattern.indptr, topology.pattern.indices)
    fronts = make_solver(topology.pattern)
    for key, solver in (("fronts", fronts), ("superlu", lu)):
        found[f"{key} factor"] = quickest(lambda s=solver: s.factor(data), 5)
        found[f"{key} solve"] = quickest(lambda s=solver: s.solve(right))
    found["step"] = quickest(lambda: step(energy, nodes, fronts), 5)
    return found


def step(energy: Energy, nodes: np.ndarray, solver) -> np.ndarray:  # type: ignore[no-untyped-def]
    """Take one linearised implicit step: what the thesis counts 20 of."""
    _, gradient, blocks = energy.hessian(nodes, exact=False)
    solver.factor(energy.scene.topology.assemble(blocks, energy.scene.fixed))
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
