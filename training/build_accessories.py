"""Make `assets/accessories.npz`, hair, shoes and hats around the built-in body, from the CC0 MakeHuman assets.

Run it as `python -m garmentq.training.build_accessories FOLDER`, where FOLDER holds `base.obj`, `clothes` and `hair` of
makehumancommunity/makehuman-assets (CC0). The outfits among the clothes are not taken: they are kept for measuring.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

from .base_mesh import Mesh, read_base_mesh, read_worn

ASSET = Path(__file__).parent / "assets" / "accessories.npz"

STEP = 2.0e-4
"""Positions are kept to this length [m], as 16-bit numbers: a fifth of the least noise of a scan."""

KINDS = (("hair", "*", "hair"), ("clothes", "shoes*", "shoes"), ("clothes", "fedora*", "hat"))
"""Folder, name and kind of what is taken."""


def build(folder: Path, path: Path = ASSET) -> int:
    """Write the accessories and return their number."""
    base = read_base_mesh(folder / "base.obj")
    arrays: dict[str, np.ndarray] = {}
    for place, pattern, kind in KINDS:
        for item in sorted((folder / place).glob(pattern)):
            for mesh in sorted(item.glob("*.obj")):
                keep(arrays, f"{kind}.{mesh.stem}", read_worn(item, mesh.stem, base))
    np.savez_compressed(path, **arrays)
    return len(arrays) // 2


def keep(arrays: dict[str, np.ndarray], name: str, worn: Mesh) -> None:
    """Add a mesh to the arrays of a file."""
    arrays[f"{name}.vertices"] = np.round(worn[0] / STEP).astype(np.int16)
    arrays[f"{name}.faces"] = worn[1].astype(np.uint16)


def main() -> None:
    """Write the file from a folder."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder", type=Path)
    options = parser.parse_args()
    print(f"{build(options.folder)} accessories in {ASSET}, {ASSET.stat().st_size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
