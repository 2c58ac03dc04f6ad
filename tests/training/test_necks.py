"""Necks are drawn, draped and measured as a garment by itself and on a person."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from garmentq.core.garment.parts.cut import Front, Hood
from garmentq.core.garment.parts.draft import draft_cut
from garmentq.core.recover.grade.neck_finish import DRAPES, NECK_KINDS, STYLE_COLLARS, NeckKind, ShownSides
from garmentq.training.necks import draw_cut, gather_samples, measure_drapes


@pytest.mark.parametrize("kind", NECK_KINDS, ids=lambda kind: kind.name)
def test_what_is_drawn_is_of_its_kind(kind: NeckKind) -> None:
    """Breaks where a cut of a kind cannot be drafted, or is drawn as another kind."""
    for seed in range(6):
        cut = draw_cut(kind, np.random.default_rng(seed))
        draft_cut(cut)
        assert cut.collar in STYLE_COLLARS[kind.style] and cut.neckline is kind.neckline
        assert (cut.front is Front.OPEN) == kind.is_open
        assert (cut.hood is not Hood.NONE) == kind.style.startswith("hood")


def test_the_drapes_that_ship_are_of_every_kind_from_both_sides() -> None:
    """Breaks where a kind is compared with no drape, or a measure is missing."""
    with np.load(DRAPES) as stored:
        samples = {name: stored[name] for name in stored.files}
    assert set(samples) == {f"{kind.name}/{sides}" for kind in NECK_KINDS for sides in ShownSides}
    assert all(len(rows) >= 3 and rows.shape[1] == 9 and np.isfinite(rows).all() for rows in samples.values())


def test_a_drape_is_measured_once(tmp_path: Path) -> None:
    """Breaks where a drape is made again, or its measures get another kind's name."""
    (path,) = measure_drapes(tmp_path, range(1))
    made = path.stat().st_mtime_ns
    assert [one.stat().st_mtime_ns for one in measure_drapes(tmp_path, range(1))] == [made]
    assert set(gather_samples(tmp_path)) == {f"{NECK_KINDS[0].name}/{sides}" for sides in ShownSides}
