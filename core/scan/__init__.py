"""From an untrusted file to a checked `Scan`."""

from .scan import Scan

__all__ = ["Scan"]
