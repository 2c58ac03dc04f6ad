"""A sparse Cholesky factorisation by dense fronts (Duff and Reid 1983)."""

from __future__ import annotations

from copy import copy
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg.blas import dgemm, dsyrk, dtrsm, sgemm, ssyrk, strsm
from scipy.linalg.lapack import dpotrf, spotrf

from ..run.kernels import kernel
from .dissection import MAX_LEAF_NODE_COUNT, dissect
from .substitution import substitute

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix

MAX_LEAF_ROW_COUNT = 3 * MAX_LEAF_NODE_COUNT
"""Largest number of rows of a front that is not cut further: three for each of `MAX_LEAF_NODE_COUNT` nodes."""

MIN_BLAS_COLUMN_COUNT = 6
"""Smallest number of right sides that are solved together: at 1400 and 3800 nodes 4 to 6 take the time of as many
single ones, 40 a quarter of it."""

_SINGLE_KERNELS = (spotrf, strsm, ssyrk, sgemm)
_DOUBLE_KERNELS = (dpotrf, dtrsm, dsyrk, dgemm)
"""Factorisation of a dense block, triangular solve, and the two products, in either precision."""


class Cholesky:
    """Factor symmetric positive definite matrices that share a pattern, A = L L^T, by fronts over a nested dissection.
    Each part of the dissection is a front [F11 .; F21 F22]: own rows and boundary rows. F11 = L11 L11^T, L21 = F21
    L11^-T, and F22 - L21 L21^T is added to the parent's front, by BLAS. The pattern is analysed once."""

    def __init__(self, indptr: np.ndarray, indices: np.ndarray, block: int = 1, single: bool = False) -> None:
        """Order the nodes, lay out the fronts and map every entry of the matrix to its place in them.

        Args:
            indptr: Start of each row in `indices`, shape [row_count + 1].
            indices: Columns of each row, ascending; the full symmetric pattern with its diagonal, shape [entry_count].
            block: Rows of a node: 3 where entries come in dense blocks of 3 x 3. The dissection cuts between nodes.
            single: Factor and solve in single precision: half the time, seven digits less the matrix's condition.
        """
        self.single = single
        self._kernels = _SINGLE_KERNELS if single else _DOUBLE_KERNELS
        number = np.float32 if single else np.float64
        self._definite = False
        graph = indptr[::block].astype(np.int64) // block**2
        self._parts = dissect(graph, _neighbours(indptr, indices, block), max(1, MAX_LEAF_ROW_COUNT // block))
        order = np.concatenate([part.nodes for part in self._parts])
        self._order = (block * order[:, None] + np.arange(block)).ravel()
        sizes = np.array([block * len(part.nodes) for part in self._parts])
        rest = np.array([block * len(part.boundary) for part in self._parts])
        starts = np.concatenate([[0], np.cumsum(sizes * (sizes + rest))])
        self._fronts = [
            (int(starts[p]), int(sizes[p]), int(rest[p]), block * part.first) for p, part in enumerate(self._parts)
        ]
        self._store = np.zeros(int(starts[-1]), number)
        self._rows = [(block * part.boundary[:, None] + np.arange(block)).ravel() for part in self._parts]
        self._joined = np.concatenate(self._rows)
        places = np.cumsum(rest) - rest
        self._layout = np.column_stack([np.array(self._fronts), places])
        self._pattern = (indptr, indices)
        self._map_entries(indptr, indices)
        self._places = _plan_storage([part.parent for part in self._parts], rest**2)
        self._passed = np.zeros(int((self._places + rest**2).max()), number)
        self._links = []
        for rows, part in zip(self._rows, self._parts, strict=True):
            if part.parent < 0:
                self._links.append(rows[:0])
                continue
            up = self._fronts[part.parent]
            inside = rows < up[3] + up[1]
            above = up[1] + np.searchsorted(self._rows[part.parent], rows)
            self._links.append(np.where(inside, rows - up[3], above))

    def in_single(self) -> Cholesky:
        """Return a solver of the same pattern in single precision, which shares the analysis."""
        other = copy(self)
        other.single, other._definite, other._kernels = True, False, _SINGLE_KERNELS
        other._store, other._passed = self._store.astype(np.float32), self._passed.astype(np.float32)
        return other

    def _map_entries(self, indptr: np.ndarray, indices: np.ndarray) -> None:
        """Find the place of each lower entry of the permuted matrix; F11 then F21, each by columns."""
        new = np.zeros(len(self._order), dtype=np.int64)
        new[self._order] = np.arange(len(new))
        row = new[np.repeat(np.arange(len(new)), np.diff(indptr))]
        column = new[indices]
        source = np.flatnonzero(row >= column)
        row, column = row[source], column[source]
        firsts = np.array([front[3] for front in self._fronts])
        part = np.searchsorted(firsts, column, side="right") - 1
        target = np.zeros(len(source), dtype=np.int64)
        order = np.argsort(part, kind="stable")
        cuts = np.searchsorted(part[order], np.arange(len(firsts) + 1))
        for p, (start, n1, n2, first) in enumerate(self._fronts):
            members = order[cuts[p] : cuts[p + 1]]
            r, c = row[members] - first, column[members] - first
            low = r >= n1
            below = np.searchsorted(self._rows[p], row[members][low])
            place = start + c * n1 + r
            place[low] = start + n1 * n1 + c[low] * n2 + below
            target[members] = place
        self._source, self._target = source, target

    def factor(self, data: np.ndarray) -> bool:
        """Factor the matrix with these entries, in the order of `indices`; False where it is not positive definite."""
        store, (potrf, trsm, syrk, _) = self._store, self._kernels
        store[:] = 0.0
        store[self._target] = data[self._source]
        updates: list[list[tuple[np.ndarray, np.ndarray]]] = [[] for _ in self._parts]
        self._definite = False
        for p in range(len(self._fronts)):
            pivot, below, _ = self._front(p)
            n1, n2 = len(pivot), len(below)
            for update, link in updates[p]:
                _add_own(update, link, pivot, below)
            _, info = potrf(pivot, lower=1, clean=0, overwrite_a=1)
            if info != 0 or not np.isfinite(pivot[-1, -1]):
                return False
            if n2:
                trsm(1.0, pivot, below, side=1, lower=1, trans_a=1, overwrite_b=1)
                place = self._places[p]
                rest = self._passed[place : place + n2 * n2].reshape((n2, n2), order="F")
                syrk(-1.0, below, c=rest, lower=1, overwrite_c=1)
                for update, link in updates[p]:
                    _add_rest(update, link, n1, rest)
                updates[self._parts[p].parent].append((rest, self._links[p]))
            updates[p] = []
        self._definite = True
        return True

    def place(self, matrix: csr_matrix) -> np.ndarray | None:
        """Return a matrix's entries in the order of the pattern, 0 where it has none; None if one is outside."""
        matrix.sum_duplicates()
        data = np.zeros(len(self._pattern[1]))
        return data if _scatter_entries(matrix.indptr, matrix.indices, matrix.data, *self._pattern, data) else None

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Solve for one right side [n] or several [n, m] with the last factor."""
        if right.ndim == 2 and right.shape[1] >= MIN_BLAS_COLUMN_COUNT:
            return self._solve_columns(right)
        if right.ndim == 2:
            return np.stack([self.solve(column) for column in right.T], axis=1)
        x = np.ascontiguousarray(right[self._order], dtype=self._store.dtype)
        substitute(x, self._store, self._layout, self._joined, self._store.dtype.type(0.0))
        result = np.zeros(len(x))
        result[self._order] = x
        return result

    def _solve_columns(self, right: np.ndarray) -> np.ndarray:
        """Solve for several right sides [n, m] front by front, by BLAS 3: each front is read once for all."""
        _, trsm, _, gemm = self._kernels
        x = np.asfortranarray(right[self._order], dtype=self._store.dtype)
        for p in range(len(self._fronts)):
            pivot, below, own = self._front(p)
            x[own] = part = trsm(1.0, pivot, x[own], lower=1)
            if len(below):
                x[self._rows[p]] -= gemm(1.0, below, part)
        for p in reversed(range(len(self._fronts))):
            pivot, below, own = self._front(p)
            part = x[own]
            if len(below):
                part = part - gemm(1.0, below, x[self._rows[p]], trans_a=1)
            x[own] = trsm(1.0, pivot, part, lower=1, trans_a=1)
        result = np.zeros(right.shape)
        result[self._order] = x
        return result

    def _front(self, p: int) -> tuple[np.ndarray, np.ndarray, slice]:
        """Return L11 [n1, n1] and L21 [n2, n1] of a front, views of the store, and its own rows."""
        start, n1, n2, first = self._fronts[p]
        pivot = self._store[start : start + n1 * n1].reshape((n1, n1), order="F")
        below = self._store[start + n1 * n1 : start + n1 * (n1 + n2)].reshape((n2, n1), order="F")
        return pivot, below, slice(first, first + n1)

    def is_positive_definite(self) -> bool:
        """Return whether the last factored matrix was positive definite."""
        return self._definite


def _neighbours(indptr: np.ndarray, indices: np.ndarray, block: int) -> np.ndarray:
    """Return the nodes beside each node, from the first of its `block` rows and the first of each block's columns."""
    rows = np.repeat(np.arange(len(indptr) - 1), np.diff(indptr))
    found: np.ndarray = indices[(rows % block == 0) & (indices % block == 0)].astype(np.int64) // block
    return found


def _plan_storage(parents: list[int], sizes: np.ndarray) -> np.ndarray:
    """Place updates of these sizes in one store by first fit, each until its parent has received it. Allocating memory
    at every factorisation costs more than the arithmetic in it."""
    places = np.zeros(len(parents), dtype=np.int64)
    kept: list[int] = []
    for p, size in enumerate(sizes):
        end = 0
        for other in kept:
            if places[other] - end >= size:
                break
            end = places[other] + sizes[other]
        places[p] = end
        kept = sorted((q for q in [*kept, p] if parents[q] > p), key=lambda q: places[q])
    return places


@kernel()
def _scatter_entries(indptr, indices, values, pattern_indptr, pattern_indices, data):  # type: ignore[no-untyped-def]
    """Copy entries to their places in a wider pattern (columns ascend in both); False where one has none."""
    for row in range(len(indptr) - 1):
        place, end = pattern_indptr[row], pattern_indptr[row + 1]
        for at in range(indptr[row], indptr[row + 1]):
            while place < end and pattern_indices[place] < indices[at]:
                place += 1
            if place == end or pattern_indices[place] != indices[at]:
                return False
            data[place] = values[at]
    return True


@kernel()
def _add_own(update, link, columns, below):  # type: ignore[no-untyped-def]
    """Add a child's update to the columns that its parent eliminates; `link` ascends."""
    n1, count = columns.shape[0], len(link)
    inner = np.searchsorted(link, n1)
    for c in range(inner):
        column = link[c]
        for r in range(c, inner):
            columns[link[r], column] += update[r, c]
        for r in range(inner, count):
            below[link[r] - n1, column] += update[r, c]


@kernel()
def _add_rest(update, link, n1, rest):  # type: ignore[no-untyped-def]
    """Add a child's update to the update of its parent; `link` ascends."""
    count = len(link)
    for c in range(np.searchsorted(link, n1), count):
        column = link[c] - n1
        for r in range(c, count):
            rest[link[r] - n1, column] += update[r, c]
