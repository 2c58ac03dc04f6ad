"""Each size on a body by its measures."""

from __future__ import annotations

import json

import numpy as np
import pytest
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.girths import TapeMeasure
from garmentq.core.body.measured import MeasureRange
from garmentq.core.body.resizing import resize_body
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.export import sizes as written_sizes
from garmentq.core.deliver.formats.grading import grade_sizes
from garmentq.core.deliver.formats.options import ExportOptions
from garmentq.core.deliver.formats.production import Production, write_production
from garmentq.core.deliver.formats.size_drapes import drape_size
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.core.reuse.wear.worn import WornGarment
from garmentq.core.run.report import ResultReport
from PIL import Image
from worn_template import is_valid_drape, load_worn_template

TEMPLATES = ("tshirt", "trousers", "skirt", "dress")


def wear(name: str) -> WornGarment:
    """Return a shipped drape as a garment that is worn."""
    worn = load_worn_template(name, get_fabric("single_jersey"))
    if worn is None:
        pytest.skip("no drape is shipped for this machine's triangulation")
    return worn


@pytest.mark.parametrize("growth", [0.0, pytest.param(-0.08, marks=pytest.mark.nightly), 0.12])
def test_a_resized_body_has_the_measures(growth):
    """Broken where a body by a size's measures misses one or its height by 3 mm, or is another person without any."""
    wearer = builtin_body("builtin:male,height=1.80,weight=75,pose=A")
    body = resize_body(wearer, dict.fromkeys(("chest", "waist", "hip"), growth))
    tapes = [TapeMeasure.of(one) for one in (wearer, body)]
    for place in ("chest", "waist", "hip"):
        assert tapes[1].measure(place).value - tapes[0].measure(place).value == pytest.approx(growth, abs=3e-3)
    assert np.ptp(body.rest_vertices[:, 1]) == pytest.approx(1.80, abs=3e-3)
    if growth == 0.0:
        assert np.abs(body.vertices - wearer.vertices).max() < 1e-6


def test_files_of_draped_sizes_tell_each_size(tmp_path, monkeypatch):
    """Broken where a size has no mesh or verdict, or one that no body has stops the others."""
    worn = wear("tshirt")

    def drape(_, size, hooks):
        if size.name == "B96":
            raise MeasureRange("no body is so")
        return quick

    class Quick:
        """A drape that was made before."""

        report = ResultReport({"ease.chest_mm": 40.0})

    quick = Quick()
    quick.worn = worn
    monkeypatch.setattr(written_sizes, "drape_size", drape)
    options = ExportOptions("sizes", first=-1, last=1, drape=True)
    files = write_production(Production(worn, options, tmp_path), tmp_path / "out")
    assert all(file.is_file() for file in files)
    told = json.loads((tmp_path / "out" / "sizes.json").read_text())["sizes"]
    assert [(one["name"], one["verdict"]) for one in told] == [("B88", "pass"), ("B92", "pass"), ("B96", "fail")]
    assert told[2]["warnings"] == ["no body is so"] and told[1]["is_base"]
    assert {"draped_B88.ply", "body_B92.ply", "nest.pdf", "pattern_B96.json"} <= {file.name for file in files}
    with Image.open(tmp_path / "out" / "sizes.png") as picture:
        assert picture.size == (600, 960)


@pytest.mark.nightly
@pytest.mark.parametrize("name", TEMPLATES)
def test_every_size_hangs_at_rest_on_its_body(name):
    """Broken where a size of -2..4 steps of 4 cm does not come to rest, crosses itself, or lies in its body by 1 mm."""
    worn = wear(name)
    base = measure_wearer(worn.body)
    for size in grade_sizes(worn.pattern, name, base, 1.70, ExportOptions("sizes", first=-2, last=4)):
        metrics = drape_size(worn, size).report.metrics
        assert is_valid_drape(metrics), (size.name, metrics)
