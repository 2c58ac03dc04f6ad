"""The files of deploy/: units start commands that exist and may do little; alerts and board name metrics that exist."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
from configparser import RawConfigParser
from dataclasses import fields
from itertools import combinations
from pathlib import Path

import pytest
import yaml
from garmentq.cli.main import COMMANDS, group
from garmentq.service.api.request_times import RequestTimes, RouteClass
from garmentq.service.metrics import prometheus_text
from garmentq.service.settings import ServiceSettings
from garmentq.service.states import QUEUES, State
from garmentq.service.store_size import StoreSize

DEPLOY = Path(__file__).parents[2] / "deploy"
UNITS = sorted((DEPLOY / "systemd").glob("*.service"))
RULES = DEPLOY / "monitoring" / "garmentq.rules.yml"
ALERTS = yaml.safe_load(RULES.read_text(encoding="utf-8"))["groups"][0]["rules"]
BOARD = json.loads((DEPLOY / "monitoring" / "garmentq.board.json").read_text(encoding="utf-8"))
EXPRESSIONS = [alert["expr"] for alert in ALERTS]
EXPRESSIONS += [target["expr"] for panel in BOARD["panels"] for target in panel["targets"]]

LABELS = {
    "state": set(State), "queue": set(QUEUES), "route": set(RouteClass), "status": {"2xx", "3xx", "4xx", "5xx"},
    "job": {"garmentq"},
}  # fmt: skip
"""Labels that an expression may select by, with all their values; the last is the scrape's own."""

HARDENED = {
    "NoNewPrivileges": "yes", "ProtectSystem": "strict", "ProtectHome": "yes", "PrivateTmp": "yes",
    "PrivateDevices": "yes", "CapabilityBoundingSet": "", "UMask": "0077", "User": "garmentq",
}  # fmt: skip

MAX_EXPOSURE = 2.5
"""Largest exposure of a unit by `systemd-analyze security`, from 0 (closed) to 10."""


def find_commands(text: str) -> list[list[str]]:
    """Return the words of each command of ours that a text names."""
    return [shlex.split(words) for words in re.findall(r"`garmentq ([^`]+)`", text)]


def check_command(words: list[str]) -> None:
    """Fail where a command or one of its options is none."""
    assert words[0] in COMMANDS, words
    command = group.get_command(None, words[0])
    if words[0] in ("db", "webhooks"):
        command, words = command.commands[words[1]], words[1:]
    command.make_context(words[0], list(words[1:]), resilient_parsing=False)


@pytest.mark.parametrize("unit", UNITS, ids=lambda path: path.stem)
def test_a_unit(unit, tmp_path):
    """Broken where a unit starts a command that is none, runs as root, may do more than it must, or is refused."""
    parser = RawConfigParser(strict=False, delimiters=("=",), comment_prefixes=("#",))
    parser.optionxform = str
    parser.read(unit, encoding="utf-8")
    service = dict(parser["Service"])
    assert service.items() >= HARDENED.items()
    program, *words = shlex.split(service["ExecStart"])
    assert program == "/opt/garmentq/bin/garmentq"
    check_command(words)
    # files are parsed in processes with a network namespace of their own
    assert service["RestrictNamespaces"] == ("yes" if words[0] == "courier" else "net user")
    assert service["StateDirectory"] == f"garmentq/{words[0]}" and service["KillMode"] == "mixed"
    if shutil.which("systemd-analyze"):
        copy = tmp_path / unit.name
        copy.write_text(unit.read_text(encoding="utf-8").replace(program, "/bin/true"), encoding="utf-8")
        done = subprocess.run(["systemd-analyze", "verify", copy], capture_output=True, text=True, check=False)
        assert (done.returncode, done.stderr) == (0, ""), done.stderr
        command = ["systemd-analyze", "security", "--offline=true", copy]
        told = subprocess.run(command, capture_output=True, text=True, check=False).stdout
        assert float(re.search(r"exposure level for \S+: ([\d.]+)", told)[1]) <= MAX_EXPOSURE


def test_the_units_share_one_environment():
    """Broken where a unit is missing, or its file of addresses sets a variable that nobody reads."""
    assert [unit.stem for unit in UNITS] == ["garmentq-courier", "garmentq-serve", "garmentq-worker"]
    lines = (DEPLOY / "systemd" / "environment").read_text(encoding="utf-8").splitlines()
    names = {line.partition("=")[0] for line in lines if not line.startswith("#")}
    assert names and names <= {f"GARMENTQ_{field.name.upper()}" for field in fields(ServiceSettings)}


