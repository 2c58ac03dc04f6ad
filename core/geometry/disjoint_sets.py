"""Label the connected components of a graph."""

from __future__ import annotations

import numpy as np

from ..run.kernels import kernel


@kernel()
def label_components(first, second, labels):  # type: ignore[no-untyped-def]
    """Find components by disjoint sets, of which each has its first node for a root (Tarjan 1975).

    Args:
        first, second: The ends of each link, int64, shape [link_count].
        labels: Filled with the component of each node, numbered by their first nodes, int32, shape [count].

    Returns:
        The number of components.
    """
    count = len(labels)
    above = np.arange(count)
    for link in range(len(first)):
        a, b = first[link], second[link]
        while above[a] != a:
            above[a] = above[above[a]]
            a = above[a]
        while above[b] != b:
            above[b] = above[above[b]]
            b = above[b]
        if a < b:
            above[b] = a
        else:
            above[a] = b
    number = 0
    for node in range(count):
        if above[node] == node:
            labels[node] = number
            number += 1
        else:
            labels[node] = labels[above[node]]
    return number
