"""The boosted baseline: gradient-boosted trees on each sample's features alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from .describe import Described
from .judge import NUMBERS

SAMPLES = 1500
"""Samples of a scan that are trained on: neighbours are so alike that more of them add time alone."""
FILE = "boosted.joblib"
"""Name of the trees' file."""
TREES = 100
"""Trees for each part."""


def train_boosted(scans: list[Described], seed: int = 0) -> Any:
    """Train trees on drawn samples of scans; needs the extra `training`."""
    from sklearn.ensemble import HistGradientBoostingClassifier

    rng = np.random.default_rng(seed)
    drawn = [rng.choice(len(scan.label), min(SAMPLES, len(scan.label)), replace=False) for scan in scans]
    values = np.concatenate([scan.inputs[take] for scan, take in zip(scans, drawn, strict=True)])
    labels = np.concatenate([scan.label[take] for scan, take in zip(scans, drawn, strict=True)])
    trees = HistGradientBoostingClassifier(
        learning_rate=0.12, max_iter=TREES, max_leaf_nodes=24, min_samples_leaf=60, l2_regularization=1.0,
        early_stopping=False, random_state=seed,
    )  # fmt: skip
    return trees.fit(values, labels)


def predict_boosted(trees: Any, scan: Described) -> np.ndarray:
    """Return logarithms of the probabilities of all samples, shape [n, 8], in the order of `PARTS`."""
    found = np.log(np.maximum(trees.predict_proba(scan.inputs), 1e-6))
    out = np.full((len(found), len(NUMBERS)), np.log(1e-6))
    out[:, [int(np.flatnonzero(NUMBERS == number)[0]) for number in trees.classes_]] = found
    return out


def save_boosted(trees: Any, folder: Path) -> None:
    """Write the trees into a folder, to be compared with others on this machine: no format to ship."""
    import joblib

    joblib.dump(trees, folder / FILE)


def load_boosted(folder: Path) -> Any | None:
    """Read the trees that a training of one's own left in a folder, or None where there are none."""
    if not (folder / FILE).exists():
        return None
    import joblib

    return joblib.load(folder / FILE)
