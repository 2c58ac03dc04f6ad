"""Take steps of Adam (Kingma and Ba 2015), with a state that can be saved and resumed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FIRST_MOMENT_DECAY, SECOND_MOMENT_DECAY = 0.9, 0.999
"""Factors by which the first and the second moment decay, those of the authors and of the thesis (section 3.3.1)."""

ADAM_EPSILON = 1e-30
"""Number added to the root of the second moment: it keeps a parameter without any gradient in place."""


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
        """Return the initial state."""
        return cls(np.zeros(size), np.zeros(size))

    def step(self, gradient: np.ndarray, rates: np.ndarray) -> tuple[Adam, np.ndarray]:
        """Return the next state and the move -rate m / sqrt(v), shape [n], about `rates` large in each parameter."""
        first = FIRST_MOMENT_DECAY * self.first + (1.0 - FIRST_MOMENT_DECAY) * gradient
        second = SECOND_MOMENT_DECAY * self.second + (1.0 - SECOND_MOMENT_DECAY) * gradient**2
        count = self.count + 1
        mean, square = first / (1.0 - FIRST_MOMENT_DECAY**count), second / (1.0 - SECOND_MOMENT_DECAY**count)
        return Adam(first, second, count), -rates * mean / (np.sqrt(square) + ADAM_EPSILON)
