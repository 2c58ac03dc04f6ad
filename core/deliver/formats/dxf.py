"""Write pieces as DXF for cutting programs (ANSI/AAMA-292, ASTM D6673), alone or as a nest of sizes."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ...garment.pattern import Panel
from ...garment.pieces.flatten import flatten_outline
from ...garment.pieces.piece import Piece, PieceSet
from ...garment.pieces.shelf_packing import pack_on_shelves
from .dialects import DIALECTS_BY_NAME, Dialect, OutlineClosing
from .drawing import GRAIN_UNKNOWN_TEXT, keep_ascii
from .flat_dxf import flat_text
from .sheet import SHEET_PIECE_GAP

if TYPE_CHECKING:
    from .production import Production

AUTHOR = "garmentq;garmentq;1"
"""Vendor, program and release, as the standard requires."""

NOTCH_WIDTH = 0.0
"""Width of a slit [m]."""

DRILL_HOLE_DIAMETER = 0.003
"""Diameter of a drill hole [m]."""

ARCHIVE_FILE_TIMESTAMP = (1980, 1, 1, 0, 0, 0)
"""Time of the files in an archive [year to second]; constant, so that its bytes depend on its content alone."""

Rules = dict[str, list[tuple[np.ndarray, int]]]
"""By the piece's name: its points [m], and the number of the rule that moves each."""


@dataclass(frozen=True)
class Block:
    """Describe one piece as a block: the piece, its block's name, and its size's name."""

    piece: Piece
    name: str
    size: str


DXF_SHEET_WIDTH = 1.4
"""Width of the sheet on which pieces are inserted side by side [m]: that of usual cloth."""


def write(production: Production, folder: Path) -> list[Path]:
    """Write `pieces_DIALECT.dxf`, its rule table and an archive of both, and return them; of the flat dialect the first
    alone."""
    dialect = DIALECTS_BY_NAME[production.options.dialect]
    pieces = production.pieces
    if dialect.is_flat:
        path = folder / f"pieces_{dialect.name}.dxf"
        path.write_bytes(flat_text([("", pieces)]).encode("ascii"))
        return [path]
    blocks = [Block(piece, piece.name, "BASE") for piece in pieces.cut_pieces]
    files = {
        f"pieces_{dialect.name}.dxf": dxf_text(pieces, blocks, dialect),
        f"pieces_{dialect.name}.rul": rule_text(dialect, ("BASE",), []),
    }
    return write_archive(files, dialect, folder, f"pieces_{dialect.name}.zip")


def write_archive(files: dict[str, str], dialect: Dialect, folder: Path, name: str) -> list[Path]:
    """Write texts as files and as one archive with a readme, and return the paths."""
    paths = []
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for file, text in [*files.items(), ("README.txt", _readme_text(dialect))]:
            archive.writestr(zipfile.ZipInfo(file, ARCHIVE_FILE_TIMESTAMP), text.encode("ascii"), zipfile.ZIP_DEFLATED)
    for file, text in files.items():
        path = folder / file
        path.write_bytes(text.encode("ascii"))
        paths.append(path)
    path = folder / name
    path.write_bytes(packed.getvalue())
    return [*paths, path]


def _readme_text(dialect: Dialect) -> str:
    unit = "inches" if dialect.is_inch else "millimetres"
    lines = [
        f"Dialect: {dialect.name}. Units: {unit}. Cut line: layer 1, sew line: layer {dialect.sew_layer}.",
        "Keep the DXF and the RUL file under the same name in one folder: the rule table belongs to the pieces.",
        "CLO and Marvelous Designer take layer 1 for the outline; their import can swap it with the sew line, or turn",
        "it into a net line with an allowance.",
        "Checked with open readers of DXF; not run in the cutting programs themselves.",
    ]
    return "\r\n".join(lines) + "\r\n"


