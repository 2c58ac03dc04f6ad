"""The service's settings: read from the environment, and back."""

from __future__ import annotations

import json
import re
from dataclasses import fields
from pathlib import Path

import pytest
from garmentq.service.settings import ServiceSettingBad, ServiceSettings, hide_password, read_settings


def test_environment_round_trip(tmp_path):
    """Broken where a worker that was started read other settings than the command that started it."""
    settings = ServiceSettings(
        home=tmp_path, lease_seconds=2.5, max_attempts=7, store=str(tmp_path / "s"), idle_seconds=0.0
    )
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
        ("rediss://u:p@host/0?ssl_cert_reqs=required", "rediss://u:***@host/0?ssl_cert_reqs=required"),
        (
            "postgresql://host/db?user=me&password=s%20x&sslmode=require",
            "postgresql://host/db?user=me&password=***&sslmode=require",
        ),
        (
            "postgresql:///db?sslpassword=s&secret_access_key=t",
            "postgresql:///db?sslpassword=***&secret_access_key=***",
        ),
        ("sqlite:////home/x.db", "sqlite:////home/x.db"),
    ],
)
def test_passwords_are_hidden(url, shown):
    """Broken where `doctor` or an error prints a secret."""
    assert hide_password(url) == shown


def test_a_secret_comes_from_a_file(tmp_path):
    """Broken where a container's secret is not read, keeps its newline, or wins over what was said plainly."""
    (tmp_path / "url").write_text("postgresql://me:secret@host/db\n")
    environment = {"GARMENTQ_DATABASE_URL_FILE": str(tmp_path / "url")}
    assert read_settings(environment).database_url == "postgresql://me:secret@host/db"
    assert read_settings({**environment, "GARMENTQ_DATABASE_URL": "sqlite:////x"}).database_url == "sqlite:////x"
    with pytest.raises(ServiceSettingBad):
        read_settings({"GARMENTQ_BROKER_URL_FILE": str(tmp_path / "nosuch")})


def test_the_store_is_a_folder_or_a_bucket(tmp_path):
    """Broken where an address is taken for a folder, or a folder stays relative to a place that a worker leaves."""
    assert read_settings({"GARMENTQ_STORE": "s3://studio/a"}).store == "s3://studio/a"
    assert read_settings({"GARMENTQ_STORE": "blobs"}).store_path == Path("blobs").absolute()


def test_doctor_shows_every_setting_and_no_secret(cli, settings):
    """Broken where a setting is missing from the list, or a password is shown by any of the checks."""
    secrets = {
        "GARMENTQ_DATABASE_URL": "postgresql://me:pssst1@127.0.0.1:1/db",
        "GARMENTQ_BROKER_URL": "rediss://me:pssst2@127.0.0.1:1/0?password=pssst3",
        "GARMENTQ_STORE": str(settings.home / "blobs"),
    }
    done = cli("doctor", "--json", **secrets)
    assert done.returncode == 1, "neither answers"
    shown = {row["check"]: row["message"] for row in map(json.loads, done.stdout.splitlines())}
    assert set(shown) >= NAMES
    assert shown["GARMENTQ_DATABASE_URL"] == "postgresql://me:***@127.0.0.1:1/db  (set)"
    assert "pssst" not in done.stdout + done.stderr


ROOT = Path(__file__).parents[2]
NAMES = {f"GARMENTQ_{field.name.upper()}" for field in fields(ServiceSettings)}


def test_the_page_names_every_setting():
    """Broken where a setting is added or renamed and docs/reference/settings.md is forgotten."""
    page = ROOT / "docs" / "reference" / "settings.md"
    assert set(re.findall(r"GARMENTQ_[A-Z0-9_]+", page.read_text(encoding="utf-8"))) == NAMES
