"""Run the inverse loop or the deformer without one part at a time, in a process of its own (thesis tables 3.4, 4.3).

python -m garmentq.cli.bench.ablation ORDER.json LINES.jsonl
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..terminal import print_table
from .lines import Line, append_lines, keep_failure

if TYPE_CHECKING:
    import numpy as np

    from ...core.garment.garment import Garment
    from ...core.recover.case import Case
    from ...core.recover.deform.settings import DeformSettings
    from ...core.recover.state import RecoveryState
    from .packs import Pack

ABLATION_SAMPLE_COUNT = 10_000
"""Number of samples of each surface for the distances, which then scatter by about 1 %."""


ABLATION_VERTEX_COUNT = 2000
"""Number of vertices of the meshes: half of a recovery's, so that nine runs take 2 minutes; every row has the same."""

ABLATION_ADAM_ITERATIONS = (40, 30)
"""Largest numbers of Adam's iterations before and after the fabric is optimised too: enough for most of the descent;
every row has the same."""


@dataclass(frozen=True)
class Switch:
    """Describe one part and the settings that switch it off.

    Attributes:
        name: As in the thesis' table; `ours` has every part on.
        table: `3.4` (the inverse loop, dress) or `4.3` (the deformer, S01).
        thesis: Chamfer distance [1e-3 m2] and normal similarity there.
        descent: Changes of `InverseSettings`.
        deforming: Changes of `DeformSettings`.
        graded: False if the deformer starts from the drape of the base pattern.
    """

    name: str
    table: str
    thesis: tuple[float, float]
    descent: dict[str, Any] = field(default_factory=dict)
    deforming: dict[str, Any] = field(default_factory=dict)
    graded: bool = True


OURS = "ours"

SWITCHES = (
    Switch(OURS, "3.4", (0.110, 0.075)),
    Switch("w/o curvature CF", "3.4", (0.115, 0.085), descent={"curvature": 0.0}),
    Switch("w/o seam loss", "3.4", (0.117, 0.076), descent={"seam": 0.0}),
    Switch("w/o physics", "3.4", (0.113, 0.081), descent={"fabric_rate": 0.0}),
    Switch(OURS, "4.3", (0.047, 0.021)),
    Switch("w/o linear grading", "4.3", (0.188, 0.106), graded=False),
    Switch("w/o contour loss", "4.3", (0.088, 0.056), deforming={"contour": 0.0}),
    Switch("w/o normal consistency", "4.3", (0.124, 0.173), deforming={"normal": 0.0}),
    Switch("w/o bending loss", "4.3", (0.158, 0.052), deforming={"bending": 0.0}),
)
"""Every row of both tables. Without physics the later iterations run with the fabric unchanged."""


@dataclass(frozen=True)
class Ablation:
    """Describe the runs of an ablation.

    Attributes:
        pack: The target's folder.
        preset: Weights of the deformation.
        tables: The tables whose rows are run.
    """

    pack: str
    preset: str = "default"
    tables: tuple[str, ...] = ("3.4", "4.3")


def empty_line(target: str, switch: Switch | None = None) -> Line:
    """Return the line of a run without results yet."""
    return {
        "target": target,
        "table": None if switch is None else switch.table,
        "setting": None if switch is None else switch.name,
        "ok": False,
        "error": None,
        "metrics": {},
        "thesis": None if switch is None else dict(zip(KEY_METRICS, switch.thesis, strict=True)),
        "cpu_seconds": None,
    }


KEY_METRICS = ("chamfer_vertex_m2e3", "normal_cosine")
"""The measures of the thesis' tables; of the simulation mesh in 3.4, of the detail mesh in 4.3."""


def ablate_pack(order: Ablation, write: Callable[[Line], None]) -> None:
    """Recover a pack with every part on, and with each part off; pass each line to `write` as soon as it is known.

    All runs share the body, the graded drape and its mesh.
    """
    from .packs import read_packs

    pack, line = read_packs(Path(order.pack))[0], empty_line(Path(order.pack).name)
    stage: _Stage | None = None
    with keep_failure(line):
        stage = _Stage.of(pack, order.preset)
    if stage is None:
        write(line)
        return
    for switch in SWITCHES:
        if switch.table in order.tables:
            write(_run(stage, switch))


def _run(stage: _Stage, switch: Switch) -> Line:
    """Run one row; an error is stored in its line."""
    line = empty_line(stage.pack.name, switch)
    with keep_failure(line):
        line["metrics"] = stage.descend(switch) if switch.table == "3.4" else stage.deform(switch)
        line["ok"] = True
    return line


