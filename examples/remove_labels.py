"""Make what a scanner gives of a scan with labels: the same surface with its colours, and no label.

Run it as `python examples/remove_labels.py examples/data/person.ply demo/person.ply`; `make demo` does.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import trimesh


def main() -> None:
    """Write the scan without its labels."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("scan", type=Path, help="a PLY with labels")
    parser.add_argument("out", type=Path, help="the PLY to write")
    options = parser.parse_args()
    given = trimesh.load(options.scan, process=False)
    bare = trimesh.Trimesh(given.vertices, given.faces, process=False)
    bare.visual.vertex_colors = given.visual.vertex_colors
    options.out.parent.mkdir(parents=True, exist_ok=True)
    bare.export(options.out)
    print(f"{len(bare.vertices)} vertices without labels in {options.out}")


if __name__ == "__main__":
    main()
