"""`garmentq bodies`."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import trimesh
from click.testing import CliRunner
from garmentq.cli.main import group


def test_an_exported_body_is_the_one_asked_for(tmp_path: Path) -> None:
    """Broken where the mesh has another height than asked, is inside out, or the joints are another body's."""
    path = tmp_path / "body.ply"
    answer = CliRunner().invoke(group, ["bodies", "export", "builtin:female,height=1.70", "-o", str(path), "--json"])
    assert answer.exit_code == 0, answer.output
    mesh = trimesh.load(path, process=False)
    assert abs(np.ptp(mesh.vertices[:, 1]) - 1.70) < 1e-3 and mesh.volume > 0.03
    joints = json.loads((tmp_path / "body_joints.json").read_text(encoding="utf-8"))
    assert len(joints) == 24 and joints["left_wrist"][0] > 0.5
    assert json.loads(answer.stdout)["joints_m"] == joints


def test_the_list_names_what_export_takes() -> None:
    """Broken where a listed body cannot be asked for, or a range is the other's."""
    from garmentq.core.body.builtin import builtin_body

    answer = CliRunner().invoke(group, ["bodies", "list", "--json"])
    bodies = [json.loads(line) for line in answer.stdout.splitlines()]
    assert {body["spec"] for body in bodies} == {"builtin:female", "builtin:male"}
    for body in bodies:
        (low, high, usual), (light, heavy, weight) = body["ranges"]
        assert low < usual < high and light < weight < heavy
        assert builtin_body(f"{body['spec']},height={usual},weight={weight},pose={body['poses'][1]}").vertices.any()
        assert set(body["poses"]) == {"T", "A", "arms-down", "stride", "seated"}  # all that a specification may ask for


def test_other_formats_are_refused(tmp_path: Path) -> None:
    """Broken where a PLY is written under another format's name."""
    answer = CliRunner().invoke(group, ["bodies", "export", "builtin:male", "-o", str(tmp_path / "body.stl")])
    assert answer.exit_code == 2
