"""Errors of production pieces and their settings, one stable code each."""

from __future__ import annotations

from ...run.errors import BadInput


class AllowanceBad(BadInput):
    """Seam allowances are given as none, 15mm, 5/8in, or EDGE=WIDTH with commas between: seam=10,hem=1in."""

    code = "pieces.allowance"


class PieceBad(BadInput):
    """A piece cannot be cut with these allowances; make them smaller, or mend the panel's outline."""

    code = "pieces.outline"
