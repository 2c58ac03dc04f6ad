"""Half sleeves of a recovered pattern become one sleeve."""

from __future__ import annotations

import numpy as np
from garmentq.core.garment.pieces.joining import join_halves
from garmentq.core.garment.templates import load_template

SLOPE = 0.3
"""Slope of a top seam against the warp that a recovery may leave, 17 degrees."""


def test_halves_are_joined_on_top_whatever_its_slope() -> None:
    """Fails if a sloping top seam left the sleeve to be joined below the arm, or its grainline lay to one side."""
    pattern = load_template("tshirt")
    moved = {}
    for panel in pattern.panels:
        if "sleeve" in panel.name:
            outwards = np.sign(panel.points[:, 0].mean())  # the arm's side: both halves hang down along it
            moved[panel.name] = panel.points - [0.0, SLOPE] * (outwards * panel.points[:, :1])
    sloped = pattern.with_points(moved)
    groups = [group for group in join_halves(sloped) if len(group.places) == 2]
    assert [sorted(place.panel for place in group.places) for group in groups] == [
        ["sleeve_back_left", "sleeve_front_left"], ["sleeve_back_right", "sleeve_front_right"],
    ]  # fmt: skip
    for group in groups:
        kept = {(ref.panel, ref.edge) for ref in group.sources}
        tops = [
            seam for seam in sloped.seams if seam.a.panel.startswith("sleeve") and seam.b.panel.startswith("sleeve")
        ]
        own = [seam for seam in tops if seam.a.panel in {place.panel for place in group.places}]
        heights = {seam: max(sloped.panel(seam.a.panel).points[seam.a.edge, 1], -9.0) for seam in own}
        top = max(own, key=heights.__getitem__)
        assert (top.a.panel, top.a.edge) not in kept and (top.b.panel, top.b.edge) not in kept
        grains = []
        for place in group.places:
            grain = sloped.panel(place.panel).grainline
            along = place.rotation @ np.array([-np.sin(grain), np.cos(grain)])
            grains.append(along * np.sign(along @ [-np.sin(group.net.grainline), np.cos(group.net.grainline)]))
        middle = (grains[0] + grains[1]) / np.linalg.norm(grains[0] + grains[1])
        assert abs(middle @ [-np.sin(group.net.grainline), np.cos(group.net.grainline)]) > 1.0 - 1e-9
        assert np.degrees(np.arccos(np.clip(grains[0] @ grains[1], -1.0, 1.0))) > 15.0


def test_what_is_folded_along_a_straight_crease_is_cut_in_one() -> None:
    """Fails if a lapel was cut off its front, a collar of one strip fell apart, or a seam closed within it stayed."""
    joined = {
        "tshirt+collar=polo": {("collar_back", "collar_fall", "collar_front_left", "collar_front_right")},
        "tshirt+collar=shirt": {("collar_back", "collar_front_left", "collar_front_right")},
        "tshirt+collar=notched,front=open": {
            ("front_left", "lapel_left"),
            ("front_right", "lapel_right"),
            ("collar_back", "collar_front_left", "collar_front_right"),
        },
    }
    for name, expected in joined.items():
        groups = join_halves(load_template(name))
        panels = [tuple(sorted(place.panel for place in group.places)) for group in groups]
        assert {one for one in panels if len(one) > 1 and "sleeve" not in one[0]} == expected, name
        strip = groups[next(i for i, one in enumerate(panels) if "collar_back" in one)]
        labels = [strip.net.edges[i].label for i in range(len(strip.net.edges))]
        assert not any(label.startswith("collarside") for label in labels), name
