"""The methods of recovery: the steps that each takes, in their order."""

from __future__ import annotations

from collections.abc import Mapping

from .steps import Descend, FitShape, Step, complete, drape, drape_anew, dress, grade, register

GRADING_STEPS: tuple[Step, ...] = (complete, dress, grade, drape)
"""The steps up to the graded pattern's drape, from which every method goes on."""

METHODS: Mapping[str, tuple[Step, ...]] = {
    "deform": (*GRADING_STEPS, register),
    "inverse": (*GRADING_STEPS, Descend(), register, drape_anew),
    "hybrid": (*GRADING_STEPS, register, FitShape(), drape_anew),
}
"""The steps by the names that `RecoverySettings.method` has: `deform` keeps the graded pattern, `inverse` descends
through the simulator as the thesis does, `hybrid` refits the registered garment, by isometry and through the simulator.
"""

STEP_CHECKPOINTS: Mapping[Step, str] = {drape: "drape"}
"""Names of the checkpoints that are kept after steps, from which a killed run goes on."""
