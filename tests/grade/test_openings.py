"""Openings beside the contours are named, measured, and chosen where a scan shows them."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.parts.cut import Collar, Cuff, Front, HemBand, Vent
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.templates import find_cut, load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.grade.choice import choose_cut
from garmentq.core.recover.grade.neck_finish import NeckFinish
from garmentq.core.recover.grade.openings import find_openings, open_slits
from garmentq.core.scan.contours.category import choose_category
from garmentq.core.scan.contours.contours import name_contours
from garmentq.core.scan.contours.garment import segment_garment
from garmentq.core.scan.contours.slits import Slit, SlitName, find_slits
from garmentq.core.scan.contours.target import Target
from garmentq.core.scan.scan import Scan

BODY = builtin_body("builtin:female,height=1.70")
SIDES = (Slit(SlitName.LEFT_VENT, 0.08), Slit(SlitName.RIGHT_VENT, 0.08))


@pytest.mark.parametrize("name", ["tshirt+vent=sides", "skirt+vent=back"])
def test_vents_of_a_drape_are_found_and_chosen(name: str) -> None:
    """Breaks where a vent is bridged as damage, gets another place or length, or the cut stays without it."""
    worn = drape_template(load_template(name), WearerGeometry(BODY), settings=DrapeSettings(template_vertices=1500))
    contours, holes = name_contours(worn.nodes, worn.faces, BODY, scanned=True)
    category = choose_category(contours, worn.nodes, BODY)
    target = Target(worn.nodes, worn.faces, vertex_normals(worn.nodes, worn.faces), contours, holes, category)
    places = {"sides": {SlitName.LEFT_VENT, SlitName.RIGHT_VENT}, "back": {SlitName.BACK_VENT}}
    length = {"sides": 0.08, "back": 0.18}[name.partition("=")[2]]
    slits = find_slits(target, BODY)
    assert {slit.name for slit in slits} == places[name.partition("=")[2]]
    assert all(slit.extent == pytest.approx(length, rel=0.25) for slit in slits)
    choice = choose_cut(target, BODY)
    assert find_cut(choice.template).vent == find_cut(name).vent
    assert {one.name for one in choice.openings} == {slit.name for slit in slits}


def test_vents_are_opened_where_a_cut_has_a_place_for_them() -> None:
    """Breaks where the user's choice is overruled, one slit of two counts, or a band is slit."""
    cut = CUTS["tshirt"]
    assert open_slits(cut, SIDES, ()).vent is Vent.SIDES
    assert open_slits(cut, SIDES, ("vent",)).vent is Vent.NONE
    assert open_slits(cut, SIDES[:1], ()).vent is Vent.NONE
    assert open_slits(cut.choose({"hem_band": HemBand.RIB.value}), SIDES, ()).vent is Vent.NONE
    assert open_slits(CUTS["trousers"], SIDES, ()).vent is Vent.NONE


CUFFS = (Slit(SlitName.LEFT_CUFF, 0.1), Slit(SlitName.RIGHT_CUFF, 0.11))


def test_slits_above_both_cuffs_are_those_of_shirt_cuffs() -> None:
    """Breaks where a tear in one sleeve makes a cuff, a short sleeve gets one, or the user's choice is overruled."""
    cut = CUTS["long_sleeve_tshirt"]
    assert open_slits(cut, CUFFS, ()).cuff is Cuff.SHIRT
    assert open_slits(cut, CUFFS[:1], ()).cuff is Cuff.NONE
    assert open_slits(cut, CUFFS, ("cuff",)).cuff is Cuff.NONE
    assert open_slits(CUTS["tshirt"], CUFFS, ()).cuff is Cuff.NONE
    assert open_slits(cut.choose({"cuff": Cuff.RIB.value}), CUFFS, ()).cuff is Cuff.RIB
    both = open_slits(cut, (*CUFFS, *SIDES), ())
    assert (both.cuff, both.vent) == (Cuff.SHIRT, Vent.SIDES)


@pytest.mark.parametrize(("width", "is_found"), [(0.004, True), (0.06, False)])
def test_a_long_hole_along_the_forearm_is_a_slit_and_a_round_one_damage(width: float, is_found: bool) -> None:
    """Breaks where a slit above a buttoned cuff, which breaks through no contour, is damage, or any hole is a slit."""
    holes, points = [], []
    for side in ("left", "right"):
        elbow, wrist = BODY.joint(f"{side}_elbow"), BODY.joint(f"{side}_wrist")
        arm = (wrist - elbow) / np.linalg.norm(wrist - elbow)
        aside = np.cross(arm, (0.0, 1.0, 0.0))
        turn = np.linspace(0.0, 2.0 * np.pi, 40, endpoint=False)
        rim = 0.05 * np.cos(turn)[:, None] * arm + 0.5 * width * np.sin(turn)[:, None] * aside
        holes.append(len(points) * 40 + np.arange(40))
        points.append(wrist - 0.1 * arm + 0.04 * aside + rim)
    vertices = np.concatenate(points)
    target = Target(vertices, np.zeros((0, 3), np.int64), vertices, (), tuple(holes), "long_sleeve_tshirt")
    found = find_slits(target, BODY)
    assert [one.name for one in found] == ([SlitName.LEFT_CUFF, SlitName.RIGHT_CUFF] if is_found else [])
    assert all(one.extent == pytest.approx(0.1, rel=0.02) for one in found)


def test_fronts_have_probabilities_and_slits_lengths() -> None:
    """Breaks where a front's probability is that of one collar alone, or a slit is said to be certain."""
    target = Target(np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros((0, 3)), (), (), "tshirt")
    finishes = [
        NeckFinish(Collar.SHIRT, Front.BUTTONS),
        NeckFinish(Collar.STAND, Front.ZIP),
        NeckFinish(Collar.NONE, Front.NONE),
    ]
    front, *vents = find_openings(target, None, finishes, SIDES)
    assert (front.name, front.extent) == ("front.closed", None)
    assert front.probability == pytest.approx(2 / 3)
    assert front.describe().evidence == {"name": "front.closed", "probability": 0.667}
    assert [(one.extent, one.probability) for one in vents] == [(0.08, None)] * 2


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["tank+front=wrap,neckline=v", "long_sleeve_tshirt+cuff=shirt"])
def test_a_wrap_and_shirt_cuffs_of_a_drape_are_chosen_and_can_be_overruled(name: str) -> None:
    """Breaks where a garment that is scanned by itself does not get the front or the cuffs that it was sewn with."""
    worn = drape_template(load_template(name), WearerGeometry(BODY))
    target = segment_garment(Scan(worn.nodes, worn.faces), BODY)
    chosen, cut = find_cut(choose_cut(target, BODY).template), find_cut(name)
    assert (chosen.front, chosen.cuff) == (cut.front, cut.cuff)
    plain = find_cut(choose_cut(target, BODY, {"front": "none", "cuff": "none"}).template)
    assert (plain.front, plain.cuff) == (Front.NONE, Cuff.NONE)
