"""Write PDF files: pages of lines and Helvetica, with equal bytes for equal content."""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from dataclasses import dataclass

MM_PER_POINT = 25.4 / 72.0
"""Length of a typographic point, 1/72 inch [mm]."""

MAX_PAGE_SIDE_UNITS = 14400.0
"""Longest side of a page [the page's own units] (PDF 1.7, annex C); a longer page has larger units."""


@dataclass(frozen=True)
class Page:
    """Describe one page: its size [mm], and drawing operators in millimetres from its lower left corner."""

    width: float
    height: float
    content: str


def pdf_bytes(pages: list[Page], title: str, drawing: str = "", layers: Sequence[str] = ()) -> bytes:
    """Return a PDF file that asks the viewer not to scale when it prints.

    Args:
        pages: The pages.
        title: Title of the document, in ASCII.
        drawing: Drawing operators in millimetres that each page may place by `/Drawing Do`, stored once.
        layers: Names of layers that a viewer shows or hides (optional content, PDF 1.7, 8.11); what is between
            `/OC /S2 BDC` and `EMC` is on the third.
    """
    count = len(pages)
    first = 7 + 2 * count
    groups = " ".join(f"{first + k} 0 R" for k in range(len(layers)))
    shown = f" /OCProperties << /OCGs [{groups}] /D << /Order [{groups}] /ON [{groups}] >> >>" if layers else ""
    named = " ".join(f"/S{k} {first + k} 0 R" for k in range(len(layers)))
    kids = " ".join(f"{7 + 2 * n} 0 R" for n in range(count))
    box = "[-100000 -100000 100000 100000]"
    properties = f" /Properties << {named} >>" if layers else ""
    resources = f"<< /Font << /F 3 0 R /B 4 0 R >> /XObject << /Drawing 6 0 R >>{properties} >>"
    objects = [
        f"<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >>{shown} >>".encode(),
        f"<< /Type /Pages /Kids [{kids}] /Count {count} >>".encode(),
        _font("Helvetica"),
        _font("Helvetica-Bold"),
        f"<< /Title {_string(title)} /Producer (garmentq) >>".encode(),
        _stream(drawing, f"/Type /XObject /Subtype /Form /BBox {box} /Resources << /Font << /F 3 0 R /B 4 0 R >> >>"),
    ]
    for n, page in enumerate(pages):
        unit = max(
            1.0, page.width / MM_PER_POINT / MAX_PAGE_SIDE_UNITS, page.height / MM_PER_POINT / MAX_PAGE_SIDE_UNITS
        )
        size = f"{page.width / MM_PER_POINT / unit:.4f} {page.height / MM_PER_POINT / unit:.4f}"
        units = f" /UserUnit {unit:.6f}" if unit > 1.0 else ""
        scale = 1.0 / MM_PER_POINT / unit
        objects.append(
            f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {size}]{units} /Resources {resources} "
            f"/Contents {8 + 2 * n} 0 R >>".encode()
        )
        objects.append(_stream(f"{scale:.8f} 0 0 {scale:.8f} 0 0 cm\n{page.content}"))
    objects += [f"<< /Type /OCG /Name {_string(name)} >>".encode() for name in layers]
    return _assemble(objects)


def show_text(x: float, y: float, size: float, text: str, bold: bool = False) -> str:
    """Return the operators that write a line of text from a point on its base line [mm]."""
    return f"BT /{'B' if bold else 'F'} {size:.3f} Tf {x:.3f} {y:.3f} Td {_string(text)} Tj ET\n"


def _font(name: str) -> bytes:
    return f"<< /Type /Font /Subtype /Type1 /BaseFont /{name} /Encoding /WinAnsiEncoding >>".encode()


def _string(text: str) -> str:
    """Return a PDF string of Windows-1252 letters, those beyond ASCII as octal codes; others become `?`."""
    plain = "".join(letter if letter.isprintable() else "?" for letter in text).encode("cp1252", "replace")
    escaped = plain.replace(b"\\", rb"\\").replace(b"(", rb"\(").replace(b")", rb"\)")
    return "(" + "".join(chr(code) if code < 127 else f"\\{code:03o}" for code in escaped) + ")"


def _stream(content: str, more: str = "") -> bytes:
    packed = zlib.compress(content.encode("ascii"), 9)
    head = f"<< {more} /Length {len(packed)} /Filter /FlateDecode >>\nstream\n"
    return head.encode() + packed + b"\nendstream"


def _assemble(objects: list[bytes]) -> bytes:
    parts, starts, at = [b"%PDF-1.6\n%\xe2\xe3\xcf\xd3\n"], [], 15
    for number, body in enumerate(objects, 1):
        whole = b"%d 0 obj\n%s\nendobj\n" % (number, body)
        starts.append(at)
        parts.append(whole)
        at += len(whole)
    table = "".join(f"{start:010d} 00000 n \n" for start in starts)
    tail = (
        f"xref\n0 {len(objects) + 1}\n0000000000 65535 f \n{table}"
        f"trailer\n<< /Size {len(objects) + 1} /Root 1 0 R /Info 5 0 R >>\nstartxref\n{at}\n%%EOF\n"
    )
    return b"".join([*parts, tail.encode()])
