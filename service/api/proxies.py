"""Client address and scheme from the headers of trusted proxies."""

from __future__ import annotations

import ipaddress
import os
from collections.abc import Awaitable, Callable, Mapping, MutableMapping, Sequence
from typing import Any

from ..settings import ServiceSettingBad

DEFAULT_PROXIES = "127.0.0.1,::1"
"""Proxies that are trusted by default: those on this machine."""

NONE = "none"
"""Value of the setting by which no proxy is trusted."""

Network = ipaddress.IPv4Network | ipaddress.IPv6Network
Message = MutableMapping[str, Any]


class ProxyHeaders:
    """Replace the address and scheme of a trusted proxy by those of its client; ignore the headers of others.

    Only the last entry of `X-Forwarded-For` is used, which the proxy itself added, and only if it is an address:
    earlier entries come from outside. Without one the client is the proxy.
    """

    def __init__(self, app: Callable[..., Awaitable[None]], proxies: Sequence[Network]) -> None:
        """Wrap an ASGI application.

        Args:
            app: The application.
            proxies: Networks of the proxies that are trusted.
        """
        self.app = app
        self.proxies = proxies

    async def __call__(self, scope: Message, receive: Any, send: Any) -> None:
        """Handle one request."""
        peer = read_address(scope["client"][0]) if scope.get("client") else None
        if scope["type"] == "http" and peer is not None:
            scope["client"] = (peer, scope["client"][1])
            if any(ipaddress.ip_address(peer) in network for network in self.proxies):
                _apply_forwarded_headers(scope)
        await self.app(scope, receive, send)


def _apply_forwarded_headers(scope: Message) -> None:
    """Set client and scheme from a proxy's headers."""
    values = {
        header_name: [value.decode("latin-1") for name, value in scope["headers"] if name == header_name]
        for header_name in (b"x-forwarded-for", b"x-forwarded-proto")
    }
    client = read_address(",".join(values[b"x-forwarded-for"]).rpartition(",")[2].strip())
    if client is not None:
        scope["client"] = (client, 0)
    scheme = ",".join(values[b"x-forwarded-proto"]).rpartition(",")[2].strip()
    if scheme in ("http", "https"):
        scope["scheme"] = scheme


def read_address(text: str) -> str | None:
    """Return an IP address in canonical form, with an IPv4 address mapped into IPv6 as IPv4; None if it is not one."""
    try:
        address = ipaddress.ip_address(text)
    except ValueError:
        return None
    if isinstance(address, ipaddress.IPv6Address):
        if address.scope_id is not None:  # it may contain any text
            address = ipaddress.IPv6Address(int(address))
        return str(address.ipv4_mapped or address)
    return str(address)


def read_proxies(environment: Mapping[str, str] | None = None) -> list[Network]:
    """Return the networks of GARMENTQ_API_PROXIES, separated by commas; `none` trusts no proxy.

    Raises:
        ServiceSettingBad: if one is invalid.
    """
    environment = os.environ if environment is None else environment
    text = environment.get("GARMENTQ_API_PROXIES", "").strip() or DEFAULT_PROXIES
    try:
        return [ipaddress.ip_network(one.strip()) for one in text.split(",") if text != NONE and one.strip()]
    except ValueError as error:
        raise ServiceSettingBad(
            f"GARMENTQ_API_PROXIES: {error}; write 10.1.0.7 or 10.1.0.0/16, separated by commas, or {NONE}."
        ) from None
