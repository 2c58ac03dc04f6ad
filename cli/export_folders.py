"""The garments of a person, or of a batch, a subject or a family: the folder of each, and names of files."""

from __future__ import annotations

import os
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ..service.backend import Backend
    from ..service.records import JobReport

RECOVER = "recover"
"""Kind of the jobs that recover a garment."""

SPELLINGS = str.maketrans({"\u00e4": "ae", "\u00f6": "oe", "\u00fc": "ue", "\u00df": "ss", "\u00c4": "Ae",
                           "\u00d6": "Oe", "\u00dc": "Ue", "\u00e6": "ae", "\u00f8": "oe", "\u00d8": "Oe"})  # fmt: skip
"""Spellings of letters in the names of files, which every program and every disk accepts."""


def find_chosen(backend: Backend, fields: Mapping[str, str]) -> dict[str, str]:
    """Return the recovered garments whose fields have these values, `tag`, `subject` or `family`: jobs by folders."""
    from ..service.query import MAX_QUERY_ROWS, JobQuery
    from ..service.states import State
    from .terminal import print_note

    terms = {**fields, "kind": RECOVER, "state": State.SUCCEEDED.value}
    found = backend.find_jobs(JobQuery(terms, sort="created", limit=MAX_QUERY_ROWS))
    if not found:
        print_note(f"no recovered garment has {' and '.join(f'{name} {value}' for name, value in fields.items())}.")
    return name_folders(backend, found)


def find_garments(backend: Backend, job: JobReport) -> dict[str, str]:
    """Return the recovered garments of a person's job by folders; none if it has none below it."""
    from ..service.query import MAX_QUERY_ROWS, JobQuery
    from ..service.states import State

    terms = {"parent": job.id, "kind": RECOVER, "state": State.SUCCEEDED.value}
    done = backend.find_jobs(JobQuery(terms, sort="created", limit=MAX_QUERY_ROWS)) if job.children else []
    return name_folders(backend, done)


def name_folders(backend: Backend, jobs: Iterable[JobReport]) -> dict[str, str]:
    """Return jobs by names of folders: person and garment, and where two would be alike the part or the job's id."""
    ordered = list(jobs)
    persons = find_persons(backend, ordered)
    found: dict[str, str] = {}
    for one in ordered:
        name = write_plain(f"{persons[one.id]} {one.garment or one.name}")
        choices = (name, f"{name}_{write_plain(one.name)}", f"{name}_{one.id}")
        found[next(choice for choice in choices if choice not in found)] = one.id
    return found


def find_persons(backend: Backend, jobs: Sequence[JobReport]) -> dict[str, str]:
    """Return the name of each job's person: its subject's, else that of its family."""
    others = sorted({one.family for one in jobs if not one.subject})
    roots = {one.id: one.name for one in backend.find_jobs_by_id(others)} if others else {}
    return {one.id: one.subject or roots.get(one.family, one.name) for one in jobs}


def write_plain(text: str) -> str:
    """Return a name of a file without spaces, accents and signs; letters of other scripts stay."""
    plain = unicodedata.normalize("NFKD", unicodedata.normalize("NFC", text).translate(SPELLINGS))
    kept = "".join(letter for letter in plain if not unicodedata.combining(letter))
    return re.sub(r"[^\w.-]+", "_", unicodedata.normalize("NFC", kept)).strip("._-")[:200] or "garment"


def prefix_files(folder: str, paths: Sequence[Path]) -> list[Path]:
    """Rename files so that each name says person, garment and content, and return the new paths."""
    renamed = [path.with_name(f"{folder}_{path.name}") for path in paths]
    for path, new in zip(paths, renamed, strict=True):
        os.replace(path, new)
    return renamed
