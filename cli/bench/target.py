"""Recover one target pack in a process of its own, to measure its memory and CPU time and to survive a crash.

python -m garmentq.cli.bench.target ORDER.json LINE.json
"""

from __future__ import annotations

import sys
from dataclasses import dataclass, replace
from pathlib import Path

from .lines import Line, answer_order, keep_failure


@dataclass(frozen=True)
class TargetOrder:
    """Describe how a pack is recovered.

    Attributes:
        pack: Its folder.
        method: Recovery method.
        preset: Weights of the deformation.
        shipped: True if the pack's own template is not used.
        out: Folder for the result, or None.
    """

    pack: str
    method: str
    preset: str
    shipped: bool
    out: str | None


def recover_target(order: TargetOrder) -> Line:
    """Recover a pack and measure it against its truth.

    Returns:
        The line that `garmentq bench --json` prints; an error is stored in it, never raised.
    """
    line = empty_line(Path(order.pack).name, order.method)
    with keep_failure(line):
        line |= _recover(order)
    if not line["ok"]:
        line["peak_mb"] = peak_mb()
    return line


def empty_line(target: str, method: str) -> Line:
    """Return the line of a target without results yet."""
    return {
        "target": target,
        "category": None,
        "template": None,
        "cut": None,
        "method": method,
        "ok": False,
        "error": None,
        "metrics": {},
        "cpu_seconds": None,
        "compile_seconds": None,
        "stage_seconds": {},
        "peak_mb": None,
        "vertices": None,
        "fabric": {},
        "panels": {},
    }


def _recover(order: TargetOrder) -> Line:
    from ...core.deliver.export.result import to_plain_json, write_recovery
    from ...core.recover.pipeline import recover
    from ...core.recover.recovery import Request
    from ...core.recover.settings import RecoverySettings
    from .compiling import time_compiling
    from .packs import read_packs, read_true_pattern
    from .pattern_match import measure_panels
    from .truth import measure_recovery

    pack = read_packs(Path(order.pack))[0]
    template = None if order.shipped else pack.template
    settings = RecoverySettings(method=order.method, preset=order.preset)
    # All input of the recovery: never the category, the true pattern or the truth's body.
    if pack.scan is None:
        request = Request(scan=pack.garment, body=pack.body, template=template, settings=settings)
    else:
        settings = replace(settings, labels_key="is_garment", keep="1")
        request = Request(scan=pack.scan, template=template, settings=settings, labels=pack.labels)
    with time_compiling() as compiling:
        recovery = recover(request)
    metrics, unmatched = measure_recovery(recovery, pack, own_template=template is not None, seed=settings.seed)
    if order.out:
        write_recovery(recovery, Path(order.out) / pack.name)
    truth = read_true_pattern(pack) if metrics.get("panel_area_error_all") is not None else None
    fabric = {e.name: {"value": e.value, "std": e.std, "identifiable": e.identifiable} for e in recovery.estimates}
    line: Line = to_plain_json(
        {
            "category": recovery.target.category,
            "template": recovery.template,
            "cut": recovery.report.manifest.get("cut"),
            "ok": True,
            "metrics": metrics,
            "cpu_seconds": recovery.report.cpu_seconds - compiling.seconds,
            "compile_seconds": compiling.seconds,
            "stage_seconds": recovery.report.stage_seconds,
            "peak_mb": recovery.report.peak_mb,
            "vertices": len(recovery.meshes.detail),
            "warnings": recovery.report.warnings,
            "unmatched_panels": unmatched,
            "fabric": fabric,
            "panels": {} if truth is None else measure_panels(recovery.pattern, truth, template is not None),
        }
    )
    return line


def peak_mb() -> float:
    """Return the largest resident memory of this process so far [MB]."""
    import resource

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak / (1e6 if sys.platform == "darwin" else 1e3)  # bytes there, kilobytes elsewhere


if __name__ == "__main__":
    answer_order(sys.argv[1:], TargetOrder, recover_target)
