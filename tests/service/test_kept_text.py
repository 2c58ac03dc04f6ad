"""Text that nothing can keep, NUL and half of a surrogate pair, is refused by a code wherever it comes in."""

from __future__ import annotations

import json
import socket
from copy import deepcopy

import httpx
import numpy as np
import pytest
from api_client import local_user, serving
from api_routes import list_routes
from garmentq.cli.size_table import read_sizes
from garmentq.core.body.measures_file import MeasuresBad, read_measures
from garmentq.core.body.motion.errors import MotionBad
from garmentq.core.body.motion.keys import read_keys
from garmentq.core.cloth.fabric_file import FabricFileBad, read_fabrics
from garmentq.core.garment.errors import PatternValueBad
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.pieces.allowance import read_allowances
from garmentq.core.garment.pieces.errors import AllowanceBad
from garmentq.core.garment.templates import load_template
from garmentq.core.run.text import TextBad, has_unstorable_text, read_json
from garmentq.core.scan.labels import read_labels
from garmentq.core.scan.refusal import LabelsUnreadable
from garmentq.service.api.app import make_app
from garmentq.service.api.limits import ApiLimits
from garmentq.service.kinds import FileRef, pack_request
from garmentq.service.kinds.person_request import PersonRequest
from garmentq.service.matching import PairsUnreadable, read_pairs
from garmentq_home import put_file
from sqlalchemy import text

WORDS = ("\x00", "a\x00b", "\ud800", "a\udfff", "\udc00\ud800")
CODED = ("%00", "a%00b", "%ED%A0%80", "%ff", "%C3")
"""The same in an address, and what is no UTF-8 at all."""

ID = {
    **dict.fromkeys(("job", "key", "webhook", "share", "subject"), "0123456789ab"), "sha256": "ab" * 32, "name": "x",
    "tag": "x",
}  # fmt: skip
JSON = {"content-type": "application/json"}
FREE = ApiLimits(requests_per_second=1e6, burst=10**6)


@pytest.fixture
def client(settings):
    """Return a client of the served home, as the local user."""
    with serving(settings, FREE) as url:
        with httpx.Client(base_url=url, timeout=60.0, headers=local_user(settings)) as opened:
            yield opened


def test_no_address_with_such_a_text_is_a_fault(client, settings):
    """Broken where a route hands a path or a query on to a database that refuses it, or looks for another name."""
    asked = 0
    for method, path, parameters in list_routes(settings):
        for parameter in parameters:
            for code in CODED:
                values, query = dict(ID), ""
                if parameter["in"] == "path":
                    values[parameter["name"]] = code
                else:
                    query = f"?{parameter['name']}={code}"
                answer = client.request(method, path.format(**values) + query)
                assert (answer.status_code, answer.json()["code"]) == (422, "text.bad"), (method, path, parameter, code)
                asked += 1
    assert asked > 200
    for page in ("/?name=", "/jobs/", "/match?a=", "/signin?next=", "/signin?link=", "/static/"):
        for code in CODED:
            assert client.get(page + code).json()["code"] == "text.bad", page
    assert client.get("/v1/query", params={"garment": "größe 😀"}).status_code == 200


def put_everywhere(value, word: str):
    """Yield JSON values, each with a word in place of one text or name somewhere in it, or beside it."""
    if isinstance(value, str):
        yield word
    elif isinstance(value, dict):
        yield {**value, word: 1}
        for name, one in value.items():
            yield from ({**value, name: put} for put in put_everywhere(one, word))
    elif isinstance(value, list):
        for at, one in enumerate(value):
            yield from ([*value[:at], put, *value[at + 1 :]] for put in put_everywhere(one, word))


def test_no_body_with_such_a_text_is_a_fault(client, settings):
    """Broken where a text deep in a request reaches a database, a file or an answer that cannot hold it."""
    app, asked = make_app(settings), 0
    app.state.rooms.database.dispose()
    document = app.openapi()
    for path, methods in document["paths"].items():
        for method, told in methods.items():
            schema = told.get("requestBody", {}).get("content", {}).get("application/json", {}).get("schema", {})
            for one in schema.get("oneOf", schema.get("anyOf", [schema])):
                if "$ref" not in one:
                    continue
                example = document["components"]["schemas"][one["$ref"].rsplit("/", 1)[1]]["example"]
                for word in ("a\x00b", "\ud800"):
                    for body in put_everywhere(example, word):
                        for content in (json.dumps(body).encode(), spell(body)):
                            answer = client.request(method, path.format(**ID), content=content, headers=JSON)
                            assert (answer.status_code, answer.json()["code"]) in (
                                (422, "text.bad"), (422, "request.bad")
                            ), (method, path, body, answer.text)  # fmt: skip
                            asked += 1
                deep = {"kind": "dress", "result": ID["job"], "options": {"sizes": [{"name": "a\x00b"}]}}
    assert client.post("/v1/jobs", json=deep).json()["code"] == "text.bad"
    assert asked > 100
    assert client.post("/v1/patterns/check", content=b"").status_code == 422
    assert client.post("/v1/patterns/check", content=b"\xff").status_code in (400, 422)


def spell(body) -> bytes:
    """Return JSON with its letters themselves instead of escapes."""
    return json.dumps(body, ensure_ascii=False).encode("utf-8", "surrogatepass")


