"""What is wrong with a pattern is told with its place, in the numbers and the unit of its file."""

from __future__ import annotations

import json
from copy import deepcopy

import numpy as np
import pytest
from garmentq.core.garment.errors import PatternFault
from garmentq.core.garment.examine import examine_file
from garmentq.core.garment.garmentcode import read_pattern
from garmentq.core.garment.garmentcode_writer import write_pattern
from garmentq.core.garment.templates import load_template

TSHIRT = write_pattern(load_template("tshirt"))


@pytest.fixture
def examine(tmp_path):
    """Return what is found in a document."""

    def find(document) -> dict:
        path = tmp_path / "pattern.json"
        path.write_text(document if isinstance(document, str) else json.dumps(document))
        return examine_file(str(path))

    return find


def spoil(change) -> dict:
    """Return the T-shirt after a change of its panels and stitches."""
    document = deepcopy(TSHIRT)
    change(document["pattern"]["panels"], document["pattern"]["stitches"])
    return document


def errors(found: dict) -> list[dict]:
    """Return the findings that keep a pattern from being draped."""
    return [one for one in found["findings"] if one["severity"] == "error"]


def test_sound_pattern_is_measured(examine):
    """Broken where lengths, areas, seams or the symmetry of a pattern that anybody can measure come out otherwise."""
    found = examine(TSHIRT)
    assert found["is_sound"] and found["findings"] == []
    front = next(one for one in found["panels"] if one["panel"] == "front")
    assert front["edges_mm"][0] == pytest.approx(420.0) and front["edges_mm"][8] == pytest.approx(510.0)
    side = found["seams"][5]
    assert (side["a"], side["b"]) == ({"panel": "back", "edge": 8}, {"panel": "front", "edge": 0})
    assert side["lengths_mm"] == pytest.approx([420.0, 420.0]) and abs(side["mismatch_mm"]) < 1e-6
    mirrors = {(one["source"], one["target"]): one for one in found["mirrors"]}
    assert [8, 0] in mirrors["front", "front"]["vertices"] and ("sleeve_back_left", "sleeve_back_right") in mirrors
    assert mirrors["front", "front"]["matrix"][0] == pytest.approx([-1.0, 0.0], abs=1e-9)


def test_mirror_moves_the_image(examine, skirt_file):
    """Broken where a panel that the file draws the other way round gets its image's move in other axes than its own."""
    for document in (TSHIRT, skirt_file):
        found = examine(document)
        assert found["mirrors"]
        for mirror in found["mirrors"]:
            source, target = (document["pattern"]["panels"][mirror[side]]["vertices"] for side in ("source", "target"))
            (a, b), (c, d) = mirror["vertices"][0], mirror["vertices"][1]
            was = [source[c][k] - source[a][k] for k in (0, 1)]
            now = [target[d][k] - target[b][k] for k in (0, 1)]
            image = [sum(row[k] * was[k] for k in (0, 1)) for row in mirror["matrix"]]
            assert image == pytest.approx(now, abs=0.5)


def test_crossing_is_told_with_its_point(examine):
    """Broken where a panel's crossing is told without both edges and the point, in the file's axes and unit."""

    def cross(panels, _):
        panels["front"]["vertices"] = [[0, 0], [10, 0], [0, 10], [10, 10]]
        panels["front"]["edges"] = [{"endpoints": [k, (k + 1) % 4]} for k in range(4)]

    document = spoil(cross)
    document["pattern"]["stitches"] = []
    found = [one for one in errors(examine(document)) if one["code"] == "pattern.self_crossing"]
    assert [place["edge"] for place in found[0]["places"]] == [1, 3]
    for place in found[0]["places"]:
        assert place["panel"] == "front" and place["point"] == pytest.approx([5.0, 5.0])


