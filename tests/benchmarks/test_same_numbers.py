"""Numbers of two trees are compared bit by bit."""

from __future__ import annotations

import subprocess
import sys

from changed_tree import ROOT, make_environment
from same_numbers import list_differences


def test_the_last_bit_counts_and_so_does_a_name_that_is_gone():
    """Broken where a change of rounding, or a number that is measured no more, passes for none."""
    before = {"a_cm": 0.1 + 0.2, "cut": "skirt", "gone": 1.0}
    assert list(list_differences(before, dict(before))) == []
    now = {"a_cm": 0.3, "cut": "skirt", "new": 2.0}
    assert list(list_differences(before, now)) == [
        "a_cm: 0.30000000000000004 -> 0.3", "gone: only before", "new: only now",
    ]  # fmt: skip


def test_the_scenes_run_outside_pytest():
    """Broken where the scenes import something that only pytest's own search path has."""
    line = [sys.executable, str(ROOT / "tests" / "golden" / "accept.py"), "--help"]
    ran = subprocess.run(line, env=make_environment(ROOT), capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr
