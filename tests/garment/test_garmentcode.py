"""The pattern JSON: round trips, mirrored panels, stitches, and files that must be refused."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest
from garmentq.core.garment.curves import edge_length, edge_points, panel_area
from garmentq.core.garment.garmentcode import load_pattern, read_pattern
from garmentq.core.garment.garmentcode_writer import save_pattern, write_pattern
from garmentq.core.garment.orientation import place_points
from garmentq.core.garment.pattern import EdgeRef
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.run.errors import BadInput
from hypothesis import given, settings
from hypothesis import strategies as st


def _same(a, b, tolerance=1e-12):
    for one, two in zip(a.panels, b.panels, strict=True):
        assert one.name == two.name and one.mirrored == two.mirrored
        assert one.points == pytest.approx(two.points, abs=tolerance)
        assert one.translation == pytest.approx(two.translation, abs=tolerance)
        assert one.rotation == pytest.approx(two.rotation, abs=1e-12)
        for i in range(len(one.edges)):
            assert one.edges[i].kind == two.edges[i].kind
            assert edge_points(one, i, 9) == pytest.approx(edge_points(two, i, 9), abs=tolerance)
    assert a.seams == b.seams


@pytest.mark.parametrize("name", ["skirt_file", "tee_file"])
def test_round_trip_keeps_the_geometry(name, request, tmp_path):
    """Breaks where export forgets a unit, a mirror, a curve's side or the gathered mark."""
    pattern = read_pattern(request.getfixturevalue(name))
    again = load_pattern(save_pattern(pattern, tmp_path / "pattern.json"))
    _same(pattern, again, 1e-9)


def test_export_draws_what_the_file_drew(skirt_file):
    """Breaks where a clockwise panel comes out mirrored, or where vertices or circles change on the way."""
    out = write_pattern(read_pattern(skirt_file))
    for name, panel in skirt_file["pattern"]["panels"].items():
        new = out["pattern"]["panels"][name]
        assert np.array(new["vertices"]) == pytest.approx(np.array(panel["vertices"], float), abs=1e-9)
        assert new["translation"] == pytest.approx(panel["translation"])
        for old_edge, new_edge in zip(panel["edges"], new["edges"], strict=True):
            assert new_edge["endpoints"] == old_edge["endpoints"]
            old = old_edge.get("curvature")
            if old is not None:
                assert new_edge["curvature"]["type"] == old["type"]
                assert np.array(new_edge["curvature"]["params"]) == pytest.approx(np.array(old["params"]), rel=1e-9)
    assert out["pattern"]["stitches"] == skirt_file["pattern"]["stitches"]


def test_unknown_keys_survive(skirt_file):
    """Breaks where export drops what another program put into the file."""
    out = write_pattern(read_pattern(skirt_file))
    assert out["parameters"] == {"length": {"value": 1}}
    assert out["properties"]["author"] == "a test"
    assert out["pattern"]["panel_order"] == ["front"]
    assert out["pattern"]["panels"]["front"]["colour"] == "red"
    assert out["pattern"]["panels"]["front"]["label"] == "leg"


def test_clockwise_panel_is_mirrored_in_its_place(skirt_file):
    """Breaks where mirroring moves the panel in 3D or leaves its normal inside."""
    pattern = read_pattern(skirt_file)
    back = pattern.panel("back")
    assert back.mirrored and not pattern.panel("front").mirrored
    assert all(panel_area(panel) > 0 for panel in pattern.panels)
    assert back.rotation[:, 2] == pytest.approx([0, 0, -1])
    assert np.linalg.det(back.rotation) == pytest.approx(1.0)
    drawn = np.array(skirt_file["pattern"]["panels"]["back"]["vertices"]) / 100
    there = np.column_stack([drawn, np.zeros(4)]) + np.array([-0.25, 0.5, -0.2])
    assert place_points(back, back.points) == pytest.approx(there, abs=1e-12)


def test_gathered_seam_is_marked(skirt_file):
    """Breaks where the ratio is taken of chords: the front's 40 cm go into a band of an arc over 32 cm."""
    seams = read_pattern(skirt_file).seams
    assert [seam.gathered for seam in seams] == [False, False, True]


def test_units_scale_everything(skirt_file):
    """Breaks where radii, absolute handles or translations are read in another unit than the vertices."""
    metres = copy.deepcopy(skirt_file)
    metres["properties"]["units_in_meter"] = 1
    for panel in metres["pattern"]["panels"].values():
        panel["vertices"] = (np.array(panel["vertices"]) / 100).tolist()
        panel["translation"] = (np.array(panel["translation"]) / 100).tolist()
        for edge in panel["edges"]:
            if edge.get("curvature", {}).get("type") == "circle":
                edge["curvature"]["params"][0] /= 100
    _same(read_pattern(skirt_file), read_pattern(metres), 1e-12)


