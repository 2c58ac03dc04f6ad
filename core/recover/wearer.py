"""Find the wearer of a request: a body file, a built-in body, or the person in the scan."""

from __future__ import annotations

from ..body.body import Body
from ..body.builtin import BodyMissing, builtin_body
from ..body.spec import BuiltinWearer
from ..people.wearer import FoundWearer, fit_wearer
from ..run.checkpoints import load, save
from ..run.hooks import Hooks
from ..scan.pieces import ScanInput
from .inputs import read_body
from .recovery import Request


def find_body(request: Request, pieces: ScanInput, hooks: Hooks) -> Body:
    """Return the body that `find_wearer` finds."""
    return find_wearer(request, pieces, hooks).body


def find_wearer(request: Request, pieces: ScanInput, hooks: Hooks) -> FoundWearer:
    """Register the given mesh or the dressed person, read a body of SMPL's format, or make the built-in body."""
    read, wearer = read_body(request), pieces.wearer
    if read is not None:
        return FoundWearer(read)
    if isinstance(request.body, BuiltinWearer):
        return FoundWearer(builtin_body(request.body))
    if wearer is None:
        raise BodyMissing()
    found = load(hooks, "body", FoundWearer)
    if found is None:
        found = fit_wearer(wearer, pieces.cloth, hooks, pieces.labels)
        save(hooks, "body", found)
    return found
