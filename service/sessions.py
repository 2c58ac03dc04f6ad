"""Browser sessions. Only the hash of a session's token is stored, as of a key's."""

from __future__ import annotations

import hashlib
import hmac
import secrets

from sqlalchemy import delete, select

from ..core.run.errors import GarmentqError
from .database import Database, clock
from .keys import LOCAL_CALLER, TOKEN_BYTES, Caller, KeyBad, authenticate_key, has_keys, hash_token
from .models import SessionRow

SESSION_SECONDS = 12 * 3600.0
"""Duration of a session [s]: a long working day; then the key must be entered again."""

MAX_KEY_SESSIONS = 50
"""Largest number of sessions of one key: a studio's browsers, with some repeated sign-ins; one more ends the oldest."""

LINK_SECONDS = 600.0
"""Validity of a sign-in link [s]: it is printed on a terminal and opened at once."""


class SessionEnded(GarmentqError):
    """The session has ended; sign in again at /signin."""

    code = "session.ended"


class CsrfBad(GarmentqError):
    """The request did not come from a page of this service; load the page again and repeat it."""

    code = "session.csrf"


class LinkUsed(GarmentqError):
    """The link was used before or has expired; `garmentq serve` prints a new one, or sign in with a key or token."""

    code = "session.link_used"


def begin_session(database: Database, caller: Caller, is_link: bool = False, earlier: str | None = None) -> str:
    """Create a session, or a link that starts one, and return its token, which is returned only here.

    The earlier session of the same browser, given by its token, ends. Expired sessions are deleted, and of the key's
    sessions the oldest beyond `MAX_KEY_SESSIONS`.
    """
    token = secrets.token_urlsafe(TOKEN_BYTES)
    seconds = LINK_SECONDS if is_link else SESSION_SECONDS
    with database.write() as session:
        is_past = SessionRow.expires <= clock()
        if earlier is not None:
            is_past |= SessionRow.hash == hash_token(earlier)
        session.execute(delete(SessionRow).where(is_past))
        condition = (SessionRow.key == caller.key) & (SessionRow.is_link == is_link)
        kept = select(SessionRow.hash).where(condition).order_by(SessionRow.created.desc()).limit(MAX_KEY_SESSIONS - 1)
        session.execute(delete(SessionRow).where(condition, SessionRow.hash.not_in(kept)))
        row = {"hash": hash_token(token), "key": caller.key, "is_link": is_link}
        session.add(SessionRow(**row, created=clock(), expires=clock() + seconds))
    return token


def authenticate_session(database: Database, token: str, is_open: bool) -> Caller:
    """Authenticate the token of a session.

    Args:
        database: The sessions' database.
        token: Content of the browser's cookie.
        is_open: Whether the service has a local user while it has no keys.

    Raises:
        SessionEnded: if there is no session, it has expired, or its key is no longer valid.
    """
    statement = select(SessionRow.key).where(SessionRow.hash == hash_token(token), ~SessionRow.is_link)
    with database.read() as session:
        key = session.scalar(statement.where(SessionRow.expires > clock()))
    if key is None or (not key and (not is_open or has_keys(database))):
        raise SessionEnded()
    try:
        return authenticate_key(database, key) if key else LOCAL_CALLER
    except KeyBad:
        raise SessionEnded("the key that signed in was revoked or has expired; sign in with another.") from None


def take_link(database: Database, token: str) -> None:
    """Use up a link that signs the local user in.

    Raises:
        LinkUsed: if it cannot be used, or was used before.
    """
    meant = delete(SessionRow).where(SessionRow.hash == hash_token(token), SessionRow.is_link)
    with database.write() as session:
        rows = session.execute(meant.where(SessionRow.expires > clock()).returning(SessionRow.hash)).all()
    if len(rows) != 1 or has_keys(database):
        raise LinkUsed()


def end_session(database: Database, token: str) -> None:
    """End a session, if it exists."""
    with database.write() as session:
        session.execute(delete(SessionRow).where(SessionRow.hash == hash_token(token)))


def make_csrf(token: str) -> str:
    """Return the token that a session's pages send with each change; it is computed from the session's token."""
    return hmac.new(token.encode(), b"csrf", hashlib.sha256).hexdigest()


def check_csrf(token: str, csrf_token: str) -> None:
    """Check the token that came with a change.

    Raises:
        CsrfBad: if it is not the session's.
    """
    if not hmac.compare_digest(make_csrf(token).encode(), csrf_token.encode("utf-8", "replace")):
        raise CsrfBad()
