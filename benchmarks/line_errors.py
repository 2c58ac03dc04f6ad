"""Measure how far recovered seams and edges lie from those of garments whose patterns are known, calibrate intervals on
some of them, and test these on others.

    python benchmarks/line_errors.py KNOWN --calibrate 30 [--write core/judge/line_errors.npz]

KNOWN is a folder of `known_patterns.py`. The first garments calibrate, the others test: for each kind of line the share
within its interval, and whether that is consistent with 90 % (binomial, 95 %).
"""

from __future__ import annotations

import argparse
import pickle
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from garmentq.core.garment.contour_edges import name_open_edges
from garmentq.core.garment.pieces.pattern_lines import PatternLine, list_lines
from garmentq.core.judge.line_intervals import INTERVAL_COVERAGE, Evidence, find_margins, fit_margins, has_sure_lines
from garmentq.core.judge.seen import find_seen_faces
from garmentq.core.recover.line_evidence import find_line_evidence
from scipy.spatial import cKDTree
from scipy.stats import binom

CONSISTENT = 0.95
"""Share of the binomial distribution within which a number of lines is consistent with the coverage."""


@dataclass(frozen=True)
class KnownLine:
    """Describe a recovered line whose truth is known.

    Attributes:
        garment: Number of the garment.
        maker: Who drafted it.
        line: The recovered line.
        evidence: What decides where it is.
        place: RMS distance of the true line from it [m].
        ratio: Logarithm of its length over the true one.
    """

    garment: int
    maker: str
    line: PatternLine
    evidence: Evidence
    place: float
    ratio: float


def read_lines(folder: Path) -> Iterator[KnownLine]:
    """Yield the lines of a garment that both its pattern and the recovered one have; left and right count once. A
    result that fails has none."""
    with (folder / "recovered.pkl").open("rb") as file:
        stored = pickle.load(file)
    known, found = stored["known"], stored["found"]
    if not has_sure_lines(found.report.gates):
        return
    pattern = name_open_edges(known)
    true = {(line.name, line.side): line for line in list_lines(pattern)}
    seen = find_seen_faces(found.garment, found.scan.surface)
    lines: dict[tuple[str, Evidence], list[KnownLine]] = {}
    for line, evidence in find_line_evidence(found.garment, found.target, found.body, seen):
        same = true.get((line.name, line.side))
        if same is not None:
            off = cKDTree(line.sample(found.garment)).query(same.sample(known))[0]
            ratio = np.log(line.measure_length(found.pattern) / same.measure_length(pattern))
            one = KnownLine(int(folder.name), stored["maker"], line, evidence, float(np.sqrt((off**2).mean())), ratio)
            lines.setdefault((line.name, evidence), []).append(one)
    for both in lines.values():
        place = float(np.sqrt(np.mean([one.place**2 for one in both])))
        first = both[0]
        ratio = float(np.mean([one.ratio for one in both]))
        yield KnownLine(first.garment, first.maker, first.line, first.evidence, place, ratio)


def is_consistent(inside: int, count: int) -> bool:
    """Check whether a number of lines within their intervals is consistent with the coverage."""
    low, high = binom.interval(CONSISTENT, count, INTERVAL_COVERAGE)
    return bool(low <= inside <= high)


def tabulate(tested: list[KnownLine], known: list[KnownLine]) -> list[str]:
    """Return a table of the tested lines by kind and evidence, in intervals of known ones."""
    errors = group(known)
    rows = [
        "| line | evidence | lines | place within | +- mm | error mm | length within | +- % | error % | consistent |"
    ]
    rows.append("|---|---|---|---|---|---|---|---|---|---|")
    kinds = sorted({(one.line.name, one.evidence) for one in tested})
    for name, evidence in [*kinds, ("", None)]:
        own = [one for one in tested if evidence is None or (one.line.name, one.evidence) == (name, evidence)]
        inside, margins = [], []
        for one in own:
            found = find_margins(one.line.name, one.evidence, errors)
            if found is None:
                continue
            inside.append((one.place <= found.place, abs(one.ratio) <= found.length))
            margins.append((1e3 * found.place, 100.0 * np.expm1(found.length)))
        if not inside:
            continue
        hits, count = np.array(inside).sum(axis=0), len(inside)
        wide = np.median(margins, axis=0)
        off = np.median([(1e3 * one.place, 100.0 * np.expm1(abs(one.ratio))) for one in own], axis=0)
        fits = " and ".join("yes" if is_consistent(int(hit), count) else "no" for hit in hits)
        rows.append(
            f"| {name or 'all'} | {evidence or ''} | {count} | {hits[0] / count:.2f} | {wide[0]:.0f} | {off[0]:.1f} | "
            f"{hits[1] / count:.2f} | {wide[1]:.1f} | {off[1]:.1f} | {fits} |"
        )
    return rows


def group(known: list[KnownLine]) -> dict:
    """Return the margins that known lines give by kind and evidence."""
    kinds = [(one.line.name, one.evidence) for one in known]
    places, lengths = np.array([one.place for one in known]), np.array([abs(one.ratio) for one in known])
    return fit_margins(kinds, places, lengths)


def main() -> None:
    """Print the table, and write the errors."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("known", type=Path)
    parser.add_argument("--calibrate", type=int, required=True, help="number of garments; the others test")
    parser.add_argument("--write", type=Path, help="file of the errors of those that calibrate")
    given = parser.parse_args()
    folders = sorted(path.parent for path in given.known.glob("*/recovered.pkl"))
    lines = [list(read_lines(folder)) for folder in folders]
    known = [line for own in lines[: given.calibrate] for line in own]
    tested = [line for own in lines[given.calibrate :] for line in own]
    print(f"{len(folders)} garments, {given.calibrate} calibrate; {len(known)} and {len(tested)} lines\n")
    print("\n".join(tabulate(tested or known, known)))
    if given.write:
        np.savez_compressed(
            given.write,
            name=np.array([one.line.name for one in known]),
            evidence=np.array([str(one.evidence) for one in known]),
            place=np.array([one.place for one in known], np.float32),
            length=np.array([abs(one.ratio) for one in known], np.float32),
        )


if __name__ == "__main__":
    main()
