"""Read a body from the file of a body model, whichever it is: SMPL, SMPL-X or Anny."""

from __future__ import annotations

from pathlib import Path

from ..body import Body
from ..model_arrays import list_arrays
from ..smpl import SmplBad, load_smpl
from .anny import PHENOTYPES
from .anny_file import load_anny


def load_body_model(path: Path) -> Body:
    """Read a body with its model's own skeleton. JSON has Anny's parameters; an `.npz` is known by its arrays' names.

    Raises:
        BadInput: where it is none of the models, with a code of its kind.
    """
    path = Path(path)
    if path.suffix.lower() == ".json":
        return load_anny(path)
    names = list_arrays(path, SmplBad)
    return load_anny(path) if names & set(PHENOTYPES) else load_smpl(path)
