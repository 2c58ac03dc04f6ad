"""Sparsity pattern of a matrix whose entries couple nodes in 3x3 blocks, and the slots that elements add to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..run.kernels import kernel

ABSENT_BLOCK_SLOT = -(2**62)
"""Index of the slot of a block that is not in the pattern."""


class Derivatives(NamedTuple):
    """Arrays that the kernels add to: gradient [N], shape [node_count, 3], and Hessian blocks, [block_count, 3, 3]."""

    gradient: np.ndarray
    blocks: np.ndarray


@dataclass(frozen=True)
class BlockPattern:
    """Map node pairs to 3x3 blocks, and those to a symmetric sparse matrix (thesis 3.2.4.3); built once per mesh.

    **Deviation**: the thesis multiplies a sparse mapping matrix with the stack of element Jacobians. Here each element
    adds its 3x3 blocks to fixed slots, in a fixed order, which is faster on one CPU core.

    Attributes:
        diagonal: Slot of each node's diagonal block, shape [node_count].
        rows, columns: Node pair (row <= column) of each block, shape [block_count].
        places: Where the block and its transpose start in the matrix's data, shape [block_count, 2].
        stride: Entries in each scalar row of a node, shape [node_count].
        indptr, indices: Pattern of the symmetric scalar matrix of 3 node_count rows (its CSC is its CSR).
    """

    node_count: int
    diagonal: np.ndarray
    rows: np.ndarray
    columns: np.ndarray
    places: np.ndarray
    stride: np.ndarray
    indptr: np.ndarray
    indices: np.ndarray

    @classmethod
    def of(cls, node_count: int, *elements: np.ndarray) -> tuple[BlockPattern, tuple[np.ndarray, ...]]:
        """Number the distinct node pairs of elements and assign their blocks a place in one matrix.

        Args:
            node_count: Nodes.
            elements: Nodes of each kind of element, shape [count, k] each; every two nodes of an element are coupled.

        Returns:
            The pattern and, for each kind, the slot of each of an element's k (k + 1) / 2 upper blocks, ~slot where the
                block is added transposed.
        """
        upper_pairs = [np.triu_indices(nodes.shape[1]) for nodes in elements]
        everyone = np.arange(node_count)
        ends = [
            np.concatenate([*(nodes[:, pair[n]].ravel() for nodes, pair in zip(elements, upper_pairs, strict=True)),
                            everyone])
            for n in (0, 1)
        ]  # fmt: skip
        turned = ends[0] > ends[1]
        low, high = np.where(turned, ends[1], ends[0]), np.where(turned, ends[0], ends[1])
        keys, slots = np.unique(low * node_count + high, return_inverse=True)
        slots = np.where(turned, ~slots, slots)
        sizes = [len(nodes) * len(pair[0]) for nodes, pair in zip(elements, upper_pairs, strict=True)]
        parts = np.split(slots, np.cumsum(sizes))[: len(sizes)]
        rows, columns = keys // node_count, keys % node_count
        upper = rows < columns
        # every block of the full matrix, in row order: the upper ones, and the transposes of those off the diagonal
        full_rows, full_columns = np.concatenate([rows, columns[upper]]), np.concatenate([columns, rows[upper]])
        order = np.lexsort((full_columns, full_rows))
        degree = np.bincount(full_rows, minlength=node_count)
        first = np.concatenate([[0], np.cumsum(degree)])
        place = np.zeros(len(order), dtype=np.int64)
        position = np.arange(len(order)) - first[full_rows[order]]
        place[order] = 9 * first[full_rows[order]] + 3 * position
        places = np.stack([place[: len(keys)], place[: len(keys)]], axis=1)
        places[upper, 1] = place[len(keys) :]
        stride = 3 * degree
        indptr = np.concatenate([[0], np.cumsum(np.repeat(stride, 3))])
        row_of_entry = np.repeat(np.arange(3 * node_count), np.repeat(stride, 3))
        offset = np.arange(indptr[-1]) - indptr[row_of_entry]
        indices = 3 * full_columns[order][first[row_of_entry // 3] + offset // 3] + offset % 3
        pattern = cls(
            node_count, np.flatnonzero(~upper), rows, columns, places, stride,
            indptr.astype(np.int32), indices.astype(np.int32),
        )  # fmt: skip
        return pattern, tuple(part.reshape(len(nodes), -1) for part, nodes in zip(parts, elements, strict=True))

    def find_slots(self, elements: np.ndarray) -> np.ndarray:
        """Return the slots of the upper blocks of elements [count, k], numbered as in `of`, [count, k (k + 1) / 2]. All
        blocks of an element that the pattern has no place for are `ABSENT_BLOCK_SLOT`."""
        return np.asarray(_find_slots(np.ascontiguousarray(elements), self.node_count, self._keys))

    @cached_property
    def _keys(self) -> np.ndarray:
        """Return one number per node pair of a block, ascending, shape [block_count]."""
        found: np.ndarray = self.rows * self.node_count + self.columns
        return found

    def assemble(self, blocks: np.ndarray, fixed: np.ndarray | None = None) -> np.ndarray:
        """Return the matrix's data from its blocks [block_count, 3, 3]; fixed nodes [node_count] get the identity."""
        data = np.zeros(len(self.indices))
        fixed = np.zeros(self.node_count, dtype=bool) if fixed is None else fixed
        _spread(blocks, (self.rows, self.columns), self.places, self.stride, fixed, data)
        return data


@kernel()
def _spread(blocks, pairs, places, stride, fixed, data):  # type: ignore[no-untyped-def]
    """Copy each block and its transpose to their places in the scalar matrix."""
    rows, columns = pairs
    for b in range(len(rows)):
        i, j = rows[b], columns[b]
        first, second = places[b, 0], places[b, 1]
        if fixed[i] or fixed[j]:
            if i == j:
                for d in range(3):
                    data[first + d * stride[i] + d] = 1.0
            continue
        for d in range(3):
            for e in range(3):
                value = blocks[b, d, e]
                data[first + d * stride[i] + e] = value
                if i != j:
                    data[second + e * stride[j] + d] = value


@kernel(inline="always")
def add_block(blocks, slot, block):  # type: ignore[no-untyped-def]
    """Add a 3x3 block to its slot, transposed where the slot is negative (~slot)."""
    if slot >= 0:
        for d in range(3):
            for e in range(3):
                blocks[slot, d, e] += block[d, e]
    else:
        for d in range(3):
            for e in range(3):
                blocks[~slot, e, d] += block[d, e]


@kernel()
def _find_slots(elements, node_count, keys):  # type: ignore[no-untyped-def]
    """Return the slots of elements by the ascending keys of all blocks; see `BlockPattern.find_slots`."""
    corners = elements.shape[1]
    slots = np.full((len(elements), corners * (corners + 1) // 2), ABSENT_BLOCK_SLOT, np.int64)
    for n in range(len(elements)):
        b = 0
        for i in range(corners):
            for j in range(i, corners):
                low, high = min(elements[n, i], elements[n, j]), max(elements[n, i], elements[n, j])
                slot_keys = low * node_count + high
                slot = np.searchsorted(keys, slot_keys)
                if b < 0 or slot == len(keys) or keys[slot] != slot_keys:
                    b = -1
                    continue
                slots[n, b] = ~slot if elements[n, i] > elements[n, j] else slot
                b += 1
        if b < 0:
            slots[n] = ABSENT_BLOCK_SLOT
    return slots
