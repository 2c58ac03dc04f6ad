"""One list of units for all that is read, and for all that asks for them."""

from __future__ import annotations

from typing import get_args, get_type_hints

import click
import numpy as np
import pytest
import trimesh
from garmentq.cli.main import COMMANDS, group
from garmentq.core.body.builtin import builtin_body
from garmentq.core.run.errors import BadInput
from garmentq.core.run.units import METRIC, UNITS, UnitName
from garmentq.core.scan.coloured import load_coloured
from garmentq.core.scan.limits import Limits
from garmentq.core.scan.load import load_pair, load_scan
from garmentq.core.scan.load_raw import load_raw
from garmentq.core.scan.pieces import load_scan_input
from garmentq.core.scan.selection import Selection
from garmentq.service.api.inspection import InspectionQuery
from garmentq.service.api.schemas import ALLOWED

INSIDE = Limits(is_confined=True)
"""Parsing here: a process for each file would take most of the time."""
METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "inch": 0.0254, "foot": 0.3048}
BODY = builtin_body("builtin:female,height=1.70")
V, F = BODY.vertices, BODY.faces
SKIRT = (V[:, 1] > V[:, 1].min() + 0.45) & (V[:, 1] < V[:, 1].min() + 1.0) & (np.abs(V[:, 0]) < 0.25)


@pytest.fixture
def files(tmp_path, request):
    """Write a person, a body, a garment that lies on it, and a person in two colours, all in one unit."""
    scale = 1.0 / METRES[request.param]
    body = trimesh.Trimesh(V * scale, F, process=False)
    own = F[SKIRT[F].all(axis=1)]
    used, local = np.unique(own, return_inverse=True)
    garment = trimesh.Trimesh(1.03 * V[used] * scale, local.reshape(-1, 3), process=False)
    colours = np.where(SKIRT[:, None], [0, 0, 255, 255], [255, 200, 180, 255]).astype(np.uint8)
    person = trimesh.Trimesh(V * scale, F, process=False, vertex_colors=colours)
    for name, mesh in (("body", body), ("garment", garment), ("person", person)):
        mesh.export(tmp_path / f"{name}.ply")
    return tmp_path


@pytest.mark.parametrize(("files", "unit"), [(unit, unit) for unit in METRES], indirect=["files"])
def test_every_reader_takes_every_unit(files, unit):
    """Broken where a unit that is offered is refused for a garment, a body or a person, or its factor is not exact."""
    garment, wearer = load_pair(files / "garment.ply", files / "body.ply", units=unit, up="y", limits=INSIDE)
    assert garment.units == wearer.units == unit
    assert np.ptp(wearer.vertices[:, 1]) == pytest.approx(np.ptp(V[:, 1]), rel=1e-6)
    alone = load_scan(files / "garment.ply", units=unit, up="y", limits=INSIDE)
    assert np.allclose(alone.vertices, garment.vertices)
    raw = load_raw(files / "person.ply", unit, "y", INSIDE)
    assert raw.units == unit and np.ptp(raw.points[:, 1]) == pytest.approx(np.ptp(V[:, 1]), rel=1e-6)
    cut = load_scan_input(
        files / "person.ply", None, units=unit, up="y", limits=INSIDE, selection=Selection(colour="#0000ff")
    )
    assert cut.garment.units == unit and np.ptp(cut.wearer.vertices[:, 1]) == pytest.approx(np.ptp(V[:, 1]), rel=1e-6)
    found = load_coloured(files / "person.ply", unit, "y", INSIDE)
    assert np.ptp(found.vertices[:, 1]) == pytest.approx(np.ptp(V[:, 1]), rel=1e-6)


@pytest.mark.parametrize(
    ("files", "kind"), [("inch", "garment"), ("inch", "body"), ("foot", "body")], indirect=["files"]
)
def test_inches_and_feet_are_named_and_then_read(files, kind):
    """Broken where the advice of a refusal leads nowhere, or a file is read in inches that nobody spoke of.

    A garment in feet has the size of another one in metres, so nobody can tell.
    """
    with pytest.raises(BadInput) as caught:
        load_scan(files / f"{kind}.ply", kind=kind, up="y", limits=INSIDE)
    assert caught.value.code == "scan.units_unknown"
    advice = caught.value.message.partition("--units ")[2].rstrip(".")
    assert advice in UNITS and advice not in METRIC
    assert load_scan(files / f"{kind}.ply", kind=kind, units=advice, up="y", limits=INSIDE).units == advice


def test_there_is_one_list():
    """Broken where a command or the interface offers other units than are read."""
    assert UNITS == METRES and get_args(UnitName) == tuple(METRES)
    asked = {}
    for name in COMMANDS:
        command = group.get_command(click.Context(group), name)
        for option in command.params:
            if option.name == "units":
                asked[name] = tuple(option.type.choices)
    assert asked.keys() >= {"run", "submit", "inspect", "segment", "dress", "refit"}
    assert {*asked.values(), tuple(ALLOWED["units"])} == {tuple(METRES)}
    assert get_type_hints(InspectionQuery)["units"] == UnitName | None
