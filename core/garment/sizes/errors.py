"""Errors of grading, with one stable code each."""

from __future__ import annotations

from ...run.errors import BadInput


class CapUnfit(BadInput):
    """No sleeve fits both arm and armhole of a size; give its upper_arm and armhole_depth, or leave both out."""

    code = "sizes.cap"
