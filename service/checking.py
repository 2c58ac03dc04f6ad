"""The first stage of every job: its files are read and checked in a limited process, which returns plain arrays.

The process that has the database's address and the store's keys never parses a user's file.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from ..core.run.errors import BadInput
from ..core.run.sandbox import Bounds, IsStopped, call_limited, never_stopped
from .order import GARMENT, PERSON
from .services import Services

STAGE = "check"
"""The stage's name in progress and events."""

DOUBTS = "doubts"
"""Key under which a check reports doubts about the files, one sentence each; they are shown at once, in an event."""


def check_files(checker: str, request: dict[str, Any], files: Path, is_stopped: IsStopped) -> dict[str, Any]:
    """Check the files of a job in a limited process.

    Args:
        checker: Dotted path of a function like `check_recovery`, `package.module:function`.
        request: The job's request, as it is stored.
        files: Folder with each file of the request, as FIELD/NAME.
        is_stopped: Called now and then; True ends the process.

    Returns:
        Description of the files, CPU time and memory, as JSON values.

    Raises:
        BadInput: if a file cannot be used; the code says why.
        Cancelled: if `is_stopped` returned True.
    """
    arguments = {"request": request, "files": str(files.absolute())}
    answer = call_limited(checker, arguments, Bounds(), is_stopped, files.parent)
    return answer.result | {"cpu_seconds": round(answer.cpu_seconds, 3), "peak_mb": round(answer.peak_mb, 1)}


def check_request(
    services: Services, kind: str, request: dict[str, Any], is_stopped: IsStopped = never_stopped
) -> dict[str, Any]:
    """Check the stored files of a request before its job is queued, as the job's first stage will.

    Args:
        services: The home with the files.
        kind: Name of the job's kind.
        request: As `pack_request` writes it.
        is_stopped: Called now and then; True ends the process.

    Returns:
        Description of the files, as JSON values; empty if the kind has no files of a user.

    Raises:
        BadInput: if a file cannot be used; the code says why.
        Cancelled: if `is_stopped` returned True.
    """
    from .kinds import find_files, find_kind

    checker = find_kind(services.settings, kind).checker(services.settings)
    if not checker:
        return {}
    with services.copying() as folder:
        files = folder / "files"
        for field, file in find_files(request):
            services.store.copy(file.sha256, files / field / file.name)
        return check_files(checker, request, files, is_stopped)


def check_recovery(request: dict[str, Any], files: str) -> dict[str, Any]:
    """Read the files of a recovery in a limited process, and write them as arrays for the pipeline.

    Args:
        request: The job's request, as it is stored.
        files: Folder with each file of the request, as FIELD/NAME.

    Returns:
        Description of the files, as JSON values.

    Raises:
        BadInput: if a file cannot be used.
    """
    from ..core.garment.reading import save_reading
    from ..core.people.labels import has_names
    from ..core.recover.inputs import read_request
    from ..core.scan.limits import Limits
    from ..core.scan.refusal import NoFaces
    from .inspect_reading import describe_reading
    from .kinds import read_request as parse_request
    from .kinds.recover_request import READING, RecoverRequest

    folder = Path(files)
    parsed = parse_request(RecoverRequest, request)
    unpacked = parsed.unpack(folder)
    if parsed.is_open and unpacked.labels is not None and has_names(unpacked.labels):
        return _mark_as_person(folder)
    try:
        reading = read_request(unpacked, Limits(is_confined=True))
    except NoFaces:
        if parsed.is_open and unpacked.labels is None:  # a garment is a surface; a point cloud with a body is a person
            return _mark_as_person(folder)
        raise
    save_reading(reading, folder / READING)
    return {"as": GARMENT, **describe_reading(reading)}


def _mark_as_person(folder: Path) -> dict[str, Any]:
    """Record that the files are a person's."""
    from .kinds.recover_request import AS_PERSON

    (folder / AS_PERSON).touch()
    return {"as": PERSON}