def dxf_text(pieces: PieceSet, blocks: Iterable[Block], dialect: Dialect, rules: Rules | None = None) -> str:
    """Return the DXF file of some pieces (R12, ASCII): a block and an insertion of each, and the style's texts."""
    out: list[str] = []
    listed = list(blocks)
    _append_groups(out, (0, "SECTION"), (2, "HEADER"))
    if dialect.acad:
        _append_groups(out, (9, "$ACADVER"), (1, dialect.acad))
    _append_groups(out, (0, "ENDSEC"), (0, "SECTION"), (2, "BLOCKS"))
    for block in listed:
        _append_groups(out, (0, "BLOCK"), (8, "0"), (2, block.name), (70, "0"), (10, "0.0"), (20, "0.0"), (30, "0.0"))
        _append_groups(out, (3, block.name))
        _draw(out, block, pieces, dialect, (rules or {}).get(block.piece.name, []))
        _append_groups(out, (0, "ENDBLK"), (8, "0"))
    _append_groups(out, (0, "ENDSEC"), (0, "SECTION"), (2, "ENTITIES"))
    sample = listed[0].size if listed else ""
    style = {
        "STYLE NAME": keep_ascii(pieces.name)[:20], "CREATION DATE": "", "CREATION TIME": "", "AUTHOR": AUTHOR,
        "SAMPLE SIZE": sample, "GRADE RULE TABLE": "GARMENTQ" if rules else "",
        "UNITS": "ENGLISH" if dialect.is_inch else "METRIC", "VERSION": dialect.version,
    }  # fmt: skip
    if dialect.has_validation:
        style["CURVE TOLERANCE"] = _number(5e-5, dialect)
    for n, (key, value) in enumerate(style.items()):
        _text(out, 1, f"{key}: {value}", (0.0, -0.02 * (n + 1)), dialect)
    for block, place in zip(listed, _place_blocks(listed, dialect), strict=True):
        x, y = (_number(float(value), dialect) for value in place)
        _append_groups(out, (0, "INSERT"), (8, "1"), (2, block.name), (10, x), (20, y), (30, "0.0"))
    _append_groups(out, (0, "ENDSEC"), (0, "EOF"))
    return "".join(out)


def _place_blocks(blocks: list[Block], dialect: Dialect) -> np.ndarray:
    """Return where each block is inserted, in the dialect's axes [m], shape [n, 2]: pieces side by side above the
    style's texts, all sizes of a piece upon each other."""
    names = list(dict.fromkeys(block.piece.name for block in blocks))
    outlines: dict[str, list[np.ndarray]] = {name: [] for name in names}
    for block in blocks:
        outlines[block.piece.name].append(_to_dialect_axes(block.piece.cut.points, dialect))
    low = np.array([np.concatenate(outlines[name]).min(axis=0) for name in names]).reshape(-1, 2)
    high = np.array([np.concatenate(outlines[name]).max(axis=0) for name in names]).reshape(-1, 2)
    corners = pack_on_shelves(high - low, SHEET_PIECE_GAP, DXF_SHEET_WIDTH, stacked=True)
    shifts = dict(zip(names, corners - low, strict=True))
    return np.array([shifts[block.piece.name] for block in blocks])


def rule_text(dialect: Dialect, sizes: tuple[str, ...], rules: list[np.ndarray], sample: str | None = None) -> str:
    """Return a rule table: the movement of a point from the sample size to every size, by rule.

    Args:
        dialect: The dialect of the reader.
        sizes: Names of the sizes, the smallest first.
        rules: Movements of each rule [m], shape [size_count, 2]; rule n + 1 is `rules[n]`.
        sample: Name of the sample size; None: the first.
    """
    unit = "ENGLISH" if dialect.is_inch else "METRIC"
    lines = [
        dialect.rule_version, f"AUTHOR: {AUTHOR}", "PRODUCT: garmentq", "VERSION: 1", "CREATION DATE:",
        "CREATION TIME:", f"UNITS: {unit}", "GRADE RULE TABLE: GARMENTQ", f"NUMBER OF SIZES: {len(sizes)}",
        f"SIZE LIST: {' '.join(sizes)}", f"SAMPLE SIZE: {sample or sizes[0]}",
    ]  # fmt: skip
    for number, moves in enumerate(rules, 1):
        lines.append(f"RULE: DELTA {number}")
        turned = _to_dialect_axes(moves, dialect)
        pairs = [f"{_number(x, dialect)}{dialect.separator}{_number(y, dialect)}" for x, y in turned]
        lines += ["  ".join(pairs[k : k + 4]) for k in range(0, len(pairs), 4)]
    return "\r\n".join([*lines, "END"]) + "\r\n"


