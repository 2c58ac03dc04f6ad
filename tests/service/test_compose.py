"""What can be known of the containers without Docker: all that the files name exists, and nothing is left open."""

from __future__ import annotations

import re
import stat
import subprocess
import sys
from dataclasses import fields
from ipaddress import ip_address
from pathlib import Path

import pytest
import yaml
from garmentq import __version__
from garmentq.cli.main import COMMANDS, group
from garmentq.service.api.proxies import read_proxies
from garmentq.service.settings import ServiceSettings, read_settings

ROOT = Path(__file__).parents[2]
COMPOSE = yaml.safe_load((ROOT / "docker-compose.yml").read_text(encoding="utf-8"))
SERVICES = COMPOSE["services"]
OURS = {name: service for name, service in SERVICES.items() if "build" in service}
NAMES = {f"GARMENTQ_{field.name.upper()}" for field in fields(ServiceSettings)} | {"GARMENTQ_API_PROXIES"}
KNOWN = {
    "AWS_SHARED_CREDENTIALS_FILE",
    "OMP_NUM_THREADS",
    "OPENBLAS_NUM_THREADS",
    "MKL_NUM_THREADS",
    "NUMBA_NUM_THREADS",
}
"""Variables that other packages read."""


def test_the_schema():
    """Broken where a key is misspelt: Docker would refuse the file."""
    command = [
        sys.executable,
        "-m",
        "check_jsonschema",
        "--builtin-schema",
        "vendor.compose-spec",
        "docker-compose.yml",
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_all_parts_are_there():
    """Broken where a part of the service is left out."""
    assert set(SERVICES) == {"upgrade", "api", "worker", "courier", "broker", "database", "store"}
    assert set(OURS) == {"upgrade", "api", "worker", "courier"}


@pytest.mark.parametrize("name", OURS)
def test_commands_and_variables_exist(name):
    """Broken where a container starts a command that is none, or sets a variable that nobody reads."""
    service = OURS[name]
    words = service["command"]
    assert words[0] in COMMANDS
    command = group.get_command(None, words[0])
    if words[0] == "db":
        command, words = command.commands[words[1]], words[1:]
    command.make_context(words[0], list(words[1:]))  # raises where an option is none
    if service.get("healthcheck", {}).get("test", [])[:2] == ["CMD", "garmentq"]:
        name, *options = service["healthcheck"]["test"][2:]
        group.get_command(None, name).make_context(name, options)
    variables = {key.removesuffix("_FILE") if key.startswith("GARMENTQ_") else key for key in service["environment"]}
    assert variables <= NAMES | KNOWN
    beside = set() if words[0] == "courier" else {"GARMENTQ_BROKER_URL", "GARMENTQ_STORE"}
    assert {"GARMENTQ_DATABASE_URL", *beside} <= variables


def test_a_proxy_before_the_published_port_is_believed():
    """Broken where all clients are the bridge's gateway to the limit on wrong keys, or whoever comes is believed."""
    proxies = read_proxies(OURS["api"]["environment"])
    for gateway in ("172.17.0.1", "172.31.0.1", "192.168.16.1"):
        assert any(ip_address(gateway) in network for network in proxies), gateway
    assert all(network.is_private for network in proxies)


@pytest.mark.parametrize("name", SERVICES)
def test_each_service_is_bounded_and_watched(name):
    """Broken where a container may take the whole host, runs an image of any version, or hangs unseen."""
    service = SERVICES[name]
    assert re.search(r":\d+\.\d+|:\d+-", service["image"]), "a pinned version"
    own = service["image"].startswith("garmentq:")
    assert not own or service["image"] == f"garmentq:{__version__}", "a release's image is named by its version"
    assert {"mem_limit", "cpus", "pids_limit", "restart"} <= set(service)
    assert {"max-size", "max-file"} <= set(service["logging"]["options"]), "a log must not fill the disk"
    assert "healthcheck" in service or service["command"] == ["db", "upgrade"]
    assert "privileged" not in service and "network_mode" not in service


@pytest.mark.parametrize("name", SERVICES)
def test_no_container_has_rights(name):
    """Broken where a parser's hole, or one of a server's, gives more than an empty container."""
    service = SERVICES[name]
    assert service["read_only"] is True and service["cap_drop"] == ["ALL"]
    assert service["security_opt"] == ["no-new-privileges:true"]
    needed = {"broker": {"DAC_OVERRIDE"}, "database": {"CHOWN", "DAC_OVERRIDE", "FOWNER", "SETGID", "SETUID"}}
    assert set(service.get("cap_add", ())) == needed.get(name, set())


def test_whoever_sends_to_webhooks_has_a_way_out():
    """Broken where messages are owed, a test says that they arrive, and no process that sends reaches the internet."""
    outside = {name for name, inner in COMPOSE["networks"].items() if not inner.get("internal")}
    sends = {
        name
        for name, service in OURS.items()
        if service["command"][0] == "courier"
        or (service["command"][0] == "worker" and service["environment"]["GARMENTQ_SEND_MESSAGES"] != "0")
    }
    assert sends == {"courier"}
    assert all(outside & set(SERVICES[name]["networks"]) for name in sends)
    assert not any(outside & set(SERVICES[name]["networks"]) for name in ("worker", "database", "broker", "store"))
    for name in ("api", "courier"):
        assert "GARMENTQ_WEBHOOK_NETWORKS" in OURS[name]["environment"]


def test_health_checks_are_light_and_tell_what_is_away():
    """Broken where a busy host makes working containers unhealthy, or an API without its database looks healthy."""
    assert "/readyz" in str(OURS["api"]["healthcheck"]["test"])
    for name in ("worker", "courier"):
        assert OURS[name]["healthcheck"]["test"] == ["CMD", "garmentq", OURS[name]["command"][0], "--check"]


def test_nothing_refuses_to_start_before_there_is_a_key():
    """Broken where the API's container starts over and over until somebody has made a key."""
    assert "--await-key" in OURS["api"]["command"]


def test_no_port_is_open_but_the_api_on_this_machine():
    """Broken where a database or broker is published, or the API to the network."""
    ports = {name: service["ports"] for name, service in SERVICES.items() if "ports" in service}
    assert ports == {"api": ["127.0.0.1:8080:8080"]}
    assert COMPOSE["networks"]["inside"] == {"internal": True}
    assert {name for name, service in SERVICES.items() if "outside" in service["networks"]} == {"api", "courier"}


def test_volumes_and_secrets_are_used_and_declared():
    """Broken where data would live in a container's own layer, or a secret is named that no file holds."""
    volumes = [volume.split(":")[0] for service in SERVICES.values() for volume in service["volumes"]]
    assert set(volumes) == set(COMPOSE["volumes"])
    assert SERVICES["database"]["volumes"] == ["database:/var/lib/postgresql"], "the place of PostgreSQL 18 and later"
    for name, service in SERVICES.items():
        granted = set(service["secrets"])
        text = str({key: value for key, value in service.items() if key != "secrets"})
        assert set(re.findall(r"/run/secrets/(\w+)", text)) == granted, name
    assert {secret for service in SERVICES.values() for secret in service["secrets"]} == set(COMPOSE["secrets"])
    assert "password:" not in (ROOT / "docker-compose.yml").read_text(encoding="utf-8").lower().replace(
        "database_password:", ""
    ).replace("broker_password:", "")


def test_dependencies_name_services_that_can_be_waited_for():
    """Broken where a container waits for a health check that is not there."""
    for service in SERVICES.values():
        for name, wish in service.get("depends_on", {}).items():
            if wish["condition"] == "service_healthy":
                assert "healthcheck" in SERVICES[name]
            else:
                assert (wish["condition"], name) == ("service_completed_successfully", "upgrade")


def test_the_secrets_script(tmp_path):
    """Broken where a secret is missing, weak, open to other users, or replaced by a second call."""
    script = ["sh", str(ROOT / "deploy" / "make-secrets.sh"), str(tmp_path / "secrets")]
    subprocess.run(script, check=True)
    files = {path.name: path.read_text() for path in (tmp_path / "secrets").iterdir()}
    assert set(files) == set(COMPOSE["secrets"])
    assert stat.S_IMODE((tmp_path / "secrets").stat().st_mode) == 0o700
    assert len(files["database_password"]) == 48 and files["database_password"] != files["broker_password"]
    settings = read_settings(
        {f"GARMENTQ_{name}_FILE": str(tmp_path / "secrets" / name.lower()) for name in ("DATABASE_URL", "BROKER_URL")}
    )
    assert settings.database_url == f"postgresql://garmentq:{files['database_password']}@database:5432/garmentq"
    assert settings.broker_url == f"redis://:{files['broker_password']}@broker:6379/0"
    key = re.search(r"aws_access_key_id = (\w+)", files["s3_credentials"])[1]
    assert yaml.safe_load(files["s3_config"])["identities"][0]["credentials"][0]["accessKey"] == key
    subprocess.run(script, check=True, capture_output=True)
    assert (tmp_path / "secrets" / "database_url").read_text() == files["database_url"]


def test_the_dockerfile():
    """Broken where the image runs as root, carries secrets, or lacks an extra, a library or compiled kernels."""
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    stages = re.findall(r"^FROM (\S+)(?: AS (\w+))?$", text, re.MULTILINE)
    assert len(stages) == 2 and stages[0][1] == "build" and "--from=build" in text
    last = text.rsplit("\nFROM ", 1)[1]
    assert re.search(r"^USER 10001:10001$", last, re.MULTILINE) and "pip" not in last
    warm = last.index("\nRUN garmentq doctor --warm\n")  # before the cache of a user: into the package's folder
    assert last.index("COPY --from=build") < warm < last.index("NUMBA_CACHE_DIR") < last.index("\nUSER ")
    lock = (ROOT / "requirements.lock").read_text(encoding="utf-8")
    assert "-r requirements.lock" in text and "\npsycopg==" in lock and "\nboto3==" in lock
    assert 'ENTRYPOINT ["garmentq"]' in last
    assert {"secrets", ".git"} <= set((ROOT / ".dockerignore").read_text(encoding="utf-8").split())
    sources = re.findall(r"^COPY (?!--from)(\S+)", text, re.MULTILINE)
    assert all((ROOT / source).exists() for source in sources)
    from garmentq.cli.doctor_checks import OPEN3D_LIBRARIES

    for library in OPEN3D_LIBRARIES:
        stem = library.split(".so.")[0].lower()
        assert re.search(rf"\b{re.escape(stem)}[\d.-]*\b", last), f"the image lacks {library}"
