"""A stand-in for the pattern window of CLO and Marvelous Designer, by the rules that public notes state.

Lines run from one straight point to the next, curve points between them are part of the line; a seam of a line or a
piece that is not there is refused; an edge sewn to itself opens a dialog; importing replaces the scene; indices count
from 0 in a new project.
"""

from __future__ import annotations

import json
import sys
import types
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline


class DialogOpened(Exception):
    """The program would wait for a click now."""


@dataclass
class PatternWindow:
    """Describe the scene: what the calls do to it.

    Attributes:
        imports: Which document's seams an import keeps: `all`, `no_seams`, or `refused`.
        pieces: Of each piece the name and its lines' points, shape [n, 2] each [mm].
        seams: (piece, line, piece, line, forward, forward) of each seam, or of an imported one the document's.
    """

    imports: str = "all"
    pieces: list[tuple[str, list[np.ndarray]]] = field(default_factory=list)
    seams: list = field(default_factory=list)

    def NewProject(self) -> None:
        """Empty the scene."""
        self.pieces, self.seams = [], []

    def CreatePatternWithPoints(self, points: list) -> int:
        """Add a piece and return its index."""
        assert all(type(x) is float and type(y) is float and kind in (0, 2) for x, y, kind in points)
        assert points[0][2] == 0 and points[0][:2] != points[-1][:2]
        corners = [n for n, point in enumerate(points) if point[2] == 0]
        lines = []
        for start, end in zip(corners, [*corners[1:], len(points)], strict=True):
            lines.append(np.array([point[:2] for point in [*points, points[0]][start : end + 1]]))
        self.pieces.append(("", lines))
        return len(self.pieces) - 1

    def AddSeamlinePairGroup(self, a: int, line_a: int, b: int, line_b: int, forward_a: bool, forward_b: bool) -> bool:
        """Sew two lines."""
        for piece, line in ((a, line_a), (b, line_b)):
            if not 0 <= piece < len(self.pieces) or not 0 <= line < len(self.pieces[piece][1]):
                return False
        if (a, line_a) == (b, line_b):
            raise DialogOpened
        self.seams.append((a, line_a, b, line_b, forward_a, forward_b))
        return True

    def ImportPatternJSON(self, path: str) -> bool:
        """Replace the scene by a document's."""
        if self.imports == "refused":
            return False
        document = json.loads(Path(path).read_text(encoding="utf-8"))
        self.NewProject()
        for piece in document["PatternList"]:
            lines = piece["ShapeInfo"]["LineList"]
            points = [np.array([[p["Position"]["x"], p["Position"]["y"]] for p in line["PointList"]]) for line in lines]
            self.pieces.append((piece["Name"], points))
        if self.imports == "all":
            self.seams = list(document["SeamLinePairGroupList"])
        return True

    def SetPatternPieceName(self, piece: int, name: str) -> None:
        """Name a piece."""
        self.pieces[piece] = (name, self.pieces[piece][1])

    def GetPatternCount(self) -> int:
        """Return how many pieces there are."""
        return len(self.pieces)

    def GetSeamlinePairGroupCount(self) -> int:
        """Return how many seams there are."""
        return len(self.seams)

    def line_length(self, piece: int, line: int) -> float:
        """Return a line's length [mm], a natural cubic spline by chord lengths through its points."""
        points = self.pieces[piece][1][line]
        chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
        if len(points) == 2:
            return float(chords[0])
        at = np.concatenate([[0.0], np.cumsum(chords)])
        fine = CubicSpline(at, points, bc_type="natural")(np.linspace(0.0, at[-1], 1500))
        return float(np.linalg.norm(np.diff(fine, axis=0), axis=1).sum())


def run_program(path: Path, window: PatternWindow, monkeypatch) -> str:
    """Run a script as the program would, and return what it said."""
    modules = {name: types.ModuleType(name) for name in ("pattern_api", "utility_api")}
    for name in dir(PatternWindow):
        if name[0].isupper():
            home = modules["utility_api" if name == "NewProject" else "pattern_api"]
            if name != "ImportPatternJSON" or window.imports != "absent":
                setattr(home, name, getattr(window, name))
    for name, module in modules.items():
        monkeypatch.setitem(sys.modules, name, module)
    scope: dict = {"__name__": "clo"}
    exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), scope)
    return str(scope["build"]())
