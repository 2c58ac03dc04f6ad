"""`garmentq bench --ablate`: what each switch changes, what a line tells, and how rows are judged."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from click.testing import CliRunner
from garmentq.cli.bench import ablation
from garmentq.cli.bench import run as bench
from garmentq.cli.bench.ablation import (
    OURS,
    SWITCHES,
    Ablation,
    Switch,
    ablate_pack,
    empty_line,
    judge_rows,
    print_ablation,
)
from garmentq.core.recover.deform.settings import DeformSettings
from garmentq.core.recover.fit.descent import InverseSettings
from garmentq.core.run.errors import BadInput


def count_changes(before: object, after: object) -> int:
    one, two = asdict(before), asdict(after)
    return sum(one[name] != two[name] for name in one)


@pytest.mark.parametrize("switch", SWITCHES, ids=lambda each: f"{each.table} {each.name}")
def test_each_switch_changes_exactly_one_thing(switch: Switch) -> None:
    """Fails where a row switches off nothing, or more than one part, or a part of the other table."""
    changes = count_changes(InverseSettings(), replace(InverseSettings(), **switch.descent))
    for preset in (DeformSettings(), DeformSettings.thesis()):
        here = count_changes(preset, replace(preset, **switch.deforming))
        assert changes + here + (not switch.graded) == (0 if switch.name == OURS else 1)
    assert not (switch.descent if switch.table == "4.3" else switch.deforming)
    assert switch.graded or switch.table == "4.3"
    off = {**switch.descent, **switch.deforming}
    assert all(value == 0.0 for value in off.values())


def test_every_row_of_both_tables_is_there() -> None:
    """Fails where a row is left out, or the thesis has a row better than its own method."""
    for table, count in (("3.4", 4), ("4.3", 5)):
        rows = [switch for switch in SWITCHES if switch.table == table]
        assert len({row.name for row in rows}) == len(rows) == count
        (ours,) = (row for row in rows if row.name == OURS)
        assert all(row.thesis > ours.thesis for row in rows if row is not ours)


def fake_stage(monkeypatch: pytest.MonkeyPatch) -> list[Switch]:
    seen: list[Switch] = []

    def run(switch: Switch) -> dict[str, float]:
        seen.append(switch)
        if switch.name == "w/o seam loss":
            raise BadInput("it tore.")
        if switch.name == "w/o physics":
            raise ZeroDivisionError
        better = switch.name in ("w/o contour loss", OURS)
        return {"chamfer_vertex_m2e3": 0.1 if better else 0.2, "normal_cosine": 0.01 if switch.name == OURS else 0.02}

    stage = SimpleNamespace(pack=SimpleNamespace(name="a"), descend=run, deform=run)
    monkeypatch.setattr(ablation, "_Stage", SimpleNamespace(of=lambda pack, preset: stage))
    return seen


@pytest.fixture()
def pack(tmp_path: Path) -> Path:
    folder = tmp_path / "packs" / "a"
    folder.mkdir(parents=True)
    (folder / "meta.json").write_text(json.dumps({"name": "a", "category": "dress"}))
    for name in ("garment.ply", "body.ply"):
        (folder / name).write_text("ply\n")
    return folder


def test_one_row_that_fails_does_not_hide_the_others(
    pack: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Fails where an error ends the study, a row goes to the other table's method, or a direction is misread."""
    seen = fake_stage(monkeypatch)
    lines: list[dict] = []
    ablate_pack(Ablation(str(pack)), lines.append)
    assert seen == list(SWITCHES)
    errors = {line["setting"]: line["error"]["code"] for line in lines if not line["ok"]}
    assert errors == {"w/o seam loss": "input.bad", "w/o physics": "bench.exception"}
    assert set(lines[0]) == set(empty_line("a"))
    judged = {line["setting"]: word for line, word in judge_rows([line for line in lines if line["table"] == "4.3"])}
    assert judged[OURS] == "" and judged["w/o contour loss"] == "normal" and judged["w/o bending loss"] == "both"
    json.dumps(lines, allow_nan=False)
    print_ablation(lines)
    shown = capsys.readouterr().out
    assert "table 3.4" in shown and "table 4.3" in shown and "0.158" in shown and "it tore." in shown


def test_the_command_runs_the_study(pack: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fails where --ablate runs the ordinary bench, loses the preset, or a study without lines passes."""
    orders: list[tuple[str, dict]] = []
    done = empty_line("a", SWITCHES[0]) | {"ok": True}

    def study(kind: bench._Study, order: dict, timeout: float):
        orders.append((kind.module, order))
        return [done], None

    monkeypatch.setattr(bench, "_run_study", study)
    result = CliRunner().invoke(bench.command, [str(pack.parent), "--ablate", "--preset", "thesis", "--json"])
    assert result.exit_code == 0, result.output
    assert json.loads(result.stdout)["setting"] == OURS
    assert orders == [("ablation", {"pack": str(pack.resolve()), "preset": "thesis"})]
    monkeypatch.setattr(bench, "_run_study", lambda *_: ([], {"code": "bench.crashed", "message": "gone"}))
    assert CliRunner().invoke(bench.command, [str(pack.parent), "--ablate", "--json"]).exit_code == 5


def test_the_module_appends_lines(pack: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Fails if an order without tables ran none, a line were lost, or an unreadable garment were a crash."""
    order, lines = tmp_path / "order.json", tmp_path / "lines.jsonl"
    order.write_text(json.dumps({"pack": str(pack)}))
    ablation.main([str(order), str(lines)])
    (refused,) = map(json.loads, lines.read_text().splitlines())
    assert refused["error"]["code"].startswith("scan.")
    fake_stage(monkeypatch)
    ablation.main([str(order), str(lines)])
    assert len(lines.read_text().splitlines()) == 1 + len(SWITCHES)
