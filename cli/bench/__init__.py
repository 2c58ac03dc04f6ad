"""Recover target packs in a folder, and compare with the truth."""

from .run import command

__all__ = ["command"]
