"""Take out of an environment what may not be passed on with it: parts of wheels that garmentq does not import.

The Dockerfile runs `python deploy/prune.py` right after it installs, and its last stage takes the environment as it is
then. The wheel of libigl is under MPL-2.0 but for these modules: `copyleft` holds CGAL (GPL) and TetGen (AGPL), and
`triangle` holds Triangle (no commercial use).
"""

from __future__ import annotations

import shutil
import sys
import sysconfig
from pathlib import Path

REMOVED = {"igl": ("copyleft", "triangle")}
"""Folders of packages that are removed, by package."""

KEPT = {"igl": ("pyigl_core", "pyigl_embree", "pyigl_spectra", "pyigl_predicates", "pyigl_cycodebase")}
"""The compiled modules that stay: those of libigl itself and of Embree (Apache-2.0), Spectra (MPL-2.0), Shewchuk's
predicates (public domain) and cyCodeBase (MIT). Another one is looked at before it is passed on."""


def prune(packages: Path) -> list[str]:
    """Remove those folders from a folder of installed packages, with their lines in the wheel's list of files.

    Returns:
        The names of the files that went.

    Raises:
        SystemExit: where a folder is not there, or a compiled module is unknown: then the wheel is another one.
    """
    gone: list[str] = []
    for package, names in REMOVED.items():
        for name in names:
            folder = packages / package / name
            if not list(folder.rglob("*.so")):
                raise SystemExit(f"{folder} has no compiled module; look at what the wheel holds now.")
            gone += [path.relative_to(packages).as_posix() for path in folder.rglob("*") if path.is_file()]
            shutil.rmtree(folder)
        left = {path.name.split(".")[0] for path in (packages / package).rglob("*.so*")}
        if left != set(KEPT[package]):
            raise SystemExit(f"{package} has {sorted(left)}; look at the licences of what is new, then change KEPT.")
    for record in packages.glob("*.dist-info/RECORD"):
        lines = record.read_text(encoding="utf-8").splitlines(keepends=True)
        kept = [line for line in lines if line.split(",")[0] not in gone]
        if len(kept) < len(lines):
            record.write_text("".join(kept), encoding="utf-8")
    return gone


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(sysconfig.get_paths()["platlib"])
    print(f"removed {len(prune(folder))} files")
