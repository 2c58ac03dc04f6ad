"""The part of `remote.RemoteBackend` for libraries, keys and webhooks, and the parsing of responses."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar
from urllib.parse import quote

from .catalogue import ImportedTemplate, Template, read_fabric, show_fabric
from .connection import Connection, ServiceUnreachable
from .materials import refuse_shipped
from .records import Json, Key
from .share_records import DEFAULT_SHARE_DAYS, Share
from .states import State
from .webhook_records import Receipt, Webhook

if TYPE_CHECKING:
    from ..core.cloth.fabric import Fabric

R = TypeVar("R")


class RemoteLibraries:
    """Implement the operations of `backend.Backend` on libraries, keys and webhooks by HTTP."""

    def __init__(self, connection: Connection) -> None:
        """Use a connection."""
        self._connection = connection
        self._ask, self._send = connection.request, connection.send

    def list_templates(self) -> list[Template]:
        """Return shipped and imported templates."""
        return read_all(Template.from_json, self._ask("GET", "/v1/templates"), "templates")

    def read_template(self, name: str) -> bytes:
        """Return a template's pattern file."""
        return self._send("GET", f"/v1/templates/{quote(name, safe='')}").content

    def import_template(self, name: str, path: Path) -> ImportedTemplate:
        """Send a pattern file as a template."""
        from ..core.garment.garmentcode import load_pattern

        load_pattern(path)
        found = self._ask("PUT", f"/v1/templates/{quote(name, safe='')}", content=path.read_bytes())
        return read(lambda: ImportedTemplate.from_json(found))

    def delete_template(self, name: str) -> None:
        """Delete an imported template."""
        self._ask("DELETE", f"/v1/templates/{quote(name, safe='')}")

    def list_materials(self) -> list[Fabric]:
        """Return every fabric of the library."""
        return read_all(read_fabric, self._ask("GET", "/v1/materials"), "materials")

    def read_material(self, name: str) -> Fabric:
        """Return one fabric."""
        found = self._ask("GET", f"/v1/materials/{quote(name, safe='')}")
        return read(lambda: read_fabric(found))

    def import_materials(self, path: Path) -> list[Fabric]:
        """Check a file of fabrics and send them, one after the other."""
        from ..core.cloth.fabric_file import read_fabrics

        fabrics = read_fabrics(path)
        for fabric in fabrics:
            refuse_shipped(fabric.name)
        for fabric in fabrics:
            self._ask("PUT", f"/v1/materials/{quote(fabric.name, safe='')}", json=show_fabric(fabric))
        return fabrics

    def delete_material(self, name: str) -> None:
        """Delete an imported fabric."""
        self._ask("DELETE", f"/v1/materials/{quote(name, safe='')}")

    def create_key(
        self, name: str, scopes: Sequence[str], quota: int, priority: int = 0, days: float | None = None
    ) -> tuple[Key, str]:
        """Create an API key and return it with its token, which is returned only here."""
        payload = {"name": name, "scopes": list(scopes), "quota": quota, "priority": priority, "days": days}
        found = self._ask("POST", "/v1/keys", tries=1, json=payload)
        return read(lambda: (Key.from_json(found), str(found["token"])))

    def list_keys(self) -> list[Key]:
        """Return every API key, oldest first."""
        return read_all(Key.from_json, self._ask("GET", "/v1/keys"), "keys")

    def revoke_key(self, key: str) -> Key:
        """Revoke an API key; its jobs stay."""
        found = self._ask("DELETE", f"/v1/keys/{quote(key, safe='')}")
        return read(lambda: Key.from_json(found))

    def create_share(self, job: str, days: int = DEFAULT_SHARE_DAYS) -> tuple[Share, str]:
        """Make a link to a job's result, and return it with its path."""
        found = self._ask("POST", f"/v1/jobs/{quote(job, safe='')}/shares", json={"days": days})
        return read(lambda: (Share.from_json(found), str(found["path"])))

    def list_shares(self, job: str) -> list[Share]:
        """Return the valid links to a job's result, oldest first."""
        return read_all(Share.from_json, self._ask("GET", f"/v1/jobs/{quote(job, safe='')}/shares"), "shares")

    def revoke_share(self, job: str, share: str) -> None:
        """Revoke a link to a job's result."""
        self._ask("DELETE", f"/v1/jobs/{quote(job, safe='')}/shares/{quote(share, safe='')}")

    def rotate_key(self, key: str, hours: float = 24.0) -> tuple[Key, str]:
        """Give an API key a new token, and return both; the token before stays valid for some hours."""
        found = self._ask("POST", f"/v1/keys/{quote(key, safe='')}/token", tries=1, params={"hours": hours})
        return read(lambda: (Key.from_json(found), str(found["token"])))

    def create_webhook(self, url: str, states: Sequence[State] = ()) -> tuple[Webhook, str]:
        """Create a webhook and return it with its secret, which is returned only here."""
        found = self._ask("POST", "/v1/webhooks", tries=1, json={"url": url, "states": list(states)})
        return read(lambda: (Webhook.from_json(found), str(found["secret"])))

    def rotate_secret(self, webhook: str, hours: float = 24.0) -> tuple[Webhook, str]:
        """Give a webhook a new secret, and return both; the one before signs its messages too, for some hours."""
        found = self._ask("POST", f"/v1/webhooks/{quote(webhook, safe='')}/secret", tries=1, params={"hours": hours})
        return read(lambda: (Webhook.from_json(found), str(found["secret"])))

    def list_webhooks(self) -> list[Webhook]:
        """Return the webhooks, oldest first."""
        return read_all(Webhook.from_json, self._ask("GET", "/v1/webhooks"), "webhooks")

    def delete_webhook(self, webhook: str) -> None:
        """Delete a webhook and its unsent messages."""
        self._ask("DELETE", f"/v1/webhooks/{quote(webhook, safe='')}")

    def test_webhook(self, webhook: str) -> Receipt:
        """Send a message of the type `test` as all others are sent, and return the outcome."""
        found = self._ask("POST", f"/v1/webhooks/{quote(webhook, safe='')}/test", tries=1)
        return read(lambda: Receipt.from_json(found))


def read(make: Callable[[], R]) -> R:
    """Return a record from a response.

    Raises:
        ServiceUnreachable: if the response is not that of a garmentq service.
    """
    try:
        return make()
    except (KeyError, TypeError, ValueError, AttributeError):
        raise ServiceUnreachable("the server is not a garmentq service: its response cannot be read.") from None


def read_all(make: Callable[[Json], R], found: Json, name: str) -> list[R]:
    """Return the records of a response's list."""
    return read(lambda: [make(item) for item in found[name]])
