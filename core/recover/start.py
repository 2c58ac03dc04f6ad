"""Read the inputs of a recovery: files, wearer, named contours and base pattern."""

from __future__ import annotations

from dataclasses import replace

from ..body.body import Body
from ..cloth.fabrics import get_fabric
from ..garment.creases import turned_area
from ..garment.parts.cut import PartsConflict
from ..garment.parts.wraps import WRAP_LABEL
from ..garment.pattern import Pattern
from ..garment.templates import draft_template, find_cut, load_template, name_cut
from ..run.clock import Clock
from ..scan.contours.body_mismatch import check_own_body
from ..scan.contours.garment import segment_garment
from ..scan.contours.rounded_rims import straighten_scan
from ..scan.contours.target import CATEGORIES, Target
from ..scan.contours.turned import free_covered_neck
from .case import Case
from .drape.sizing import oversize_measures
from .drape.wearer import WearerGeometry
from .fit.locks import find_locked_coordinates
from .grade.choice import Choice, choose_cut, describe_absent
from .grade.hem_corners import share_by_hems
from .grade.neck_finish import ShownSides
from .inputs import read_files, read_template
from .recovery import Request
from .settings import SettingsBad
from .state import RecoveryState
from .wearer import find_wearer


def read_case(request: Request, clock: Clock) -> Case:
    """Read the files, find the wearer and name the garment's contours.

    Raises:
        BodyMismatch: where the garment was not scanned on the body of the file.
    """
    with clock.stage("scan", "reading the scan"):
        pieces = read_files(request)
    with clock.stage("body", "finding the wearer's joints") as hooks:
        found = find_wearer(request, pieces, hooks)
    with clock.stage("segment", "naming the open contours"):
        scan = straighten_scan(pieces.garment)
        check_own_body(scan.vertices, found.body)
        target = segment_garment(scan, found.body)
        category = request.settings.garment or (None if request.reading is None else request.reading.category)
        if category is not None:
            target = replace(target, category=check_category(category))
    return Case(request, scan, target, WearerGeometry(found.body), found.undeclared)


def choose_base(case: Case) -> RecoveryState:
    """Return the state before the first step: the base pattern, and wearer and cloth as given.

    Raises:
        LockUnknown: where a lock names nothing of the base pattern; checked here, before the costly steps.
    """
    settings = case.settings
    choice = find_template(case.request, case.scan_target, case.body)
    base = replace(choice.pattern, symmetric=settings.free != "symmetry")
    find_locked_coordinates(base, base, settings.locks)
    target = free_wrapped_neck(free_covered_neck(case.scan_target, case.body, turned_area(base)), base)
    state = RecoveryState(choice.template, base, target, case.wearer, get_fabric(settings.fabric))
    found = (*(one.describe() for one in choice.candidates), *(one.describe() for one in choice.openings))
    return state.with_findings(*found).with_notes(*choice.notes)


def free_wrapped_neck(target: Target, pattern: Pattern) -> Target:
    """Return a target whose neck is not trusted where its pattern is wrapped: the pattern's front edges go on below the
    point of the V, where those of the seen neckline end."""
    if all(panel.label != WRAP_LABEL for panel in pattern.panels):
        return target
    return target.distrust("neck")


def find_template(request: Request, target: Target, body: Body) -> Choice:
    """Return the base pattern: the given file, the named template with the chosen parts, or what the scan shows.

    A library pattern is split between front and back as the scan's hems show (`share_by_hems`). Choices for all of a
    person's garments are left out, and noted, where one has no place for them.

    Raises:
        PartsConflict: where parts are chosen for a pattern file, the garment has no place for one, or they cannot be
            sewn to each other.
    """
    template, settings = read_template(request), request.settings
    chosen_parts = settings.chosen_parts
    of_person = request.reading is not None and request.reading.category is not None
    if request.template is not None and template is not None:
        if settings.parts is not None:
            raise PartsConflict(f"the parts of a pattern file are drawn in it; leave out '{settings.parts}'.")
        return Choice(request.template.stem, template)
    if settings.template is None:
        sides = ShownSides.OUTSIDE if of_person else ShownSides.BOTH
        choice = choose_cut(target, body, chosen_parts, sides)
        if not of_person:
            find_cut(choice.template).check_places(chosen_parts)
    else:
        named = find_cut(settings.template)
        cut = named.choose(chosen_parts)
        notes = describe_absent(cut, chosen_parts)
        if of_person:
            cut = named.choose({part: word for part, word in chosen_parts.items() if cut.has_place_for(part)})
        name, measures = name_cut(settings.template.partition("+")[0], cut), oversize_measures(body)
        pattern = load_template(name) if measures is None else draft_template(name, measures)
        choice = Choice(name, pattern, notes=notes)
    pattern, shares = share_by_hems(choice.pattern, target, body)
    return replace(choice, pattern=pattern, notes=(*choice.notes, *(share.describe() for share in shares)))


def check_category(name: str) -> str:
    """Return a category's name unchanged if it exists.

    Raises:
        SettingsBad: where it does not.
    """
    if name not in CATEGORIES:
        raise SettingsBad(f"garment '{name}' is not one of {', '.join(CATEGORIES)}.")
    return name
