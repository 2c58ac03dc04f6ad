"""Send stored files in blocks as they are read: no copy is made, and memory does not grow with the file.

A whole file is hashed while it is sent, and its last block is sent only if the hash is right: of a damaged file less
arrives than `Content-Length` promises, and of one of a single block nothing. A part is not hashed, because that would
read the whole file; a client that joins parts finds the hash in the `ETag`.
"""

from __future__ import annotations

import logging
import secrets
from collections.abc import Generator, Mapping
from dataclasses import dataclass, field
from urllib.parse import quote

from fastapi import Request, Response
from fastapi.responses import StreamingResponse
from starlette.concurrency import run_in_threadpool
from starlette.types import Receive, Scope, Send

from ...core.run.errors import GarmentqError
from ..keys import Caller
from ..records import Artifact
from ..store import STORE_BLOCK_SIZE, ArtifactDamaged, Store
from .access import AppState
from .guard import IS_HEAD
from .media_types import BYTES, find_media_type
from .problems import make_problem
from .ranges import RangeBad, read_ranges

log = logging.getLogger(__name__)

REVALIDATED = "private, no-cache"
"""Cache-Control of a downloaded file: a browser may keep it, but asks each time whether it is still there and the same,
and so shows no body after its deletion; proxies keep nothing."""


@dataclass(frozen=True)
class SendOptions:
    """Describe how a file is sent.

    Attributes:
        media: Its media type.
        headers: Further headers.
    """

    media: str = BYTES
    headers: Mapping[str, str] = field(default_factory=dict)


class Download(StreamingResponse):
    """Send blocks; the download is counted while it is sent, and no longer when the client disconnects.

    An error before the first block is answered as a problem; an error after it closes the connection and is logged.
    """

    def __init__(
        self,
        rooms: AppState,
        caller: Caller,
        blocks: Generator[bytes],
        shown: SendOptions,
        status_code: int = 200,
    ) -> None:
        """Prepare the response; nothing is read yet.

        Args:
            rooms: State of the application.
            caller: Caller for whom the download is counted.
            blocks: The content; it opens its file when the first block is requested.
            shown: Media type and headers.
            status_code: 200, or 206 for parts.
        """
        super().__init__(blocks, status_code, shown.headers, shown.media)
        self._blocks = blocks
        self._counted = rooms.meter.downloading(caller.key)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Count the download and send it."""
        with self._counted:
            await super().__call__(scope, receive, send)

    async def stream_response(self, send: Send) -> None:
        """Read each block after the previous one has been sent."""
        has_begun = False
        try:
            block = await run_in_threadpool(next, self._blocks, None)
            await send({"type": "http.response.start", "status": self.status_code, "headers": self.raw_headers})
            has_begun = True
            while block is not None:
                await send({"type": "http.response.body", "body": block, "more_body": True})
                block = await run_in_threadpool(next, self._blocks, None)
            await send({"type": "http.response.body", "body": b"", "more_body": False})
        except GarmentqError as error:
            if not has_begun:
                raise
            log.error("a download was cut off: %s: %s", error.code, error.message)
        finally:
            self._blocks.close()


def send_file(
    rooms: AppState, caller: Caller, file: Artifact, request: Request, shown: SendOptions | None = None
) -> Response:
    """Return a response with a stored file, with the parts of it in `Range`, or 304 (`If-None-Match`).

    Args:
        rooms: State of the application.
        caller: The caller.
        file: The file.
        request: The request, which may be a HEAD.
        shown: Media type and headers; None: as an attachment.

    Raises:
        ArtifactMissing, ArtifactDamaged: if the store does not have it, or in another size.
    """
    etag = f'"{file.sha256}"'
    headers = {"etag": etag, "cache-control": REVALIDATED}
    etags = request.headers.get("if-none-match", "")
    if etags.strip() == "*" or etag in etags:
        return Response(status_code=304, headers=headers)
    size = rooms.store.size(file.sha256)
    if size != file.size:
        raise ArtifactDamaged()
    attached = {"content-disposition": _content_disposition(file.name)}
    shown = shown or SendOptions(find_media_type(file.name), attached)
    headers |= {"accept-ranges": "bytes", **shown.headers}
    try:
        ranges = _find_ranges(request, etag, size)
    except RangeBad as error:
        answer = make_problem(error.status, error.code, error.message)
        if error.status == 416:
            answer.headers["content-range"] = f"bytes */{size}"
        return answer
    length, media = size, shown.media
    if len(ranges) == 1:
        start, stop = ranges[0]
        length = stop - start
        headers["content-range"] = f"bytes {start}-{stop - 1}/{size}"
    boundary = secrets.token_hex(13)
    if len(ranges) > 1:
        length = sum(len(_head_part(part, size, media, boundary)) + part[1] - part[0] for part in ranges)
        length += len(_end_parts(boundary))
        media = f"multipart/byteranges; boundary={boundary}"
    headers["content-length"] = str(length)
    status = 206 if ranges else 200
    if request.scope.get(IS_HEAD):
        return Response(status_code=status, headers=headers, media_type=media)
    if len(ranges) > 1:
        blocks = _read_parts(rooms.store, file, ranges, (shown.media, boundary))
    elif ranges and length < size:
        blocks = _read_part(rooms.store, file, ranges[0])
    else:
        blocks = rooms.store.read_checked(file.sha256, size)
    return Download(rooms, caller, blocks, SendOptions(media, headers), status)


def slice_bytes(content: bytes) -> Generator[bytes]:
    """Yield some bytes in blocks, so that no second copy of them is held in memory."""
    for start in range(0, len(content), STORE_BLOCK_SIZE):
        yield content[start : start + STORE_BLOCK_SIZE]


def _find_ranges(request: Request, etag: str, size: int) -> list[tuple[int, int]]:
    """Return the requested ranges; none for the whole file, or if `If-Range` names another version."""
    text = request.headers.get("range")
    if text is None or request.headers.get("if-range", etag) != etag:
        return []
    return read_ranges(text, size)


def _read_part(store: Store, file: Artifact, part: tuple[int, int]) -> Generator[bytes]:
    """Yield a part of a stored file; a file that has become shorter is damaged."""
    left = part[1] - part[0]
    for block in store.read(file.sha256, *part):
        left -= len(block)
        yield block
    if left:
        raise ArtifactDamaged()


def _read_parts(store: Store, file: Artifact, parts: list[tuple[int, int]], form: tuple[str, str]) -> Generator[bytes]:
    media, boundary = form
    for part in parts:
        yield _head_part(part, file.size, media, boundary)
        yield from _read_part(store, file, part)
    yield _end_parts(boundary)


def _head_part(part: tuple[int, int], size: int, media: str, boundary: str) -> bytes:
    place = f"bytes {part[0]}-{part[1] - 1}/{size}"
    return f"\r\n--{boundary}\r\nContent-Type: {media}\r\nContent-Range: {place}\r\n\r\n".encode()


def _end_parts(boundary: str) -> bytes:
    return f"\r\n--{boundary}--\r\n".encode()


def _content_disposition(name: str) -> str:
    """Return the header that makes a browser save a file under its name instead of showing it."""
    plain = name.rpartition("/")[2]
    encoded = quote(plain)
    return f'attachment; filename="{plain}"' if encoded == plain else f"attachment; filename*=utf-8''{encoded}"
