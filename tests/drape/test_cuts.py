"""Cuts from parts hang on the built-in bodies as the shipped templates do."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.distance import DistanceGrid
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.body.girths import armpit_height
from garmentq.core.body.projection import project_outside
from garmentq.core.garment.curves import flat_contours
from garmentq.core.garment.parts.cut import PARTS, Hood, PartsConflict
from garmentq.core.garment.parts.part_words import differing_parts
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.sewing import mesh_pattern
from garmentq.core.garment.templates import find_cut, load_template, name_cut
from garmentq.core.geometry.intersections import self_intersections
from garmentq.core.recover.drape.dress import dress
from garmentq.core.recover.drape.hoods import take_off_hood
from garmentq.core.recover.drape.pbd import build_distance_constraints
from garmentq.core.recover.drape.pose_path import PosePath, pose_cloth
from garmentq.core.recover.drape.waist import waist_loop
from garmentq.core.recover.drape.worn_contours import name_worn_contours
from garmentq.core.scan.contours.contours import name_contours
from sized_template import size_template

NODES = 350
"""Edges of 5 cm: the coarsest at which a sleeve still is a tube."""

HOOD_NODES = 1000
"""Edges of 3 cm: cloth of 5 cm is too stiff for a hood to fold at the neck."""

STATURES = {"female": "builtin:female,height=1.70", "male": "builtin:male"}

POSES = ("A", "stride", "arms-down", "seated")

DRAWN = 60
"""Cuts that are drawn at random, with a fixed seed."""

CALM = 0.15
"""Speed below which cloth hangs and no longer falls [m/s]; a full circle's folds still swing by a few cm/s."""


@cache
def wearer(gender: str, pose: str) -> tuple[Body, DistanceGrid, ExposedSurface]:
    """Return the built-in body in a pose with its distance fields."""
    body = builtin_body(f"{STATURES[gender]},pose={pose}")
    return body, DistanceGrid.from_mesh(body.vertices, body.faces), ExposedSurface.of(body)


@cache
def way(gender: str, pose: str) -> PosePath:
    """Return a body's frames into a pose."""
    body, _, skin = wearer(gender, pose)
    return PosePath.of(body, skin)


@cache
def draw_cuts() -> tuple[str, ...]:
    """Draw the names of cuts: a template with other choices for two of its parts or more, where these can be sewn."""
    rng = np.random.default_rng(20)
    names: dict[str, None] = {}
    while len(names) < DRAWN:
        stem = str(rng.choice(list(CUTS)))
        open_parts = [part for part in PARTS if part not in ("bodice", "gores") and CUTS[stem].has_place_for(part)]
        changed = rng.permutation(open_parts)[: rng.integers(1, 6)]
        choices = {str(part): str(rng.choice([str(choice) for choice in PARTS[part]])) for part in changed}
        name = name_cut(stem, CUTS[stem].choose(choices))
        try:
            same_kind = find_cut(name).category and bool(load_template(name).panels)
        except PartsConflict:
            continue
        if same_kind and len(differing_parts(CUTS[stem], find_cut(name))) > 1:
            names[name] = None
    return tuple(names)


