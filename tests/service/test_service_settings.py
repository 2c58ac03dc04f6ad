"""The service's settings: read from the environment, and back."""

from __future__ import annotations

import re
from dataclasses import fields
from pathlib import Path

import pytest
from garmentq.service.settings import ServiceSettingBad, ServiceSettings, hide_password, read_settings


def test_environment_round_trip(tmp_path):
    """Broken where a worker that was started read other settings than the command that started it."""
    settings = ServiceSettings(home=tmp_path, lease_seconds=2.5, max_attempts=7, store=tmp_path / "s", idle_seconds=0.0)
    assert read_settings(settings.as_environment()) == settings


def test_defaults_and_home(tmp_path):
    """Broken where `--home` did not win, or a home were relative to a folder that a worker leaves."""
    assert read_settings({}).home == Path("~/.local/share/garmentq").expanduser()
    assert read_settings({"GARMENTQ_HOME": "/x"}, home=tmp_path).home == tmp_path
    assert read_settings({}, home="rel").home.is_absolute()
    assert read_settings({"GARMENTQ_HOME": str(tmp_path)}).database == f"sqlite:///{tmp_path}/garmentq.db"


@pytest.mark.parametrize("text", ["x", "-1", "0", "nan", "inf", ""])
def test_bad_numbers(text):
    """Broken where a lease of nothing made every worker a zombie."""
    environment = {"GARMENTQ_LEASE_SECONDS": text}
    if not text:
        assert read_settings(environment).lease_seconds == 30.0
        return
    with pytest.raises(ServiceSettingBad):
        read_settings(environment)


@pytest.mark.parametrize(
    ("url", "shown"),
    [
        ("postgresql+psycopg://me:secret@host:5432/db", "postgresql+psycopg://me:***@host:5432/db"),
        ("redis://:p%40ss@host/0", "redis://:***@host/0"),
        ("redis://host/0", "redis://host/0"),
        ("sqlite:////home/x.db", "sqlite:////home/x.db"),
    ],
)
def test_passwords_are_hidden(url, shown):
    """Broken where `doctor` or an error prints a secret."""
    assert hide_password(url) == shown


ROOT = Path(__file__).parents[2]
NAMES = {f"GARMENTQ_{field.name.upper()}" for field in fields(ServiceSettings)}


def test_the_page_names_every_setting():
    """Broken where a setting is added or renamed and docs/service.md is forgotten."""
    assert set(re.findall(r"GARMENTQ_[A-Z_]+", (ROOT / "docs" / "service.md").read_text(encoding="utf-8"))) == NAMES


def test_the_compose_file_names_what_exists():
    """Broken where the compose file sets a variable that nobody reads, or starts a command that is none."""
    from garmentq.cli.main import COMMANDS

    text = (ROOT / "docker-compose.yml").read_text(encoding="utf-8")
    assert set(re.findall(r"GARMENTQ_[A-Z_]+", text)) <= NAMES
    assert {"GARMENTQ_HOME", "GARMENTQ_BROKER_URL"} <= set(re.findall(r"GARMENTQ_[A-Z_]+", text))
    assert re.findall(r'command: \["(\w+)"\]', text) == ["worker"] and "worker" in COMMANDS
    volumes = re.findall(r"^  (\w+):$", text.split("\nvolumes:\n")[1], re.MULTILINE)
    assert sorted(volumes) == ["broker", "home"] and all(f"- {name}:/" in text for name in volumes)
    assert "ports:" not in text, "nothing may be published that has no key"