def test_every_metric_of_alerts_and_board_exists(database, settings):
    """Broken where a metric is renamed, and an alert that names it stays silent for ever."""
    size = StoreSize(database, settings)
    text = prometheus_text(database) + RequestTimes().format_metrics() + size.format_metrics()
    kinds = dict(re.findall(r"^# TYPE (\S+) (\S+)$", text, re.MULTILINE))
    found = {f"{name}_{part}" for name, kind in kinds.items() if kind == "histogram" for part in ("bucket", "count")}
    found |= {name for name, kind in kinds.items() if kind != "histogram"}
    for expression in EXPRESSIONS:
        named = set(re.findall(r"\bgarmentq_[a-z0-9_]+", expression))
        assert named <= found, expression
        assert named or expression.startswith("up{"), expression
        assert all(expression.count(a) == expression.count(b) for a, b in ("()", "[]", "{}"))
        for label, values in re.findall(r'(\w+)=~?"([^"]*)"', expression):
            assert set(values.split("|")) <= LABELS[label], expression
        for name, function in re.findall(r"(?:(rate|increase)\()(garmentq_[a-z0-9_]+)", expression):
            counts = kinds.get(function, "") == "counter" or function.endswith(("_bucket", "_count"))
            assert counts, f"{name} is for counters"


@pytest.mark.parametrize("alert", ALERTS, ids=lambda alert: alert["alert"])
def test_an_alert_names_the_next_step(alert):
    """Broken where whoever is woken has to look for what to do, or types a command that is none."""
    assert alert["labels"]["severity"] in ("critical", "warning")
    assert alert["annotations"]["summary"].endswith(".") and alert["annotations"]["action"].endswith(".")
    for words in find_commands(alert["annotations"]["action"]):
        check_command(words)


def test_the_board_has_no_panel_on_another():
    """Broken where Grafana drops a panel with another's number, or draws one over another."""
    panels = BOARD["panels"]
    assert len({panel["id"] for panel in panels}) == len({panel["title"] for panel in panels}) == len(panels)
    places = [panel["gridPos"] for panel in panels]
    assert all(place["x"] + place["w"] <= 24 for place in places)
    for one, other in combinations(places, 2):
        beside = one["x"] + one["w"] <= other["x"] or other["x"] + other["w"] <= one["x"]
        assert beside or one["y"] + one["h"] <= other["y"] or other["y"] + other["h"] <= one["y"]


@pytest.mark.skipif(shutil.which("promtool") is None, reason="the Debian package prometheus has promtool")
def test_alerts_fire_when_they_should(tmp_path):
    """Broken where Prometheus refuses the rules, an alert sleeps through its fault, or rings in a quiet service."""
    quiet = {
        'garmentq_workers{instance="a"}': "1+0x60",
        'garmentq_jobs{instance="a",state="queued",queue="cpu"}': "5+0x60",
        'garmentq_api_responses_total{route="read",status="2xx"}': "0+60x60",
        'garmentq_api_responses_total{route="read",status="5xx"}': "0+0x60",
        'garmentq_outages{code="store.full"}': "0+0x60",
        'garmentq_store_free_bytes{instance="a"}': "90000000000+0x60",
    }
    cases = [
        ({}, {}),
        ({'garmentq_workers{instance="a"}': "0+0x60"}, {"GarmentqNoWorker": ("critical", {})}),
        (
            {'garmentq_api_responses_total{route="read",status="5xx"}': "0+10x60"},
            {"GarmentqApiFaults": ("critical", {})},
        ),
        ({'garmentq_outages{code="store.full"}': "2+0x60"}, {"GarmentqOutage": ("critical", {"code": "store.full"})}),
        (
            {'garmentq_store_free_bytes{instance="a"}': "90000000000-1000000000x60"},
            {"GarmentqStoreFills": ("warning", {})},
        ),
    ]  # fmt: skip
    names = ["GarmentqNoWorker", "GarmentqApiFaults", "GarmentqOutage", "GarmentqStoreFills", "GarmentqQueueIsOld"]
    written = []
    for changes, firing in cases:
        series = [{"series": name, "values": values} for name, values in (quiet | changes).items()]
        expected = []
        for name in names:
            alert = next(one for one in ALERTS if one["alert"] == name)
            rings = []
            if name in firing:
                severity, labels = firing[name]
                summary = alert["annotations"]["summary"].replace("{{ $value }}", "2")
                summary = summary.replace("{{ $labels.code }}", labels.get("code", ""))
                summary = summary.replace("{{ $value | humanizePercentage }}", "14.29%")
                told = {"summary": summary, "action": alert["annotations"]["action"]}
                rings = [{"exp_labels": {"severity": severity, **labels}, "exp_annotations": told}]
            expected.append({"eval_time": "55m", "alertname": name, "exp_alerts": rings})
        written.append({"interval": "1m", "input_series": series, "alert_rule_test": expected})
    path = tmp_path / "alerts.yml"
    path.write_text(yaml.safe_dump({"rule_files": [str(RULES)], "evaluation_interval": "1m", "tests": written}))
    for words in (["check", "rules", RULES], ["test", "rules", path]):
        done = subprocess.run(["promtool", *words], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
