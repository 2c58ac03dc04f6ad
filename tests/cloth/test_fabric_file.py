"""Files of fabrics: what is read of them, what is refused, and that the cloth hangs by it."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from garmentq.core.cloth.bending_friction import measure_angles
from garmentq.core.cloth.fabric_check import check_fabric
from garmentq.core.cloth.fabric_file import read_fabrics, write_fabrics
from garmentq.core.cloth.fabrics import get_fabric, load_fabrics
from garmentq.core.cloth.locking import reduce_membrane_stiffness
from garmentq.core.cloth.scene import Scene
from garmentq.core.cloth.settings import SolveSettings
from garmentq.core.cloth.statics import equilibrium
from garmentq.core.cloth.topology import Topology
from garmentq.core.run.errors import BadInput

MINE = replace(get_fabric("cotton_poplin"), name="mine", title="Popeline, 120 g/m2, blau-weiß")


@pytest.mark.parametrize("suffix", ["json", "csv"])
def test_round_trip(suffix, tmp_path):
    """Broken where a number, a title or a source is another after it was written and read."""
    fabrics = [MINE, replace(get_fabric("denim"), name="theirs", k=1.0 / 3e4, title="")]
    write_fabrics(fabrics, tmp_path / f"fabrics.{suffix}")
    assert read_fabrics(tmp_path / f"fabrics.{suffix}") == fabrics


@pytest.mark.parametrize("suffix", ["json", "csv"])
def test_every_shipped_fabric_is_in_range(suffix, tmp_path):
    """Broken where an exported fabric cannot be imported under a name of its own."""
    write_fabrics([replace(one, name=f"my_{one.name}") for one in load_fabrics()], tmp_path / f"all.{suffix}")
    assert len(read_fabrics(tmp_path / f"all.{suffix}")) == len(load_fabrics())


def test_units_are_read(tmp_path):
    """Broken where a unit is taken for another one."""
    told = _tell(MINE)
    told["parameters"]["density"] |= {"value": 120, "unit": "g/m2"}
    told["parameters"]["thickness"] |= {"value": 0.25, "unit": "mm"}
    told["parameters"]["k"] |= {"value": 16, "unit": "uN m"}
    (found,) = read_fabrics(_write([told], tmp_path))
    for name in ("density", "thickness", "k"):
        assert getattr(found, name) == pytest.approx(getattr(MINE, name), rel=1e-12), name


HOSTILE = [
    ("fabric.unit_bad", "density", {"value": 120, "unit": "oz"}),
    ("fabric.unit_bad", "H00", {"unit": ""}),
    ("fabric.out_of_range", "density", {"value": 120}),
    ("fabric.out_of_range", "density", {"value": 5, "unit": "g/m2"} | {"value": 0.5}),
    ("fabric.out_of_range", "k", {"value": -1e-5}),
    ("fabric.out_of_range", "H01", {"value": 1000.0}),
    ("fabric.out_of_range", "H00", {"value": 5.2}),
    ("fabric.file_bad", "k", {"value": float("nan")}),
    ("fabric.file_bad", "k", {"value": float("inf")}),
    ("fabric.file_bad", "k", {"value": True}),
    ("fabric.file_bad", "k", {"value": [1]}),
    ("fabric.file_bad", "k", {"value": 10**400}),
    ("fabric.file_bad", "k", {"unit": 3}),
    ("fabric.source_bad", "k", {"source": ""}),
    ("fabric.source_bad", "k", {"source": "measured: "}),
    ("fabric.source_bad", "k", {"source": "somebody said so once"}),
    ("fabric.source_bad", "k", {"source": "measured: a text with \x1b[31m in it"}),
]


@pytest.mark.parametrize(("code", "name", "change"), HOSTILE)
def test_wrong_numbers_are_refused(code, name, change, tmp_path):
    """Broken where a number without unit, source or sense becomes a fabric."""
    told = _tell(MINE)
    told["parameters"][name] |= change
    assert _refuse(_write([told], tmp_path)) == code


@pytest.mark.parametrize(
    ("code", "change"),
    [
        ("fabric.name_bad", {"name": "../x"}),
        ("fabric.name_bad", {"name": ""}),
        ("fabric.name_bad", {"name": "a" * 65}),
        ("fabric.name_bad", {"title": "=1+1"}),
        ("fabric.name_bad", {"title": "a\nb"}),
        ("fabric.file_bad", {"name": 3}),
        ("fabric.file_bad", {"name": [1]}),
        ("fabric.file_bad", {"parameters": {}}),
        ("fabric.file_bad", {"parameters": 3}),
    ],
)
def test_wrong_names_are_refused(code, change, tmp_path):
    """Broken where a name could be a path, or a title a formula of a spreadsheet."""
    assert _refuse(_write([_tell(MINE) | change], tmp_path)) == code


@pytest.mark.parametrize(
    "content",
    [
        b"", b"\xff\xfe\x00", b"{", b"[]", b'{"fabrics": []}', b'{"fabrics": 3}', b'{"fabrics": [3]}',
        b'{"fabric": []}',
        b'{"fabrics": ' + b"[" * 100_000, b"name,value\nx,1\n", b"\x00,\x00", b" " * 2_000_000,
        b"name,title,parameter,value,unit,source\nmine,,k,1e-5,N m,measured: in our own laboratory\n",
        b"name,title,parameter,value,unit,source\nmine,k\n",
    ],
)  # fmt: skip
def test_other_files_are_refused(content, tmp_path):
    """Broken where a file that is no library ends in a traceback, or in no fabric without a word."""
    (tmp_path / "bad").write_bytes(content)
    assert _refuse(tmp_path / "bad") == "fabric.file_bad"
    assert _refuse(tmp_path / "none") == "fabric.file_bad"


def test_a_fabric_twice_is_refused(tmp_path):
    """Broken where of two fabrics of one name the last is taken without a word."""
    assert _refuse(_write([_tell(MINE), _tell(MINE)], tmp_path)) == "fabric.file_bad"


def test_a_source_too_many_is_refused():
    """Broken where something is kept of a fabric that nobody reads."""
    with pytest.raises(BadInput) as caught:
        check_fabric(replace(MINE, sources=(*MINE.sources, ("colour", "measured: with our own eyes"))))
    assert caught.value.code == "fabric.source_bad"


def test_stiffer_fabric_hangs_with_less_curvature(sheet, grid_of, tmp_path):
    """Broken where the bending stiffness of a file does not reach the cloth: on the same ball it bends as much."""
    write_fabrics([MINE, replace(MINE, name="stiffer", k=20.0 * MINE.k)], tmp_path / "two.json")
    flat, faces = sheet(13, 13, 0.36, 0.36)
    nodes = np.column_stack([flat[:, 0] - 0.17, np.full(len(flat), 0.103), 0.16 - flat[:, 1]])
    ball = grid_of(lambda points: np.linalg.norm(points, axis=-1) - 0.1)
    bends = []
    for fabric in read_fabrics(tmp_path / "two.json"):
        topology = Topology.from_mesh(faces, flat[faces])
        drape = equilibrium(
            Scene(topology, reduce_membrane_stiffness(fabric), ball), nodes, settings=SolveSettings(max_iterations=400)
        )
        assert drape.converged
        bends.append(np.sqrt(np.mean(measure_angles(topology, drape.nodes) ** 2)))
    assert bends[1] < 0.8 * bends[0]


def _tell(fabric):
    """Return a fabric as a file says it."""
    units = {"density": "kg/m2", "k": "N m", "thickness": "m", "friction": "1"}
    return {
        "name": fabric.name,
        "title": fabric.title,
        "parameters": {
            name: {"value": getattr(fabric, name), "unit": units.get(name, "N/m"), "source": source}
            for name, source in fabric.sources
        },
    }


def _write(fabrics, folder):
    path = folder / "fabrics.json"
    path.write_text(json.dumps({"fabrics": fabrics}), encoding="utf-8")
    return path


def _refuse(path) -> str:
    """Return the code of the error that reading a file ends in."""
    with pytest.raises(BadInput) as caught:
        read_fabrics(path)
    return caught.value.code
