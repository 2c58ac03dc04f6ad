"""What a seed draws: who wears what, of which cloth, in which pose, and how he is scanned."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from foreign_drapes import Cloth
from garmentq.training.designs import OUTER_FINISHES, draw_word

REVISION = 2
"""Counts up where the same seed gives other targets."""

SINGLE = {
    "tshirt": 0.2, "long_sleeve_tshirt": 0.15, "tank": 0.1, "dress": 0.2, "skirt": 0.15, "trousers": 0.12,
    "shorts": 0.08,
}  # fmt: skip
"""Categories of garments scanned alone, and how often each is drawn."""

UPPERS = {"tshirt": 0.45, "long_sleeve_tshirt": 0.4, "tank": 0.15}
LOWERS = {"trousers": 0.55, "skirt": 0.25, "shorts": 0.2}
ONE_PIECES = {"dress": 0.85, "jumpsuit": 0.15}

ONE_PIECE, TUCKED = 0.25, 0.3
"""Share of persons in one garment, and of the others who wear the upper one inside the lower."""

POSES = {"A": 0.5, "arms-down": 0.3, "T": 0.1, "stride": 0.1}
"""Poses that scanning protocols ask for."""

MASSES, STIFFNESSES, BENDINGS = (0.15, 0.6), (80.0, 320.0), (0.1, 4.0)
"""Between which a cloth is drawn, in Blender's units, by ratios: four times its default's either way for bending."""

NOISES = (0.2e-3, 1.5e-3)
"""Standard deviation of a scan's noise [m], by ratios: structured light to a telephone's depth camera."""

HOLES, HOLE_RADII = 5, (0.01, 0.04)
"""Most holes of a scan, less one, and their radii [m]: what hands, props and steep views leave open."""

GARMENTCODE = 0.5
"""Share of the drafts that are GarmentCode's where its programs are given."""

FINISHES = (
    ("long_sleeve_tshirt", "own", "collar=shirt,front=buttons"),
    ("long_sleeve_tshirt", "own", "collar=shirt,front=open"),
    ("tshirt", "own", "collar=polo,front=placket"),
    ("long_sleeve_tshirt", "garmentcode", "collar=turtleneck"),
    ("long_sleeve_tshirt", "own", "collar=notched,front=buttons"),
    ("tshirt", "garmentcode", ""),
    ("long_sleeve_tshirt", "own", "collar=shawl,front=open"),
    ("long_sleeve_tshirt", "own", "collar=stand,front=zip"),
    ("tshirt", "garmentcode", "collar=turtleneck"),
    ("long_sleeve_tshirt", "own", "hood=two,hood_worn=down,front=zip"),
    ("long_sleeve_tshirt", "garmentcode", "hood=two,hood_worn=up"),
    ("long_sleeve_tshirt", "garmentcode", ""),
)  # fmt: skip
"""Category, program and parts of finished tops, one for a garment and one for a person in turn: eleven kinds of fronts,
collars and hoods, and two tops with none."""


INNER_FINISHES = {
    "": 0.6,
    "collar=shirt,front=buttons": 0.2,
    "collar=polo,front=placket": 0.1,
    "collar=turtleneck": 0.1,
}
"""Parts of a top below an outer layer, and how often each is drawn; a tank has none."""


@dataclass(frozen=True)
class Draft:
    """Describe a garment to draft.

    Attributes:
        category: What it is.
        program: `own` parts or `garmentcode`.
        seed: Of its design.
        role: As raw packs call it: `upper`, `lower`, `onepiece`, `outer`.
        parts: Of its front, collar and hood, `front=zip,collar=stand`; empty: those of the shipped cuts.
    """

    category: str
    program: str
    seed: int
    role: str
    parts: str = ""


@dataclass(frozen=True)
class Target:
    """Describe a target.

    Attributes:
        name: Of its folder.
        is_person: Whether all of the person is scanned, without labels; otherwise one garment, its wearer known.
        seed: Of the wearer, and of what is drawn while it is made.
        drafts: What is worn, the innermost first.
        pose: Of the scan.
        cloth: What each draft is made of.
        solver: Who drapes it: `blender` or `newton`.
        noise: Standard deviation of the scan's points [m].
        holes: Radii [m].
    """

    name: str
    is_person: bool
    seed: int
    drafts: tuple[Draft, ...]
    pose: str
    cloth: tuple[Cloth, ...]
    solver: str
    noise: float
    holes: tuple[float, ...]


def draw_targets(seed: int, count: int, programs: tuple[str, ...], solvers: tuple[str, ...]) -> tuple[Target, ...]:
    """Return the targets of a seed, a garment and a person in turn; the first ones are the same for every count.

    Args:
        seed: Any number.
        count: Of targets.
        programs: Who can draft: `own`, and `garmentcode` where it is there.
        solvers: Who can drape: `blender`, `newton`.
    """
    return tuple(draw_target(seed, index, programs, solvers) for index in range(count))


