"""A motion of a plain skeleton, and its variants as other programs would write them to BVH files."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial.transform import Rotation

TRUNK = ("pelvis", "spine", "chest", "neck", "head")
LIMBS = ("collar", "shoulder", "elbow", "wrist", "hip", "knee", "ankle", "toe")

FRAMES = 9

TO_Z_UP = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
"""From y up, facing +z, to z up, facing -y."""


@dataclass(frozen=True)
class Node:
    """Describe a joint: its parent's role, its offset [cm], its turns against its parent [n, 3, 3], and its own place
    in each pose [n, 3] where it has position channels."""

    parent: str
    offset: np.ndarray
    turns: np.ndarray
    move: np.ndarray | None = None


Model = dict[str, Node]
"""Joints by role, each after its parent."""


def make_reference(seed: int = 5) -> Model:
    """Return somebody who walks a curve, bends, turns and lifts arms: every joint turns in every pose."""
    random, model = np.random.default_rng(seed), {}
    time = np.linspace(0.0, 1.0, FRAMES)

    def turns(size: float) -> np.ndarray:
        waves = np.sin(2 * np.pi * (time[:, None] * random.uniform(0.3, 1.0, 3) + random.uniform(0, 1, 3)))
        return Rotation.from_euler("zxy", size * waves * [0.7, 1.0, 0.8], degrees=True).as_matrix()

    def add(role: str, parent: str, offset: tuple[float, float, float], size: float) -> None:
        model[role] = Node(parent, np.array(offset), turns(size))

    add("pelvis", "", (0, 0, 0), 20)
    way = np.stack([60 * time, 92 + 3 * np.sin(9 * time), 90 * time**2], axis=1)
    model["pelvis"] = replace(model["pelvis"], move=way)
    add("spine", "pelvis", (0, 10, 0), 15)
    add("chest", "spine", (0, 20, 0), 15)
    add("neck", "chest", (0, 22, 0), 15)
    add("head", "neck", (0, 10, 0), 20)
    for side, x in (("left", 1.0), ("right", -1.0)):
        add(f"{side} collar", "chest", (3 * x, 18, 0), 8)
        add(f"{side} shoulder", f"{side} collar", (14 * x, 0, 0), 50)
        add(f"{side} elbow", f"{side} shoulder", (28 * x, 0, 0), 50)
        add(f"{side} wrist", f"{side} elbow", (25 * x, 0, 0), 25)
        add(f"{side} hip", "pelvis", (9 * x, -4, 0), 35)
        add(f"{side} knee", f"{side} hip", (0, -42, 0), 40)
        add(f"{side} ankle", f"{side} knee", (0, -41, 0), 15)
        add(f"{side} toe", f"{side} ankle", (0, -5, 13), 10)
    return model


def still() -> np.ndarray:
    """Return turns of a joint that does not."""
    return np.tile(np.eye(3), (FRAMES, 1, 1))


def insert(model: Model, role: str, end: str, new: str, turns: np.ndarray, kept: np.ndarray | None = None) -> Model:
    """Return a model with a new joint halfway between a joint and the next; the first one's turns become `kept`."""
    found: Model = {}
    for name, node in model.items():
        if name == role and kept is not None:
            node = replace(node, turns=kept)
        if node.parent == role and name != end and role in TRUNK and end in TRUNK:
            found[name] = node  # legs stay on the pelvis, arms on the chest
            continue
        if name == end:
            found[new] = Node(role, node.offset / 2, turns)
            node = replace(node, parent=new, offset=node.offset / 2)
        found[name] = node
    return found


def split_twist(model: Model, role: str, end: str, new: str) -> Model:
    """Return a model whose bone turns about its length by a joint of its own, in its middle."""
    axis, turns = model[end].offset / np.linalg.norm(model[end].offset), model[role].turns
    quats = Rotation.from_matrix(turns).as_quat()
    along = np.concatenate([(quats[:, :3] @ axis)[:, None] * axis, quats[:, 3:]], axis=1)
    twist = Rotation.from_quat(along).as_matrix()
    return insert(model, role, end, new, twist, turns @ twist.transpose(0, 2, 1))


def drop(model: Model, role: str) -> Model:
    """Return a model without a joint; its children hang on its parent, and it must not turn."""
    gone = model[role]
    return {
        name: replace(node, parent=gone.parent, offset=node.offset + gone.offset) if node.parent == role else node
        for name, node in model.items()
        if name != role
    }


def turn_axes(model: Model, axes: np.ndarray, scale: float = 1.0) -> Model:
    """Return a model in other axes and another unit."""
    return {
        name: Node(
            node.parent,
            scale * axes @ node.offset,
            axes @ node.turns @ axes.T,
            None if node.move is None else scale * node.move @ axes.T,
        )
        for name, node in model.items()
    }


