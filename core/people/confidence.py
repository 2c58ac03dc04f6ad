"""Convert scores to probabilities, and define the limits below which nothing is recovered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..run.errors import BadInput, GarmentqError
from .hints import NOTHING_WORN
from .part import Part
from .separation import FoundGarment, Outfit

POSTERIOR_TEMPERATURE = 0.5
"""Factor by which a point's log-probabilities are divided within a reading of the outfit (temperature scaling), as
smoothing lowers the networks' confidence. On 94 scans of simulated persons of held-out designs 0.967 of the samples are
right where the outfit is read rightly. Their mean confidence is 0.875 at 1, 0.904 at 0.7 and 0.919 at 0.5; a lower
value would give a confidence of 0.9 where less than 0.97 are right."""

BORDER_STEP_SCALE = 2e-3
"""Step at a border that alone makes its evidence 1 [m]: a thin hem is 1 to 2 mm thick, and stands off more."""

BORDER_CONTRAST_SCALE = 12.0
"""Difference of colour at a border that alone makes its evidence 1 [CIE76 in L*a*b*, the lightness weighted by 0.4]:
three times that of shadows between neighbouring patches of one cloth."""

MIN_SHOWN_BORDER_SHARE = 0.5
"""Least share of a border that the scan has to show; with less the border is inferred."""

MIN_GARMENT_CONFIDENCE = 0.6
"""Mean probability of a garment's points below which the labels are refused as unsure, unless checked by a person."""

GARMENT_WARNING_CONFIDENCE = 0.8
"""Mean probability of a garment's points below which the user is warned."""

MIN_OUTFIT_LOG_ODDS = 0.7
"""Log-odds of the two best readings below which the labels are refused as unsure, unless checked: two to one."""

OUTFIT_WARNING_LOG_ODDS = 2.0
"""Log-odds of the two best readings below which the user is warned and both are named."""

MIN_WARNED_ALTERNATIVE = float(1.0 / (1.0 + np.exp(OUTFIT_WARNING_LOG_ODDS)))
"""Probability of another category from which on the user is warned [1]: as of another outfit."""


class LabelsUnsure(BadInput):
    """It is not clear what is worn; look at the picture, then say --wearing, or mend labels.npz and give --labels."""

    code = "segment.unsure"


class NoCloth(BadInput):
    """Nothing is worn but skin or underwear; say --wearing nothing to keep the body, or what is worn."""

    code = "segment.no_cloth"


def apply_temperature(posterior: np.ndarray, temperature: float = POSTERIOR_TEMPERATURE) -> np.ndarray:
    """Return a posterior, shape [n, k], with its log-probabilities divided by a temperature."""
    log = np.log(np.maximum(posterior, 1e-9)) / temperature
    scaled = np.exp(log - log.max(axis=1, keepdims=True))
    return np.asarray(scaled / scaled.sum(axis=1, keepdims=True))


def border_evidence(step: np.ndarray, contrast: np.ndarray) -> np.ndarray:
    """Return the evidence of each place of a border: sqrt((step / STEP)^2 + (contrast / CONTRAST)^2), 1 is enough.

    Args:
        step: Height of the garment over what is beyond [m], shape [n].
        contrast: Difference of the colours of the two sides, shape [n].
    """
    return np.asarray(np.hypot(np.maximum(step, 0.0) / BORDER_STEP_SCALE, contrast / BORDER_CONTRAST_SCALE))


def is_shown(step: np.ndarray, contrast: np.ndarray) -> bool:
    """Check whether the scan shows a border."""
    return bool((border_evidence(step, contrast) >= 1.0).mean() >= MIN_SHOWN_BORDER_SHARE)


def contour_confidence(step: np.ndarray, contrast: np.ndarray) -> float:
    """Return the probability that a border is within 2 cm of where it was found: 1 - exp(-median evidence)."""
    return float(1.0 - np.exp(-np.median(border_evidence(step, contrast))))


def check_garments(garments: tuple[FoundGarment, ...], outfits: tuple[Outfit, ...]) -> tuple[FoundGarment, ...]:
    """Return the garments, each with the reason why a person should look before it is recovered, or None.

    Args:
        garments: What was found.
        outfits: Readings, the best first.
    """
    is_covered = any(garment.part is Part.OUTER for garment in garments)
    return tuple(replace(garment, problem=_find_problem(garment, outfits, is_covered)) for garment in garments)


def check_confidence(
    garments: tuple[FoundGarment, ...], outfits: tuple[Outfit, ...], is_given: bool
) -> tuple[tuple[str, ...], GarmentqError | None]:
    """Return the warnings to the user, and the reason why nothing can be recovered; None where some garment can.

    Args:
        garments: What was found, each checked.
        outfits: Readings, the best first.
        is_given: Whether the user gave what is worn: then a scan without clothes is no problem.
    """
    warnings = []
    if not garments:
        return (), None if is_given else NoCloth()
    problems = [garment.problem for garment in garments]
    is_blocked = None not in problems
    if len(outfits) > 1 and outfits[0].score - outfits[1].score < OUTFIT_WARNING_LOG_ODDS:
        first, second = (_name_outfit(outfit) for outfit in outfits[:2])
        warnings.append(f"It is taken for {first}, but may be {second}; say --wearing {second.replace(' and ', ',')}.")
    for garment in garments:
        if garment.confidence < GARMENT_WARNING_CONFIDENCE:
            warnings.append(f"The {garment.part.word} is unsure ({garment.confidence:.2f}); look at the picture.")
        other = garment.alternative
        if other is not None and other.probability > MIN_WARNED_ALTERNATIVE:
            warnings.append(
                f"The {garment.part.word} is taken for {garment.category}, but may be {other.category} "
                f"({100.0 * other.probability:.0f} %)."
            )
        hidden = [contour.name for contour in garment.contours if contour.is_inferred]
        if hidden:
            warnings.append(f"Nothing shows where the {garment.part.word} ends at {', '.join(hidden)}: inferred.")
        if garment.problem is not None and not is_blocked:
            warnings.append(f"The {garment.part.word} is not recovered. {garment.problem.message}")
    return tuple(warnings), problems[0] if is_blocked else None


def _find_problem(garment: FoundGarment, outfits: tuple[Outfit, ...], is_covered: bool) -> BadInput | None:
    """Return the reason why a person should look at a garment first, or None.

    Args:
        garment: The garment.
        outfits: Readings, the best first.
        is_covered: Whether an outer layer is worn over what is not on the legs alone.
    """
    word, reason = garment.part.word, ""
    is_open = len(outfits) > 1 and outfits[0].score - outfits[1].score < MIN_OUTFIT_LOG_ODDS
    if garment.confidence < MIN_GARMENT_CONFIDENCE:
        reason = f"What was found of {word} is unsure."
    elif is_covered and garment.part not in (Part.LOWER, Part.OUTER):
        reason = f"An outer layer hides most of {word}."
    elif not garment.category:
        reason = f"The openings of {word} could not be made out."
    elif is_open and garment.part not in outfits[1].parts:
        first, second = (_name_outfit(outfit) for outfit in outfits[:2])
        reason = f"It may be {first}, or {second}."
    return LabelsUnsure(f"{reason} {LabelsUnsure().message}") if reason else None


def _name_outfit(outfit: Outfit) -> str:
    """Return the words of a reading's garments, as `--wearing` takes them but for the commas."""
    return " and ".join(part.word for part in outfit.parts) or NOTHING_WORN


def garment_confidence(label: np.ndarray, confidence: np.ndarray, part: Part) -> float:
    """Return the mean probability of a part's points, shape [n]."""
    return float(confidence[label == part].mean())
