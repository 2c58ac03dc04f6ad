"""Two quick kinds of jobs: a root that makes three pieces, the last of which waits for the others and reads them.

Each job that STANDIN_KILLS names kills its process once at each of its stages, the last of them within the
transaction that stores its result. A piece is refused while there is a file `fail-NAME` beside the marks.
"""

from __future__ import annotations

import os
import signal
from dataclasses import dataclass
from pathlib import Path

from garmentq.service.kinds import PARENT, ChildRequest, Kind, Outcome, pack_request
from garmentq_standin import Refused

KINDS = "garmentq_family:Root,garmentq_family:Piece"
"""What GARMENTQ_KINDS must say."""

PIECES = ("front", "back", "whole")


@dataclass(frozen=True)
class RootRequest:
    """Ask for a root that makes the pieces."""

    text: str


@dataclass(frozen=True)
class PieceRequest:
    """Ask for one piece."""

    text: str


def die_once(name: str, stage: str) -> None:
    """Kill this process the first time that a job is at a stage, where that is asked for of the job."""
    path = Path(os.environ["STANDIN_MARKS"])
    line = f"{name} {stage}"
    known = path.read_text().splitlines() if path.exists() else []
    with path.open("a", encoding="ascii") as stream:
        stream.write(f"{line}\n")
    if name in os.environ.get("STANDIN_KILLS", "").split() and line not in known:
        os.kill(os.getpid(), signal.SIGKILL)


def write(name: str, text: str, work, hooks) -> str:
    """Do what both kinds do: go through the stages and write one file with what was read."""
    read = {key: (folder / "text.txt").read_text() for key, folder in sorted(work.inputs.items())}
    for stage in ("begin", "end"):
        hooks.progress(stage, 0.5)
        die_once(name, stage)
    if (Path(os.environ["STANDIN_MARKS"]).parent / f"fail-{name}").exists():
        raise Refused()
    (work.out / "text.txt").write_text(" ".join([text, *(f"{key}=({value})" for key, value in read.items())]))
    return name


class Root(Kind):
    """Make three pieces."""

    name = "standin.root"
    request = RootRequest
    stages = ("check", "begin", "end")

    def run(self, request, work, hooks):
        """Write one file."""
        return write("root", request.text, work, hooks)

    def store(self, session, claim, result):
        """Ask for the pieces."""
        die_once(result, "store")
        front, back, whole = (
            ChildRequest(name, Piece.name, pack_request(PieceRequest(name)), inputs={"root": PARENT}) for name in PIECES
        )
        reads = {"root": PARENT, "front": "front", "back": "back"}
        return Outcome({}, (front, back, ChildRequest(whole.name, whole.kind, whole.request, PIECES[:2], reads)))


class Piece(Kind):
    """Write one file."""

    name = "standin.piece"
    request = PieceRequest
    stages = ("check", "begin", "end")

    def run(self, request, work, hooks):
        """Write one file with what was read."""
        return write(request.text, request.text, work, hooks)

    def store(self, session, claim, result):
        """Keep no rows."""
        die_once(result, "store")
        return Outcome({})

    def show(self, session, row):
        """Show the text."""
        return {"text": row.request["text"]}