def wrap(model: Model, name: str, turns: np.ndarray, place: np.ndarray) -> Model:
    """Return a model under a joint that turns [n, 3, 3] and goes its way [n, 3]; in the world nothing changes."""
    (top, node), *others = model.items()
    assert node.move is not None
    back = turns.transpose(0, 2, 1)
    move = np.einsum("nab,nb->na", back, node.move - place)
    inner = replace(node, parent=name, turns=back @ node.turns, move=None if np.abs(move).max() < 1e-9 else move)
    return {name: Node("", np.zeros(3), turns, place), top: inner, **dict(others)}


def tilt(model: Model, name: str) -> Model:
    """Return a model whose axes have z up, under a joint that turns them back to y up."""
    (top, node), *others = turn_axes(model, TO_Z_UP).items()
    turns = np.tile(TO_Z_UP.T, (FRAMES, 1, 1))
    return {name: Node("", np.zeros(3), turns, np.zeros((FRAMES, 3))), top: replace(node, parent=name), **dict(others)}


def pose(model: Model) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return places [n, 3] and turns [n, 3, 3] of a model's joints in the world."""
    places: dict[str, np.ndarray] = {}
    turns: dict[str, np.ndarray] = {}
    for name, node in model.items():
        own = np.tile(node.offset, (FRAMES, 1)) if node.move is None else node.move
        above = turns.get(node.parent, still())
        places[name] = places.get(node.parent, np.zeros((FRAMES, 3))) + np.einsum("nab,nb->na", above, own)
        turns[name] = above @ node.turns
    return places, turns


def name_plainly() -> dict[str, str]:
    """Return names of the joints by role, as most programs have them."""
    found = dict(zip(TRUNK, ("Hips", "Spine", "Spine1", "Neck", "Head"), strict=True))
    parts = ("Shoulder", "Arm", "ForeArm", "Hand", "UpLeg", "Leg", "Foot", "ToeBase")
    return found | {
        f"{side} {role}": f"{side.title()}{part}"
        for side in ("left", "right")
        for role, part in zip(LIMBS, parts, strict=True)
    }


@dataclass(frozen=True)
class Spelling:
    """Choose how a file is written.

    Attributes:
        order: Axes of the turns, outermost first.
        blank: What stands between words.
        lower: Keywords and channels in lower case.
        comma: Comma decimals.
        ends: Whether there are End Sites.
        places: Position channels of joints that have none: "", `replaced` or `added` to their OFFSET.
        frames: Added to the number of frames that the file states.
        line: Ends a line.
        first: What the file begins with.
    """

    order: str = "ZXY"
    blank: str = " "
    lower: bool = False
    comma: bool = False
    ends: bool = True
    places: str = ""
    frames: int = 0
    line: str = "\n"
    first: str = ""


def write_bvh(model: Model, names: dict[str, str], how: Spelling = Spelling()) -> bytes:
    """Return a model as a BVH file."""
    lines, columns = [f"{how.first}HIERARCHY"], []

    def number(value: float) -> str:
        return f"{value:.6f}".replace(".", "," if how.comma else ".")

    def word(text: str) -> str:
        return text.lower() if how.lower else text

    def add(role: str) -> None:
        node, places = model[role], how.places
        if not node.parent:
            places = "replaced"
        lines.append(f"{word('JOINT' if node.parent else 'ROOT')}{how.blank}{names.get(role, role)}")
        lines.append("{")
        lines.append(how.blank.join([word("OFFSET"), *(number(value) for value in node.offset)]))
        channels = [f"{axis}rotation" for axis in how.order]
        if node.move is not None or places:
            way = np.tile(node.offset, (FRAMES, 1)) if node.move is None else node.move
            columns.append(way - node.offset if places == "added" else way)
            channels = [f"{axis}position" for axis in "XYZ"] + channels
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # a quarter of a turn about the second axis has many angles, each right
            columns.append(Rotation.from_matrix(node.turns).as_euler(how.order, degrees=True))
        lines.append(how.blank.join([word("CHANNELS"), str(len(channels)), *(word(each) for each in channels)]))
        children = [name for name, other in model.items() if other.parent == role]
        for child in children:
            add(child)
        if not children and how.ends:
            lines.extend([word("End Site"), "{", f"{word('OFFSET')} {number(0)} {number(0)} {number(5)}", "}"])
        lines.append("}")

    add(next(iter(model)))
    lines.extend([word("MOTION"), f"{word('Frames:')}{how.blank}{FRAMES + how.frames}"])
    lines.append(f"{word('Frame Time:')}{how.blank}{number(1 / 30)}")
    lines.extend(how.blank.join(number(value) for value in row) for row in np.concatenate(columns, axis=1))
    return (how.line.join(lines) + how.line).encode()