def hang(name: str, gender: str, poses: tuple[str, ...]) -> None:
    """Dress a body in a cut in the T-pose, take it into poses, and check that it is whole, outside and calm there."""
    body, grid, skin = wearer(gender, "T")
    count = NODES if find_cut(name).hood is Hood.NONE else HOOD_NODES
    garment = mesh_pattern(load_template(name) if gender == "female" else size_template(name, body), count)
    threads, waist = build_distance_constraints(garment), waist_loop(garment)
    nodes = dress(garment, body, grid, threads=threads)
    assert len(self_intersections(nodes, garment.faces)) == 0, f"{name} in T"
    assert skin.measure(project_outside(nodes, skin, garment.faces))[0].min() >= -1e-3
    for pose in poses:
        _, posed, outside = wearer(gender, pose)
        there, velocity = pose_cloth(threads, nodes, way(gender, pose), posed, pins=waist)
        assert len(self_intersections(there, garment.faces)) == 0, f"{name} in {pose}"
        assert outside.measure(there)[0].min() >= -1e-3, f"{name} in {pose}"
        assert np.quantile(np.linalg.norm(velocity, axis=1), 0.9) < CALM, f"{name} in {pose}"


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        "tshirt+neckline=boat,sleeve=cap",
        "tshirt+neckline=v,sleeve_head=raglan",
        "tank+yoke=front",
        "tshirt+collar=stand",
        "long_sleeve_tshirt+sleeve_head=set-in,yoke=shoulders,cuff=band",
        "dress+neckline=v,skirt=half-circle,waist=seam",
        pytest.param("sleeved_dress+sleeve_head=set-in,shaping=princess", marks=pytest.mark.nightly),
        "dress+shaping=princess,skirt=gored,waist=seam",
        "skirt+skirt=gored,gores=8",
        pytest.param("pencil_skirt+skirt=gored,gores=10", marks=pytest.mark.nightly),
        pytest.param("dress+skirt=gored,gores=8,waist=seam", marks=pytest.mark.nightly),
        pytest.param("dress+skirt=gored,gores=12,waist=seam", marks=pytest.mark.nightly),
        "sleeved_dress+shaping=darts,skirt=straight,waist=seam",
        pytest.param("pencil_skirt+shaping=darts", marks=pytest.mark.nightly),
        "pencil_skirt+skirt=tiered",
        "skirt+skirt=full-circle,yoke=hip",
        "trousers+legs=wide,waistband=band",
        "skirt+skirt=pleated,yoke=hip",
        "sleeved_jumpsuit+legs=wide,waist=seam",
        pytest.param("jumpsuit+waist=seam", marks=pytest.mark.nightly),
        "tank+bodice=strapless",
        pytest.param("dress+bodice=strapless", marks=pytest.mark.nightly),
        "long_sleeve_tshirt+sleeve_head=set-in,sleeve_pieces=two",
        "long_sleeve_tshirt+front=open",
        pytest.param("long_sleeve_tshirt+collar=stand,front=zip", marks=pytest.mark.nightly),
        pytest.param("dress+front=open", marks=pytest.mark.nightly),
        pytest.param("sleeved_dress+front=buttons,waist=seam", marks=pytest.mark.nightly),
        pytest.param("tank+bodice=shift,front=open", marks=pytest.mark.nightly),
        "long_sleeve_tshirt+sleeve_head=dropped,hem_band=rib,cuff=rib,collar=rib",
        pytest.param("tshirt+bodice=shift,shaping=princess,hem_band=rib,cuff=rib", marks=pytest.mark.nightly),
        "tshirt+collar=turtleneck",
        "skirt+waistband=elastic",
        pytest.param("skirt+skirt=full-circle,waistband=elastic", marks=pytest.mark.nightly),
        pytest.param("trousers+waistband=elastic", marks=pytest.mark.nightly),
        "trousers+legs=leggings",
        "long_sleeve_tshirt+hood=two,hood_worn=up",
        pytest.param("long_sleeve_tshirt+hood=two", marks=pytest.mark.nightly),
        pytest.param("tshirt+hood=three,hood_worn=up,front=zip", marks=pytest.mark.nightly),
        pytest.param("sleeved_jumpsuit+hood=three", marks=pytest.mark.nightly),
        "long_sleeve_tshirt+collar=shirt,front=buttons",
        pytest.param("tshirt+collar=convertible,front=open", marks=pytest.mark.nightly),
        pytest.param("tshirt+collar=polo", marks=pytest.mark.nightly),
        "long_sleeve_tshirt+collar=notched,front=buttons",
        pytest.param("long_sleeve_tshirt+collar=shawl,front=open", marks=pytest.mark.nightly),
        "long_sleeve_tshirt+front=wrap,neckline=v",
        pytest.param("dress+front=wrap,neckline=v", marks=pytest.mark.nightly),
        "sleeved_dress+front=wrap,neckline=v,waist=seam,skirt=half-circle",
        pytest.param("tank+bodice=shift,front=wrap,neckline=v,vent=sides", marks=pytest.mark.nightly),
        pytest.param("tshirt+front=wrap,neckline=v,hem_band=rib,yoke=back", marks=pytest.mark.nightly),
        "dress+skirt=pencil,waist=seam,shaping=gathers",
        pytest.param("sleeved_jumpsuit+waist=seam,shaping=gathers", marks=pytest.mark.nightly),
        pytest.param("trousers+waistband=band,shaping=gathers", marks=pytest.mark.nightly),
        "skirt+vent=sides",
        pytest.param("pencil_skirt+vent=back", marks=pytest.mark.nightly),
        pytest.param("sleeved_dress+skirt=straight,waist=seam,vent=back", marks=pytest.mark.nightly),
        pytest.param("tshirt+vent=sides", marks=pytest.mark.nightly),
        pytest.param("long_sleeve_tshirt+collar=notched,front=buttons,vent=back", marks=pytest.mark.nightly),
        "long_sleeve_tshirt+sleeve_head=set-in,cuff=shirt",
        pytest.param("long_sleeve_tshirt+collar=shirt,front=buttons,cuff=shirt,vent=sides", marks=pytest.mark.nightly),
    ],
)
def test_a_cut_hangs(name: str) -> None:
    """Breaks where a part is placed through its neighbour or the body, or a seam is sewn the wrong way round."""
    hang(name, "female", ("A",))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("parts", "gender"),
    [
        ("hood=two,hood_worn=down", "female"),
        pytest.param("hood=two,hood_worn=up", "male", marks=pytest.mark.nightly),
        pytest.param("hood=three,hood_worn=down,front=zip", "male", marks=pytest.mark.nightly),
        pytest.param("hood=three,hood_worn=up,front=buttons", "female", marks=pytest.mark.nightly),
        pytest.param("hood=two,hood_worn=down,front=open", "female", marks=pytest.mark.nightly),
        pytest.param("hood=three,hood_worn=up,front=open", "female", marks=pytest.mark.nightly),
    ],
)
def test_a_hood_is_worn_up_or_down(parts: str, gender: str) -> None:
    """Breaks where a hood is not on the head, or not behind the neck, or the edge of its face opening has no name."""
    name, (body, grid, _), (posed, around, outside) = (
        f"long_sleeve_tshirt+{parts}",
        wearer(gender, "T"),
        wearer(gender, "A"),
    )
    garment = mesh_pattern(size_template(name, body), HOOD_NODES)
    threads = build_distance_constraints(garment)
    nodes, velocity = pose_cloth(threads, dress(garment, body, grid, threads=threads), way(gender, "A"), around)
    assert len(self_intersections(nodes, garment.faces)) == 0
    assert outside.measure(nodes)[0].min() >= -1e-3
    assert np.quantile(np.linalg.norm(velocity, axis=1), 0.9) < CALM
    front = {"front.left", "front.right"} if "front=open" in parts else set()
    names = {contour.name for contour in name_contours(nodes, garment.faces, posed)[0]}
    assert names == {"neck", "hem", "cuff.left", "cuff.right"} | front
    hooded = take_off_hood(garment)
    assert hooded is not None
    hood = np.delete(nodes, hooded.nodes, axis=0)
    if "hood_worn=up" in parts:
        assert hood[:, 1].max() > posed.vertices[:, 1].max()
        return
    assert hood[:, 1].max() < posed.joint("head")[1] + 0.05
    assert np.median(hood[:, 2]) < posed.joint("neck")[2] - 0.05


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tshirt", "sleeved_dress+waist=seam,skirt=straight"])
def test_the_right_front_of_a_wrap_is_worn_over_the_left_one(name: str) -> None:
    """Breaks where the fronts change their order as the body takes its size, or the neckline counts what is covered."""
    stem, sign, parts = name.partition("+")
    name = f"{stem}+front=wrap,neckline=v{',' if sign else ''}{parts}"
    (body, grid, _), (posed, around, _) = wearer("female", "T"), wearer("female", "A")
    garment = mesh_pattern(load_template(name), NODES)
    threads = build_distance_constraints(garment)
    nodes, _ = pose_cloth(threads, dress(garment, body, grid, threads=threads), way("female", "A"), around)
    names = [panel.name for panel in garment.pattern.panels]
    outer, inner = (garment.faces[garment.panel_of_face == names.index(f"front_{side}")] for side in ("right", "left"))
    depth = find_depths(nodes[inner].mean(axis=1), nodes[outer])
    in_front = np.abs(nodes[inner].mean(axis=1)[:, 0] - posed.joint("neck")[0]) < 0.1
    assert (depth[in_front] > 0.0).sum() > 0.3 * in_front.sum() and not (depth[in_front] < 0.0).any()
    neck = next(one for one in name_worn_contours(garment, nodes, posed) if one.name == "neck")
    flat = flat_contours(garment.pattern)["neck"]
    assert 0.95 * flat < neck.length < 1.2 * flat, "the front edges lie on the bias, and stretch over the bust"
    assert not neck.is_closed


