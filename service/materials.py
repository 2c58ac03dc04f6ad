"""The fabric library of a home: shipped fabrics, and those that a user imported."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from sqlalchemy import select

from ..core.run.errors import BadInput
from .catalogue import read_fabric, show_fabric
from .database import Database, clock, skip_damaged_rows
from .models import FabricRow

if TYPE_CHECKING:
    from ..core.cloth.fabric import Fabric


class FabricShipped(BadInput):
    """A shipped fabric cannot be replaced or deleted; choose another name."""

    code = "fabric.shipped"


def import_materials(database: Database, path: Path) -> list[Fabric]:
    """Store the fabrics of a file, all or none; imported fabrics of the same names are replaced.

    Raises:
        FabricFileBad, FabricUnitBad: if the file cannot be read.
        FabricNameBad, FabricSourceBad, FabricOutOfRange: as `check_fabric` says.
        FabricShipped: if one has a shipped fabric's name.
    """
    from ..core.cloth.fabric_file import read_fabrics

    fabrics = read_fabrics(path)
    keep_materials(database, fabrics)
    return fabrics


def keep_materials(database: Database, fabrics: list[Fabric]) -> None:
    """Store fabrics that were checked, in one transaction.

    Raises:
        FabricShipped: if one has a shipped fabric's name.
    """
    for fabric in fabrics:
        refuse_shipped(fabric.name)
    with database.write() as session:
        for fabric in fabrics:
            session.merge(FabricRow(name=fabric.name, fabric=show_fabric(fabric), created=clock()))


@skip_damaged_rows
def list_materials(database: Database) -> list[Fabric]:
    """Return shipped and imported fabrics, each kind by name."""
    from ..core.cloth.fabrics import load_fabrics

    with database.read() as session:
        rows = session.scalars(select(FabricRow).order_by(FabricRow.name)).all()
    return [*load_fabrics(), *(read_fabric(row.fabric) for row in rows)]


def read_material(database: Database, name: str) -> Fabric:
    """Return a shipped or an imported fabric.

    Raises:
        FabricUnknown: if there is none of that name; the message lists the known ones.
    """
    from ..core.cloth.fabrics import FabricUnknown

    fabrics = list_materials(database)
    for fabric in fabrics:
        if fabric.name == name:
            return fabric
    known = ", ".join(fabric.name for fabric in fabrics)
    raise FabricUnknown(f"no fabric '{name[:64]}' in the library; there are: {known}.")


def resolve_fabric(database: Database, name: str | Fabric | None) -> str | Fabric | None:
    """Return a fabric as a job's request has it: a shipped one's name, an imported one itself.

    A request with the numbers stays the same job if its fabric is renamed or changed later.

    Raises:
        FabricUnknown: if there is none of that name.
    """
    if not isinstance(name, str) or is_shipped(name):
        return name
    return read_material(database, name)


def delete_material(database: Database, name: str) -> Fabric:
    """Delete an imported fabric and return it; jobs that use it keep its numbers.

    Raises:
        FabricShipped: if it is a shipped one.
        FabricUnknown: if there is none of that name.
    """
    refuse_shipped(name)
    deleted = read_material(database, name)
    with database.write() as session:
        row = session.get(FabricRow, name)
        if row is not None:
            session.delete(row)
    return deleted


def is_shipped(name: str) -> bool:
    """Return whether a shipped fabric has the name."""
    from ..core.cloth.fabrics import load_fabrics

    return name in [fabric.name for fabric in load_fabrics()]


def refuse_shipped(name: str) -> None:
    """Refuse the name of a shipped fabric.

    Raises:
        FabricShipped: if it is one.
    """
    if is_shipped(name):
        raise FabricShipped(f"'{name}' is a shipped fabric, which cannot be replaced or deleted; choose another name.")
