"""What `inspect_file` tells about a file, with and without a body."""

import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from garmentq.core.run.errors import BadInput
from garmentq.core.scan.contours.body_mismatch import (
    BodyMismatch,
    check_own_body,
    explain_misfit,
    find_misfit_warnings,
)
from garmentq.service.inspect_garment import inspect_file


def test_file_alone_and_on_a_body(tmp_path, wearers, skin):
    """The report must be plain JSON and say what a run would understand."""
    body = wearers["T"]
    vertices, faces = skin(body, "tshirt")
    path = tmp_path / "shirt.stl"
    trimesh.Trimesh(100 * vertices, faces, process=False).export(path)
    alone = inspect_file(path)
    told = json.loads(json.dumps(alone.as_dict()))
    assert (told["units"], told["up"], told["name"]) == ("cm", "y", "shirt")
    assert told["category"] is None and told["contours_m"] is None and len(told["boundaries_m"]) == 4
    assert np.allclose(told["extent_m"], np.ptp(vertices, axis=0), atol=1e-3)
    assert told["vertex_count"] == len(vertices) and told["face_count"] == len(faces)
    assert any("duplicate" in sentence for sentence in told["repairs"])
    worn = json.loads(json.dumps(inspect_file(path, body).as_dict()))
    assert worn["category"] == "tshirt" and worn["holes_m"] == []
    assert set(worn["contours_m"]) == {"neck", "hem", "cuff.left", "cuff.right"}
    # A contour is measured after outliers are put back; a clean shirt has none, however coarse its hem.
    assert sorted(worn["contours_m"].values(), reverse=True) == pytest.approx(worn["boundaries_m"], abs=1e-3)
    assert worn["body"]["height_m"] == pytest.approx(1.70, abs=0.01)


def test_closed_shell_is_refused_with_a_body_only(tmp_path, wearers):
    """A closed mesh can be looked at, but has no contour to be matched on a body."""
    body = wearers["T"]
    path = tmp_path / "closed.ply"
    trimesh.Trimesh(body.vertices, body.faces, process=False).export(path)
    assert inspect_file(path).boundaries_m == ()
    with pytest.raises(BadInput) as caught:
        inspect_file(path, body)
    assert caught.value.code == "segment.no_contour"


def test_a_body_that_is_not_its_own(tmp_path, wearers, skin):
    """Broken where a garment that passes through a body, or hangs beside it, is read without a remark."""
    body = wearers["T"]
    vertices, _ = skin(body, "tshirt")
    assert explain_misfit(vertices, body.vertices, body.faces) == ""
    wider = body.vertices * [1.3, 1.0, 1.3]
    assert "inside the body" in explain_misfit(vertices, wider, body.faces)
    assert "inside the body" in explain_misfit(vertices, wider, body.faces[:, ::-1]), "a body that is inside out"
    assert "hangs beside it" in explain_misfit(vertices + [0.0, 0.0, 1.0], body.vertices, body.faces)
    assert explain_misfit(vertices, body.vertices * [0.9, 1.0, 0.9], body.faces) == "", "cut loose, or a slimmer body"
    given = replace(body, vertices=wider, source="mesh:wide")
    assert find_misfit_warnings(vertices, given) and not find_misfit_warnings(
        vertices, replace(given, source="smpl:fitted")
    )
    with pytest.raises(BodyMismatch, match=r"^[0-9]+ % of the garment"):
        check_own_body(vertices, given)
    check_own_body(vertices, replace(given, source="builtin:female"))  # stands for a wearer of about its measures
    check_own_body(vertices, replace(body, source="mesh:own"))