def find_depths(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return how far triangles are before points along z [m], shape [n]; not a number where none is there."""
    a, b, c = (triangles[:, None, k, :2] for k in range(3))
    x = points[None, :, :2]
    sides = np.stack([turn(c - b, x - b), turn(a - c, x - c), turn(b - a, x - a)])
    shares = sides / turn(b - a, c - a)
    depth = np.einsum("kfn,fk->fn", shares, triangles[:, :, 2]) - points[:, 2]
    inside = (shares >= 0.0).all(axis=0)
    return np.where(inside.any(axis=0), np.where(inside, depth, -np.inf).max(axis=0), np.nan)


def turn(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return the cross product of plane vectors."""
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


@pytest.mark.slow
@pytest.mark.parametrize("gender", sorted(STATURES))
def test_a_strapless_top_is_worn_below_the_arms(gender: str) -> None:
    """Breaks where its upper edge, which no arm passes, is taken for a waist and hung from the hips."""
    body, grid, _ = wearer(gender, "T")
    garment = mesh_pattern(size_template("tank+bodice=strapless", body), NODES)
    nodes = dress(garment, body, grid, threads=build_distance_constraints(garment))
    edge = waist_loop(garment)
    assert edge is not None
    below = armpit_height(body) - nodes[edge, 1]
    assert 0.0 < below.min() and below.max() < 0.08


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["trousers+waistband=band", "shorts+legs=straight,waistband=band"])
def test_a_fold_in_the_lap_leaves_the_body(name: str) -> None:
    """Breaks where cloth stays in the crease between belly and thigh: outside it would cross, and was put back."""
    hang(name, "female", ("seated",))


@pytest.mark.nightly
@pytest.mark.parametrize("number", range(DRAWN))
def test_a_drawn_cut_hangs_on_a_drawn_body_in_a_drawn_pose(number: int) -> None:
    """Breaks where two parts that draft and sew cannot be worn together."""
    rng = np.random.default_rng([20, number])
    hang(draw_cuts()[number], str(rng.choice(sorted(STATURES))), (str(rng.choice(POSES)),))
