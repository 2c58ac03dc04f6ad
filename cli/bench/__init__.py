"""Recover target packs in a folder, and compare the results with the truth."""

from .run import command as command