def test_no_header_with_such_a_text_is_a_fault(client):
    """Broken where NUL in a header reaches the application."""
    for name in ("Authorization", "Idempotency-Key", "Cookie", "X-Forwarded-For"):
        with socket.create_connection((client.base_url.host, client.base_url.port), timeout=30) as opened:
            opened.sendall(f"GET /v1/jobs HTTP/1.1\r\nHost: 127.0.0.1\r\n{name}: a\x00b\r\n\r\n".encode())
            assert b" 400 " in opened.recv(4096)


def test_no_command_with_such_a_text_is_a_traceback(cli, settings, database, queue_job, tmp_path):
    """Broken where an argument that is no UTF-8 ends in a traceback, or a file of such a name cannot be read."""
    job, bad = queue_job(), "a\udcffb"
    commands = (
        ("status", bad), ("delete", "--person", bad), ("keys", "create", bad), ("keys", "revoke", bad),
        ("query", "--where", f"name = {bad}"), ("materials", "show", bad), ("templates", "show", bad), ("result", bad),
        ("match", job, bad), ("webhooks", "delete", bad), ("webhooks", "create", f"https://a.example/{bad}"),
        ("dress", job, "--body", f"builtin:{bad}"), ("audit", "--key", bad), ("export", job, "--as", bad),
    )  # fmt: skip
    with serving(settings) as url:
        for words in commands:
            for variables in ({}, {"GARMENTQ_URL": url}):
                done = cli(*words, **variables)
                assert (done.returncode, done.stderr) == (4, f"error text.bad: {TextBad().message}\n"), words
    odd = put_file(tmp_path, "odd.ply").rename(tmp_path / "caf\udce9.ply")
    done = cli("submit", odd, "--body", "builtin:female")
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("word", WORDS)
def test_no_statement_takes_such_a_text(database, word):
    """Broken where SQLite keeps what PostgreSQL refuses, or the refusal is the driver's."""
    with pytest.raises(TextBad), database.write() as session:
        session.execute(text("select :word"), {"word": word})
    with database.read() as session:
        assert session.execute(text("select :word"), {"word": "größe 😀"}).scalar() == "größe 😀"
    with pytest.raises(TextBad):
        pack_request(PersonRequest(FileRef("ab" * 32, "a.ply"), marks=(word,)))


def test_a_pattern_with_such_a_text_is_named(client, settings):
    """Broken where a contour's name crashes the reader, in a file or in an order, and no code says what is wrong."""
    document = write_pattern(load_template("skirt"))
    own = next(name for name, value in document["properties"].items() if isinstance(value, dict) and "panels" in value)
    for word in WORDS:
        panels = document["properties"][own]["panels"]
        name = next(name for name in panels if panels[name].get("contours"))
        for place in ("contours", "grainline", word):
            changed = deepcopy(document)
            changed["properties"][own]["panels"][name][place] = [word] * 9 if place != word else 1
            for source in (changed, json.dumps(changed), spell(changed)):
                with pytest.raises(PatternValueBad, match="surrogate"):
                    read_pattern(source)
    kept = client.post("/v1/patterns", params={"name": "p.json"}, content=json.dumps(changed)).json()["sha256"]
    answer = client.get("/v1/match", params={"first": kept, "second": "skirt"})
    assert (answer.status_code, answer.json()["code"]) == (422, "pattern.value_bad")
    answer = client.put("/v1/templates/mine", content=json.dumps(changed))
    assert (answer.status_code, answer.json()["code"]) == (422, "pattern.value_bad")


@pytest.mark.parametrize(
    ("read", "name", "content", "refusal"),
    [
        (read_fabrics, "f.json", {"fabrics": [{"name": "X", "title": "X", "parameters": {}}]}, FabricFileBad),
        (read_measures, "m.json", {"gender": "female", "height": 170, "note": "X"}, MeasuresBad),
        (read_keys, "k.json", {"fps": 30, "keys": [{"t": 0, "pose": "A"}], "author": "X"}, MotionBad),
        (read_labels, "l.json", ["top", "X"], LabelsUnreadable),
        (read_pairs, "p.json", {"front": "X"}, PairsUnreadable),
    ],
)
def test_no_reader_takes_such_a_text(tmp_path, read, name, content, refusal):
    """Broken where a file's text goes on to what cannot hold it."""
    for word in WORDS:
        path = tmp_path / name
        path.write_text(json.dumps(content).replace("X", json.dumps(word)[1:-1]))
        with pytest.raises(refusal):
            read(path)


def test_other_readers_of_texts(tmp_path):
    """Broken where labels of an array, allowances or sizes take such a text, or sound ones are refused."""
    for word in ("a\x00b", "\ud800"):
        np.save(tmp_path / "l.npy", np.array(["top", word]))
        with pytest.raises(LabelsUnreadable):
            read_labels(tmp_path / "l.npy")
        with pytest.raises(AllowanceBad):
            read_allowances(json.dumps({word: 10}))
        with pytest.raises(Exception, match="table of sizes"):
            read_sizes(json.dumps([{"name": word}]))
    np.save(tmp_path / "l.npy", np.array(["top", "größe"]))
    assert read_labels(tmp_path / "l.npy").tolist() == ["top", "größe"]
    assert read_json('{"a": "\\ud83d\\ude00"}') == {"a": "😀"} and not has_unstorable_text(
        {"a": ["😀", ("x", 1, None)]}
    )
