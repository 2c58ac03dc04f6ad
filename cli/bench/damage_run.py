"""Recover one target pack under every damage, in a process of its own; print the results beside the clean run.

python -m garmentq.cli.bench.damage_run ORDER.json LINES.jsonl
"""

from __future__ import annotations

import json
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..terminal import print_table
from .lines import Line, append_lines, keep_failure
from .table import mean

if TYPE_CHECKING:
    from ...core.run.hooks import Arrays
    from ...core.scan.scan import Scan
    from .damage import Damage
    from .packs import Pack

SHOWN_METRICS = (
    "surface_rms_mm.s2t",
    "surface_rms_mm.t2s",
    "normal_cosine",
    "flipped_faces",
    "self_intersecting_faces",
)
"""Metrics of a line, all against the clean truth."""

SAME_TARGET_TOLERANCE = 1e-6
"""Distance of positions below which two targets are the same [m]: float32 in another unit or axis rounds to a tenth of
it."""


@dataclass(frozen=True)
class DamageOrder:
    """Describe the runs of a study.

    Attributes:
        pack: The target's folder.
        damages: Names of damages; empty: every one.
        presets: Weights of the deformation.
        seed: Seed of the damages and the recovery.
    """

    pack: str
    damages: tuple[str, ...] = ()
    presets: tuple[str, ...] = ("default", "thesis")
    seed: int = 0


def study_pack(order: DamageOrder, write: Callable[[Line], None]) -> None:
    """Recover a pack under every damage and preset; pass each line to `write` as soon as it is known.

    The body is registered once if its file is the same. A damage whose repaired target equals the clean one, vertex by
    vertex and face by face, has the clean run's figures. The graded drape does not depend on the preset and is shared
    between presets. Everything else is computed again.
    """
    from .damage import DAMAGES
    from .packs import read_packs

    pack = read_packs(Path(order.pack))[0]
    with tempfile.TemporaryDirectory(prefix="garmentq-damage-") as folder:
        study = _Study(pack, order.seed, Path(folder))
        for damage in DAMAGES:
            for preset in order.presets if damage.name in order.damages or not order.damages else ():
                line = empty_line(pack.name, damage.name, preset)
                with keep_failure(line):
                    line |= study.recover(damage, preset)
                write(line)


def empty_line(target: str, damage: str, preset: str) -> Line:
    """Return the line of a run without results yet."""
    return {
        "target": target,
        "damage": damage,
        "preset": preset,
        "ok": False,
        "error": None,
        "same_as_clean": False,
        "metrics": {},
        "untrusted": [],
        "cpu_seconds": None,
    }


@dataclass
class _Study:
    """Recover one pack repeatedly, and keep what the runs share.

    Attributes:
        pack: The target.
        seed: Seed of the damages and the recovery.
        folder: Folder for the damaged files.
        clean: The undamaged scan after its repair.
        lines: Results of the runs so far, by damage and preset.
        checkpoints: Arrays that the runs share, by name.
    """

    pack: Pack
    seed: int
    folder: Path
    clean: Scan | None = None
    lines: dict[tuple[str, str], Line] = field(default_factory=dict)
    checkpoints: dict[str, Arrays] = field(default_factory=dict)

    def recover(self, damage: Damage, preset: str) -> Line:
        """Return the figures of one run."""
        from ...core.deliver.export.result import to_plain_json
        from ...core.recover.inputs import read_files
        from ...core.recover.pipeline import recover
        from ...core.recover.recovery import Request
        from ...core.recover.settings import RecoverySettings
        from ...core.run.hooks import Hooks
        from .truth import measure_recovery

        garment, body = _damaged_files(self.pack, damage, self.seed, self.folder)
        settings = RecoverySettings(method="deform", preset=preset, seed=self.seed)
        request = Request(scan=garment, body=body, template=self.pack.template, settings=settings)
        scan = read_files(request).garment
        if damage.name == "clean":
            self.clean = scan
        elif self.clean is not None and _is_same_target(scan, self.clean) and ("clean", preset) in self.lines:
            return {**self.lines["clean", preset], "same_as_clean": True}

        def keep(name: str, arrays: Arrays) -> None:
            self.checkpoints[name if name == "body" else f"{name} {damage.name}"] = dict(arrays)

        def find(name: str) -> Arrays | None:
            return self.checkpoints.get(name if name == "body" else f"{name} {damage.name}")

        recovery = recover(request, Hooks(save_checkpoint=keep, load_checkpoint=find))
        own_template = self.pack.template is not None
        metrics, _ = measure_recovery(recovery, self.pack, own_template=own_template, seed=self.seed)
        untrusted = [contour.name for contour in recovery.target.contours if not contour.trusted]
        found: Line = to_plain_json(
            {"ok": True, "metrics": {name: metrics[name] for name in SHOWN_METRICS}, "untrusted": untrusted}
        )
        self.lines[damage.name, preset] = found
        return dict(found)


