"""A stand-in for a recovery that leaves its re-drape for later, and for that; what it finds is in the scan's name.

`torn...` hangs so that the result fails, `same...` so that its verdict stays, `lost...` cannot be draped until `MENDED`
is in the environment; everything else passes.
"""

from __future__ import annotations

import json
import os
from dataclasses import replace
from pathlib import Path

import garmentq_standin
from garmentq.core.judge.gates import evaluate_gates
from garmentq.core.recover.case import Case
from garmentq.core.recover.delivery import UnfinishedRecovery
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.recovery import Recovery, Request
from garmentq.core.recover.settings import LATER, NEVER
from garmentq.core.recover.state import RecoveryState
from garmentq.core.run.errors import GarmentqError
from garmentq.core.run.hooks import Hooks
from garmentq.core.run.report import Metrics

MISSING = "redrape_missing"
DISTANCES = {"torn": 50.0, "same": 30.0}
"""Distance of the re-draped mesh from the scan [mm], by the beginning of the scan's name: 20 is doubtful, 40 fails."""


class Crumpled(GarmentqError):
    """The cloth crumples; drape it on another wearer."""

    code = "drape.crumpled"


def recover(request: Request, hooks: Hooks) -> Recovery:
    """Return a tiny result, and leave the re-drape as the settings say."""
    found = garmentq_standin.make_recovery(request, 2.0)
    if request.settings.redrape not in (LATER, NEVER):
        return _judge(found, found.report.metrics | _measure(request.scan.stem))
    wearer = WearerGeometry(found.body)
    state = RecoveryState(found.template, found.pattern, found.target, wearer, found.fabric)
    case = Case(request, found.scan, found.target, wearer)
    left = _judge(found, found.report.metrics | {MISSING: 1.0})
    return UnfinishedRecovery(**vars(left), case=case, state=state) if request.settings.redrape == LATER else left


def finish(case: Case, state: RecoveryState, known: Metrics, hooks: Hooks) -> Recovery:
    """Return the same result with the re-drape."""
    name = case.scan.name
    hooks.progress("redrape", 0.5)
    if name.startswith("lost") and "MENDED" not in os.environ:
        raise Crumpled()
    found = garmentq_standin.make_recovery(replace(case.request, scan=Path(name)), 2.0)
    metrics = {one: value for one, value in known.items() if one != MISSING} | _measure(name)
    return _judge(found, metrics)


def write(recovery: Recovery, folder: Path) -> list[Path]:
    """Write the files that a re-drape replaces, and one that it does not."""
    texts = {"metrics.json": json.dumps(recovery.report.metrics), "report.html": f"{recovery.report.cpu_seconds:.2f}"}
    texts |= {"detail.ply": "detail", "manifest.json": "{}"}
    if MISSING not in recovery.report.metrics:
        texts["redrape.ply"] = "redrape"
    for name, text in texts.items():
        (folder / name).write_text(text)
    return [folder / name for name in texts]


def _measure(name: str) -> Metrics:
    distance = next((DISTANCES[word] for word in DISTANCES if name.startswith(word)), 5.0)
    return {f"redrape.surface_rms_mm.{way}": distance for way in ("s2t", "t2s")}


def _judge(found: Recovery, metrics: Metrics) -> Recovery:
    return replace(found, report=replace(found.report, metrics=metrics, gates=evaluate_gates(metrics)))
