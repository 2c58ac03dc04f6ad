"""Sign-in and sign-out: a key, the home's token or a link of `garmentq serve` starts a session with a cookie."""

from __future__ import annotations

import re
from contextlib import suppress
from typing import Annotated, Any
from urllib.parse import parse_qs

from fastapi import APIRouter, Depends, Request, Response
from fastapi.responses import RedirectResponse
from starlette.concurrency import run_in_threadpool

from ...core.run.errors import GarmentqError
from ..api.access import AppState, AppStateDependency
from ..api.guard import find_session, name_cookie
from ..api.problems import RETRY_SECONDS, error_status, make_public_message, make_retry_header
from ..keys import LOCAL_CALLER, Caller, KeyBad, KeyMissing, authenticate_token
from ..sessions import (
    SESSION_SECONDS,
    LinkUsed,
    SessionEnded,
    authenticate_session,
    begin_session,
    check_csrf,
    end_session,
    make_csrf,
    take_link,
)
from .markup import Html, html
from .shell import Visitor, draw_shell

router = APIRouter(include_in_schema=False)

LOCAL_PATH = re.compile(r"/(?![/\\])[A-Za-z0-9/_.~?=&,:%+-]{0,500}")
"""Paths to which a browser may be redirected after sign-in: pages of this service."""


EMPTIED = {"clear-site-data": '"cache"'}
"""Header that clears a browser's cache of this service, so that the next user cannot see meshes and pictures of
a body."""


class SignInNeeded(GarmentqError):
    """The page needs a session; sign in at /signin."""

    code = "session.missing"


def get_visitor(request: Request, rooms: AppStateDependency) -> Visitor:
    """Return the visitor of a page, and count the request for the visitor's key.

    Raises:
        SignInNeeded: if there is no session, or it has ended.
        ScopeMissing: if the key may not read.
    """
    token = find_session(request.scope)
    if token is None:
        raise SignInNeeded()
    try:
        caller = authenticate_session(rooms.database, token, bool(rooms.local_token))
    except SessionEnded:
        raise SignInNeeded() from None
    rooms.meter.take(caller.key)
    caller.check_scope("read")
    return Visitor(caller, make_csrf(token))


def recognise_visitor(request: Request) -> Visitor | None:
    """Return the visitor for the navigation of a page with an error; None without a session that lasts."""
    rooms: AppState = request.app.state.rooms
    token = find_session(request.scope)
    with suppress(GarmentqError):
        if token is not None:
            caller = authenticate_session(rooms.database, token, bool(rooms.local_token))
            return Visitor(caller, make_csrf(token))
    return None


VisitorOf = Annotated[Visitor, Depends(get_visitor)]


@router.get("/signin")
def show_signin(request: Request, rooms: AppStateDependency, link: str = "", next: str = "/") -> Response:
    """Return the form; a link of `garmentq serve` signs in at once, and only once."""
    if not link:
        return _draw_form(rooms, next)
    try:
        if not rooms.local_token:
            raise LinkUsed()
        rooms.meter.check_address(address_of(request), link)
        take_link(rooms.database, link)
        return _begin(request, rooms, LOCAL_CALLER, next)
    except GarmentqError as error:
        _note(request, rooms, error)
        return _draw_form(rooms, next, error)


@router.post("/signin")
async def sign_in(request: Request, rooms: AppStateDependency) -> Response:
    """Start a session for a key, or for the token of a home without keys."""
    form = parse_qs((await request.body()).decode("utf-8", "replace"))
    token, target = form.get("token", [""])[0].strip(), form.get("next", ["/"])[0]
    return await rooms.lanes.admission.run(_sign_in, request, rooms, token, target)


@router.post("/signout")
async def sign_out(request: Request, rooms: AppStateDependency) -> Response:
    """End the session."""
    form = parse_qs((await request.body()).decode("utf-8", "replace"))
    answer = RedirectResponse("/signin", 303, EMPTIED)
    if (token := find_session(request.scope)) is not None:
        try:
            check_csrf(token, form.get("csrf", [""])[0])
            await run_in_threadpool(end_session, rooms.database, token)
        except GarmentqError as error:
            return _draw_form(rooms, "/", error)
        answer.delete_cookie(name_cookie(request.url.scheme), **_flags(request))
    return answer


def _sign_in(request: Request, rooms: AppState, token: str, target: str) -> Response:
    try:
        _refuse_foreign(request)
        rooms.meter.check_address(address_of(request), token or None)
        caller = authenticate_token(rooms.database, token or None, rooms.local_token)
        rooms.meter.take(caller.key)
    except GarmentqError as error:
        _note(request, rooms, error)
        return _draw_form(rooms, target, error)
    rooms.meter.note_key(token)
    return _begin(request, rooms, caller, target)


def _refuse_foreign(request: Request) -> None:
    """Refuse a form that was sent from another site's page, so that it cannot sign a visitor in with a foreign key."""
    if request.headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
        raise SignInNeeded("sign in on the page of this service.")


def _note(request: Request, rooms: AppState, error: GarmentqError) -> None:
    if error.code in (KeyBad.code, LinkUsed.code):
        rooms.meter.note_wrong(address_of(request))


def _begin(request: Request, rooms: AppState, caller: Caller, target: str) -> Response:
    session = begin_session(rooms.database, caller, earlier=find_session(request.scope))
    answer = RedirectResponse(target if LOCAL_PATH.fullmatch(target) else "/", 303, EMPTIED)
    seconds = int(SESSION_SECONDS)
    answer.set_cookie(name_cookie(request.url.scheme), session, max_age=seconds, **_flags(request))
    return answer


def _flags(request: Request) -> dict[str, Any]:
    """Return the cookie's flags: no script reads it, and no other site's page sends it."""
    return {"path": "/", "httponly": True, "samesite": "strict", "secure": request.url.scheme == "https"}


def address_of(request: Request) -> str:
    """Return the address of a request's client; empty if it is unknown."""
    return request.client.host if request.client else ""


def _draw_form(rooms: AppState, target: str, error: GarmentqError | None = None) -> Response:
    refused, status, seconds = Html(), 200, getattr(error, "retry_seconds", RETRY_SECONDS)
    if error is not None:
        message = "enter a key." if isinstance(error, KeyMissing) else make_public_message(error)
        refused, status = html('<p class="error" role="alert">{}</p>', message), error_status(error)
    hint = html(TOKEN_HINT) if rooms.local_token else Html()
    form = html(FORM, refused=refused, target=target if LOCAL_PATH.fullmatch(target) else "/", told=hint)
    answer = draw_shell("Sign in", form, status=status)
    answer.headers.update(make_retry_header(status, seconds))
    return answer


FORM = """<section class="signin"><h1>Sign in</h1>{refused}
<form method="post" action="/signin">
<input type="hidden" name="next" value="{target}">
<label for="token">API key or local token</label>
<input id="token" name="token" type="password" autocomplete="current-password" required autofocus spellcheck="false">
<button type="submit" class="primary">Sign in</button>
</form>
<p>A key begins with <code>gq_</code>; an operator creates it on the page Keys. Your browser stores a
session of 12 hours, not the key.</p>{told}</section>"""

TOKEN_HINT = """\
<p>A service without keys accepts the token in the file <code>api.token</code> of its home, or the link
that it prints when it starts.</p>"""
