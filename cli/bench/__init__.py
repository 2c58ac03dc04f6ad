"""Recover target packs in a folder, and compare the results with the truth."""

from .run import command

__all__ = ["command"]
