"""The cards of a result: garments, pictures, facts, checks and exports, and the camera of its 3D view."""

from __future__ import annotations

import base64
import io
from types import SimpleNamespace

import numpy as np
import pytest
from garmentq.core.deliver.formats.registry import DESCRIPTIONS
from garmentq.core.judge.gates import GATE_RULES
from garmentq.service.models import ArtifactRow, JobRow
from garmentq.service.pages.checks_card import describe_limit, draw_checks
from garmentq.service.pages.exports_card import PURPOSES, describe_size, draw_made
from garmentq.service.pages.facts_card import list_facts
from garmentq.service.pages.garment_words import CHECKS, describe_template, title_check, title_garment
from garmentq.service.records import Artifact, Gate
from person_jobs import keep_person
from PIL import Image
from shells import dress_in_shells

FIT, NECK, SEAMS = "surface_fit_s2t", "neck_finish", "seams"


def make_gate(name: str, verdict: str, value: float, limit: float | None = None) -> Gate:
    """Return a stored check with the limit of this version's rule."""
    rule = next(rule for rule in GATE_RULES if rule.name == name)
    return Gate(name, verdict, value, rule.fail if limit is None else limit, f"{name} says; choose with --part x=y.")


def test_checks_that_did_not_pass_come_first_with_their_limits():
    """Broken where a failed check is folded away, its limits are missing, or a page speaks of a terminal's options."""
    gates = [make_gate(FIT, "pass", 1.6), make_gate(NECK, "doubtful", 0.19), make_gate(SEAMS, "fail", 4.0)]
    shown = str(draw_checks(gates, ["Dropped 7 stray pieces."]))
    assert shown.index("Lengths of seams") < shown.index("Finish of the neck") < shown.index("<details>")
    assert shown.index("<summary>1 of 3 checks passed") < shown.index("Mesh to scan")
    assert "4 mm; passes up to 0.5 mm, fails above 3 mm" in shown and "0.19; passes up to 0.15, fails above 1" in shown
    assert "--part" not in shown and FIT not in shown
    assert str(draw_checks([], [])) == "" and "passed" not in str(draw_checks([], ["A remark."]))


def test_limits_of_another_version_are_not_mixed_with_this_ones():
    """Broken where the first limit of this version's rule stands beside the stored second limit of another version."""
    assert describe_limit(make_gate(FIT, "fail", 4.2, 3.0)) == "4.2 mm; limit 3 mm"
    assert describe_limit(make_gate("flips", "pass", 0.18)) == "0.18 %; passes up to 0.5 %, fails above 3 %"
    assert describe_limit(Gate("unknown", "pass", None, None, "")) == ""


def test_every_check_and_format_has_words():
    """Broken where a rule or a format is added or renamed and the page shows its bare name, or has no line for it."""
    names = {rule.name for rule in GATE_RULES}
    assert set(CHECKS) <= names and all("_" not in title_check(name) for name in names)
    assert title_check("upper.at_rest") == "Upper: drapes at rest"
    assert set(PURPOSES) == set(DESCRIPTIONS) and next(iter(PURPOSES)) == "pdf"
    assert title_garment("tshirt") == "T-shirt" and title_garment("one-piece") == "One-piece"
    assert describe_template("tshirt+neckline=v") == "T-shirt, neckline v"


def test_an_export_shows_its_file_first():
    """Broken where the file that was ordered is hidden, or what the pattern lacks reads as a complaint."""
    job = SimpleNamespace(id="3685ecfd4f81", warnings=["pockets, <b>labels"])
    shown = str(draw_made(job, [Artifact("pieces.pdf", 64 * "0", 34_984)], None))
    assert shown.index("pieces.pdf") < shown.index("Not in this pattern") < shown.index("pockets, &lt;b&gt;labels")
    assert "35 kB" in shown and "Made of" not in shown
    assert [describe_size(size) for size in (7, 999_400, 1_234_567_890)] == ["7 bytes", "999 kB", "1.23e+03 MB"]


SCAN = {
    "name": "scan", "units": "cm", "up": "z", "is_cloud": False, "vertex_count": 30482, "face_count": 59884,
    "file_count": 30488, "extent_m": [1.2008, 1.6661, 0.3122], "has_colours": True, "has_labels": False,
    "notes": ["Split 9 vertices.", "Turned 3 pieces."],
}  # fmt: skip


@pytest.mark.parametrize("changes", [{}, {"is_cloud": True, "has_colours": False, "file_count": 30482, "notes": []}])
def test_facts_are_those_of_the_form(page, changes):
    """Broken where a stored description reads differently on a job's page and in the form that submits a scan."""
    found = {"as": "person", "scan": SCAN | changes, "body": {"height_m": 1.7}, "category": None, "contours_m": None}
    job = SimpleNamespace(details={"checked": found}, kind="person")
    page.goto("/")
    script = "(found) => import('/static/inspection.js').then((own) => own.tellInspection(found))"
    told = page.evaluate(script, found | {"is_sure": True, "remarks": []})
    assert [list(row) for row in list_facts(job)] == [row for row in told if row[0] != "Result"]