def test_absolute_handles_are_the_same_curve(skirt_file):
    """Breaks where absolute handles are taken for relative ones."""
    absolute = copy.deepcopy(skirt_file)
    absolute["properties"]["curvature_coords"] = "absolute"
    for panel in absolute["pattern"]["panels"].values():
        for edge in panel["edges"]:
            curve = edge.get("curvature", {})
            if curve.get("type") in ("quadratic", "cubic"):
                start, end = (np.array(panel["vertices"][i], float) for i in edge["endpoints"])
                left = np.array([-(end - start)[1], (end - start)[0]])
                curve["params"] = [(start + a * (end - start) + b * left).tolist() for a, b in curve["params"]]
    _same(read_pattern(skirt_file), read_pattern(absolute), 1e-12)


def test_circle_side_and_size(skirt_file):
    """Breaks where `right` or `large_arc` is misread: right of the chord is below an edge that runs to +x."""
    band = read_pattern(skirt_file).panel("band")
    drop = 0.60 - np.sqrt(0.60**2 - 0.16**2)
    assert edge_points(band, 0, 2)[1] == pytest.approx([0.16, -drop], abs=1e-12)
    assert edge_length(band, 0) == pytest.approx(1.2 * np.arcsin(0.16 / 0.6), rel=1e-12)


def test_shuffled_edges_are_put_in_order(tee_file):
    """Breaks where edges are taken in file order, or stitches keep the file's numbers."""
    shuffled = copy.deepcopy(tee_file)
    order = [0, 3, 6, 1, 4, 7, 2, 5]
    edges = shuffled["pattern"]["panels"]["front"]["edges"]
    shuffled["pattern"]["panels"]["front"]["edges"] = [edges[k] for k in order]
    shuffled["pattern"]["panels"]["front"]["edges"][3]["endpoints"] = [2, 1]
    for stitch in shuffled["pattern"]["stitches"]:
        for side in stitch:
            if side["panel"] == "front":
                side["edge"] = order.index(side["edge"])
    _same(read_pattern(tee_file), read_pattern(shuffled))


def test_a_panel_drawn_from_inside_is_turned(tee_file):
    """Breaks where a back that is drawn counter-clockwise from the front is sewn inside out."""
    inside = copy.deepcopy(tee_file)
    inside["pattern"]["panels"]["back"]["rotation"] = [0, 0, 0]
    for stitch in inside["pattern"]["stitches"]:
        for side in stitch:
            if side["panel"] == "back":
                # The same outline stands unturned: left is right, and edge i lies where 8 - i was, hem apart.
                side["edge"] = (8 - side["edge"]) % 8
    pattern = read_pattern(inside)
    assert pattern.panel("back").rotation[:, 2] == pytest.approx([0, 0, -1])
    assert pattern.panel("front").rotation[:, 2] == pytest.approx([0, 0, 1])
    _same(pattern, read_pattern(json.dumps(write_pattern(pattern))), 1e-9)
    garment = mesh_pattern(pattern, edge_length=0.05)
    assert len(garment.faces)


def _change(path, value):
    def change(file):
        at = file
        for key in path[:-1]:
            at = at[key]
        at[path[-1]] = value

    return change


def _remove(*path):
    def change(file):
        at = file
        for key in path[:-1]:
            at = at[key]
        del at[path[-1]]

    return change


FRONT = ("pattern", "panels", "front")
STITCHES = ("pattern", "stitches")


