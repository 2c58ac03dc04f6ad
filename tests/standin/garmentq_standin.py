"""A quick stand-in for the pipeline, so that tests of the queue take seconds; what it does is in the scan's name.

`slow...` takes 4 s in 40 steps with a checkpoint after each 5, `gated...` does them at once but waits before those that
its test holds back (`hold_gate`), `crash...` dies of a signal, `bad...` is refused, `fault...` has a bug, `leave...`
ends its process, `short...` takes 0.1 s, `stuck...` takes 10 minutes and never asks whether it must stop, `deaf...`
takes no signal either, as compiled code does; everything else succeeds at once.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from garmentq.core.body.body import Body
from garmentq.core.cloth.fabric import Fabric
from garmentq.core.cloth.fabrics import DEFAULT_FABRIC
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.meshes import Meshes
from garmentq.core.garment.pattern import Edge, Panel, Pattern
from garmentq.core.garment.pieces.numbers import PieceNumbers
from garmentq.core.recover.recovery import STAGES, Recovery, Request
from garmentq.core.run.errors import BadInput, Cancelled
from garmentq.core.run.hooks import Hooks
from garmentq.core.run.report import ResultReport
from garmentq.core.run.verdict import Gate, Verdict
from garmentq.core.scan.contours.target import Target
from garmentq.core.scan.scan import Scan

STEPS = 40
STEP_SECONDS = 0.1


class Refused(BadInput):
    """The file is cut off; export it again."""

    code = "scan.truncated"


def recover(request: Request, hooks: Hooks) -> Recovery:
    """Do what the scan's name says, and give a tiny result."""
    name = request.scan.stem
    hooks.progress("scan", 0.5, "reading")
    if name.startswith("bad"):
        raise Refused()
    if name.startswith("fault"):
        raise ZeroDivisionError("a bug")
    if name.startswith("crash"):
        os.kill(os.getpid(), signal.SIGKILL)
    if name.startswith("leave"):
        sys.exit(3)
    if name.startswith("short"):
        time.sleep(0.1)
    if name.startswith("deaf"):
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGUSR2})
    if name.startswith(("stuck", "deaf")):
        time.sleep(600.0)
    if name.startswith("slow"):
        _work(hooks, lambda step: time.sleep(STEP_SECONDS))
    if name.startswith("gated"):
        _work(hooks, lambda step: _wait(hooks, step))
    for stage in STAGES:
        hooks.progress(stage, 1.0)
    return make_recovery(request, float(len(name)))


def write(recovery: Recovery, folder: Path) -> list[Path]:
    """Write one file."""
    path = folder / "metrics.txt"
    path.write_text(repr(recovery.report.metrics))
    return [path]


def hold_gate(marks: Path, step: int) -> None:
    """Stop the gated jobs of a marks file before a step; it is replaced whole, so no reader sees half of it."""
    fresh = marks.with_suffix(".fresh")
    fresh.write_text(str(step))
    fresh.replace(marks.with_suffix(".gate"))


def _wait(hooks: Hooks, step: int) -> None:
    gate = Path(os.environ["STANDIN_MARKS"]).with_suffix(".gate")
    while step >= int(gate.read_text()):
        hooks.check()
        time.sleep(0.01)


def _work(hooks: Hooks, pause: Callable[[int], None]) -> None:
    """Count to `STEPS`; the marks file, if one is named, tells which steps were really done."""
    kept = hooks.load_checkpoint("drape")
    first = 0 if kept is None else int(kept["step"])
    marks = os.environ.get("STANDIN_MARKS")
    for step in range(first, STEPS):
        try:
            pause(step)
            hooks.progress("drape", step / STEPS, f"step {step}")
        except Cancelled:
            hooks.save_checkpoint("drape", {"step": np.array(step)})
            raise
        if marks:
            with open(marks, "a", encoding="ascii") as stream:
                stream.write(f"{step} {os.getpid()}\n")
        if (step + 1) % 5 == 0:
            hooks.save_checkpoint("drape", {"step": np.array(step + 1)})


def make_recovery(request: Request, rms: float) -> Recovery:
    """Make a complete recovery of one square panel."""
    square = np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.1], [0.0, 0.1]])
    nodes = np.c_[square, np.zeros(4)]
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    pattern = Pattern("square", (Panel("front", square, (Edge(),) * 4),), ())
    eyes = np.tile(np.eye(4), (24, 1, 1))
    joints, weights = np.zeros((24, 3)), np.full((4, 24), 1 / 24)
    body = Body(nodes, faces, joints, weights, eyes, nodes, faces, joints, weights, np.eye(3), source="mesh:standin")
    empty = np.zeros(2, dtype=int)
    garment = Garment(pattern, nodes, faces, square, faces, np.arange(4), empty, np.zeros(4, dtype=int), {})
    category = "skirt" if "skirt" in request.scan.stem else "tshirt"
    return Recovery(
        scan=Scan(nodes, faces, name=request.scan.stem),
        body=body,
        target=Target(nodes, faces, np.tile([0.0, 0.0, 1.0], (4, 1)), (), (), category),
        template=category,
        pattern=pattern,
        fabric=Fabric(request.settings.fabric or DEFAULT_FABRIC, 100.0, 10.0, 100.0, 30.0, 1e-5, 0.15),
        garment=garment,
        meshes=Meshes(nodes, nodes),
        report=ResultReport(
            metrics={"surface_rms_mm.t2s": rms, "surface_rms_mm.s2t": rms / 2, "panel_area_error": None},
            gates=(Gate("penetration", Verdict.PASS, 0.1, 1.0, "fine"),),
            warnings=("this is a stand-in",),
            stage_seconds=dict.fromkeys(STAGES, 0.01),
            cpu_seconds=0.1,
            peak_mb=100.0,
            manifest={"seed": request.settings.seed},
        ),
        pieces=(PieceNumbers("FRONT", 1, False, False, 0.4, 0.0144, 0.0144, 0),),
    )