def check_person(request: dict[str, Any], files: str) -> dict[str, Any]:
    """Read the files of a dressed person in a limited process, and write them as arrays.

    Args:
        request: The job's request, as it is stored.
        files: Folder with each file of the request, as `find_files` places it.

    Returns:
        Description of the files, as JSON values.

    Raises:
        BadInput: if a file cannot be used.
    """
    from ..core.people.person_input import PersonFiles, describe_person_input, read_person_input, save_person_input
    from ..core.scan.limits import Limits
    from .inspect_scan import explain_missing_body, is_garment_refusal
    from .kinds import FileRef
    from .kinds import read_request as parse_request
    from .kinds.person_request import PERSON_INPUT_FILE, PersonRequest

    folder = Path(files)
    parsed = parse_request(PersonRequest, request)
    found = PersonFiles(
        folder / "scan" / parsed.scan.name,
        None if parsed.labels is None else folder / "labels" / parsed.labels.name,
        folder / "body" / parsed.body.name if isinstance(parsed.body, FileRef) else None,
        {word: folder / parsed.place(word) / file.name for word, file in parsed.templates.items()},
        parsed.settings.units,
        parsed.settings.up,
        parsed.settings.height,
    )
    try:
        content = read_person_input(found, Limits(is_confined=True))
    except BadInput as error:
        if is_garment_refusal(error) and parsed.given_as is None and parsed.body is None:
            error.message = explain_missing_body(error)
        raise
    save_person_input(content, folder / PERSON_INPUT_FILE)
    return describe_person_input(content)


def check_body(request: dict[str, Any], files: str) -> dict[str, Any]:
    """Read the file of a body in a limited process, and write it as arrays.

    Args:
        request: The job's request, as it is stored, with the field `body`, and perhaps `units` and `up`.
        files: Folder with each file of the request, as FIELD/NAME.

    Returns:
        Description of the file, as JSON values.

    Raises:
        BadInput: if it cannot be used.
    """
    from ..core.reuse.wear.bodies import describe_body_file, read_body_file
    from ..core.run.records import write_record
    from ..core.scan.limits import Limits
    from .kinds.dress_request import BODY

    folder = Path(files)
    path = folder / "body" / request["body"]["name"]
    body = read_body_file(path, request.get("units"), request.get("up"), Limits(is_confined=True))
    write_record(body, folder / BODY)
    return describe_body_file(body)


def check_motion(request: dict[str, Any], files: str) -> dict[str, Any]:
    """Read the file of a motion in a limited process, and write it as arrays.

    Args:
        request: The job's request, as it is stored, with the field `motion`.
        files: Folder with each file of the request, as FIELD/NAME.

    Returns:
        Description of the file, as JSON values.

    Raises:
        BadInput: if it cannot be used.
    """
    from ..core.body.motion.read import load_motion
    from ..core.run.records import write_record
    from .kinds.animate_request import MOTION

    folder = Path(files)
    recording = load_motion(folder / "motion" / request["motion"]["name"])
    write_record(recording, folder / MOTION)
    return {
        "motion": {
            "poses": len(recording.turns),
            "rate": round(recording.rate, 3),
            "joints": int(recording.known.sum()),
            "notes": list(recording.notes),
        },
        DOUBTS: list(recording.doubts()),
    }


def check_edit(request: dict[str, Any], files: str) -> dict[str, Any]:
    """Read the file of an edited pattern in a limited process, and write it as arrays.

    Args:
        request: The job's request, as it is stored, with the field `pattern`.
        files: Folder with each file of the request, as FIELD/NAME.

    Returns:
        Description of the file, as JSON values.

    Raises:
        BadInput: if it cannot be used.
    """
    from ..core.garment.garmentcode import load_pattern
    from ..core.garment.reading import save_given_pattern
    from .inspect_reading import describe_pattern
    from .kinds.edit_request import PATTERN

    folder = Path(files)
    pattern = load_pattern(folder / "pattern" / request["pattern"]["name"])
    save_given_pattern(pattern, folder / PATTERN)
    return {"pattern": describe_pattern(pattern)}
