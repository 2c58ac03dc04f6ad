"""What is compared: labels, their confidence, and whether the outfit was read."""

import numpy as np
from garmentq.core.people.part import Part
from garmentq.training.compare import Answer, judge_answers, split_by_outfit

SKIN, UPPER, LOWER, ONE_PIECE, OUTER = (
    int(part) for part in (Part.SKIN, Part.UPPER, Part.LOWER, Part.ONE_PIECE, Part.OUTER)
)


def answer(label, outfit, likely):
    """Return an answer with the same confidence for each sample, and an outfit that was chosen."""
    return Answer(np.array(label), np.full(len(label), 0.9), frozenset(outfit), likely)


def test_scans_are_split_by_what_is_worn_and_whether_it_was_read():
    """Broken where a coat counts as a wrong outfit of the others, or a stray sample as a garment."""
    two = np.array([SKIN] * 50 + [UPPER] * 25 + [LOWER] * 25)
    stray, coat = two.copy(), two.copy()
    stray[0] = ONE_PIECE
    coat[60:75] = OUTER
    right = (answer(two, (Part.UPPER, Part.LOWER), 0.8), stray)
    wrong = (answer([SKIN] * 50 + [ONE_PIECE] * 50, (Part.ONE_PIECE,), 0.6), two)
    layered = (answer(two, (Part.UPPER, Part.LOWER), 0.9), coat)
    groups = split_by_outfit([right, wrong, layered])
    assert [groups[name] for name in groups] == [[right, wrong], [right], [wrong], [layered]]
    figures = judge_answers(groups["no outer layer"])
    assert (figures["scans"], figures["outfit_right"], figures["outfit_said"]) == (2, 0.5, 0.7)
    assert np.isclose(figures["accuracy"], (0.99 + 0.5) / 2)


def test_samples_alone_have_no_outfit():
    """Broken where an answer without a choice of the outfit is counted among those that read it wrongly."""
    bare = (Answer(np.array([SKIN, UPPER]), np.array([0.9, 0.9])), np.array([SKIN, UPPER]))
    assert not any(split_by_outfit([bare]).values())
    assert "outfit_right" not in judge_answers([bare])