@pytest.mark.parametrize(
    ("code", "change"),
    [
        ("pattern.incomplete", _remove("pattern")),
        ("pattern.incomplete", _remove("pattern", "panels")),
        ("pattern.incomplete", _change(("pattern", "panels"), {})),
        ("pattern.incomplete", _remove(*FRONT, "vertices")),
        ("pattern.incomplete", _remove(*FRONT, "edges", 0, "endpoints")),
        ("pattern.units_missing", _remove("properties", "units_in_meter")),
        ("pattern.value_bad", _change(("properties", "units_in_meter"), 0)),
        ("pattern.value_bad", _change(("properties", "units_in_meter"), "cm")),
        ("pattern.value_bad", _change((*FRONT, "vertices", 0), [0, "x"])),
        ("pattern.value_bad", _change((*FRONT, "vertices", 0), [0, float("nan")])),
        ("pattern.value_bad", _change((*FRONT, "vertices", 0), [0, 10**400])),
        ("pattern.value_bad", _change((*FRONT, "edges", 0, "endpoints"), [0, 99])),
        ("pattern.value_bad", _change((*FRONT, "edges", 0, "endpoints"), [0, -1])),
        ("pattern.value_bad", _change((*FRONT, "edges", 0, "curvature"), {"type": "spline", "params": []})),
        ("pattern.value_bad", _change((*FRONT, "edges", 0, "curvature"), {"type": "circle", "params": [1, 0, 0]})),
        ("pattern.value_bad", _change((*FRONT, "translation"), [0, 0])),
        ("pattern.open_loop", _remove(*FRONT, "edges", 0)),
        ("pattern.open_loop", _change((*FRONT, "edges", 0, "endpoints"), [0, 2])),
        ("pattern.self_crossing", _change((*FRONT, "vertices", 1), [20, 60])),
        ("pattern.degenerate", _change((*FRONT, "vertices", 1), [0, 0])),
        ("pattern.seam_unknown", _change((*STITCHES, 0, 0, "panel"), "hood")),
        ("pattern.seam_unknown", _change((*STITCHES, 0, 0, "edge"), 7)),
        ("pattern.edge_sewn_twice", _change((*STITCHES, 0, 0, "edge"), 3)),
        ("pattern.value_bad", _change(STITCHES, {"a": 1})),
        ("pattern.value_bad", _change(("pattern", "panels", "a\x00"), {})),
        ("pattern.value_bad", _change(("pattern", "panels", "a" * 201), {})),
        ("pattern.value_bad", _change((*FRONT, "label"), "\ud800")),
        ("pattern.value_bad", _change(("properties", "garmentq"), {"category": "a" * 33})),
        ("pattern.incomplete", _change((*STITCHES, 0), [])),
    ],
)
def test_bad_files_get_a_code_and_one_line(skirt_file, code, change):
    """Breaks where a malformed file raises anything else, or gives a pattern."""
    change(skirt_file)
    with pytest.raises(BadInput) as caught:
        read_pattern(skirt_file)
    assert caught.value.code == code
    assert caught.value.message and "\n" not in caught.value.message


@pytest.mark.parametrize(
    "text",
    [
        "",
        "no json",
        "[" * 100_000,
        '{"pattern": NaN}',
        "[]",
        "null",
        b"\xff\xfe\x00",
        '{"pattern": ' + "9" * 5000 + "}",
    ],
)
def test_hostile_text_is_refused(text):
    """Breaks where the parser's own errors (depth, digits, encoding) reach the user."""
    with pytest.raises(BadInput) as caught:
        read_pattern(text)
    assert caught.value.code.startswith("pattern.")


def test_size_caps(skirt_file, tmp_path):
    """Breaks where a huge file or thousands of panels are read to the end."""
    many = {f"p{i}": skirt_file["pattern"]["panels"]["front"] for i in range(201)}
    skirt_file["pattern"] = {"panels": many, "stitches": []}
    with pytest.raises(BadInput) as caught:
        read_pattern(skirt_file)
    assert caught.value.code == "pattern.too_large"
    (tmp_path / "big.json").write_bytes(b" " * 10_000_001)
    with pytest.raises(BadInput) as caught:
        load_pattern(tmp_path / "big.json")
    assert caught.value.code == "pattern.too_large"
    with pytest.raises(BadInput) as caught:
        load_pattern(tmp_path / "none.json")
    assert caught.value.code == "pattern.unreadable"


_JSON = st.recursive(
    st.none() | st.booleans() | st.integers(-3, 10**9) | st.floats() | st.text(max_size=3),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=3), inner, max_size=3),
    max_leaves=6,
)


@settings(max_examples=150, deadline=None, suppress_health_check=list(__import__("hypothesis").HealthCheck))
@given(data=st.data())
def test_any_value_anywhere_is_read_or_refused(skirt_file, data):
    """Breaks where some replaced value gives a traceback instead of a pattern or a BadInput."""
    file = copy.deepcopy(skirt_file)
    at = file
    while True:
        key = data.draw(st.sampled_from(sorted(at) if isinstance(at, dict) else range(len(at))))
        if not isinstance(at[key], dict | list) or not at[key] or data.draw(st.integers(0, 3)) == 0:
            break
        at = at[key]
    at[key] = data.draw(_JSON)
    try:
        pattern = read_pattern(file)
    except BadInput as error:
        assert error.code.startswith("pattern.")
    else:
        assert np.isfinite(pattern.points).all()
        write_pattern(pattern)


def test_right_wrong_marks_must_agree(skirt_file):
    """Breaks where a one-sided pattern (one side seam turned, the other not) is sewn all the same."""
    skirt_file["pattern"]["stitches"][0].append("right_wrong")
    with pytest.raises(BadInput) as caught:
        read_pattern(skirt_file)
    assert caught.value.code == "pattern.not_orientable"


def test_seams_name_the_same_edges_after_import(skirt_file):
    """Breaks where mirroring renumbers edges although the loop's order stays."""
    seam = read_pattern(skirt_file).seams[0]
    assert seam.a == EdgeRef("front", 1) and seam.b == EdgeRef("back", 2) and seam.reversed
