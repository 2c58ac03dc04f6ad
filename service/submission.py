"""From files on disk to a queued job: the files are stored, and one scan with the same settings is one job."""

from __future__ import annotations

import hashlib
import json
import re
import unicodedata
import uuid
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from sqlalchemy import exists, select
from sqlalchemy.orm import Session

from .. import __version__
from ..core.body.spec import BuiltinWearer
from ..core.cloth.fabrics import DEFAULT_FABRIC
from ..core.recover.settings import LATER, WAIT, RecoverySettings
from ..core.run.errors import BadInput
from .batches import note_tags
from .database import Database, clock, take_advisory_lock
from .families import find_tree, grant_family, requeue_jobs
from .jobs import JobUnknown, create
from .keys import check_quota, grant_job
from .kinds import FileRef, pack_request
from .kinds.person_request import PartChoice, PersonRequest
from .kinds.recover import Recover
from .kinds.recover_request import RecoverRequest
from .lanes import Lane, choose_lane
from .models import JobRow, JobTagRow, OwnerRow, ScanRow, SubjectJobRow, SubjectRow
from .new_job import NewJob
from .order import Order, is_person
from .states import UNSUCCESSFUL, State
from .store import Store, StoredFile
from .subjects import choose_subject, set_subject
from .terms import JobTerms


class BodyUnreadable(BadInput):
    """The body file cannot be read; give a mesh file, or --body builtin:female,height=1.70."""

    code = "body.unreadable"


class LabelBad(BadInput):
    """A name has at most 255 printable letters, each of at most 20 tags 1 to 64; choose shorter ones."""

    code = "order.label_bad"


class InputNotEnded(BadInput):
    """The job whose result is to be read has no result; wait until it has succeeded."""

    code = "job.input_not_ended"


PERSON_KIND = "person"
"""Name of the kind that segments a person; its class need not be loaded to name it."""

MAX_FAMILY_NAME_LENGTH, MAX_TAG_LENGTH, MAX_FAMILY_TAGS = 255, 64, 20
"""Largest numbers of letters of a family's name and of a tag, and of its tags; the longest name is the column's."""

ALLOWED_NAME_SIGNS = "._-()+,"
"""Characters of a file's name that are kept beside letters and digits: none has a meaning in a page, a shell or a
spreadsheet."""


@dataclass(frozen=True)
class JobRequest:
    """Describe the request of one job of any kind; its files are in the store.

    Attributes:
        kind: Name of the kind.
        request: The kind's request, as `pack_request` writes it.
        scan: Key of the file from which the family's work derives; for a job that only reads results, that of an input.
        inputs: Ids of the jobs whose results it reads, by the name of the folder in which it finds them.
        terms: How it is queued, with its name.
        before: Id of the job that it repeats with other settings, whose subject it has; empty: none.
        lane: Which jobs it goes before.
    """

    kind: str
    request: dict[str, Any]
    scan: str
    inputs: Mapping[str, str] = field(default_factory=dict)
    terms: JobTerms = field(default_factory=JobTerms)
    before: str = ""
    lane: Lane = Lane.BATCH


@dataclass(frozen=True)
class SubmissionResult:
    """Describe the result of a submission.

    Attributes:
        job: The job's id.
        is_new: False if an equal job existed; it is requeued if it had ended without success.
        state: The job's state now.
        understood: What the check of the files found, as JSON values; None if they are checked by the job.
    """

    job: str
    is_new: bool
    state: State
    understood: dict[str, Any] | None = None


Check = Callable[[str, dict[str, Any]], dict[str, Any]]
"""Check of the stored files of a request, by the name of its kind and the packed request; it returns what it found."""


def submit(database: Database, store: Store, order: Order, check: Check | None = None) -> SubmissionResult:
    """Store the files, check them, then create the recovery.

    Args:
        database: The jobs' database.
        store: Where the files are kept; those of a refused order are removed by the next collection of garbage.
        order: What is to be recovered.
        check: Reads the files before the job is queued; None: the job's first stage does.

    Raises:
        BodyMissing: if the scan is given as a garment, and no body is named.
        BadInput: as the check refuses a file.
        SettingsBad: if options contradict each other.
        LabelBad: if name or tags cannot be used.
        StorageFull: if the files cannot be stored.
    """
    of_person = is_person(order)
    if order.body is None and not of_person:
        _check_dressed(order)
    check_labels(order.terms)
    scan = store.put(order.scan)
    request = _describe_person(order, scan, store) if of_person else _describe(order, scan, store)
    kind, terms = PERSON_KIND if of_person else Recover.name, order.terms.complete(own_name(order.scan.name))
    understood = None if check is None else check(kind, request)
    with database.write() as session:
        take_advisory_lock(session, scan.sha256)
        if session.get(ScanRow, scan.sha256) is None:
            name = request["scan"]["name"]
            session.add(ScanRow(sha256=scan.sha256, name=name, size=scan.size, created=clock()))
            session.flush()
        lane = choose_lane(request["settings"])
        done = add_job(session, JobRequest(kind, request, scan.sha256, terms=terms, lane=lane))
    return replace(done, understood=understood)


