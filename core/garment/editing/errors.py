"""Errors of operations on a pattern."""

from __future__ import annotations

from ..errors import PatternFault


class EditBad(PatternFault):
    """The operation cannot be done on this pattern; see docs/reference/http.md for what each one takes."""

    code = "pattern.edit_bad"
