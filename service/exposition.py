"""Metrics in the Prometheus text format (version 0.0.4)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

Labelled = tuple[Mapping[str, str], float]

PREFIX = "garmentq_"
"""Beginning of the name of every metric."""


def format_family(name: str, kind: str, help_text: str, values: Iterable[Labelled]) -> str:
    """Return one metric with all its labelled values."""
    return "\n".join([*_head(name, kind, help_text), *(_line(name, labels, value) for labels, value in values)]) + "\n"


def format_histogram(
    name: str, help_text: str, bounds: Sequence[float], values: Iterable[tuple[Mapping[str, str], Sequence[int], float]]
) -> str:
    """Return one histogram.

    Args:
        name: Its name.
        help_text: What it counts.
        bounds: Upper bounds of all buckets but the last, which has none, in rising order.
        values: For each set of labels the number of observations in each bucket, and the sum of the observations.
    """
    lines = _head(name, "histogram", help_text)
    for labels, counts, total in values:
        below = 0
        for bound, count in zip([*map(str, bounds), "+Inf"], counts, strict=True):
            below += count
            lines.append(_line(f"{name}_bucket", {**labels, "le": bound}, below))
        lines += [_line(f"{name}_sum", labels, total), _line(f"{name}_count", labels, below)]
    return "\n".join(lines) + "\n"


def _head(name: str, kind: str, help_text: str) -> list[str]:
    return [f"# HELP {PREFIX}{name} {help_text}", f"# TYPE {PREFIX}{name} {kind}"]


def _line(name: str, labels: Mapping[str, str], value: float) -> str:
    inside = ",".join(f'{key}="{_escape(text)}"' for key, text in labels.items())
    return f"{PREFIX}{name}{{{inside}}} {float(value)!r}" if inside else f"{PREFIX}{name} {float(value)!r}"


def _escape(text: str) -> str:
    return text.replace("\\", r"\\").replace("\n", r"\n").replace('"', r"\"")