def add_job(session: Session, order: JobRequest) -> SubmissionResult:
    """Add a job with its first event and outbox row, or return an equal job, requeued if it did not succeed.

    Raises:
        JobUnknown: if the key may not see a job that is to be read, or there is none.
        InputNotEnded: if a job that is to be read has no result.
        QueueFull: if the key has reached its number of open jobs.
        SubjectUnknown, SubjectBad: if its subject cannot be used.
    """
    terms = order.terms
    for job in order.inputs.values():  # first: an equal job shows the contents of its inputs
        _check_input(session, job, terms.key)
    subject = _find_subject(session, order)
    dedup, row = _find_equal(session, order, subject)
    if row is not None:
        if row.state in UNSUCCESSFUL:
            requeue_jobs(session, [row], "resubmitted", terms.key, terms.quota)
        grant_family(
            session, terms.key, row
        )  # after the quota: a new owner's row locks the key's, which the quota locks too
        _join(session, row, terms, subject)
        return SubmissionResult(row.id, False, row.state)
    check_quota(session, terms.key, terms.quota)
    new = NewJob(
        dedup, order.kind, order.request, order.scan, terms.name, terms.priority, terms.queue, order.lane, terms.key,
        terms.tags, order.inputs,
    )  # fmt: skip
    made = create(session, new)
    grant_job(session, terms.key, made.id)
    note_tags(session, terms.key, terms.tags)
    if subject:
        set_subject(session, subject, [made.id])
    return SubmissionResult(made.id, True, made.state)


def _find_subject(session: Session, order: JobRequest) -> str:
    """Return the id of an order's subject: the named one, or that of a job that it is made from."""
    if order.terms.subject:
        return choose_subject(session, order.terms.key, order.terms.subject)
    own = select(SubjectJobRow.subject).join(SubjectRow, SubjectRow.id == SubjectJobRow.subject)
    own = own.where(SubjectRow.key == order.terms.key, SubjectJobRow.job.in_([*order.inputs.values(), order.before]))
    return session.scalar(own.order_by(SubjectJobRow.job).limit(1)) or ""


def _find_equal(session: Session, order: JobRequest, subject: str) -> tuple[str, JobRow | None]:
    """Return the hash of an order, and the equal job if there is one.

    A job of a subject is shared neither with other keys nor with other subjects: such orders have hashes of their own.
    """
    terms = order.terms
    for realm in (terms.realm, f"{terms.key} {subject}"):
        dedup = _hash(replace(order, terms=replace(terms, realm=realm)))
        take_advisory_lock(session, dedup)  # equal orders at the same time are one job
        row = session.scalars(select(JobRow).where(JobRow.dedup == dedup).with_for_update()).one_or_none()
        if row is None or _may_join(session, row, terms.key, subject):
            return dedup, row
    return _hash(replace(order, terms=replace(terms, nonce=uuid.uuid4().hex))), None


def _may_join(session: Session, row: JobRow, key: str, subject: str) -> bool:
    """Return whether an order of a key for a subject (empty: none) may be an existing job."""
    people = select(SubjectRow).join(SubjectJobRow, SubjectJobRow.subject == SubjectRow.id)
    known = session.scalars(people.where(SubjectJobRow.job == row.id)).one_or_none()
    if known is not None:
        return known.key == key and subject in ("", known.id)
    return not subject or not _find_others(session, row.id, key)


def _find_others(session: Session, job: str, key: str) -> bool:
    """Return whether another key owns a job."""
    return bool(session.scalar(select(exists().where(OwnerRow.job == job, OwnerRow.key != key))))


def _join(session: Session, row: JobRow, terms: JobTerms, subject: str) -> None:
    """Add an order's subject and tags to the family of the equal job that it is, unless another key has that too."""
    known = set(session.scalars(select(JobTagRow.tag).where(JobTagRow.job == row.id)))
    note_tags(session, terms.key, {*known, *terms.tags})
    new_tags = [tag for tag in dict.fromkeys(terms.tags) if tag not in known]
    if _find_others(session, row.id, terms.key):
        return
    family = [one.id for one in find_tree(session, row, is_locked=True)] if subject or new_tags else []
    if subject:
        set_subject(session, subject, family)
    if len(known) + len(new_tags) <= MAX_FAMILY_TAGS:
        session.add_all(JobTagRow(job=job, tag=tag) for job in family for tag in new_tags)


def check_labels(terms: JobTerms) -> None:
    """Check a family's name and tags.

    Raises:
        LabelBad: if they cannot be used.
    """
    name, tags = terms.name, terms.tags
    is_bad = len(name) > MAX_FAMILY_NAME_LENGTH or not name.isprintable() or len(set(tags)) > MAX_FAMILY_TAGS
    if is_bad or any(not 0 < len(tag) <= MAX_TAG_LENGTH or not tag.isprintable() for tag in tags):
        raise LabelBad()