def draw_target(seed: int, index: int, programs: tuple[str, ...], solvers: tuple[str, ...], attempt: int = 0) -> Target:
    """Return one target of a seed, as `draw_targets`; the next attempt is another one of the same kind.

    Args:
        seed: Any number.
        index: Of the target; odd ones are persons.
        programs: Who can draft.
        solvers: Who can drape.
        attempt: How many before could not be made.
    """
    rng = np.random.default_rng([REVISION, seed, index, attempt])
    is_person = index % 2 == 1
    wanted = _draw_outfit(rng) if is_person else (("onepiece", _choose(SINGLE, rng)),)
    drafts = []
    for role, category in wanted:
        foreign = rng.random() < GARMENTCODE
        program = "garmentcode" if foreign and "garmentcode" in programs else "own"
        drafts.append(Draft(category, program, int(rng.integers(1, 2**20)), role))
    pose = _choose(POSES, rng)
    cloth = tuple(Cloth(*(_between(ends, rng) for ends in (MASSES, STIFFNESSES, BENDINGS))) for _ in drafts)
    solver = str(rng.choice(["blender", "newton"]))
    noise = _between(NOISES, rng)
    holes = tuple(rng.uniform(*HOLE_RADII, int(rng.integers(HOLES))).tolist())
    words = "_".join(draft.category for draft in drafts)
    name = f"{'person' if is_person else 'garment'}_{seed}_{index:02d}_{words}"
    solver = solver if solver in solvers else solvers[0]
    return Target(
        name, is_person, 10_000 * seed + 100 * attempt + index, tuple(drafts), pose, cloth, solver, noise, holes
    )


def finish(target: Target) -> Target:
    """Return a target whose top is one of `FINISHES`, by the index at its name's end; a person wears it over a lower
    garment.

    Args:
        target: Of `draw_target`.
    """
    index = target.seed % 100
    category, program, parts = FINISHES[index // 2 % len(FINISHES)]
    top = Draft(category, program, target.seed, "upper", parts)
    if not target.is_person:
        name = f"garment_{target.seed}_{category}"
        return replace(target, name=name, drafts=(replace(top, role="onepiece"),), cloth=target.cloth[:1])
    lower = next((draft for draft in target.drafts if draft.role == "lower"), None)
    rng = np.random.default_rng([REVISION, target.seed])
    lower = lower or Draft(_choose(LOWERS, rng), "own", int(rng.integers(1, 2**20)), "lower")
    cloth = (*target.cloth, *target.cloth)[:2]
    return replace(target, name=f"person_{target.seed}_{category}", drafts=(lower, top), cloth=cloth)


def draw_layered(seed: int, index: int, solver: str, attempt: int = 0) -> Target:
    """Return a person in two or three layers; the outer one is open where the index is even.

    Args:
        seed: Any number.
        index: Of the target.
        solver: Who drapes.
        attempt: How many before could not be made.
    """
    rng = np.random.default_rng([REVISION, seed, index, attempt])
    finishes = {
        word: share for word, share in OUTER_FINISHES.items() if ("front=open" in word) == (index % 2 == 0)
    }  # fmt: skip
    drafts = []
    for role, category in _draw_outfit(rng):
        parts = draw_word(INNER_FINISHES, rng) if role == "upper" and category != "tank" else ""
        drafts.append(Draft(category, "own", int(rng.integers(1, 2**20)), role, parts))
    parts = draw_word(finishes, rng).replace("hood", "hood=two,hood_worn=down")
    drafts.append(Draft("long_sleeve_tshirt", "own", int(rng.integers(1, 2**20)), "outer", parts))
    pose = _choose(POSES, rng)
    cloth = tuple(Cloth(*(_between(ends, rng) for ends in (MASSES, STIFFNESSES, BENDINGS))) for _ in drafts)
    noise, holes = _between(NOISES, rng), tuple(rng.uniform(*HOLE_RADII, int(rng.integers(HOLES))).tolist())
    words = "_".join(draft.category if draft.role != "outer" else "outer" for draft in drafts)
    name = f"layered_{seed}_{index:02d}_{words}"
    return Target(name, True, 10_000 * seed + 100 * attempt + index, tuple(drafts), pose, cloth, solver, noise, holes)


def _draw_outfit(rng: np.random.Generator) -> tuple[tuple[str, str], ...]:
    """Return role and category of what a person wears, the innermost first."""
    if rng.random() < ONE_PIECE:
        return (("onepiece", _choose(ONE_PIECES, rng)),)
    pair = ("upper", _choose(UPPERS, rng)), ("lower", _choose(LOWERS, rng))
    return pair if rng.random() < TUCKED else pair[::-1]


def _choose(shares: dict[str, float], rng: np.random.Generator) -> str:
    names, weights = zip(*shares.items(), strict=True)
    return str(rng.choice(names, p=np.array(weights) / sum(weights)))


def _between(ends: tuple[float, float], rng: np.random.Generator) -> float:
    return float(np.exp(rng.uniform(*np.log(ends))))
