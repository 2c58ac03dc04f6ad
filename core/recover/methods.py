"""List the steps of each recovery method, in order."""

from __future__ import annotations

from collections.abc import Mapping

from .steps import Descend, FitShape, Step, complete, drape, drape_anew, dress, grade, register

GRADING_STEPS: tuple[Step, ...] = (complete, dress, grade, drape)
"""The steps up to the graded pattern's drape, which all methods share."""

METHODS: Mapping[str, tuple[Step, ...]] = {
    "deform": (*GRADING_STEPS, register),
    "inverse": (*GRADING_STEPS, Descend(), register, drape_anew),
    "hybrid": (*GRADING_STEPS, register, FitShape(), drape_anew),
}
"""Steps by the names of `RecoverySettings.method`: `deform` keeps the graded pattern, `inverse` descends through the
simulator as the thesis does, `hybrid` refits the registered garment by isometry and through the simulator."""

STEP_CHECKPOINTS: Mapping[Step, str] = {drape: "drape"}
"""Names of the checkpoints that are saved after steps; an interrupted run resumes from them."""
