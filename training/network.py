"""The network of `core/people/networks.py` in torch, to be trained, and its weights as a file."""

from __future__ import annotations

import json
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn

from ..core.people.features import FEATURE_LAYOUT_VERSION
from ..core.people.limbs import Limb
from ..core.people.networks import (
    EXCHANGE_ROUND_COUNT,
    FILTER_DILATIONS,
    KINDS,
    LIMB_GROUPS,
    LIMB_SECTOR_COUNT,
    LIMB_STATION_COUNT,
    MAX_FEATURE_DEVIATION,
    OPPOSITE_LIMBS,
    RECTIFIER_SLOPE,
    TOTAL_CELL_COUNT,
    LimbCells,
    Network,
)
from ..core.people.part import GARMENTS, PARTS

WIDTH = 48
"""Numbers that a sample and a cell keep: 120,000 parameters in all, 0.25 MB in half precision."""


class PersonNetwork(nn.Module):
    """Predict part, tightness, distance to a border, and the garments that are worn."""

    def __init__(self, mean: np.ndarray, spread: np.ndarray, of_kinds: bool = False) -> None:
        """Take mean and spread of the features, shape [F] each, and whether it tells `KINDS` apart and not parts."""
        super().__init__()
        self.register_buffer("mean", torch.from_numpy(mean.astype(np.float32)))
        self.register_buffer("spread", torch.from_numpy(spread.astype(np.float32)))
        self.first, self.second = nn.Linear(len(mean), WIDTH), nn.Linear(WIDTH, WIDTH)
        for turn in range(EXCHANGE_ROUND_COUNT):
            self.add_module(f"round{turn}", Exchange())
        self.of_kinds = of_kinds
        self.part = nn.Linear(WIDTH, len(KINDS) if of_kinds else len(PARTS))
        self.tightness = nn.Linear(WIDTH, 2)
        self.border = nn.Linear(WIDTH, 1)
        self.present = nn.Linear(WIDTH, len(GARMENTS))
        self.bend = nn.LeakyReLU(RECTIFIER_SLOPE)

    def forward(self, values: torch.Tensor, cells: tuple[torch.Tensor, ...]) -> tuple[torch.Tensor, ...]:
        """Return logits [n, 8], log tightness and its log spread [n, 2], border distance [n], garments' logits [4].

        A network of kinds returns what is added to the rules' logarithms, [n, 5], instead of logits.
        """
        hidden = ((values - self.mean) / self.spread).clamp(-MAX_FEATURE_DEVIATION, MAX_FEATURE_DEVIATION)
        hidden = self.bend(self.second(self.bend(self.first(hidden))))
        for turn in range(EXCHANGE_ROUND_COUNT):
            hidden = hidden + getattr(self, f"round{turn}")(hidden, cells)
        return self.part(hidden), self.tightness(hidden), self.border(hidden)[:, 0], self.present(hidden.mean(dim=0))


class Exchange(nn.Module):
    """Pool samples to cells, filter along limbs, join with the other side and the whole, and hand back."""

    def __init__(self) -> None:
        """Make the layers, named as the file names them."""
        super().__init__()
        self.pool, self.mix = nn.Linear(2 * WIDTH + 1, WIDTH), nn.Linear(3 * WIDTH, WIDTH)
        for i, dilation in enumerate(FILTER_DILATIONS):
            self.add_module(f"along{i}", nn.Conv1d(WIDTH, WIDTH, 5, dilation=dilation, padding=2 * dilation))
        self.whole0, self.whole1 = nn.Linear(len(LIMB_GROUPS) * WIDTH, WIDTH), nn.Linear(WIDTH, WIDTH)
        self.back0, self.back1 = nn.Linear(3 * WIDTH, WIDTH), nn.Linear(WIDTH, WIDTH)
        self.bend = nn.LeakyReLU(RECTIFIER_SLOPE)

    def forward(self, hidden: torch.Tensor, cells: tuple[torch.Tensor, ...]) -> torch.Tensor:
        """Return what is added to the samples, shape [n, width]."""
        index, low, high, share = cells
        count = torch.zeros(TOTAL_CELL_COUNT).index_add_(0, index, torch.ones(len(index)))
        full = (count > 0).float()[:, None]
        mean = torch.zeros(TOTAL_CELL_COUNT, WIDTH).index_add_(0, index, hidden) / count.clamp(min=1)[:, None]
        spot = index[:, None].expand_as(hidden)
        highest = torch.zeros(TOTAL_CELL_COUNT, WIDTH).scatter_reduce(0, spot, hidden, "amax", include_self=False)
        cell = self.bend(self.pool(torch.cat([mean, highest, full], dim=1)))
        cell = cell.reshape(len(Limb), LIMB_SECTOR_COUNT, LIMB_STATION_COUNT, WIDTH)
        slices = cell.mean(dim=1, keepdim=True).expand_as(cell)
        cell = self.bend(self.mix(torch.cat([cell, slices, slices[list(OPPOSITE_LIMBS)]], dim=-1)))
        row = cell.reshape(-1, LIMB_STATION_COUNT, WIDTH).transpose(1, 2)
        for i in range(len(FILTER_DILATIONS)):
            row = row + self.bend(getattr(self, f"along{i}")(row))
        cell = row.transpose(1, 2).reshape(len(Limb), LIMB_SECTOR_COUNT, LIMB_STATION_COUNT, WIDTH)
        weight = full.reshape(len(Limb), LIMB_SECTOR_COUNT, LIMB_STATION_COUNT, 1)
        whole = torch.cat(
            [
                (cell[list(group)] * weight[list(group)]).sum(dim=(0, 1, 2)) / weight[list(group)].sum().clamp(min=1)
                for group in LIMB_GROUPS
            ]
        )
        whole = self.bend(self.whole1(self.bend(self.whole0(whole))))
        flat = cell.reshape(-1, WIDTH)
        near = flat[low] * (1 - share[:, None]) + flat[high] * share[:, None]
        return self.back1(self.bend(self.back0(torch.cat([hidden, near, whole.expand_as(hidden)], dim=1))))


def to_torch(cells: LimbCells) -> tuple[torch.Tensor, ...]:
    """Return cells as tensors."""
    return tuple(torch.from_numpy(np.ascontiguousarray(a)) for a in (cells.index, cells.low, cells.high, cells.share))


def save_weights(network: PersonNetwork, temperature: float, path: Path, about: dict[str, Any]) -> None:
    """Write the weights in half precision, and beside them what is known of them with the file's hash."""
    arrays: dict[str, Any] = {name: value.numpy().astype(np.float16) for name, value in network.state_dict().items()}
    arrays |= {name: network.state_dict()[name].numpy() for name in ("mean", "spread")}
    np.savez_compressed(path, version=FEATURE_LAYOUT_VERSION, temperature=temperature, **arrays)
    count = sum(value.numel() for value in network.parameters())
    about = {
        "sha256": sha256(path.read_bytes()).hexdigest(),
        "features": FEATURE_LAYOUT_VERSION,
        "parameters": count,
        **about,
    }
    path.with_suffix(".json").write_text(json.dumps(about, indent=1) + "\n", encoding="utf-8")


def load_network(path: Path) -> Network | None:
    """Read a network that a training wrote; None where there is none, or it reads another layout of features."""
    if not path.exists():
        return None
    with np.load(path) as kept:
        if int(kept["version"]) != FEATURE_LAYOUT_VERSION:
            return None
        weights = {name: kept[name].astype(np.float32) for name in kept.files if name not in ("version", "temperature")}
        return Network(weights, float(kept["temperature"]))
