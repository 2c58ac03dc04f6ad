"""The tiling of a large sheet by sheets of paper."""

from __future__ import annotations

from dataclasses import dataclass

from .papers import Paper


@dataclass(frozen=True)
class Tile:
    """Describe one sheet of paper of a tiling: its row from the top and column from the left, from 0."""

    row: int
    column: int

    @property
    def name(self) -> str:
        """Return its label, A1 at the upper left."""
        letters, number = "", self.row + 1
        while number:
            number, rest = divmod(number - 1, 26)
            letters = chr(65 + rest) + letters
        return f"{letters}{self.column + 1}"


@dataclass(frozen=True)
class Tiling:
    """Describe a tiling: the part that each sheet of paper shows [mm], and the sheets that are not empty."""

    paper: Paper
    window: tuple[float, float]
    step: tuple[float, float]
    tiles: tuple[Tile, ...]
