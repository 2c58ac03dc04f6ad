"""Openings beside the contours are named, measured, and chosen where a scan shows them."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.garment.parts.cut import Collar, Front, HemBand, Vent
from garmentq.core.garment.parts.shipped_cuts import CUTS
from garmentq.core.garment.templates import find_cut, load_template
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.recover.drape.stage import DrapeSettings, drape_template
from garmentq.core.recover.drape.wearer import WearerGeometry
from garmentq.core.recover.grade.choice import choose_cut
from garmentq.core.recover.grade.neck_finish import NeckFinish
from garmentq.core.recover.grade.openings import find_openings, open_vents
from garmentq.core.scan.contours.category import choose_category
from garmentq.core.scan.contours.contours import name_contours
from garmentq.core.scan.contours.slits import Slit, SlitName, find_slits
from garmentq.core.scan.contours.target import Target

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
    assert open_vents(cut, SIDES, fixed=False).vent is Vent.SIDES
    assert open_vents(cut, SIDES, fixed=True).vent is Vent.NONE
    assert open_vents(cut, SIDES[:1], fixed=False).vent is Vent.NONE
    assert open_vents(cut.choose({"hem_band": HemBand.RIB.value}), SIDES, fixed=False).vent is Vent.NONE
    assert open_vents(CUTS["trousers"], SIDES, fixed=False).vent is Vent.NONE


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
