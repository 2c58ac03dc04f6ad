"""Derived jobs, which work on a stored result instead of a scan, such as `dress`: from an order to a queued job."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from ..core.cloth.fabric import Fabric
from ..core.run.errors import BadInput
from ..core.run.sandbox import IsStopped, never_stopped
from .jobs import JobUnknown, find_job
from .kinds import FileRef, RequestBad, find_files, find_kind, pack_request, read_request
from .materials import resolve_fabric
from .models import ArtifactRow, JobRow, OwnerRow
from .results import RESULT
from .submission import PERSON_KIND, JobRequest, SubmissionResult, add_job, check_labels, clean_name
from .terms import JobTerms

if TYPE_CHECKING:
    from .kinds import Kind
    from .services import Services


class InputWrong(BadInput):
    """The job's kind has no result that can be used here; name a recovery, or a job derived from one."""

    code = "job.input_kind"


@dataclass(frozen=True)
class DerivedOrder:
    """Describe an order of a job that works on a stored result.

    Attributes:
        kind: Name of the kind, `dress`; for a person's job it dresses a body in all of its garments.
        result: Id of the job whose result it works on, or on this machine a beginning of it.
        over: Id of the job whose garment the result is worn over, or a beginning of it; empty: it is worn alone.
        options: Fields of the kind's request other than files, as JSON values.
        files: Files of the request by field: on this machine, or stored ones.
        terms: How the job is queued.
    """

    kind: str
    result: str
    options: Mapping[str, Any] = field(default_factory=dict)
    files: Mapping[str, Path | FileRef] = field(default_factory=dict)
    over: str = ""
    terms: JobTerms = field(default_factory=JobTerms)


def submit_derived(services: Services, order: DerivedOrder, is_stopped: IsStopped = never_stopped) -> SubmissionResult:
    """Store an order's files, check its request, and queue the job.

    Raises:
        RequestBad: if the kind works on no result, or its request is invalid.
        JobUnknown: if the key may not see the result's job, or there is none.
        InputWrong: if its result is of a kind that cannot be used.
        InputNotEnded: if it has no result.
        PatternUnsound: if an edited pattern cannot be draped.
        ResultOld: if it was stored by a version that kept no garment to be worn again.
        LabelBad: if name or tags cannot be used.
    """
    kind = _choose_kind(services, order)
    if len(kind.reads) != 1:
        raise RequestBad(f"a job '{order.kind}' works on no stored result; leave out the result, or name another kind.")
    if order.over and not kind.reads_too:
        raise RequestBad(f"a job '{kind.name}' is worn over no other garment; leave that out, or dress in one garment.")
    ((folder, kinds),) = kind.reads.items()
    reads = [(folder, kinds, order.result)]
    reads += [(name, others, order.over) for name, others in kind.reads_too.items() if order.over]
    check_labels(order.terms)
    files = {name: _keep(services, file) for name, file in order.files.items()}
    checked = read_request(kind.request, {**_find_fabric(services, order.options), **files})
    request = pack_request(checked)
    if {place for place, _ in find_files(request)} - files.keys():  # a known hash is not an upload
        raise RequestBad("a file of the request is named among its options; upload it and name it among the files.")
    rows = [_find_own(services, order, named) for _, _, named in reads]
    row = rows[0]
    kind.refuse(services.store, checked, is_stopped)
    with services.database.write() as session:
        for one, (name, allowed, _) in zip(rows, reads, strict=True):
            if one.kind not in allowed:
                raise InputWrong(
                    f"job {one.id} is a job '{one.kind}', and '{kind.name}' works on the result of "
                    f"{' or '.join(allowed)}; `garmentq status {one.id}` shows the jobs below it."
                )
            _check_files(session, one.id, kind.choose_input(checked, name))
        request = kind.adopt(session, request, row)
        more = kind.find_inputs(session, request, row)
        for name, job in more.items():
            _check_files(session, job, kind.choose_input(checked, name))
        inputs = {name: one.id for one, (name, _, _) in zip(rows, reads, strict=True)} | more
        terms = order.terms.complete(row.name)
        return add_job(session, JobRequest(kind.name, request, row.scan, inputs, terms, lane=kind.lane))


def _choose_kind(services: Services, order: DerivedOrder) -> Kind:
    """Return the requested kind, or the one that replaces it if the result is that of a person's job."""
    kind = find_kind(services.settings, order.kind)
    if not kind.persons:
        return kind
    is_person = _find_own(services, order, order.result).kind == PERSON_KIND
    return find_kind(services.settings, kind.persons) if is_person else kind


def _find_own(services: Services, order: DerivedOrder, named: str) -> JobRow:
    """Return a job that an order names; a job that the order's key does not own counts as unknown.

    Raises:
        JobUnknown: if there is none.
    """
    row = find_job(services.database, named)
    with services.database.read() as session:
        if order.terms.key and session.get(OwnerRow, (order.terms.key, row.id)) is None:
            raise JobUnknown(f"there is no job '{named[:40]}'; `garmentq status` lists them all.")
    return row


def _check_files(session: Session, job: str, names: tuple[str, ...]) -> None:
    """Refuse a stored result that lacks a file that is read; a result without files is of a job that has not ended.

    Raises:
        ResultOld: if it lacks one.
    """
    known = set(session.scalars(select(ArtifactRow.name).where(ArtifactRow.job == job, ArtifactRow.kind == RESULT)))
    if known and not known.issuperset(names):
        from ..core.reuse.wear.worn import ResultOld

        raise ResultOld()


def _find_fabric(services: Services, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return options with the imported fabric that they name, as JSON values.

    Raises:
        FabricUnknown: if there is none of that name.
        RequestBad: if it is not a name.
    """
    name = options.get("fabric")
    if name is None:
        return dict(options)
    if not isinstance(name, str):
        raise RequestBad("give a fabric by its name; `garmentq materials` lists and imports them.")
    found = resolve_fabric(services.database, name)
    return {**options, "fabric": pack_request(found) if isinstance(found, Fabric) else found}


def _keep(services: Services, file: Path | FileRef) -> dict[str, str]:
    """Store a file, and return its key and cleaned name as JSON values.

    Raises:
        FileMissing: if it does not exist.
    """
    if isinstance(file, Path):
        from ..core.scan.refusal import FileMissing

        if not file.is_file():
            raise FileMissing(f"{file} is not a file; check the path.")
        file = FileRef(services.store.put(file).sha256, clean_name(file.name))
    return {"sha256": file.sha256, "name": file.name}