def own_name(file: str) -> str:
    """Return a file's name for display: the letters, marks and digits of any script, and harmless characters."""
    kept = (c if unicodedata.category(c)[0] in "LMN" or c in ALLOWED_NAME_SIGNS else " " for c in Path(file).stem)
    return " ".join("".join(kept).split())[:MAX_FAMILY_NAME_LENGTH] or "scan"


def clean_name(name: str) -> str:
    """Return a file name without folders, control characters and characters with a meaning in a shell or a page.

    It begins neither with a dot nor, like an option, with a dash.
    """
    return re.sub(r"[^A-Za-z0-9._-]+", "_", Path(name).name)[-100:].lstrip(".-") or "file"


def _check_dressed(order: Order) -> None:
    from ..core.body.builtin import BodyMissing
    from ..core.recover.recovery import make_selection

    if make_selection(order.labels, order.settings) is None:
        raise BodyMissing()


def _describe(order: Order, scan: StoredFile, store: Store) -> dict[str, Any]:
    """Return an order's request; files are given by hashes, so that the same files elsewhere are the same order."""
    labels, settings = _store_file(order.labels, store) if order.labels else None, _drop_wait(order.settings)
    file = FileRef(scan.sha256, clean_name(order.scan.name))
    template = _keep_template(order.template, order.settings.template, store)
    body = _keep_body(order, store)
    return pack_request(RecoverRequest(file, body, template, settings, labels, given_as=order.given_as))


def _describe_person(order: Order, scan: StoredFile, store: Store) -> dict[str, Any]:
    """Return a person's request in the same way."""
    choices = {
        word: PartChoice(
            _keep_template(one.template, one.name, store) or one.name, one.garment, one.fabric, one.lock, one.parts
        )
        for word, one in order.choices.items()
    }
    request = PersonRequest(
        FileRef(scan.sha256, clean_name(order.scan.name)),
        _drop_wait(order.settings),
        _store_file(order.labels, store) if order.labels else None,
        _keep_body(order, store),
        _keep_template(order.template, order.settings.template, store),
        order.wearing,
        order.marks,
        choices,
        order.given_as,
    )
    check_wearing(request)
    return pack_request(request)


def check_wearing(request: PersonRequest) -> None:
    """Check what a person is said to wear, and that the choices fit it: now, and not after the labelling.

    Raises:
        HintBad: if a word is no garment.
        ChoiceAmbiguous: if a choice names no garment, and two could be meant.
    """
    if request.wearing is not None:
        from ..core.people.hints import parse_wearing

        request.choose([part.word for part in parse_wearing(request.wearing)])


def _drop_wait(settings: RecoverySettings) -> RecoverySettings:
    """Return settings as they are stored: the re-drape that is waited for is not named, as in earlier versions."""
    return replace(settings, redrape=None) if settings.redrape == WAIT else settings


def _keep_body(order: Order, store: Store) -> FileRef | BuiltinWearer | None:
    return _store_file(order.body, store) if isinstance(order.body, Path) else order.body


def _keep_template(file: Path | None, name: str | None, store: Store) -> FileRef | None:
    """Store a pattern file under the name of an imported template."""
    if file is None:
        return None
    kept = _store_file(file, store)
    return replace(kept, name=clean_name(f"{name}.json")) if name else kept


def _store_file(path: Path, store: Store) -> FileRef:
    try:
        return FileRef(store.put(path).sha256, clean_name(path.name))
    except FileNotFoundError:
        raise BodyUnreadable(f"there is no file '{path}'.") from None


def _check_input(session: Session, job: str, key: str) -> None:
    """Refuse a job without a result, and one that the key does not own, which counts as unknown."""
    row = session.get(JobRow, job)
    if row is None or (key and session.get(OwnerRow, (key, job)) is None):
        raise JobUnknown(f"there is no job '{job[:40]}'; `garmentq status` lists them all.")
    if row.state != State.SUCCEEDED:
        raise InputNotEnded(f"job {job} is {row.state}; its result can be read once it has succeeded.")


def _hash(order: JobRequest) -> str:
    """Return the hash that equal jobs share: of what is computed, not of the job's name."""
    terms, request = order.terms, _name_computed(order.request)
    value: dict[str, Any] = {"request": request, "version": __version__, "nonce": terms.nonce}
    if order.kind != Recover.name:
        value["kind"] = order.kind
    if terms.realm:
        value["realm"] = terms.realm
    if order.inputs:
        value["inputs"] = dict(order.inputs)
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()


def _name_computed(request: dict[str, Any]) -> dict[str, Any]:
    """Return a request by what it computes: with the default fabric named, and a later re-drape as one at once."""
    settings = request.get("settings")
    if not isinstance(settings, dict):
        return request
    computed = {name: value for name, value in settings.items() if (name, value) != ("redrape", LATER)}
    if computed.get("fabric", "") is None:
        computed["fabric"] = DEFAULT_FABRIC
    return {**request, "settings": computed}
