"""What a stored result hands to later jobs: it comes back bit for bit, and what is not whole is refused."""

from __future__ import annotations

from dataclasses import fields, replace

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.cloth.scene import SteadyRotation
from garmentq.core.garment.templates import load_draped_template
from garmentq.core.reuse.wear import worn as worn_file
from garmentq.core.reuse.wear.worn import (
    WORN_FILE_NAME,
    ResultOld,
    WornGarment,
    find_waist,
    load_worn,
    make_waist_target,
    save_worn,
)
from garmentq.core.run.checkpoints import fingerprint
from garmentq.core.scan.contours.target import Contour


@pytest.fixture(scope="module")
def worn() -> WornGarment:
    """Return a skirt as it hangs on the body that it was drafted for."""
    garment = load_draped_template("skirt")
    assert garment is not None
    garment = replace(garment, pattern=replace(garment.pattern, extra={"note": ["kept", 1]}))
    waist = garment.contour("waist")
    assert waist is not None
    turning = SteadyRotation(5.0, (0.0, 1.0, 0.0))
    body = builtin_body("builtin:female,height=1.70")
    return WornGarment(garment, get_fabric("denim"), body, garment.nodes[waist.vertices], turning, "skirt", "skirt")


def test_comes_back_bit_for_bit(worn, tmp_path):
    """Broken where an array is rounded, or a field of garment, body or fabric is forgotten."""
    save_worn(worn, tmp_path)
    back = load_worn(tmp_path)
    for name in ("nodes", "faces", "uv", "uv_faces", "uv_node", "panel_of_face", "panel_of_uv"):
        np.testing.assert_array_equal(getattr(back.garment, name), getattr(worn.garment, name))
    assert back.garment.edge_uv.keys() == worn.garment.edge_uv.keys()
    for edge, along in worn.garment.edge_uv.items():
        np.testing.assert_array_equal(back.garment.edge_uv[edge], along)
    for field in fields(worn.body):
        if isinstance(value := getattr(worn.body, field.name), np.ndarray):
            np.testing.assert_array_equal(getattr(back.body, field.name), value)
    np.testing.assert_array_equal(back.pattern.points, worn.pattern.points)
    np.testing.assert_array_equal(back.waist, worn.waist)
    assert back.pattern.extra == {"note": ["kept", 1]}
    assert (back.fabric, back.rotation, back.template, back.category) == (
        worn.fabric, worn.rotation, "skirt", "skirt",
    )  # fmt: skip
    assert [contour.name for contour in back.garment.contours] == [c.name for c in worn.garment.contours]


def test_an_open_front_stays_open(worn, tmp_path):
    """Broken where neckline and hem of an open front come back as closed curves, or a closed garment's as open ones."""
    names = ("neck", "front.left", "hem", "front.right", "cuff.left")
    loop = worn.garment.contours[0].vertices
    contours = tuple(Contour(name, loop, 1.0, is_closed=name.startswith("cuff")) for name in names)
    save_worn(replace(worn, garment=worn.garment.at(worn.garment.nodes, contours)), tmp_path)
    assert [contour.is_closed for contour in load_worn(tmp_path).garment.contours] == [False] * 4 + [True]
    save_worn(worn, tmp_path)
    assert all(contour.is_closed for contour in load_worn(tmp_path).garment.contours)


def test_the_stored_form_is_that_of_earlier_results():
    """Broken where a field of what is stored is added or changed, so that results of 0.2.0 can no longer be worn."""
    assert fingerprint(worn_file._StoredWorn).startswith("44d461ab6d94b411")


def test_result_without_it_is_refused(worn, tmp_path):
    """Broken where a result of an earlier version, or a cut file, is a traceback."""
    with pytest.raises(ResultOld):
        load_worn(tmp_path)
    path = save_worn(worn, tmp_path)
    assert path.name == WORN_FILE_NAME
    path.write_bytes(path.read_bytes()[:1000])
    with pytest.raises(ResultOld):
        load_worn(tmp_path)


def test_file_of_another_version_is_refused(worn, tmp_path, monkeypatch):
    """Broken where a file of another version is read as if it were this one's, or one that states none."""
    path = save_worn(worn, tmp_path)
    monkeypatch.setattr(worn_file, "WORN_FORMAT_VERSION", worn_file.WORN_FORMAT_VERSION + 1)
    with pytest.raises(ResultOld):
        load_worn(tmp_path)
    monkeypatch.undo()
    with np.load(path) as arrays:
        left = {name: arrays[name] for name in arrays.files if name != "version"}
    np.savez(path, **left)
    with pytest.raises(ResultOld):
        load_worn(tmp_path)


def test_version_goes_up_with_the_fields():
    """Broken where a field of what is kept changes and the version does not: then state here both as they are now."""
    assert (worn_file.WORN_FORMAT_VERSION, fingerprint(worn_file._StoredWorn)[:12]) == (1, "44d461ab6d94")


def test_hangs_from_its_waist(worn):
    """Broken where the curve that a skirt hangs from is lost, or a shirt gets one."""
    waist = worn.target.contour("waist")
    np.testing.assert_array_equal(worn.target.vertices[waist.vertices], worn.waist)
    assert replace(worn, waist=None).target.contours == ()


def test_a_covered_garment_hangs_from_its_own_waist(worn):
    """Broken where trousers below a long top hang from where that ends, or a seen waist is not the scan's."""
    garment, lower = worn.garment, worn.waist - [0.0, 0.3, 0.0]
    seen = make_waist_target(lower, "skirt")
    np.testing.assert_array_equal(find_waist(garment, seen), lower)
    covered = replace(seen, contours=tuple(replace(contour, hidden=True) for contour in seen.contours))
    for target in (covered, replace(seen, contours=())):
        own = find_waist(garment, target)
        assert own[:, 1].mean() == pytest.approx(worn.waist[:, 1].mean(), abs=1e-3)
    shirt = load_draped_template("tshirt")
    assert find_waist(shirt, make_waist_target(None, "tshirt")) is None
