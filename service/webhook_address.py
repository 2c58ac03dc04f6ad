"""Addresses that a webhook may reach: the public internet, and networks that the operator allows."""

from __future__ import annotations

import asyncio
import ipaddress
import re
import socket
from collections.abc import Sequence
from urllib.parse import SplitResult, urlsplit

from ..core.run.errors import BadInput
from .settings import ServiceSettingBad

Address = ipaddress.IPv4Address | ipaddress.IPv6Address
Network = ipaddress.IPv4Network | ipaddress.IPv6Network

MAX_WEBHOOK_URL_LENGTH = 2000
"""Longest address [characters], about the limit of proxies."""
PORTS = {"https": 443, "http": 80}

TUNNEL_NETWORKS = tuple(ipaddress.ip_network(text) for text in ("2001::/32", "2002::/16", "192.88.99.0/24"))
"""Teredo and 6to4: public addresses that may lead to any IPv4 address."""

UNICAST = ipaddress.ip_network("2000::/3")
"""The part of IPv6 that is assigned to the internet; NAT64 and mapped addresses are outside."""


class WebhookBad(BadInput):
    """A webhook is https://HOST/PATH of the public internet, without user, password or fragment."""

    code = "webhook.bad"


class AddressForbidden(WebhookBad):
    """The webhook's host has an address that is not public; GARMENTQ_WEBHOOK_NETWORKS allows further networks."""

    code = "webhook.address_forbidden"


def check_url(url: str, networks: str) -> SplitResult:
    """Return the parts of a webhook's address.

    Args:
        url: The address.
        networks: Networks that are allowed beyond the public ones, separated by commas.

    Raises:
        WebhookBad: if it cannot be one.
        AddressForbidden: if its host is an address that is not allowed.
    """
    allowed = read_networks(networks)
    if len(url) > MAX_WEBHOOK_URL_LENGTH or not re.fullmatch(r"[!-~]+", url):
        raise WebhookBad(f"a webhook has at most {MAX_WEBHOOK_URL_LENGTH} printable ASCII characters.")
    try:
        parts = urlsplit(url)
        host, port = parts.hostname, parts.port
    except ValueError:
        raise WebhookBad() from None
    if not host or parts.scheme not in PORTS or port == 0 or "@" in parts.netloc or parts.fragment:
        raise WebhookBad()
    if parts.scheme == "http" and not allowed:
        raise WebhookBad("a webhook is https; http is for networks that GARMENTQ_WEBHOOK_NETWORKS names.")
    address = _read_address(host)
    if address is not None and not is_allowed(address, parts.scheme, allowed):
        raise AddressForbidden()
    return parts


def read_networks(text: str) -> list[Network]:
    """Return the networks of GARMENTQ_WEBHOOK_NETWORKS.

    Raises:
        ServiceSettingBad: if one is invalid.
    """
    try:
        return [ipaddress.ip_network(one.strip()) for one in text.split(",") if one.strip()]
    except ValueError as error:
        raise ServiceSettingBad(f"GARMENTQ_WEBHOOK_NETWORKS: {error}; write 10.1.0.0/16, with commas.") from None


def is_allowed(address: Address, scheme: str, networks: Sequence[Network]) -> bool:
    """Return whether a message may be sent to an address: a public one by https, or one of the allowed networks."""
    if any(address in network for network in networks if network.version == address.version):
        return True
    return scheme == "https" and is_public(address)


def is_public(address: Address) -> bool:
    """Return whether an address is on the public internet.

    Not public are loopback, private, shared (100.64/10), link-local, unique-local, multicast, reserved, documentation
    and unspecified addresses, and IPv6 addresses that stand for an IPv4 address.
    """
    if address.version == 6 and address not in UNICAST:
        return False
    is_carrier = any(address in network for network in TUNNEL_NETWORKS if network.version == address.version)
    return address.is_global and not (address.is_multicast or address.is_reserved or is_carrier)


async def resolve(host: str, port: int, scheme: str, networks: Sequence[Network]) -> list[Address]:
    """Resolve a host once; the sender connects to the returned addresses and does not resolve again.

    Raises:
        OSError: if the name has no address.
        AddressForbidden: if one of the addresses is not allowed; a host with a public and a private one is an attack.
    """
    found = await asyncio.get_running_loop().getaddrinfo(host, port, type=socket.SOCK_STREAM)
    addresses = [ipaddress.ip_address(str(one[4][0]).partition("%")[0]) for one in found]
    if not addresses:
        raise OSError("no address")
    if not all(is_allowed(address, scheme, networks) for address in addresses):
        raise AddressForbidden()
    return list(dict.fromkeys(addresses))


def _read_address(host: str) -> Address | None:
    try:
        return ipaddress.ip_address(host)
    except ValueError:
        return None