def _damaged_files(pack: Pack, damage: Damage, seed: int, folder: Path) -> tuple[Path, Path | None]:
    """Write the damaged garment, and the body if the damage changes it; return both paths."""
    from ...core.deliver.export.meshes import write_ply
    from .packs import read_true_mesh

    garment = folder / f"{damage.name}_garment.ply"
    vertices, faces = damage.apply(*read_true_mesh(pack), np.random.default_rng(seed))
    write_ply(vertices, faces, garment)
    if not damage.moves_body:
        return garment, pack.body
    body = folder / f"{damage.name}_body.ply"
    vertices, faces = damage.apply(*read_true_mesh(pack, pack.body), np.random.default_rng(seed))
    write_ply(vertices, faces, body)
    return garment, body


def _is_same_target(scan: Scan, clean: Scan) -> bool:
    """Return whether two scans have the same faces at the same positions."""
    return (
        scan.vertices.shape == clean.vertices.shape
        and np.array_equal(scan.faces, clean.faces)
        and float(np.abs(scan.vertices - clean.vertices).max()) < SAME_TARGET_TOLERANCE
    )


def print_study(lines: Sequence[Line]) -> None:
    """Print the table: each damage's distances to the clean truth in mm, both presets beside each other."""
    presets = list(dict.fromkeys(line["preset"] for line in lines))
    found = {(line["target"], line["damage"], line["preset"]): line for line in lines}
    rows: list[list[object]] = []
    for target, damage in dict.fromkeys((line["target"], line["damage"]) for line in lines):
        row: list[object] = [target, damage]
        for preset in presets:
            line = found.get((target, damage, preset), empty_line(target, damage, preset))
            values = [line["metrics"].get(name) for name in SHOWN_METRICS[:3]]
            row += [None if value is None else float(f"{value:.3g}") for value in values]
        undamaged = found[target, damage, presets[0]]
        note = undamaged["error"]["code"] if undamaged["error"] else "as clean" if undamaged["same_as_clean"] else ""
        rows.append([*row, ", ".join([note, *undamaged["untrusted"]]).strip(", ")])
    columns = ["target", "damage", *(f"{preset} {name}" for preset in presets for name in ("s2t", "t2s", "normal"))]
    print_table([*columns, "note"], rows, title="Damage (mm to the clean truth; listed contours are not trusted)")
    for preset in presets:
        worst = mean([line["cpu_seconds"] for line in lines if line["preset"] == preset and not line["same_as_clean"]])
        print_table(["preset", "mean CPU s of a run"], [[preset, worst and round(worst, 1)]])


def main(arguments: list[str]) -> None:
    """Read an order, append its lines."""
    order = DamageOrder(**json.loads(Path(arguments[0]).read_text(encoding="utf-8")))
    with append_lines(Path(arguments[1])) as write:
        study_pack(order, write)


if __name__ == "__main__":
    main(sys.argv[1:])
