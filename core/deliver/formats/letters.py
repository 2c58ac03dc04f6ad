"""Measure lines of text in the letters of PDF, and break or shrink them so that they fit."""

from __future__ import annotations

import unicodedata

HELVETICA_WIDTHS = (
    278, 278, 355, 556, 556, 889, 667, 222, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556, 556, 556,
    556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833,
    722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 278, 278, 278, 469, 556, 222, 556, 556, 500, 556,
    556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500, 500, 334,
    260, 334, 584,
)  # fmt: skip
"""Widths of the letters from blank to `~` in Helvetica [thousandths of the size] (Adobe, Core 14 font metrics)."""

HELVETICA_BOLD_WIDTHS = (
    278, 333, 474, 556, 556, 889, 722, 278, 333, 333, 389, 584, 278, 333, 278, 278, 556, 556, 556, 556, 556, 556, 556,
    556, 556, 556, 333, 333, 584, 584, 584, 611, 975, 722, 722, 722, 722, 667, 611, 778, 722, 278, 556, 722, 611, 833,
    722, 778, 667, 778, 722, 667, 611, 722, 667, 944, 667, 667, 611, 333, 278, 333, 584, 556, 278, 556, 611, 556, 611,
    556, 333, 611, 611, 278, 278, 556, 278, 889, 611, 611, 611, 611, 389, 556, 333, 611, 556, 778, 556, 556, 500, 389,
    280, 389, 584,
)  # fmt: skip
"""Widths of the letters from blank to `~` in Helvetica Bold [thousandths of the size] (Adobe, Core 14 font metrics)."""

OTHER_LETTER_WIDTH = 1000
"""Width of a letter that has no basic one [thousandths of the size]: as wide as an em, the widest but `@`."""


def measure_text(text: str, size: float, is_bold: bool = False) -> float:
    """Return the width of a line of text in Helvetica, in the unit of its size; accents add nothing."""
    widths = HELVETICA_BOLD_WIDTHS if is_bold else HELVETICA_WIDTHS
    plain = (unicodedata.normalize("NFKD", letter)[:1] for letter in text)
    return size / 1e3 * sum(widths[ord(one) - 32] if " " <= one <= "~" else OTHER_LETTER_WIDTH for one in plain)


def fit_size(text: str, size: float, width: float, is_bold: bool = False) -> float:
    """Return a size of letters, at most the given one, at which a line is no wider than a width of the same unit."""
    return min(size, width / max(measure_text(text, 1.0, is_bold), 1e-9))


def break_line(text: str, size: float, width: float, indent: str = "") -> list[str]:
    """Return a line of text as lines no wider than a width of the unit of its size, broken at blanks; a single longer
    word is broken anywhere. The further lines begin with an indent."""
    lines = [""]
    for word in text.split(" "):
        longer = f"{lines[-1]} {word}" if lines[-1].strip() else lines[-1] + word
        if measure_text(longer, size) <= width:
            lines[-1] = longer
            continue
        if lines[-1].strip():
            lines.append(indent)
        for letter in word:
            if measure_text(lines[-1] + letter, size) > width and lines[-1].strip():
                lines.append(indent)
            lines[-1] += letter
    return lines