WRONG = [
    ("pattern.degenerate", lambda p, s: p["front"]["vertices"].__setitem__(0, p["front"]["vertices"][1]), (0, "front")),
    ("pattern.open_loop", lambda p, s: p["back"]["edges"].pop(2), (1, "back")),
    ("pattern.seam_unknown", lambda p, s: s[3][0].__setitem__("edge", 99), (None, "back")),
    ("pattern.seam_unknown", lambda p, s: s[3][0].__setitem__("panel", "hood"), (None, "hood")),
    ("pattern.edge_sewn_twice", lambda p, s: s.__setitem__(3, s[2]), (3, "back")),
    ("pattern.panel_loose", lambda p, s: s.__delitem__(slice(6, None)), (None, "sleeve_front_left")),
    ("pattern.seam_unequal", lambda p, s: p["front"]["vertices"].__setitem__(0, [25.5, -80.0]), (8, "back")),
]


@pytest.mark.parametrize(("code", "change", "place"), WRONG, ids=[f"{w[0]}-{w[2][1]}" for w in WRONG])
def test_fault_is_told_with_its_place(examine, code, change, place):
    """Broken where a pattern that cannot be sewn is let through, or is told of without the panel and the edge."""
    found = errors(examine(spoil(change)))
    assert found[0]["code"] == code
    assert (found[0]["places"][0]["edge"], found[0]["places"][0]["panel"]) == place


def test_small_mismatch_is_a_warning_and_a_gather_none(examine):
    """Broken where a seam that can be sewn is refused, or one that is gathered on purpose is told of."""
    document = spoil(lambda panels, _: panels["front"]["vertices"].__setitem__(0, [25.5, -63.8]))
    found = examine(document)
    assert found["is_sound"] and [(one["code"], one["seam"]) for one in found["findings"]] == [
        ("pattern.seam_unequal", 5)
    ]
    document["properties"]["garmentq"]["gathered"] = [5]
    assert examine(document)["findings"] == []


def test_panel_too_narrow_for_its_mesh_is_named(examine):
    """Broken where a pattern that cannot be meshed is found sound, or nobody says which panel."""

    def narrow(panels, _):
        panels["sleeve_back_left"]["vertices"][1] = [-19.1, -4.3]
        panels["sleeve_back_left"]["vertices"][2] = [-25.41, -21.51]

    document = spoil(narrow)
    document["properties"]["garmentq"]["gathered"] = list(range(12))
    found = errors(examine(document))
    assert found and {place["panel"] for one in found for place in one["places"]} == {"sleeve_back_left"}


@pytest.mark.parametrize("document", [{}, {"pattern": {}}, {"pattern": {"panels": 7}}])
def test_what_is_no_pattern_is_one_finding(examine, document):
    """Broken where a document that is no pattern ends in an error instead of an answer."""
    found = examine(document)
    assert not found["is_sound"] and len(found["findings"]) == 1 and found["panels"] == []


@pytest.mark.parametrize("text", ["", "[]", "{", "null", '{"pattern": NaN}'])
def test_what_is_no_document_is_refused(examine, text):
    """Broken where bytes that are no JSON object are examined as a pattern."""
    with pytest.raises(PatternFault):
        examine(text)


def as_browser(text: str) -> float:
    """Return a number as a browser writes it: a whole one without a point."""
    return int(float(text)) if float(text).is_integer() else float(text)


def test_read_and_written_again_is_the_same_file():
    """Broken where a document that nobody changed gets other bytes: an undo to the start would be no undo."""
    generator = np.random.default_rng(4)
    for name in ("tshirt", "pencil_skirt", "sleeved_jumpsuit"):
        pattern = load_template(name)
        for unit in (100, 1000, 39.37, 1):
            pattern.extra["units_in_meter"] = unit
            moved = pattern.with_points(pattern.points + generator.normal(0.0, 1e-3, pattern.points.shape))
            first = json.dumps(write_pattern(moved), indent=1)
            assert json.dumps(write_pattern(read_pattern(first)), indent=1) == first
            plain = json.dumps(json.loads(first, parse_float=as_browser))
            assert json.dumps(write_pattern(read_pattern(plain)), indent=1) == first
