"""Signing in, what pages may do, and the files that they load."""

from __future__ import annotations

import gzip
import hashlib
import json

import httpx
import pytest
from garmentq.service.keys import LOCAL_CALLER, create_key, revoke_key
from garmentq.service.pages.markup import Html, html, join
from garmentq.service.pages.shell import POLICY
from garmentq.service.pages.static_files import FOLDER, find_edition, list_imports, load_files
from garmentq.service.sessions import begin_session

VENDOR = FOLDER / "vendor"


@pytest.fixture
def visitor(address, settings):
    """Return a client of the served home that has not signed in."""
    with httpx.Client(base_url=address, timeout=30.0) as opened:
        yield opened


def sign_in(client, token: str):
    """Send the form."""
    return client.post("/signin", data={"token": token, "next": "/"})


def read_csrf(client) -> str:
    """Return what a page sends along with each change."""
    page = client.get("/").text
    return page.split('name="csrf-token" content="')[1].split('"')[0]


def test_the_bundle_is_the_one_that_was_built():
    """Broken where the vendored bundle was changed by hand, lost its licence, or grew beyond its bounds."""
    for told in VENDOR.glob("*.json"):
        known, bundle = json.loads(told.read_text()), told.with_suffix(".js").read_bytes()
        assert hashlib.sha256(bundle).hexdigest() == known["sha256"]
        assert len(bundle) <= 1_000_000 and len(gzip.compress(bundle, 9)) <= 300_000
        assert "MIT License" in told.with_name(f"{told.stem}.LICENSE.txt").read_text()
    assert len(list(VENDOR.glob("*.js"))) == len(list(VENDOR.glob("*.json"))) == 1


def test_static_files_are_those_of_the_folder(visitor):
    """Broken where a path leads out of the folder, a type is wrong, or a browser loads what it has."""
    for name, file in load_files().items():
        answer = visitor.get(f"/static/{name}")
        assert answer.content == file.content and answer.headers["content-type"] == file.media
        assert answer.headers["x-content-type-options"] == "nosniff"
        again = visitor.get(f"/static/{name}", headers={"if-none-match": answer.headers["etag"]})
        assert again.status_code == 304 and not again.content
    packed = visitor.get("/static/vendor/three-0.187.0.js", headers={"accept-encoding": "gzip"})
    assert packed.headers["content-encoding"] == "gzip" and int(packed.headers["content-length"]) <= 300_000
    for edition, lasting in ((find_edition(), "immutable"), ("files-0123456789abcdef", "no-cache")):
        answer = visitor.get(f"/static/{edition}/jobs.js")
        assert lasting in answer.headers["cache-control"] and answer.content == load_files()["jobs.js"].content
    plain = visitor.get("/static/style.css", headers={"accept-encoding": "identity"})
    assert "content-encoding" not in plain.headers
    for wrong in ("nosuch.js", "../shell.py", "..%2fshell.py", "vendor/three-0.187.0.json", "", "vendor",
                  f"{find_edition()}/../shell.py", f"{find_edition()}/"):  # fmt: skip
        assert visitor.get(f"/static/{wrong}").status_code == 404


def test_a_page_names_all_modules_that_it_will_need():
    """Broken where an import is overlooked, so that a browser learns of a module only from another one."""
    named = set(list_imports("result.js"))
    assert {"viewer.js", "shown.js", "pattern_view.js", "frames.js"} < named and named <= set(load_files())
    assert any(name.startswith("vendor/three") for name in named)


def test_pages_lead_to_signing_in_and_back(visitor, settings):
    """Broken where a page shows something to a stranger, or the way back leads to another site."""
    answer = visitor.get("/jobs/3685ecfd4f81?a=1")
    assert answer.status_code == 303 and answer.headers["location"] == "/signin?next=%2Fjobs%2F3685ecfd4f81%3Fa%3D1"
    token = (settings.home / "api.token").read_text()
    for target, wanted in {
        "/jobs/3685ecfd4f81?a=1": "/jobs/3685ecfd4f81?a=1",
        "//evil.example/": "/",
        "/\\evil.example": "/",
        "https://evil.example": "/",
    }.items():
        answer = visitor.post("/signin", data={"token": token, "next": target})
        assert (answer.status_code, answer.headers["location"]) == (303, wanted)
    assert sign_in(visitor, "wrong").status_code == 401
    assert sign_in(visitor, "").status_code == 401
    assert visitor.post("/signin", data={"token": token}, headers={"sec-fetch-site": "cross-site"}).status_code == 403


def test_the_cookie_is_for_this_site_alone(visitor, settings, database):
    """Broken where a script or another site could use the cookie, or the database holds what opens the service."""
    answer = sign_in(visitor, (settings.home / "api.token").read_text())
    cookie = answer.headers["set-cookie"].lower()
    assert all(word in cookie for word in ("httponly", "samesite=strict", "path=/", "max-age=43200"))
    assert "secure" not in cookie and cookie.startswith("garmentq=")
    value = visitor.cookies["garmentq"]
    assert value not in (settings.home / "garmentq.db").read_bytes().decode("latin-1")
    with httpx.Client(base_url=str(visitor.base_url), headers={"x-forwarded-proto": "https"}) as proxied:
        cookie = sign_in(proxied, (settings.home / "api.token").read_text()).headers["set-cookie"]
        assert cookie.startswith("__Host-garmentq=") and "Secure" in cookie


