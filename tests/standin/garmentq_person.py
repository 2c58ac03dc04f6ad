"""A quick stand-in for taking a person apart; what it finds is in the scan's name, as `garmentq_standin` has it.

`dress...` wears a one-piece, `unsure...` is refused with everything written, `bare...` is refused at once, the top of
`coat...` is not recovered; everybody else wears top and trousers.
Where STANDIN_KILLS names `person`, the process is killed once before it writes anything,
and once within the transaction that stores the result.
"""

from __future__ import annotations

import json
import os

import numpy as np
from garmentq.core.garment.reading import Reading, save_reading
from garmentq.core.recover.recovery import Request
from garmentq.core.run.errors import BadInput
from garmentq.core.run.hooks import Hooks
from garmentq.core.run.report import ResultReport
from garmentq.core.scan.pieces import ScanInput
from garmentq.core.scan.scan import Scan
from garmentq.service.kinds import RunContext
from garmentq.service.kinds.person_found import PersonFound
from garmentq.service.kinds.person_request import PersonRequest
from garmentq.service.kinds.recover_request import PERSON_REPORT_FILE, READING
from garmentq_family import die_once
from garmentq_standin import make_recovery


class Unsure(BadInput):
    """What is worn cannot be told; correct labels.npz and hand it in with --labels."""

    code = "segment.unsure"


class Bare(BadInput):
    """The person wears nothing that could be recovered."""

    code = "segment.no_clothes"


class Found(PersonFound):
    """Dies on its way into the database."""

    @property
    def words(self):
        """Return the garments, the first time only with a kill."""
        kill("person", "store")
        return PersonFound.words.fget(self)


def kill(name: str, stage: str) -> None:
    """Kill the process the first time, where a test asks for it."""
    if "STANDIN_MARKS" in os.environ:
        die_once(name, stage)


def take_apart(request: PersonRequest, work: RunContext, hooks: Hooks) -> PersonFound:
    """Find what the scan's name says."""
    name = request.scan.name
    for stage in ("body", "separate", "garments"):
        hooks.progress(stage, 0.5)
    kill("person", "garments")
    if name.startswith("bare"):
        raise Bare()
    parts = request.wearing.split(",") if request.wearing else ["upper", "lower"]
    if name.startswith("dress"):
        parts = ["one-piece"]
    recovery = make_recovery(Request(work.files / "scan" / name), 1.0)
    (work.out / "labels.npz").write_bytes(b"labels")
    (work.out / "report.html").write_text("<html></html>")
    garments = [{"part": part, "category": "tshirt", "confidence": 0.97, "contours": []} for part in parts]
    if name.startswith("coat"):
        garments[0]["problem"] = {"code": Unsure.code, "message": "An outer layer hides most of upper."}
    (work.out / PERSON_REPORT_FILE).write_text(json.dumps({"garments": garments}))
    nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.0]])
    piece = Scan(nodes, np.array([[0, 1, 2], [0, 2, 3]]), name=name)
    for part in parts:
        (work.out / part).mkdir()
        save_reading(Reading(ScanInput(piece, piece), recovery.body), work.out / part / READING)
    outfits = [{"parts": parts, "score": -1.0}, {"parts": ["one-piece"], "score": -4.0}]
    person = {"garments": garments, "outfits": outfits, "parts": dict.fromkeys(parts, 2)}
    problem = Unsure() if name.startswith("unsure") else None
    metrics = {f"confidence.{part}": 0.97 for part in parts}
    report = ResultReport(metrics, (), ("this is a stand-in",), {"separate": 0.1}, 0.1, 100.0)
    return Found(recovery.body, person, report, problem)
