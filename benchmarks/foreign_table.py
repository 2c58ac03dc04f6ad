"""Compare what was recovered from the packs of `foreign_drapes.py` with what was drafted, and print the table.

    garmentq bench PACKS --library --json --out RESULTS > LINES.jsonl
    python benchmarks/foreign_table.py DRAFTS... --packs PACKS --results RESULTS --lines LINES.jsonl

Judged are the category, the parts that a design names (a draft of our own names all of them; darts are left out), the
seam at the waist of a dress or a jumpsuit, and the verdict of all that the bench measures. Panels at least 12 cm wide
are compared one by one where both patterns have as many of them at each place around the wearer, and as many bands.

GarmentCode cuts tops in halves with a straight seam in the middle in front and behind, our parts have none there. It
shapes nothing, so halves are joined there before panels are compared. Darts are cut out of a panel's area, its outline
runs across their mouths.
"""

from __future__ import annotations

import argparse
import json
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from foreign_panels import Piece, compare_pieces, join_halves
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.garment.parts.cut import PARTS, Cut
from garmentq.core.garment.templates import find_cut
from garmentq.core.judge.gates import evaluate_gates
from garmentq.core.run.verdict import Verdict, worst_verdict

ALIKE = ({"crew", "scoop"}, {"cap", "short", "elbow"})
"""Words for one part in several lengths or depths, which grading turns into each other."""


@dataclass(frozen=True)
class Row:
    """Describe one recovery beside its truth.

    Attributes:
        name: Of the draft.
        crossing: Faces of the drape that cross others.
        true: The parts that are judged.
        found: The cut that was recovered, by its name.
        is_category: Whether the category is right.
        wrong: The wrong parts, `part: true as found`.
        area: Mean error of the areas of panels; None where they do not correspond.
        outline: Mean distance of their outlines [mm]; None likewise.
        total: How much larger all panels together are, bands too.
        verdict: The worst of the gates.
        why: The gates that do not pass, with what they measured.
        distances: From the scan to the detail mesh and back, RMS [mm].
    """

    name: str
    crossing: int
    true: str
    found: str
    is_category: bool
    wrong: tuple[str, ...]
    area: float | None
    outline: float | None
    total: float
    verdict: Verdict
    why: str
    distances: tuple[float, float]


@dataclass(frozen=True)
class Folders:
    """Name the folders of drafts, of their drapes and of what was recovered from these."""

    drafts: tuple[Path, ...]
    packs: Path
    results: Path


def list_true_parts(design: dict[str, Any]) -> dict[str, str]:
    """Return what a draft's cut is to be, by part."""
    if "cut" in design:
        cut = find_cut(design["cut"])
        return {part: str(getattr(cut, part)) for part in PARTS if cut.has_place_for(part) and part != "shaping"}
    named = {part: word for part, word in design["parts"].items() if part != "darts"}
    return named | ({"waist": "seam"} if design["category"] in ("dress", "jumpsuit") else {})


def list_wrong_parts(design: dict[str, Any], found: Cut) -> tuple[str, ...]:
    """Return the parts that are not right, each as `part: true as found`."""
    wrong = []
    for part, word in list_true_parts(design).items():
        own = str(getattr(found, part))
        if own != word and not any({own, word} <= words for words in ALIKE):
            wrong.append(f"{part}: {word} as {own}")
    return tuple(wrong)


def read_row(line: dict[str, Any], folders: Folders) -> Row:
    """Compare one line of the bench with its draft."""
    name = line["target"]
    folder = next(path / name for path in folders.drafts if (path / name).is_dir())
    told = json.loads((folders.packs / name / "meta.json").read_text())
    design = json.loads((folder / "design.json").read_text())
    truth = join_halves(load_pattern(folder / "specification.json"))
    ours = join_halves(load_pattern(folders.results / name / "pattern.json"))
    pairs = compare_pieces(ours, truth)
    metrics = line["metrics"]
    gates = evaluate_gates(metrics)
    why = ", ".join(f"{gate.name} {gate.value:.3g}" for gate in gates if gate.verdict is not Verdict.PASS)
    return Row(
        name=name,
        crossing=told["self_intersecting_faces"],
        true=f"`{design['cut']}`" if "cut" in design else ", ".join(list_true_parts(design).values()),
        found=line["cut"],
        is_category=line["category"] == design["category"],
        wrong=list_wrong_parts(design, find_cut(line["cut"])),
        area=float(np.mean([abs(pair.area) for pair in pairs])) if pairs else None,
        outline=1e3 * float(np.mean([pair.outline for pair in pairs])) if pairs else None,
        total=_sum_areas(ours) / _sum_areas(truth) - 1.0,
        verdict=worst_verdict(gate.verdict for gate in gates),
        why=why,
        distances=(metrics["surface_rms_mm.s2t"], metrics["surface_rms_mm.t2s"]),
    )


def _sum_areas(pieces: Iterable[Piece]) -> float:
    return sum(piece.area for piece in pieces)


def print_rows(rows: list[Row]) -> None:
    """Print a row for each recovery, and the totals."""
    columns = ("draft", "crossing", "true", "found", "wrong", "area", "all", "outline", "s2t / t2s", "verdict")
    print(f"| {' | '.join(columns)} |")
    print(f"|{'---|' * len(columns)}")
    for row in rows:
        area = "" if row.area is None else f"{100.0 * row.area:.1f} %"
        outline = "" if row.outline is None else f"{row.outline:.1f}"
        wrong = "; ".join((*(() if row.is_category else ("category",)), *row.wrong))
        verdict = f"{row.verdict}: {row.why}" if row.why else str(row.verdict)
        distances = " / ".join(f"{distance:.2f}" for distance in row.distances)
        cells = (
            row.name, str(row.crossing), row.true, f"`{row.found}`", wrong, area,
            f"{100.0 * row.total:+.1f} %", outline, distances, verdict,
        )  # fmt: skip
        print(f"| {' | '.join(cells)} |")
    for title, some in (("all", rows), ("own", [row for row in rows if row.name.startswith("own")])):
        _print_totals(title, some)
    _print_totals("GarmentCode", [row for row in rows if not row.name.startswith("own")])


def _print_totals(title: str, rows: list[Row]) -> None:
    right = [row for row in rows if row.is_category and not row.wrong]
    verdicts: dict[bool, dict[str, int]] = {True: defaultdict(int), False: defaultdict(int)}
    for row in rows:
        verdicts[row in right][str(row.verdict)] += 1
    areas = [row.area for row in right if row.area is not None]
    outlines = [row.outline for row in right if row.outline is not None]
    print(
        f"{title}: {len(rows)}; category {sum(row.is_category for row in rows)}, parts {len(right)}; "
        f"of the right ones' panels ({len(areas)}) area {100.0 * np.mean(areas or [np.nan]):.1f} %, "
        f"outline {np.mean(outlines or [np.nan]):.1f} mm; right {dict(verdicts[True])}, wrong {dict(verdicts[False])}"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("drafts", type=Path, nargs="+", help="folders of drafts")
    parser.add_argument("--packs", type=Path, required=True)
    parser.add_argument("--results", type=Path, required=True)
    parser.add_argument("--lines", type=Path, required=True)
    given = parser.parse_args()
    lines = [json.loads(line) for line in given.lines.read_text().splitlines()]
    folders = Folders(tuple(given.drafts), given.packs, given.results)
    print_rows([read_row(line, folders) for line in lines if line["ok"]])
    for line in lines:
        if not line["ok"]:
            print(f"{line['target']}: {line['error']}")


if __name__ == "__main__":
    main()
