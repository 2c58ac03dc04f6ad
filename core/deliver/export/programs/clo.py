"""Build a sewn garment in CLO or Marvelous Designer: run this file in their Python editor, in a new project.

It first imports its pattern document. Where the program has no such import, or leaves out a seam, it draws the pieces
point by point in an empty project and sews them line by line; the open project is replaced. Written after the
documented interface; not run in either program.
"""

import json
import os
import tempfile
from typing import Any

DOCUMENT = "{}"
"""The pattern document, as JSON."""

POINTS = "{}"
"""The same garment for the second method, as JSON: pieces with (x, y, kind) in mm, and seams by piece and line."""


def build() -> str:
    """Build the garment, and return one line on how it was built."""
    import pattern_api  # CLO's and Marvelous Designer's own modules

    wanted = json.loads(POINTS)
    pieces, seams = len(wanted["pieces"]), len(wanted["seams"])
    how = "document"
    if not import_document(pattern_api) or count(pattern_api) != (pieces, seams):
        how = "points"
        start_anew()
        draw_points(pattern_api, wanted)
    name_pieces(pattern_api, wanted)
    found = count(pattern_api)
    verdict = "complete" if found == (pieces, seams) else f"NOT COMPLETE, expected {pieces} pieces and {seams} seams"
    return f"garmentq: {found[0]} pieces and {found[1]} seams by {how}, {verdict}"


def import_document(pattern_api: Any) -> bool:
    """Import the pattern document, and return whether that succeeded."""
    if not hasattr(pattern_api, "ImportPatternJSON"):
        return False
    path = os.path.join(tempfile.mkdtemp(), "garment.json")
    with open(path, "w", encoding="utf-8") as file:
        file.write(DOCUMENT)
    return bool(pattern_api.ImportPatternJSON(path.replace(os.sep, "/")))


def count(pattern_api: Any) -> "tuple[int, int]":
    """Return the numbers of pieces and seams of the scene."""
    return int(pattern_api.GetPatternCount()), int(pattern_api.GetSeamlinePairGroupCount())


def start_anew() -> None:
    """Empty the scene, so that indices of pieces count from 0."""
    import utility_api

    utility_api.NewProject()


def draw_points(pattern_api: Any, wanted: "dict[str, Any]") -> None:
    """Draw the pieces as corners and points of splines, and sew them; a line runs from corner to corner."""
    index = {}
    for piece in wanted["pieces"]:
        points = [(float(x), float(y), int(kind)) for x, y, kind in piece["points"]]
        index[piece["name"]] = pattern_api.CreatePatternWithPoints(points)
    for seam in wanted["seams"]:
        a, b = seam["a"], seam["b"]
        pattern_api.AddSeamlinePairGroup(
            index[a["piece"]], a["line"], index[b["piece"]], b["line"], bool(a["forward"]), bool(b["forward"])
        )


def name_pieces(pattern_api: Any, wanted: "dict[str, Any]") -> None:
    """Name the pieces; they have the document's order either way."""
    for number, piece in enumerate(wanted["pieces"]):
        if number < int(pattern_api.GetPatternCount()):
            pattern_api.SetPatternPieceName(number, piece["name"])


if __name__ == "__main__":
    print(build())  # noqa: T201
