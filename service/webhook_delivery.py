"""Send one message to a webhook: signed, to an address that was checked, without redirects, within 5 s in all."""

from __future__ import annotations

import asyncio
import base64
import hashlib
import hmac
import json
import logging
import ssl
import time
from functools import cache
from urllib.parse import SplitResult

import httpx

from .. import __version__
from .webhook_address import PORTS, Address, WebhookBad, check_url, read_networks, resolve
from .webhook_records import Receipt
from .webhooks import Message

log = logging.getLogger(__name__)

UNREACHABLE_MESSAGE = "the host has no public address, does not respond, or its certificate is not trusted"
"""Fixed text for every undelivered message: its sender must not learn the names of an inner network."""

WEBHOOK_DELIVERY_TIMEOUT = 5.0
"""Time limit of one message [s], from the look-up of its address to the head of the response."""


def sign(secret: str, mark: str, at: int, body: bytes) -> str:
    """Return the signature of a message by Standard Webhooks 1.0.0: HMAC-SHA256 of `ID.TIME.BODY`.

    Args:
        secret: `whsec_` and the key in base64.
        mark: The message's id.
        at: When it is sent [s since 1970].
        body: The content.

    Returns:
        `v1,` and the digest in base64.
    """
    key = base64.b64decode(secret.removeprefix("whsec_"))
    digest = hmac.new(key, b"%s.%d.%s" % (mark.encode(), at, body), hashlib.sha256).digest()
    return "v1," + base64.b64encode(digest).decode()


async def send(message: Message, networks: str, context: ssl.SSLContext | None = None) -> Receipt:
    """Send a message; a failure is returned as a fixed text, never raised.

    Args:
        message: The message.
        networks: Networks that are allowed beyond the public ones.
        context: Trusted certificates; by default the system's authorities.
    """
    try:
        async with asyncio.timeout(WEBHOOK_DELIVERY_TIMEOUT):
            status = await _post(message, networks, context or _make_tls_context())
    except TimeoutError:
        return Receipt(None, f"no response within {WEBHOOK_DELIVERY_TIMEOUT:g} s")
    except (httpx.HTTPError, httpx.InvalidURL, OSError, UnicodeError, WebhookBad) as error:
        log.info("message %s was not sent: %s: %s", message.id, type(error).__name__, error)
        return Receipt(None, UNREACHABLE_MESSAGE)
    return Receipt(status, None if 200 <= status < 300 else f"the response was {status}, not 2xx")


async def _post(message: Message, networks: str, context: ssl.SSLContext) -> int:
    """Return the status of the response; nothing else of it is read."""
    url, at = check_url(message.url, networks), int(time.time())
    assert url.hostname is not None
    port = url.port or PORTS[url.scheme]
    addresses = await resolve(url.hostname, port, url.scheme, read_networks(networks))
    body = json.dumps(message.body, separators=(",", ":"), allow_nan=False).encode()
    valid = [one for one in (message.secret, message.earlier_secret) if one is not None]
    headers = {
        "host": url.netloc,
        "content-type": "application/json",
        "user-agent": f"garmentq/{__version__}",
        "webhook-id": message.id,
        "webhook-timestamp": str(at),
        "webhook-signature": " ".join(sign(one, message.id, at, body) for one in valid),
    }
    async with httpx.AsyncClient(
        verify=context, trust_env=False, follow_redirects=False, timeout=WEBHOOK_DELIVERY_TIMEOUT
    ) as client:
        for index, address in enumerate(addresses):
            try:
                request = client.build_request(
                    "POST", _pin_address(url, address, port), content=body, headers=headers,
                    extensions={"sni_hostname": url.hostname},
                )  # fmt: skip
                answer = await client.send(request, stream=True)
            except httpx.ConnectError:
                if index + 1 == len(addresses):
                    raise
                continue
            try:
                return answer.status_code
            finally:
                await answer.aclose()
    raise AssertionError("a host without an address was refused before")


def _pin_address(url: SplitResult, address: Address, port: int) -> str:
    """Return the URL of a request with the host's resolved address in place of its name."""
    host = f"[{address}]" if address.version == 6 else str(address)
    query = f"?{url.query}" if url.query else ""
    return f"{url.scheme}://{host}:{port}{url.path or '/'}{query}"


@cache
def _make_tls_context() -> ssl.SSLContext:
    return ssl.create_default_context()