@dataclass(frozen=True)
class _Stage:
    """Describe what all rows of a pack share: the graded drape, and the drape of the base pattern."""

    pack: Pack
    case: Case
    graded: RecoveryState
    ungraded: Garment
    preset: DeformSettings

    @classmethod
    def of(cls, pack: Pack, preset: str) -> _Stage:
        """Run the steps up to the graded drape, and drape the base pattern."""
        from ...core.recover.deform.settings import DeformSettings
        from ...core.recover.drape.stage import drape_graded, drape_template, remesh
        from ...core.recover.methods import GRADING_STEPS
        from ...core.recover.pipeline import run_steps
        from ...core.recover.recovery import Request
        from ...core.recover.settings import RecoverySettings
        from ...core.recover.start import choose_base, read_case
        from ...core.run.clock import Clock

        settings = RecoverySettings(method="deform", vertex_count=ABLATION_VERTEX_COUNT)
        clock = Clock()
        case = read_case(Request(pack.garment, pack.body, template=pack.template, settings=settings), clock)
        state = choose_base(case)
        worn = drape_template(state.base, state.wearer, state.target)
        ungraded = drape_graded(remesh(worn, ABLATION_VERTEX_COUNT), state.wearer, state.fabric, state.target)[0]
        return cls(pack, case, run_steps(GRADING_STEPS, case, state, clock), ungraded, DeformSettings.of_preset(preset))

    def descend(self, switch: Switch) -> dict[str, float | None]:
        """Run the inverse loop and measure its simulation mesh."""
        from ...core.recover.fit.descent import InverseSettings
        from ...core.recover.fit.inverse import fit_inverse
        from ...core.recover.state import made

        settings = InverseSettings(
            iterations=ABLATION_ADAM_ITERATIONS[0], fabric_iterations=ABLATION_ADAM_ITERATIONS[1]
        )
        found = made(fit_inverse(self.case, self.graded, replace(settings, **switch.descent)).garment)
        return self._measure(found, found.nodes)

    def deform(self, switch: Switch) -> dict[str, float | None]:
        """Run the deformer and measure the detail mesh."""
        from ...core.recover.deform.deformer import deform
        from ...core.recover.state import made

        start, state = made(self.graded.graded) if switch.graded else self.ungraded, self.graded
        settings = replace(self.preset, **switch.deforming)
        return self._measure(start, deform(start, state.target, state.wearer.exposed, settings=settings).nodes)

    def _measure(self, garment: Garment, nodes: np.ndarray) -> dict[str, float | None]:
        """Measure nodes against the truth as it is in the file."""
        from ...core.geometry.geometry import vertex_normals
        from ...core.geometry.intersections import self_intersections
        from ...core.judge.chamfer import VertexCloud, chamfer_and_normals
        from ...core.judge.fit import measure_distance
        from ...core.judge.patterns import measure_seams
        from .packs import read_true_mesh

        truth = read_true_mesh(self.pack)
        cloud = VertexCloud(nodes, vertex_normals(nodes, garment.faces))
        chamfer, cosine = chamfer_and_normals(cloud, VertexCloud(truth[0], vertex_normals(*truth)))
        found = dict(zip(KEY_METRICS, (1e3 * chamfer, cosine), strict=True))
        crossing = float(len(self_intersections(nodes, garment.faces)))
        distances = measure_distance(nodes, garment.faces, *truth, samples=ABLATION_SAMPLE_COUNT)
        seams = {"seam_mismatch_mm": measure_seams(garment.pattern)["seam_mismatch_mm"]}
        return {**found, **distances, **seams, "self_intersecting_faces": crossing}


def print_ablation(lines: Sequence[Line]) -> None:
    """Print both tables, the thesis' figures beside ours, and whether each row changes in the thesis' direction."""
    for table, title in (("3.4", "the inverse loop, simulation mesh"), ("4.3", "the deformer, detail mesh")):
        rows: list[list[object]] = []
        for line, holds in judge_rows([line for line in lines if line["table"] == table]):
            shown = [*KEY_METRICS, "surface_rms_mm.s2t", "surface_rms_mm.t2s", "seam_mismatch_mm"]
            values = [line["metrics"].get(name) for name in [*shown, "self_intersecting_faces"]]
            numbers = [None if value is None else float(f"{value:.3g}") for value in values]
            rows.append([line["target"], line["setting"], *numbers, *line["thesis"].values(), holds])
        if rows:
            columns = [
                "target",
                "setting",
                "chamfer",
                "normal",
                "s2t",
                "t2s",
                "seams",
                "cross.",
                "thesis",
                "normal",
                "worse",
            ]
            print_table(columns, rows, title=f"Beside thesis table {table}: {title} (chamfer x 1e3 m2; mm)")
    failed = [line for line in lines if line["error"]]
    if failed:
        rows = [[line["target"], line["setting"], line["error"]["code"], line["error"]["message"]] for line in failed]
        print_table(["target", "setting", "error", "message"], rows, title="Failures")


def judge_rows(lines: Sequence[Line]) -> Iterator[tuple[Line, str]]:
    """Yield for each row which of the two measures got worse without the part; in the thesis both do, in every row."""
    hybrid = {line["target"]: line["metrics"] for line in lines if line["setting"] == OURS and line["ok"]}
    for line in lines:
        known = hybrid.get(line["target"])
        if line["setting"] == OURS or not line["ok"] or known is None:
            yield line, "" if line["ok"] else "failed"
            continue
        worse = [name for name in KEY_METRICS if line["metrics"][name] > known[name]]
        words = {0: "neither", 1: "chamfer" if worse == [KEY_METRICS[0]] else "normal", 2: "both"}
        yield line, words[len(worse)]


def main(arguments: list[str]) -> None:
    """Read an order, append its lines."""
    order = Ablation(**json.loads(Path(arguments[0]).read_text(encoding="utf-8")))
    with append_lines(Path(arguments[1])) as write:
        ablate_pack(order, write)


if __name__ == "__main__":
    main(sys.argv[1:])