def test_a_stored_description_of_another_version_is_no_error():
    """Broken where a result of an earlier version, or of a kind without files, has no page."""
    for details in ({}, {"checked": None}, {"checked": {"as": "garment", "scan": {"extent_m": []}}, "parts": {}}):
        assert dict(list_facts(SimpleNamespace(details=details, kind="recover"))).keys() <= {"Detected as"}


def test_a_person_shows_garments_first_and_the_body_on_demand(page, site, whole_tube, tmp_path):
    """Broken where a body without clothes is sent before a visitor wants it, or garments are not above the pictures."""
    person = keep_person(site.services, tmp_path / "anna", dress_in_shells(1))
    garment = site.keep("upper")
    with site.services.database.write() as session:
        session.get(JobRow, garment).parent = person
    report = site.services.store.put_bytes(make_report())
    with site.services.database.write() as session:
        file = {"kind": "result", "name": "report.html", "sha256": report.sha256, "size": report.size, "created": 0.0}
        session.add(ArtifactRow(job=person, **file))
    sent = []
    page.on("request", lambda request: sent.append(request.url))
    page.goto(f"/results/{person}")
    page.locator("#result[data-ready]").wait_for()
    heads = page.locator("h2").all_inner_texts()
    assert heads.index("Garments") < heads.index("Pictures") < heads.index("Detected in the files")
    link = page.locator("#garments a")
    assert link.get_attribute("href") == f"/results/{garment}" and link.inner_text() == "Skirt"
    heads = page.locator(".pictures > figure figcaption").all_inner_texts()
    assert heads == ["Scan", "Parts", "Confidence", "another"]
    assert not [url for url in sent if url.endswith("/pictures/0/1") or url.endswith("/pictures/0")]
    page.get_by_text("Show body").click()
    body = page.locator(".bare img")
    assert body.evaluate("(image) => image.decode().then(() => image.naturalWidth)") == 10
    for wrong in ("0/4", "0/-1", "1/0", "7/0"):
        assert page.context.request.get(f"/results/{person}/pictures/{wrong}").status == 404


def make_report() -> bytes:
    """Return a report with a sheet of four columns, 10 pixels each, and a picture that is no sheet."""
    out = io.BytesIO()
    Image.new("RGB", (40, 9), "white").save(out, "PNG")
    data = base64.b64encode(out.getvalue()).decode()
    titles = ("scan, body, parts and confidence from three sides", "another")
    return "".join(f'<img style="" alt="{title}" src="data:image/png;base64,{data}">' for title in titles).encode()


def test_the_camera_frames_the_whole_figure_at_every_size_and_angle(page):
    """Broken where feet or hands are cut off, at first, after a view button, as it turns, or in another window size."""
    page.goto("/")
    script = """async () => {
      const { Viewer } = await import('/static/viewer.js');
      const place = document.createElement('div'), found = [];
      document.body.append(place);
      const figure = [0, 0, 0, 0.1, 1.7, 0, 0.6, 1.1, 0.1, -0.6, 1.1, 0.1, 0, 0.02, 0.18, 0, 1.0, -0.15];
      const viewer = new Viewer(place);
      viewer.add('figure', Float32Array.from(figure), Uint16Array.from([0, 1, 2, 3, 4, 5]));
      const corners = Array.from({ length: figure.length / 3 }, (_, n) => figure.slice(3 * n, 3 * n + 3));
      const measure = () => {
        viewer.camera.updateMatrixWorld();
        const box = place.getBoundingClientRect(), points = corners.map((corner) => viewer.project(corner));
        return [0, 1].map((axis) => Math.max(...points.map((point) =>
          Math.abs((point[axis] - (axis ? box.top : box.left)) / (axis ? box.height : box.width) - 0.5))));
      };
      for (const [width, height] of [[300, 620], [620, 620], [1240, 300]]) {
        Object.assign(place.style, { width: `${width}px`, height: `${height}px` });
        viewer.frame();
        viewer.resize();
        for (const angle of [0, Math.PI / 2, Math.PI, -Math.PI / 2]) {
          viewer.frame(angle);
          found.push(measure());
        }
        for (let n = 0; n < 12; n += 1) { viewer.turn(Math.PI / 6); found.push(measure()); }
      }
      return found;
    }"""
    shares = np.array(page.evaluate(script))
    assert (shares < 0.5).all() and (shares.max(axis=1) > 0.4).mean() > 0.5  # whole, and not small


def test_the_turntable_turns_and_rests_for_who_wants_no_motion(open_window, site):
    """Broken where the turntable does not turn, cannot be stopped, or turns for a visitor who wants no motion."""
    script = """new Promise((done) => { const place = document.querySelector('#space'); let count = 0;
      place.addEventListener('drawn', () => { count += 1; }); setTimeout(() => done(count), 400); })"""
    with open_window() as opened:
        page = opened.new_page()
        page.goto(f"/results/{site.result}")
        page.locator("#result[data-ready]").wait_for()
        button = page.get_by_role("button", name="Turntable")
        assert page.evaluate(script) == 0
        button.click()
        assert page.evaluate(script) > 1 and button.get_attribute("aria-pressed") == "true"
        page.get_by_role("button", name="Back", exact=True).click()
        assert button.get_attribute("aria-pressed") == "false"
        button.click()
        page.emulate_media(reduced_motion="reduce")
        button.wait_for(state="hidden")
        assert page.evaluate(script) <= 1