def _draw(
    out: list[str], block: Block, pieces: PieceSet, dialect: Dialect, rules: list[tuple[np.ndarray, int]]
) -> None:
    """Append the entities of one piece."""
    piece = block.piece
    cut = piece.cut
    _outline(out, 1, cut.points, dialect)
    if any(edge.width for edge in piece.edges):
        _outline(out, dialect.sew_layer, flatten_outline(piece.net)[0], dialect)
    if dialect.has_validation:
        _outline(out, 84, cut.points, dialect)
    if dialect.marks_points:
        notched = {tuple(notch.point) for notch in piece.notches}
        for point, is_corner in zip(cut.points, cut.corner, strict=True):
            if is_corner or tuple(point) not in notched:
                _point(out, 2 if is_corner else 3, point, dialect)
        _sew_points(out, piece.net, dialect)
    for notch in piece.notches:
        layer = dialect.notch_layer
        if dialect.notch_is_line:
            _line(out, layer, np.array([notch.point, notch.point + notch.depth * notch.inward]), dialect)
            continue
        angle = np.degrees(np.arctan2(*_to_dialect_axes(notch.inward[None], dialect)[0][::-1])) % 360.0
        _point(out, layer, notch.point, dialect, notch.depth)
        _append_groups(out, (39, _number(NOTCH_WIDTH, dialect)), (50, f"{angle:.4f}"))
    if piece.fold is not None:
        number = piece.fold
        _line(out, 6, piece.net.points[[number, (number + 1) % len(piece.net.points)]], dialect)
    if piece.is_grain_known:
        _line(out, 7, piece.grain, dialect)
    for line in piece.darts:
        _polyline(out, 8, line, dialect, closed=False)
    for marked in piece.lines:
        _polyline(out, 8, marked.points, dialect, closed=False)
        x, y = marked.points.mean(axis=0)
        _text(out, dialect.text_layer, marked.name, (float(x), float(y)), dialect)
    for drill in piece.drills:
        _point(out, 13, drill, dialect, DRILL_HOLE_DIAMETER)
    middle = piece.grain.mean(axis=0)
    texts = {
        dialect.name_key: piece.name,
        dialect.size_key: block.size,
        "QUANTITY": f"{piece.quantity // 2},{piece.quantity // 2}" if piece.pair else f"{piece.quantity}",
        "MATERIAL": keep_ascii(pieces.fabric)[:20],
        "ANNOTATION": keep_ascii(pieces.size) if piece.is_grain_known else GRAIN_UNKNOWN_TEXT,
    }
    for n, (key, value) in enumerate(texts.items()):
        _text(out, dialect.text_layer, f"{key}: {value}", (middle[0] + 0.01, middle[1] - 0.01 * n), dialect)
    for point, number in rules:
        _text(out, 1, f"# {number}", (float(point[0]), float(point[1])), dialect)


def _sew_points(out: list[str], net: Panel, dialect: Dialect) -> None:
    """Append the turn and curve points of a sew line."""
    outline, edge = flatten_outline(net)
    for point, is_corner in zip(outline, edge != np.roll(edge, 1), strict=True):
        _point(out, 2 if is_corner else 3, point, dialect)


def _outline(out: list[str], layer: int, points: np.ndarray, dialect: Dialect) -> None:
    closed = dialect.closing == OutlineClosing.FLAG
    _polyline(out, layer, points if closed else np.concatenate([points, points[:1]]), dialect, closed)


def _polyline(out: list[str], layer: int, points: np.ndarray, dialect: Dialect, closed: bool) -> None:
    _append_groups(out, (0, "POLYLINE"), (8, layer), (66, 1), (70, int(closed)))
    for x, y in _to_dialect_axes(points, dialect):
        _append_groups(out, (0, "VERTEX"), (8, layer), (10, _number(x, dialect)), (20, _number(y, dialect)))
    _append_groups(out, (0, "SEQEND"))


def _line(out: list[str], layer: int, ends: np.ndarray, dialect: Dialect) -> None:
    (ax, ay), (bx, by) = _to_dialect_axes(ends, dialect)
    _append_groups(
        out, (0, "LINE"), (8, layer), (10, _number(ax, dialect)), (20, _number(ay, dialect)), (30, _number(0, dialect))
    )
    _append_groups(out, (11, _number(bx, dialect)), (21, _number(by, dialect)), (31, _number(0, dialect)))


def _point(out: list[str], layer: int, point: np.ndarray, dialect: Dialect, height: float = 0.0) -> None:
    ((x, y),) = _to_dialect_axes(point[None], dialect)
    _append_groups(out, (0, "POINT"), (8, layer), (10, _number(x, dialect)), (20, _number(y, dialect)))
    _append_groups(out, (30, _number(height, dialect)))


def _text(out: list[str], layer: int, text: str, place: tuple[float, float], dialect: Dialect) -> None:
    ((x, y),) = _to_dialect_axes(np.array([place]), dialect)
    _append_groups(out, (0, "TEXT"), (8, layer), (10, _number(x, dialect)), (20, _number(y, dialect)))
    _append_groups(out, (40, _number(0.005, dialect)), (1, text))


def _to_dialect_axes(points: np.ndarray, dialect: Dialect) -> np.ndarray:
    """Return points in the axes of the dialect: the warp, our +y, along y or x."""
    return points @ np.array([[0.0, -1.0], [1.0, 0.0]]) if dialect.grain_along_x else np.asarray(points)


def _number(metres: float, dialect: Dialect) -> str:
    """Return a length in the dialect's unit; never `-0.000`."""
    value = f"{metres / 0.0254:.4f}" if dialect.is_inch else f"{1e3 * metres:.3f}"
    return value.removeprefix("-") if float(value) == 0.0 else value


def _append_groups(out: list[str], *pairs: tuple[int, object]) -> None:
    out += [f"{code:>3}\r\n{value}\r\n" for code, value in pairs]
