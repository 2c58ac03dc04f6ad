"""The golden file: what each scene measured when its numbers were last accepted, how far each may be off, and why."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from golden_numbers import Measured

RECORD = Path(__file__).parent / "golden.json"

SPREADS = 5.0
"""Largest deviations of the scatter's runs that a number may be off: where a number scatters normally, one run in a
thousand is farther off than five times the largest of four."""

LEAST_SHARE = 0.002
"""Of a value that it may be off however little it scattered: sums in another order, on another processor."""

LEAST = {"mm": 0.02, "cm": 0.02, "cm2": 0.5, "error": 0.001, "bending": 0.02, "m2": 0.01}
"""What a number may be off at least by the last word of its name, in its unit: a hundredth of what matters of it."""


@dataclass(frozen=True)
class Deviation:
    """Describe a number or a word of a scene that is not what was accepted."""

    scene: str
    name: str
    accepted: float | str | None
    found: float | str | None
    tolerance: float = 0.0

    def __str__(self) -> str:
        """Return it as a line."""
        if isinstance(self.accepted, float) and isinstance(self.found, float):
            return f"{self.scene}: {self.name} {self.found:.6g}, accepted {self.accepted:.6g} +- {self.tolerance:.3g}"
        return f"{self.scene}: {self.name} {self.found!r}, accepted {self.accepted!r}"


def load_record(path: Path = RECORD) -> dict[str, Any]:
    """Return the golden file; empty where there is none yet."""
    if not path.exists():
        return {"scenes": {}, "history": []}
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def describe_scatter(runs: Sequence[Measured]) -> dict[str, Any]:
    """Return a scene's entry: the first run's numbers, each with what it may be off; words that all runs share.

    Args:
        runs: The scene as it is, then with its input moved.
    """
    first, others = runs[0], runs[1:]
    numbers = {}
    for name, value in sorted(first.numbers.items()):
        found = [run.numbers[name] for run in others if name in run.numbers]
        if len(found) == len(others):
            numbers[name] = {"value": value, "tolerance": _tolerate(name, value, found)}
    words = {n: w for n, w in sorted(first.words.items()) if all(run.words.get(n) == w for run in others)}
    return {"numbers": numbers, "words": words}


def _tolerate(name: str, value: float, others: Iterable[float]) -> float:
    spread = max((abs(other - value) for other in others), default=0.0)
    least = LEAST.get(name.replace(".", "_").split("_")[-1], 0.0)
    return float(np.float32(max(SPREADS * spread, LEAST_SHARE * abs(value), least)))


def widen(record: dict[str, Any], scene: str, found: Measured, reason: str) -> list[str]:
    """Let a scene's numbers be off as far as another machine's are, and return the lines of what changed.

    The accepted values stay; the run counts as one more of the scatter. Words that differ are compared no more.

    Args:
        record: The golden file.
        scene: The scene.
        found: What the other machine measures.
        reason: Kept beside the changes.
    """
    entry, changes = record["scenes"][scene], {}
    for one in compare(scene, entry, found):
        if isinstance(one.accepted, float) and isinstance(one.found, float):
            tolerance = _tolerate(one.name, one.accepted, (one.found,))
            changes[f"{one.name}: tolerance"] = [one.tolerance, tolerance]
            entry["numbers"][one.name]["tolerance"] = tolerance
        elif isinstance(one.accepted, str):
            changes[f"{one.name}: no longer compared"] = [one.accepted, one.found]
            del entry["words"][one.name]
    if changes:
        record["history"].append({"scene": scene, "reason": reason, "changes": changes})
    return [f"{scene}: {name} {old} -> {new}" for name, (old, new) in changes.items()]


def compare(scene: str, entry: Mapping[str, Any], found: Measured) -> list[Deviation]:
    """Return what a run has beyond what its scene's entry allows; a name that is missing counts."""
    wrong: list[Deviation] = []
    for name, kept in entry["numbers"].items():
        value = found.numbers.get(name)
        if value is None or not abs(value - kept["value"]) <= kept["tolerance"]:
            wrong.append(Deviation(scene, name, kept["value"], value, kept["tolerance"]))
    for name, word in entry["words"].items():
        if found.words.get(name) != word:
            wrong.append(Deviation(scene, name, word, found.words.get(name)))
    return wrong


def accept(record: dict[str, Any], scene: str, entry: dict[str, Any], reason: str) -> list[str]:
    """Put a scene's new entry into the record with the reason, and return the lines of what changed."""
    old = record["scenes"].get(scene, {"numbers": {}, "words": {}})
    before = {name: kept["value"] for name, kept in old["numbers"].items()} | old["words"]
    now = {name: kept["value"] for name, kept in entry["numbers"].items()} | entry["words"]
    changes = {n: [before.get(n), now.get(n)] for n in sorted({*before, *now}) if before.get(n) != now.get(n)}
    record["scenes"][scene] = entry
    if changes:
        record["history"].append({"scene": scene, "reason": reason, "changes": changes if old["numbers"] else "new"})
    return [f"{scene}: {name} {old} -> {new}" for name, (old, new) in changes.items()]


def save_record(record: Mapping[str, Any], path: Path = RECORD) -> None:
    """Write the golden file."""
    path.write_text(json.dumps(record, indent=1, sort_keys=True) + "\n")
