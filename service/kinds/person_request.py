"""The request of segmenting a person; the module is light, as the limited process that reads its files imports it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from ...core.cloth.fabric import Fabric
from ...core.people.part import GARMENTS
from ...core.recover.settings import RecoverySettings
from ...core.run.errors import BadInput
from .recover_request import RecoverRequest
from .request import BuiltinText, FileRef, RequestBad

PERSON_INPUT_FILE = "given.npz"
"""File with the arrays of the files that were read, beside their folders."""

WORDS = tuple(part.word for part in GARMENTS)
"""The garments by the words of options and folders."""


class ChoiceAmbiguous(BadInput):
    """Several garments are worn, and the option names none of them; put the part in front: --template upper:FILE."""

    code = "person.choice_ambiguous"


@dataclass(frozen=True)
class PartChoice:
    """Describe how one garment of a person is recovered; None stands for the choice for all garments.

    Attributes:
        template: A pattern file, a shipped template's name, or None.
        garment: Category that overrides the detected one, or None.
        fabric: Name of a shipped fabric, an imported fabric itself, or None.
        lock: Parameters that the fit must not change, separated by commas, or None.
        parts: Choices of parts of the cut, `neckline=v`, or None. A stored request omits it if it is None: equal orders
            of releases without this field are the same job.
    """

    template: FileRef | str | None = None
    garment: str | None = None
    fabric: str | Fabric | None = None
    lock: str | None = None
    parts: str | None = field(default=None, metadata={"is_left_out": True})


@dataclass(frozen=True)
class PersonRequest:
    """Describe the segmentation of a person and the recovery of each garment.

    Attributes:
        scan: The person's file.
        settings: Settings of all recoveries; `template`, `garment`, `fabric` and `lock` apply to the one garment that
            has no choice of its own.
        labels: A label file with `names`, which overrides the labelling, or None.
        body: The wearer's file, a built-in body, or None: estimated under the clothes.
        template: A pattern file for the one garment that has no choice of its own, or None.
        wearing: Exactly these garments, `upper,lower`, or None.
        marks: Parts of single points, `upper=0.1,1.2,0.05` each.
        choices: Choices for single garments, by their words.
        given_as: `person` if the user says that the scan is one.
    """

    scan: FileRef
    settings: RecoverySettings = field(default_factory=RecoverySettings)
    labels: FileRef | None = None
    body: FileRef | BuiltinText | None = None
    template: FileRef | None = None
    wearing: str | None = None
    marks: tuple[str, ...] = ()
    choices: Mapping[str, PartChoice] = field(default_factory=dict)
    given_as: str | None = None

    def __post_init__(self) -> None:
        """Refuse choices for unknown garments.

        Raises:
            RequestBad: if there is one.
        """
        if not set(self.choices) <= set(WORDS):
            raise RequestBad(f"choices are of {', '.join(WORDS)}; {RequestBad().message}")

    @property
    def templates(self) -> dict[str, FileRef]:
        """Return the pattern files by garment; that for all garments has an empty name."""
        found = {word: choice.template for word, choice in self.choices.items()}
        return {word: file for word, file in {"": self.template, **found}.items() if isinstance(file, FileRef)}

    def place(self, word: str) -> str:
        """Return the place of a garment's pattern file, as `find_files` returns it."""
        return f"choices/{word}/template" if word else "template"

    def choose(self, words: Sequence[str]) -> dict[str, PartChoice]:
        """Return the choices for each garment that was found.

        Raises:
            ChoiceAmbiguous: if an option names no garment, and two could be meant.
        """
        plain = self._plain()
        found = {word: self.choices.get(word, PartChoice()) for word in words}
        for name, value in plain.items():
            open_words = [word for word in words if getattr(found[word], name) is None]
            if value is None or not open_words:
                continue
            if len(open_words) > 1 and not (name == "lock" and _is_common(str(value))):
                shown = value.name if isinstance(value, FileRef | Fabric) else value
                raise ChoiceAmbiguous(
                    f"--{name} {shown}: {' and '.join(open_words)} are worn; name the part, as in "
                    f"--{name} {open_words[0]}:{shown}."
                )
            for word in open_words:
                found[word] = replace(found[word], **{name: value})  # type: ignore[arg-type]
        return found

    def _plain(self) -> dict[str, FileRef | Fabric | str | None]:
        """Return the choices that name no part."""
        chosen = self.settings
        template = self.template or chosen.template
        return {"template": template, "garment": chosen.garment, "fabric": chosen.fabric, "lock": chosen.lock}

    def make_recovery(self, word: str, choice: PartChoice) -> RecoverRequest:
        """Return the request of a garment's recovery; a pattern file is in its reading."""
        template = choice.template.name.rpartition(".")[0] if isinstance(choice.template, FileRef) else choice.template
        settings = replace(
            self.settings, template=template, garment=choice.garment, fabric=choice.fabric,
            lock=choice.lock, parts=self.settings.overrule_parts(choice.parts), keep=None, keep_colour=None, cloth=None,
            labels_key=None,
        )  # fmt: skip
        return RecoverRequest(None, None, None, settings, part=word)


def _is_common(lock: str) -> bool:
    """Return whether locks mean the same for every garment."""
    return all(word.strip() in ("fabric", "symmetry") for word in lock.split(","))


def make_person(request: RecoverRequest) -> PersonRequest:
    """Return a person's request for the scan of a recovery that turned out to be a person's.

    Raises:
        RequestBad: if there is no scan.
    """
    if request.scan is None:
        raise RequestBad()
    return PersonRequest(request.scan, request.settings, request.labels, request.body, request.template)
