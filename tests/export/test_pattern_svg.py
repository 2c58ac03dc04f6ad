"""The SVG pattern, read back with an XML parser: true scale, real curves, ids, no overlap."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ElementTree
from itertools import pairwise

import numpy as np
import pytest
from garmentq.core.deliver.export.pattern_svg import write_svg
from garmentq.core.garment.curves import edge_points, reverse_edge
from garmentq.core.garment.pattern import Edge, Panel, Pattern

SVG = "{http://www.w3.org/2000/svg}"


def _pattern() -> Pattern:
    points = np.array([[0.0, 0.0], [0.4, 0.0], [0.4, 0.3], [0.0, 0.3]])
    arcs = (
        Edge("arc", np.array([[0.5, -0.2]]), label="hem <1>"),
        Edge("quadratic", np.array([[0.3, 0.2]])),
        Edge("arc", np.array([[0.5, -0.8]])),
        Edge("cubic", np.array([[0.3, 0.2], [0.6, -0.2]])),
    )
    bump = (Edge("arc", np.array([[0.5, 0.2]])), Edge(), reverse_edge(Edge("arc", np.array([[0.5, 0.1]]))), Edge())
    return Pattern(
        "two & two",
        (
            Panel("front", points, arcs, notches=((0, 0.5),)),
            Panel("back <a>", points, bump, label="body"),
            Panel("back &a>", points, bump),
        ),
        (),
    )


def _numbers(text: str) -> list[float]:
    return [float(value) for value in re.findall(r"-?\d+(?:\.\d+)?", text)]


def _sample(d: str) -> np.ndarray:
    """Sample an edge's path `M x y CMD ...` [mm], shape [201, 2], by the SVG specification's formulas."""
    move, kind, rest = re.match(r"M ([-\d. ]+?) ([LQCA]) (.*)", d).groups()
    start, numbers, t = np.array(_numbers(move)), _numbers(rest), np.linspace(0, 1, 201)[:, None]
    if kind == "A":
        radius, _, _, large, sweep, x, y = numbers
        return _sample_arc(start, np.array([x, y]), radius, bool(large), bool(sweep), t)
    points = [start, *np.array(numbers).reshape(-1, 2)]
    while len(points) > 1:
        points = [a + t * (b - a) for a, b in pairwise(points)]
    return points[0]


def _sample_arc(start, end, radius, large, sweep, t):
    """SVG 1.1 appendix F.6.5: centre from end points, for a circle without rotation."""
    half = (start - end) / 2
    scale = np.sqrt(max(radius**2 - half @ half, 0.0) / (half @ half)) * (-1 if large == sweep else 1)
    centre = (start + end) / 2 + scale * np.array([half[1], -half[0]])
    first, last = (np.arctan2(*(point - centre)[::-1]) for point in (start, end))
    turn = (last - first) % (2 * np.pi)
    turn = turn if sweep else turn - 2 * np.pi
    angle = first + t * turn
    return centre + radius * np.concatenate([np.cos(angle), np.sin(angle)], axis=1)


@pytest.fixture
def drawing(tmp_path):
    """Write the pattern and parse the file."""
    return ElementTree.parse(write_svg(_pattern(), tmp_path / "pattern.svg")).getroot()


def _by_id(root) -> dict[str, ElementTree.Element]:
    items = [item for item in root.iter() if "id" in item.attrib]
    assert len({item.attrib["id"] for item in items}) == len(items), "an id appears twice"
    return {item.attrib["id"]: item for item in items}


def test_edges_read_back_at_true_scale(drawing):
    """Breaks where an arc takes the wrong side, y is not turned, or a unit is not a millimetre."""
    items = _by_id(drawing)
    for name, panel in zip(("front", "back__a_", "back__a_-2"), _pattern().panels, strict=True):
        read = [_sample(items[f"{name}.{i}"].attrib["d"]) for i in range(4)]
        shift = read[0][0] - panel.points[0] * [1e3, -1e3]
        for i in range(4):
            true = edge_points(panel, i, 400) * [1e3, -1e3] + shift
            distance = np.linalg.norm(read[i][:, None] - true[None], axis=-1)
            assert distance.min(axis=1).max() < 1.2 and distance.min(axis=0).max() < 3.0
            length = np.linalg.norm(np.diff(read[i], axis=0), axis=1).sum()
            assert length == pytest.approx(np.linalg.norm(np.diff(true, axis=0), axis=1).sum(), rel=1e-3)


def test_page_is_in_millimetres_with_a_scale_bar(drawing):
    """Breaks where printing at 100 % is not true to scale."""
    _, _, width, height = _numbers(drawing.attrib["viewBox"])
    assert drawing.attrib["width"] == f"{width:.3f}mm" and drawing.attrib["height"] == f"{height:.3f}mm"
    bar = _sample(_by_id(drawing)["scale-bar.10cm"].attrib["d"])
    assert np.linalg.norm(bar[-1] - bar[0]) == pytest.approx(100.0)
    assert "10 cm" in [text.text for text in drawing.iter(f"{SVG}text")]


def test_names_labels_and_grain_are_there(drawing):
    """Breaks where a name with markup characters spoils the file, or a label, notch or grainline is forgotten."""
    items = _by_id(drawing)
    assert items["front.0"].attrib["data-label"] == "hem <1>"
    texts = [text.text for text in drawing.iter(f"{SVG}text")]
    assert "back <a>" in texts and "body" in texts
    assert all(f"{name}.grainline" in items for name in ("front", "back__a_", "back__a_-2"))
    assert sum(item.attrib.get("class") == "notch" for item in drawing.iter()) == 1


def test_pieces_do_not_overlap(drawing):
    """Breaks where the layout uses control points and a bulging curve reaches into its neighbour or off the page."""
    items = _by_id(drawing)
    boxes = []
    for name in ("front", "back__a_", "back__a_-2"):
        points = np.concatenate([_sample(items[f"{name}.{i}"].attrib["d"]) for i in range(4)])
        boxes.append((points.min(axis=0), points.max(axis=0)))
    _, _, width, height = _numbers(drawing.attrib["viewBox"])
    for i, (low, high) in enumerate(boxes):
        assert (low >= 0).all() and (high <= [width, height]).all()
        for other_low, other_high in boxes[i + 1 :]:
            assert (high < other_low).any() or (other_high < low).any()
