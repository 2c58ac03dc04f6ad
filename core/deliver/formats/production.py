"""The input of the writers of production formats, and their lookup by name."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from pathlib import Path

import numpy as np

from ...cloth.fabric import Fabric
from ...garment.contour_edges import name_open_edges
from ...garment.garmentcode_writer import save_pattern
from ...garment.measures import BodyMeasures
from ...garment.pattern import Pattern
from ...garment.pieces.make import Style, make_pieces
from ...garment.pieces.piece import PieceSet
from ...judge.line_intervals import describe_margins
from ...recover.drape.sizing import measure_wearer
from ...reuse.wear.worn import WornGarment
from ...run.hooks import SILENT_HOOKS, Hooks
from .levels import find_hang_height, find_levels
from .options import ExportOptions
from .registry import FORMATS

FIT_FILE_NAME = "fit.json"
"""Name of the file of a result with its fit's estimates."""

MANIFEST_FILE_NAME = "manifest.json"
"""Name of the file of a result with what it was made of."""

HAND_PULL = 25.0
"""Pull of two fingers on cloth [N/m]: 2.5 N on 10 cm."""

MIN_KNIT_STRETCH = 0.18
"""Smallest stretch of a knit under a hand's pull [1]: that of stable knits (H. Joseph-Armstrong, Patternmaking for
Fashion Design, stretch gauge). Of the library's woven cloths a jacket's polyester alone stretches as much."""

STEM = "pieces"
"""Beginning of an export's file names, which contain no name from a user."""


@dataclass(frozen=True)
class Production:
    """Describe a garment to be written for production.

    Attributes:
        worn: The garment with its pattern, cloth and wearer.
        options: The options of the export.
        files: Folder of the result's files, for writers that need its meshes.
        scan: The scan's file, or its reading, for writers that need its colours, or None.
        hooks: Progress and cancellation, for long computations.
        made: Day on which the result was made, `2026-11-28`, or an empty text.
    """

    worn: WornGarment
    options: ExportOptions
    files: Path
    scan: Path | None = None
    hooks: Hooks = SILENT_HOOKS
    made: str = ""

    @cached_property
    def measures(self) -> BodyMeasures:
        """Return the wearer's measures."""
        return measure_wearer(self.worn.body)

    @cached_property
    def height(self) -> float:
        """Return the wearer's height [m]."""
        return float(np.ptp(self.worn.body.rest_vertices[:, 1]))

    @cached_property
    def style(self) -> Style:
        """Return the labels of the pieces: the garment's name, the wearer's size, the cloth, the scan and the day."""
        fabric = self.worn.fabric
        known = (("scan", find_scan_name(self.files)), ("made", self.made))
        return Style(
            describe_garment(self.worn.pattern.name),
            describe_size(self.measures, self.height),
            fabric.title or fabric.name.replace("_", " "),
            is_stretchy(fabric),
            tuple((label, value) for label, value in known if value),
            find_levels(self.worn.pattern, self.measures, find_hang_height(self.worn.waist, self.worn.body)),
            read_margins(self.files),
        )

    @cached_property
    def pieces(self) -> PieceSet:
        """Return the production pieces of the garment."""
        return make_pieces(self.pattern, self.options.piece_settings, self.style, self.point_std)

    @cached_property
    def pattern(self) -> Pattern:
        """Return the garment's pattern, open edges without a name named as the garment is worn."""
        return name_open_edges(self.worn.garment)

    @cached_property
    def point_std(self) -> np.ndarray | None:
        """Return the standard deviation of each control point [m], shape [point_count, 2]; None where the result has
        none for this pattern."""
        return read_point_std(self.files / FIT_FILE_NAME, self.pattern)


def is_stretchy(fabric: Fabric) -> bool:
    """Check whether a fabric stretches as a knit does: under a hand's pull by `MIN_KNIT_STRETCH` or more, across its
    warp."""
    return HAND_PULL / fabric.H00 >= MIN_KNIT_STRETCH


def describe_garment(name: str) -> str:
    """Return the name of a pattern as words: `tshirt+neckline=v` is `tshirt, v neckline`."""
    template, _, parts = name.partition("+")
    words = [template.replace("_", " ")]
    for part in filter(None, parts.split(",")):
        key, sign, choice = part.partition("=")
        words.append((f"{choice} {key}" if sign else part).replace("_", " "))
    return ", ".join(words)


def find_scan_name(result: Path) -> str:
    """Return the name of the scan's file without its ending, from the manifest of a result; an empty text without."""
    try:
        name = json.loads((result / MANIFEST_FILE_NAME).read_text(encoding="utf-8"))["scan"]["name"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return ""
    return Path(str(name)).stem


def read_margins(result: Path) -> tuple[str, ...]:
    """Read how sure a result's seams and edges are from its manifest, a text each; none where it does not say."""
    try:
        lines = json.loads((result / MANIFEST_FILE_NAME).read_text(encoding="utf-8"))["lines"]
        return tuple(", ".join(filter(None, describe_margins(line))) for line in lines)
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return ()


def read_point_std(path: Path, pattern: Pattern) -> np.ndarray | None:
    """Read the standard deviation of each control point of a pattern from a fit's file [m], shape [point_count, 2];
    None where the file does not have it."""
    try:
        stored = json.loads(path.read_text(encoding="utf-8"))["control_point_std_m"]
        found = np.concatenate([np.array(stored[panel.name], float) for panel in pattern.panels])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return found if found.shape == pattern.points.shape and np.isfinite(found).all() else None


def describe_size(measures: BodyMeasures, height: float) -> str:
    """Return a size by its wearer's girths and height, in whole centimetres (as EN 13402 designates)."""
    girths = {"bust": measures.bust, "waist": measures.waist, "hip": measures.hip, "height": height}
    return " ".join(f"{name} {100.0 * value:.0f}" for name, value in girths.items())


def write_production(production: Production, folder: Path) -> list[Path]:
    """Write a garment in the format of its options, and return the files.

    Raises:
        PieceBad: where a piece cannot be cut.
        SheetTooSmall: where the paper is too narrow.
    """
    module, _, name = FORMATS[production.options.format].partition(":")
    write: Callable[[Production, Path], list[Path]] = getattr(import_module(module), name)
    folder.mkdir(parents=True, exist_ok=True)
    return write(production, folder)


def write_garmentcode(production: Production, folder: Path) -> list[Path]:
    """Write the pattern as GarmentCode JSON, and return the file."""
    return [save_pattern(production.pattern, folder / "pattern.json")]
