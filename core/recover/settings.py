"""Define the settings of one recovery, with the reason for each default."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from ..cloth.fabric import Fabric
from ..run.errors import BadInput

METHODS = ("deform", "inverse", "hybrid")
PRESETS = ("default", "thesis")
WAIT, LATER, NEVER = REDRAPES = ("wait", "later", "never")
QUALITIES: Mapping[str, Mapping[str, Any]] = {
    "preview": {"method": "deform", "vertex_count": 2000},
    "standard": {"method": "hybrid", "vertex_count": 4000},
    "fine": {"method": "hybrid", "vertex_count": 8000},
}
"""Settings of each quality. `standard` is the default; `preview` takes a third of its time, and fits no pattern; `fine`
takes half as long again, for a detail mesh a quarter nearer to the scan."""
STATURE_RANGE = (0.5, 2.5)
"""Least and largest height of a person [m]: from a small child on."""
_LOCK = re.compile(r"fabric|symmetry|panel:.+|point:.+/\d+")


class SettingsBad(BadInput):
    """A setting is not one of the allowed values; see `garmentq run --help`."""

    code = "settings.bad"


def complete_by_quality(quality: str | None, values: Mapping[str, Any]) -> dict[str, Any]:
    """Return values of settings with those of a quality that are not among them; None stands for `standard`.

    Raises:
        SettingsBad: where there is no such quality.
    """
    if quality not in (None, *QUALITIES):
        raise SettingsBad(f"quality '{quality}' is not one of {', '.join(QUALITIES)}.")
    return {**QUALITIES[quality or "standard"], **values}


@dataclass(frozen=True)
class RecoverySettings:
    """Describe how one garment is recovered.

    Attributes:
        method: `hybrid`, the default, recovers pattern and cloth: grade, drape, deform onto the scan, refit the pattern
            to the deformed mesh and through the simulator, and drape it again as the simulation mesh. `deform` stops at
            the detail mesh, in under half the time. `inverse` descends from the graded pattern through the simulator
            (the thesis' loop), drapes the resulting pattern, and deforms that onto the scan.
        preset: Deformer preset; `default`, or `thesis` for the published weights in the reading that works.
        garment: Category that overrides the one chosen from the contours, or None.
        template: Name of a shipped or imported template that overrides the chosen one, or None.
        fabric: Name of a shipped fabric, a fabric (imported: looked up when queued), or None for `DEFAULT_FABRIC`.
        units: A name of `UNITS`, of the scan's and body's file, or None to find it.
        up: `y` or `z` of the file, or None to find it.
        vertex_count: Number of vertices of the garment mesh; 4000 gives edges of about 1.5 cm on a T-shirt, which still
            resolve the folds of a scan, and Newton steps of about 0.2 s.
        seed: Number that seeds the surface samples of the metrics; nothing else is random.
        keep: Labels of a dressed person's scan that are the garment, separated by commas (`upper,sleeve`), or None.
        labels_key: Name of the array with the labels in a label file of several, or None to find it.
        keep_colour: The garment's colour as `#rrggbb`, instead of labels, or None.
        colour_tolerance: Distance of colours [RGB, 0 to 255] up to which a colour is the garment's; 60 spans a camera's
            noise and soft shadows, while skin is 150 from denim.
        lock: What the fit keeps as given or graded, comma-separated, or None: `fabric`, `panel:NAME`,
            `point:PANEL/INDEX` (the point where edge INDEX begins, from 0), and mirror images; `symmetry`: the default.
        free: What grading and fit may change beyond the default, or None: `symmetry` lets left and right differ. A
            garment that is cut symmetric is recovered better with symmetry kept: noise and folds are not symmetric.
        parts: Choices of parts of the cut that overrule the scan, `neckline=v,sleeve=long`, or None. Left out of a
            stored request where None, so that equal orders of releases without it are the same job.
        keep_cut: True leaves every panel with the seams and darts of its base pattern; otherwise `hybrid` adds a dart
            where a panel cannot be isometric to the scan, and closes a needless one. Left out as `parts` is.
        cloth: Labels of a dressed person's other clothes, by commas, or None: they hide the body and are no skin.
        height: How high the person of a raw scan stands [m], where the file's unit is not known, or None: the unit
            tells. Left out as `parts` is.
        redrape: When the pattern is dressed anew: `wait`, which None stands for, before the result is handed out;
            `later`, by a job of its own; or `never`. Left out as `parts` is.
    """

    method: str = "hybrid"
    preset: str = "default"
    garment: str | None = None
    template: str | None = None
    fabric: str | Fabric | None = None
    units: str | None = None
    up: str | None = None
    vertex_count: int = 4000
    seed: int = 0
    keep: str | None = None
    labels_key: str | None = None
    keep_colour: str | None = None
    colour_tolerance: float = 60.0
    lock: str | None = None
    free: str | None = None
    cloth: str | None = None
    parts: str | None = field(default=None, metadata={"is_left_out": True})
    keep_cut: bool | None = field(default=None, metadata={"is_left_out": True})
    redrape: str | None = field(default=None, metadata={"is_left_out": True})
    height: float | None = field(default=None, metadata={"is_left_out": True})

    def __post_init__(self) -> None:
        """Check every value.

        Raises:
            SettingsBad: where one is outside its list or range.
            PartUnknown: where a part or a choice of it does not exist.
        """
        if self.method not in METHODS:
            raise SettingsBad(f"method '{self.method}' is not one of {', '.join(METHODS)}.")
        if self.preset not in PRESETS:
            raise SettingsBad(f"preset '{self.preset}' is not one of {', '.join(PRESETS)}.")
        if self.redrape not in (None, *REDRAPES):
            raise SettingsBad(f"redrape '{self.redrape}' is not one of {', '.join(REDRAPES)}.")
        if not 500 <= self.vertex_count <= 20000:
            raise SettingsBad(f"vertex_count {self.vertex_count} is outside 500 to 20000.")
        if self.height is not None and not STATURE_RANGE[0] <= self.height <= STATURE_RANGE[1]:
            raise SettingsBad(f"height {self.height} is outside {STATURE_RANGE[0]} to {STATURE_RANGE[1]} m.")
        if self.height is not None and self.units is not None:
            raise SettingsBad("height and units exclude each other; give the one that is known.")
        if self.keep is not None and not self.kept_labels:
            raise SettingsBad(f"keep '{self.keep}' names no label; give one, or several separated by commas.")
        if self.keep is not None and self.keep_colour is not None:
            raise SettingsBad("keep and keep_colour exclude each other; select the garment by labels or by colour.")
        for word in self.locks:
            if not _LOCK.fullmatch(word):
                raise SettingsBad(f"lock '{word}' is none of fabric, symmetry, panel:NAME, point:PANEL/INDEX.")
        if self.free not in (None, "symmetry"):
            raise SettingsBad(f"free '{self.free}' is not 'symmetry'.")
        if self.free in self.locks:
            raise SettingsBad(f"'{self.free}' cannot be locked and free.")
        if self.parts is not None:
            from ..garment.parts.cut import Cut  # imported here, for patterns import numba

            Cut().choose(self.chosen_parts)
        if not 0.0 < self.colour_tolerance <= 442.0:
            raise SettingsBad(f"colour_tolerance {self.colour_tolerance} is outside 0 to 442 (black to white).")

    @property
    def chosen_parts(self) -> dict[str, str]:
        """Return the choices of parts by part.

        Raises:
            PartUnknown: where one is not `PART=CHOICE`.
        """
        from ..garment.parts.part_words import parse_parts

        return parse_parts(self.parts or "")

    def overrule_parts(self, part_choices: str | None) -> str | None:
        """Return the choices of parts, those of one garment (`neckline=v`) before those for all."""
        if part_choices is None:
            return self.parts
        words = [word.strip() for word in part_choices.split(",")]
        named = {word.partition("=")[0].strip() for word in words}
        common = [word.strip() for word in (self.parts or "").split(",")]
        return ",".join([*(word for word in common if word and word.partition("=")[0].strip() not in named), *words])

    @property
    def locks(self) -> tuple[str, ...]:
        """Return the locks one by one."""
        return tuple(word.strip() for word in (self.lock or "").split(",") if word.strip())

    @property
    def kept_labels(self) -> tuple[str, ...]:
        """Return the labels to keep, one by one."""
        return tuple(word.strip() for word in (self.keep or "").split(",") if word.strip())

    @property
    def cloth_labels(self) -> tuple[str, ...]:
        """Return the labels of the other clothes, one by one."""
        return tuple(word.strip() for word in (self.cloth or "").split(",") if word.strip())

    def as_dict(self) -> dict[str, Any]:
        """Return the settings as plain JSON values."""
        return asdict(self)