def test_a_session_reads_and_changes_with_its_token_only(visitor, settings):
    """Broken where a page of another site could change something, or a session goes on after signing out."""
    assert visitor.get("/v1/jobs").status_code == 401
    sign_in(visitor, (settings.home / "api.token").read_text())
    assert visitor.get("/v1/jobs").status_code == 200
    wanted = {"jobs": ["3685ecfd4f81"]}
    refused = visitor.post("/v1/jobs/states", json=wanted)
    assert (refused.status_code, refused.json()["code"]) == (403, "session.csrf")
    csrf = {"x-csrf-token": read_csrf(visitor)}
    assert visitor.post("/v1/jobs/states", json=wanted, headers=csrf).status_code == 200
    assert visitor.post("/v1/jobs/states", json=wanted, headers={"x-csrf-token": "0" * 64}).status_code == 403
    assert visitor.post("/signout", data={"csrf": "0"}).status_code == 403
    kept = visitor.cookies["garmentq"]
    assert visitor.post("/signout", data={"csrf": csrf["x-csrf-token"]}).status_code == 303
    again = visitor.get("/v1/jobs", headers={"cookie": f"garmentq={kept}"})
    assert (again.status_code, again.json()["code"]) == (401, "session.ended")


def test_a_session_is_worth_what_its_key_is(visitor, settings, database):
    """Broken where a revoked key still works in a browser, or the local user stays once there are keys."""
    sign_in(visitor, (settings.home / "api.token").read_text())
    row, token = create_key(database, "studio", ("read",))
    assert visitor.get("/v1/jobs").json()["code"] == "session.ended"
    assert visitor.get("/").headers["location"].startswith("/signin")
    assert sign_in(visitor, token).status_code == 303
    csrf = {"x-csrf-token": read_csrf(visitor)}
    assert visitor.get("/v1/jobs").status_code == 200
    assert visitor.post("/v1/scans?name=a.ply", content=b"ply", headers=csrf).json()["code"] == "key.scope_missing"
    revoke_key(database, row.id)
    assert visitor.get("/v1/jobs").json()["code"] == "session.ended"


def test_a_browser_has_one_session_and_keeps_nothing_of_it(address, visitor, settings):
    """Broken where the session before lives on when a browser signs in anew, or the next user of a browser finds the
    meshes of a body in its cache."""
    token = (settings.home / "api.token").read_text()
    sign_in(visitor, token)
    earlier = dict(visitor.cookies)
    with httpx.Client(base_url=address, timeout=30.0) as other:
        sign_in(other, token)
        again = sign_in(visitor, token)
        assert again.headers["clear-site-data"] == '"cache"' and dict(visitor.cookies) != earlier
        assert visitor.get("/").status_code == other.get("/").status_code == 200
        with httpx.Client(base_url=address, timeout=30.0, cookies=earlier) as old:
            assert old.get("/").status_code == 303 and old.get("/v1/jobs").status_code == 401
    csrf = read_csrf(visitor)
    assert "clear-site-data" not in visitor.get("/").headers
    assert visitor.post("/signout", data={"csrf": csrf}).headers["clear-site-data"] == '"cache"'


def test_a_link_signs_in_once(visitor, settings, database):
    """Broken where a link works twice, or a session's cookie passes for one."""
    link = begin_session(database, LOCAL_CALLER, is_link=True)
    assert visitor.get("/v1/jobs", headers={"cookie": f"garmentq={link}"}).status_code == 401
    assert visitor.get("/signin", params={"link": link}).headers["location"] == "/"
    assert visitor.get("/v1/jobs").status_code == 200
    assert visitor.get("/signin", params={"link": link}).status_code == 401
    assert visitor.get("/signin", params={"link": visitor.cookies["garmentq"]}).status_code == 401


def test_templates_escape():
    """Broken where a value could become a tag or leave its attribute."""
    hostile = """<script>alert(1)</script>"'&"""
    assert html('<p title="{}">{}</p>', hostile, Html("<b>x</b>")) == (
        '<p title="&lt;script&gt;alert(1)&lt;/script&gt;&quot;&#x27;&amp;"><b>x</b></p>'
    )
    with pytest.raises(ValueError, match="converts nothing"):
        html("{!r}", "x")
    with pytest.raises(TypeError, match="only HTML"):
        join(["<b>"])  # type: ignore[list-item]


def test_pages_say_what_a_browser_may_do(visitor, settings):
    """Broken where a page may run what stands in it, or load from elsewhere."""
    for path in ("/signin", "/"):
        answer = visitor.get(path)
        sign_in(visitor, (settings.home / "api.token").read_text())
        answer = visitor.get(path)
        assert answer.headers["content-security-policy"] == POLICY and "unsafe" not in POLICY
        assert answer.headers["cache-control"] == "no-store"
        assert "<style" not in answer.text and " style=" not in answer.text and "<script>" not in answer.text


def test_signing_in_in_a_browser(chromium, site):
    """Broken where the form, the session or signing out does not work in a real browser."""
    with chromium.new_context(base_url=site.url) as opened:
        page = opened.new_page()
        page.goto("/jobs/" + site.result)
        page.get_by_label("API key or local token").fill(site.token)
        page.keyboard.press("Enter")
        page.wait_for_url(f"**/jobs/{site.result}")
        assert page.evaluate("document.cookie") == ""
        page.get_by_role("button", name="Sign out").click()
        page.wait_for_url("**/signin")
        page.goto("/")
        assert "/signin" in page.url


def test_a_page_loads_in_a_browser(page, site):
    """Broken where a module of the foundation does not load, or a page asks another host."""
    page.goto(f"/results/{site.result}")
    assert page.title() == "Skirt · tube – garmentq"
    told = page.evaluate("import('/static/api.js').then((api) => api.getJson('/v1/jobs?limit=1000'))")
    assert site.result in [job["job"] for job in told["jobs"]]
    states = "import('/static/api.js').then((api) => api.postJson('/v1/jobs/states', {jobs: [JOB]}))"
    assert page.evaluate(states.replace("JOB", f"'{site.result}'"))["jobs"][0]["state"] == "succeeded"
