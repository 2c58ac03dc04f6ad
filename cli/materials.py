"""`garmentq materials`."""

from __future__ import annotations

from dataclasses import asdict

import click

from .options import json_option


@click.command("materials")
@click.argument("name", required=False)
@json_option
def command(name: str | None, as_json: bool) -> None:
    """List the fabrics of the library.

    With a name: all its parameters in SI units, and where each of them comes from.

    \b
    Example:
      garmentq materials
      garmentq materials denim --json
    """
    from ..core.simulate import get_fabric, load_fabrics
    from .terminal import print_json, print_table

    fabrics = (get_fabric(name),) if name else load_fabrics()
    if as_json:
        for fabric in fabrics:
            print_json({**asdict(fabric), "sources": dict(fabric.sources)})
        return
    print_table(
        ["name", "title", "g/m2", "H00 N/m", "H01 N/m", "H11 N/m", "H22 N/m", "k N m", "thickness m", "friction"],
        [
            [f.name, f.title, f.density * 1000, f.H00, f.H01, f.H11, f.H22, f.k, f.thickness, f.friction]
            for f in fabrics
        ],
    )
    if name:
        print_table(["parameter", "where its value comes from"], fabrics[0].sources)
