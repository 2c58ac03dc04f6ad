"""Adam, step by step (Kingma and Ba 2015), as a value that can be kept and taken up again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FIRST, SECOND = 0.9, 0.999
"""Decay of both moments, the authors' own and the thesis' (section 3.3.1)."""

TINY = 1e-30
"""Added to the second moment's root: only keeps a parameter without any gradient where it is."""


@dataclass(frozen=True)
class Adam:
    """Describe both moments of the gradient.

    Attributes:
        first, second: Decaying means of the gradient and of its square, shape [n].
        count: Steps taken.
    """

    first: np.ndarray
    second: np.ndarray
    count: int = 0

    @classmethod
    def of(cls, size: int) -> Adam:
        """Begin with no memory."""
        return cls(np.zeros(size), np.zeros(size))

    def step(self, gradient: np.ndarray, rates: np.ndarray) -> tuple[Adam, np.ndarray]:
        """Return the next state and the move -rate m / sqrt(v), shape [n], about `rates` large in each parameter."""
        first = FIRST * self.first + (1.0 - FIRST) * gradient
        second = SECOND * self.second + (1.0 - SECOND) * gradient**2
        count = self.count + 1
        mean, square = first / (1.0 - FIRST**count), second / (1.0 - SECOND**count)
        return Adam(first, second, count), -rates * mean / (np.sqrt(square) + TINY)
