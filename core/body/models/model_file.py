"""Read a body from the file of a body model, whichever it is: SMPL, SMPL-X, Anny, MHR or SOMA."""

from __future__ import annotations

from pathlib import Path

from ..body import Body
from ..model_arrays import BodyModelBad, list_arrays
from ..smpl import SmplBad, load_smpl
from .anny import PHENOTYPES
from .anny_file import load_anny
from .mhr import MHR_PERSON_ARRAYS, SAM_NAMES, load_mhr
from .soma import load_soma

PERSON_ARRAYS = frozenset(("identity_model_type", *MHR_PERSON_ARRAYS, *SAM_NAMES))
"""Names of arrays of persons by MHR and SOMA, which mean nothing without their model's."""


def load_body_model(path: Path) -> Body:
    """Read a body with its model's own skeleton. JSON has Anny's parameters; an `.npz` is known by its arrays' names.

    Raises:
        BadInput: where it is none of the models, with a code of its kind.
    """
    path = Path(path)
    if path.suffix.lower() == ".json":
        return load_anny(path)
    names = list_arrays(path, SmplBad)
    if "bind_shape" in names:
        return load_soma(path)
    if "base_shape" in names:
        return load_mhr(path)
    if names & PERSON_ARRAYS and "v_template" not in names:
        raise BodyModelBad(f"{path.name} has a person's parameters without the model's arrays; save both in one file.")
    return load_anny(path) if names & set(PHENOTYPES) else load_smpl(path)
