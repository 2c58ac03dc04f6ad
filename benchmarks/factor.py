"""Time the ways to factor a symmetric sparse matrix on the systems that garmentq solves.

Run with one thread: OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/factor.py

Each row is one system of a T-shirt's mesh: its rows, then CPU ms of SuperLU (order and factor), and as multiples of it
of our own Cholesky: analysis of the pattern, factorisation, and solutions for three right sides beside SuperLU's.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator

import numpy as np
import scipy.sparse as sparse
from garmentq.core.cloth.topology import Topology
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.geometry import cotangent_laplacian, gradient_operator
from garmentq.core.geometry.linear import SuperLU
from garmentq.core.geometry.multifrontal import Cholesky
from garmentq.core.recover.grade.registration import bending_operators

SIZES = (1000, 3000, 8000)
"""Nodes of the mesh."""


def cpu_ms(work: Callable[[], object], repeats: int = 5) -> float:
    """Return the smallest CPU time of a few runs [ms], after one that compiles and warms up."""
    work()
    times = []
    for _ in range(repeats):
        start = time.process_time()
        work()
        times.append(time.process_time() - start)
    return 1e3 * min(times)


def systems(count: int) -> Iterator[tuple[str, sparse.csr_matrix, int]]:
    """Build the systems of a T-shirt of so many nodes: name, matrix, rows of a node."""
    garment = mesh_pattern(load_template("tshirt"), count)
    size = len(garment.nodes)
    topology = Topology.from_garment(garment)
    operator, areas = gradient_operator(garment.rest, garment.faces, size)
    laplacian = operator.T @ sparse.diags(np.repeat(areas, 2)) @ operator
    bending, mass = bending_operators(garment)
    pattern = topology.pattern
    blocks = sparse.csr_matrix((np.ones(len(pattern.indices)), pattern.indices, pattern.indptr))
    # stretch of 300 N/m on every pair of nodes that a face or a hinge couples
    stiff = sparse.diags(np.asarray(blocks.sum(axis=1)).ravel() + 1.0) - blocks
    yield "cloth, 3x3 blocks", sparse.csr_matrix(300.0 * stiff), 3
    yield "Laplacian", sparse.csr_matrix(laplacian + 1e-3 * sparse.identity(size)), 1
    yield "squared Laplacian", sparse.csr_matrix(bending + sparse.diags(mass) / 0.05**4), 1
    flat = cotangent_laplacian(garment.rest, garment.faces, size)
    assert abs(flat - laplacian).max() < 1e-6 * abs(flat).max()


def main() -> None:
    """Print the table."""
    print(f"{'system':20}{'rows':>8}{'SuperLU':>10}{'analysis':>10}{'factor':>8}{'solve':>8}")
    for count in SIZES:
        for name, matrix, block in systems(count):
            matrix.sort_indices()
            right = np.random.default_rng(0).normal(size=(matrix.shape[0], 3))
            lu, own = SuperLU(matrix.indptr, matrix.indices), Cholesky(matrix.indptr, matrix.indices, block)
            base = cpu_ms(lambda m=matrix, s=lu: s.factor(m.data))  # type: ignore[misc]
            solved = cpu_ms(lambda b=right, s=lu: s.solve(b))  # type: ignore[misc]
            analysis = cpu_ms(lambda m=matrix, k=block: Cholesky(m.indptr, m.indices, k), 3)  # type: ignore[misc]
            factor = cpu_ms(lambda m=matrix, s=own: s.factor(m.data))  # type: ignore[misc]
            solve = cpu_ms(lambda b=right, s=own: s.solve(b))  # type: ignore[misc]
            shares = (analysis / base, factor / base, solve / solved)
            print(
                f"{name:20}{matrix.shape[0]:8}{base:10.1f}"
                + "".join(f"{x:{w}.2f}" for x, w in zip(shares, (10, 8, 8), strict=True))
            )


if __name__ == "__main__":
    main()
