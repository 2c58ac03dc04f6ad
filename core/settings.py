"""What a user may choose about one recovery; every default says why."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from .errors import BadInput

METHODS = ("deform",)
PRESETS = ("default", "thesis")


class SettingsBad(BadInput):
    """A setting is not one of the allowed values; see `garmentq run --help`."""

    code = "settings.bad"


@dataclass(frozen=True)
class RecoverySettings:
    """Choose how one garment is recovered.

    Attributes:
        method: `deform`: grade, drape, then deform onto the scan.
        preset: Deformer preset; `default`, or `thesis` for the published weights in the reading that works.
        garment: Category that overrides the one chosen from the contours, or None.
        template: Name of a shipped or imported template that overrides the chosen one, or None.
        fabric: Name in the fabric library. A plain cotton weave is the default: mid-range in weight and stiffness.
        units: `m`, `cm` or `mm` of the scan's and body's file, or None to find it.
        up: `y` or `z` of the file, or None to find it.
        vertex_count: Vertices of the garment mesh; 4000 gives edges of about 1.5 cm on a T-shirt, where the folds of a
            scan are still resolved and a Newton step takes about 0.2 s.
        seed: Seeds every random choice, so that the same input gives the same output.
    """

    method: str = "deform"
    preset: str = "default"
    garment: str | None = None
    template: str | None = None
    fabric: str = "cotton_poplin"
    units: str | None = None
    up: str | None = None
    vertex_count: int = 4000
    seed: int = 0

    def __post_init__(self) -> None:
        """Check every value.

        Raises:
            SettingsBad: where one is outside its list or range.
        """
        if self.method not in METHODS:
            raise SettingsBad(f"method '{self.method}' is not one of {', '.join(METHODS)}.")
        if self.preset not in PRESETS:
            raise SettingsBad(f"preset '{self.preset}' is not one of {', '.join(PRESETS)}.")
        if not 500 <= self.vertex_count <= 20000:
            raise SettingsBad(f"vertex_count {self.vertex_count} is outside 500 to 20000.")

    def as_dict(self) -> dict[str, Any]:
        """Give the settings as plain JSON values."""
        return asdict(self)
