"""Panels that stand turned around the wearer, as gores do, lie flat beside each other before a body is dressed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.garment.garment import Garment
from garmentq.core.garment.pattern import Edge, EdgeRef, Panel, Pattern, Seam
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import load_template
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.drape.gores import fan_out, find_sides
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from wearers import find_wearer

TOP, BOTTOM, LENGTH, WAIST = 0.11, 0.36, 0.5, 1.0


def draw_gores(count: int, first: float) -> Pattern:
    """Draw a skirt of gores that stand around the wearer, the first turned by an angle [degrees] to the left."""
    points = np.array([[-BOTTOM / 2, -LENGTH], [BOTTOM / 2, -LENGTH], [TOP / 2, 0.0], [-TOP / 2, 0.0]])
    edges = (Edge(contour="hem"), Edge(), Edge(contour="waist"), Edge())
    panels = []
    for place in range(count):
        turn = np.radians(first) + 2.0 * np.pi * place / count
        outward = np.array([np.sin(turn), 0.0, np.cos(turn)])
        across = np.array([np.cos(turn), 0.0, -np.sin(turn)])
        rotation = np.stack([across, [0.0, 1.0, 0.0], outward], axis=1)
        panels.append(Panel(f"gore_{place}", points, edges, rotation, 0.5 * outward + [0.0, WAIST, 0.0]))
    seams = [Seam(EdgeRef(f"gore_{n}", 1), EdgeRef(f"gore_{(n + 1) % count}", 3)) for n in range(count)]
    return Pattern("gores", tuple(panels), tuple(seams), "skirt")


def lie_flat(garment: Garment) -> np.ndarray:
    """Return the flat vertices as they are seen from the front [m], shape [n, 2]."""
    rotation = np.stack([panel.rotation[:2, :2] for panel in garment.pattern.panels])[garment.panel_of_uv]
    return np.einsum("nij,nj->ni", rotation, garment.uv)


@pytest.mark.parametrize(("count", "first"), [(8, 0.0), (8, 22.5), (8, -6.0), (6, 30.0), (4, 0.0)])
def test_gores_lie_flat_as_they_are_and_beside_each_other(count: int, first: float) -> None:
    """Fails if a gore is as narrow as it is seen, folded over, or lies across the next one."""
    garment = mesh_pattern(draw_gores(count, first), 600)
    flat, side = fan_out(garment, lie_flat(garment)), find_sides(garment)
    edges = garment.uv_faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    assert (side[edges].prod(axis=1) >= 0.0).all()
    assert {-1.0, 1.0} <= set(side)
    corners = flat[garment.uv_faces]
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    worn = np.sign(side[garment.uv_faces].sum(axis=1))
    assert (worn * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) > 0.0).all()
    for sign in (1.0, -1.0):
        mine = np.flatnonzero(sign * side > 0.0)
        ends = edges[np.isin(edges, mine).all(axis=1)]
        found, drawn = (np.linalg.norm(np.diff(at[ends], axis=1), axis=2) for at in (flat, garment.uv))
        np.testing.assert_allclose(found, drawn, rtol=1e-9)
        for node in np.unique(garment.uv_node[mine]):
            assert np.ptp(flat[mine[garment.uv_node[mine] == node]], axis=0).max() < 1e-9


@pytest.mark.parametrize("name", ["skirt", "four_panel_skirt", "trousers", "tshirt"])
def test_panels_of_front_and_back_stay_as_they_are(name: str) -> None:
    """Fails if what is drafted for front and back alone is laid anew: drapes must stay what they were."""
    garment = mesh_pattern(load_template(name), 350)
    flat = lie_flat(garment)
    assert fan_out(garment, flat) is flat
    assert set(np.unique(find_sides(garment))) == {-1.0, 1.0}


def test_what_lies_level_is_not_laid_as_a_fan() -> None:
    """Fails if a yoke or a hood that is placed lying on the shoulders is taken for a gore."""
    shirt = load_template("tshirt")
    level = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    panels = (replace(shirt.panels[0], rotation=level), *shirt.panels[1:])
    garment = mesh_pattern(replace(shirt, panels=panels), 350)
    flat = lie_flat(garment)
    assert fan_out(garment, flat) is flat


@pytest.mark.parametrize("first", [0.0, 22.5])
def test_a_flared_skirt_of_gores_is_dressed_without_a_crossing(first: float) -> None:
    """Fails if gores start as they are seen from the front: those at the sides are worn crumpled through each other."""
    settings = DrapeSettings(template_vertices=500)
    worn = drape_template(draw_gores(8, first), find_wearer(), settings=settings)
    assert len(self_intersections(worn.nodes, worn.faces)) == 0
    assert {contour.name for contour in worn.contours} == {"hem", "waist"}
