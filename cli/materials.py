"""`garmentq materials`."""

from __future__ import annotations

import click

from .options import json_option

PARAMETERS = ("H00", "H01", "H11", "H22", "k", "thickness", "friction")


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
    from ..service.backend import open_backend
    from ..service.catalogue import show_fabric
    from ..service.settings import read_settings
    from .terminal import print_json, print_table

    backend = open_backend(read_settings())
    fabrics = [backend.read_material(name)] if name else backend.list_materials()
    if as_json:
        for fabric in fabrics:
            print_json(show_fabric(fabric))
        return
    print_table(
        ["name", "title", "g/m2", "H00 N/m", "H01 N/m", "H11 N/m", "H22 N/m", "k N m", "thickness m", "friction"],
        [[f.name, f.title, f.density * 1000, *(getattr(f, n) for n in PARAMETERS)] for f in fabrics],
    )
    if name:
        print_table(["parameter", "where its value comes from"], list(fabrics[0].sources))
