"""What the commands write under the mask 022: a home for its user alone, and what was asked for as the user writes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from api_work import finish
from garmentq.service.backup import make_backup
from garmentq_home import make_environment, make_settings, put_file
from patience import WAIT_SECONDS
from served_process import serving_alone


def run(settings, *words: object, mask: int = 0o022) -> subprocess.CompletedProcess[str]:
    """Run a command as a process of a user with a mask."""
    command = [sys.executable, "-m", "garmentq.cli.main", *map(str, words)]
    options = {"env": make_environment(settings), "umask": mask, "timeout": WAIT_SECONDS, "check": False}
    done = subprocess.run(command, capture_output=True, text=True, **options)
    assert done.returncode == 0, done
    return done


def find_open(folder: Path) -> dict[str, str]:
    """Return what of a folder, and the folder itself, others have a right to, with its mode."""
    modes = {path: path.lstat().st_mode & 0o777 for path in (folder, *folder.rglob("*")) if not path.is_symlink()}
    return {str(path): oct(mode) for path, mode in modes.items() if mode & 0o077}


@pytest.fixture
def filled(settings, database, store, queue_job, tmp_path):
    """Return a finished job of the home."""
    job = queue_job()
    finish(settings, database, store, job, tmp_path / "made")
    return job


def test_a_restored_home_is_private(settings, filled, tmp_path):
    """Broken where a home that a restore makes, or a folder above it, can be read by others."""
    run(settings, "backup", tmp_path / "saved" / "b.tar")
    assert find_open(tmp_path / "saved") == {}
    new = make_settings(tmp_path / "deep" / "er" / "home")
    run(new, "restore", tmp_path / "saved" / "b.tar")
    assert (new.home / "garmentq.db").is_file() and any(new.store_path.rglob("*"))
    assert find_open(tmp_path / "deep") == {}


@pytest.mark.parametrize("how", ["restore", "upgrade"])
def test_an_open_home_is_closed(settings, database, filled, tmp_path, how):
    """Broken where a home of an earlier version stays readable after a restore or an upgrade."""
    make_backup(settings, tmp_path / "b.tar")
    database.dispose()
    for path in (settings.home, *settings.home.rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)
    kept = settings.home / "mine.txt"
    kept.write_text("the user's own")
    kept.chmod(0o644)
    (settings.store_path / "link").symlink_to(kept)
    run(settings, *(("db", "upgrade") if how == "upgrade" else ("restore", tmp_path / "b.tar", "--overwrite")))
    assert find_open(settings.home) == {str(kept): "0o644"}


@pytest.mark.nightly
def test_every_command_keeps_its_home_private(tmp_path):
    """Broken where a command makes something of a home that others can read: database, store, socket, log, token."""
    settings = make_settings(tmp_path / "a" / "home")
    scan, body = put_file(tmp_path, "skirt.ply"), put_file(tmp_path, "body.ply")
    try:
        for words in (
            ("keys", "create", "one"),
            ("submit", scan, "--body", body),
            ("up", "--workers", 1),
            ("status",),
            ("run", scan, "--body", body, "--lenient"),
            ("backup", settings.home / "b.tar"),
        ):
            run(settings, *words)
            assert find_open(tmp_path / "a") == {}, words
        assert any(path.is_file() for path in (settings.home / "results").rglob("*"))
        assert {"api.token", "garmentq.db", "worker.log", "broker.log"} <= serve(settings, tmp_path)
        assert find_open(tmp_path / "a") == {}
    finally:
        run(settings, "down")
    assert find_open(tmp_path / "a") == {}


def serve(settings, folder: Path) -> set[str]:
    """Serve a home for a moment under the mask 022, and return the names in it meanwhile."""
    with serving_alone(make_environment(settings), folder / "serve.log", umask=0o022):
        assert find_open(settings.home) == {}
        return {path.name for path in settings.home.iterdir()}


@pytest.mark.parametrize("mask", [0o022, *(pytest.param(mask, marks=pytest.mark.nightly) for mask in (0o002, 0o077))])
def test_what_was_asked_for_follows_the_users_mask(settings, filled, tmp_path, mask):
    """Broken where a file that a user asked for cannot be read by those who may read the user's other files."""
    out = tmp_path / "out"
    written = [
        ("export", filled, "--out", out / "deep" / "result"),
        ("templates", "export", "tshirt", "--out", tmp_path / "tshirt.json"),
        ("materials", "export", "denim", "--out", tmp_path / "denim.json"),
        ("bodies", "export", "builtin:female,height=1.70", "--out", tmp_path / "fresh.ply"),
    ]
    for words in written:
        run(settings, *words, mask=mask)
    files = [tmp_path / name for name in ("tshirt.json", "denim.json", "fresh.ply", "fresh_joints.json")]
    files += [path for path in out.rglob("*") if path.is_file()]
    assert len(files) >= 6 and {path.stat().st_mode & 0o777 for path in files} == {0o666 & ~mask}
    assert {path.stat().st_mode & 0o777 for path in (out, *out.rglob("*")) if path.is_dir()} == {0o777 & ~mask}
    assert find_open(settings.home) == {}


def test_a_remote_export_follows_the_users_mask(settings, filled, tmp_path):
    """Broken where files that come from a service have other rights than those of a home."""
    with serving_alone(make_environment(settings), tmp_path / "serve.log") as served:
        command = [sys.executable, "-m", "garmentq.cli.main", "export", filled, "--out", str(tmp_path / "out")]
        environment = make_environment(settings) | {"GARMENTQ_URL": served.url}
        subprocess.run(command, env=environment, umask=0o027, timeout=WAIT_SECONDS, check=True)
    assert {path.stat().st_mode & 0o777 for path in (tmp_path / "out").iterdir()} == {0o640}
