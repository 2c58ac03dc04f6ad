"""The codec of checkpoints: what was kept comes back, and what is not of its type is ignored."""

from __future__ import annotations

import io
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.recover.fit import material, shape
from garmentq.core.recover.fit.descent import Descent
from garmentq.core.recover.state import RecoveryState
from garmentq.core.reuse.animate import animation
from garmentq.core.run.checkpoints import FORMAT_KEY, fingerprint, load, pack, save, unpack
from garmentq.core.run.hooks import Arrays, Hooks
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import array_shapes, arrays

KINDS = (Body, RecoveryState, shape._ShapeCheckpoint, Descent, material._TriedStiffnesses, animation._FrameChunk)
"""Every type that a stage keeps."""


class Colour(Enum):
    """A closed set."""

    RED = "r"
    BLUE = "b"


@dataclass(frozen=True)
class Inner:
    """A part of a state."""

    values: np.ndarray
    name: str


@dataclass(frozen=True)
class State:
    """One field of every sort that the codec knows."""

    count: int
    share: float
    done: bool
    text: str
    colour: Colour
    array: np.ndarray
    inner: Inner
    maybe: Inner | None
    number: float | None
    pairs: tuple[tuple[int, str], ...]
    pair: tuple[float, Colour]
    table: dict[str, np.ndarray]
    names: dict[Colour, str]
    values: dict[str, Any]


@dataclass(frozen=True)
class Longer(Inner):
    """What `Inner` might be after a release."""

    more: int = 0


def equal(one: Any, other: Any) -> bool:
    """Compare bit by bit, types included."""
    if is_dataclass(one):
        same = (equal(getattr(one, field.name), getattr(other, field.name)) for field in fields(one))
        return type(one) is type(other) and all(same)
    if isinstance(one, dict):
        return list(one) == list(other) and all(equal(one[name], other[name]) for name in one)
    if isinstance(one, tuple):
        return len(one) == len(other) and all(map(equal, one, other))
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and one.shape == other.shape and one.tobytes() == other.tobytes()
    return type(one) is type(other) and (one == other or one != one)


def through_a_file(arrays_: Arrays) -> Arrays:
    """Write and read arrays as a worker does."""
    buffer = io.BytesIO()
    np.savez(buffer, **arrays_)
    buffer.seek(0)
    with np.load(buffer, allow_pickle=False) as found:
        return {name: found[name] for name in found.files}


ARRAYS = st.one_of(
    arrays(np.float64, array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=4)),
    arrays(np.int64, array_shapes(max_dims=2, min_side=0, max_side=4)),
    arrays(np.bool_, array_shapes(max_dims=1, min_side=0, max_side=4)),
)
WHOLE = st.integers(-(2**63), 2**63 - 1)
TEXT = st.text(st.characters(exclude_categories=["Cs"]))
INNERS = st.builds(Inner, ARRAYS, TEXT)
COLOURS = st.sampled_from(Colour)
JSON_LEAVES = st.none() | st.booleans() | st.floats(allow_nan=False) | WHOLE | TEXT
STATES = st.builds(
    State,
    count=WHOLE,
    share=st.floats(),
    done=st.booleans(),
    text=TEXT,
    colour=COLOURS,
    array=ARRAYS,
    inner=INNERS,
    maybe=st.none() | INNERS,
    number=st.none() | st.floats(),
    pairs=st.lists(st.tuples(WHOLE, TEXT)).map(tuple),
    pair=st.tuples(st.floats(), COLOURS),
    table=st.dictionaries(TEXT, ARRAYS, max_size=3),
    names=st.dictionaries(COLOURS, TEXT),
    values=st.dictionaries(TEXT, st.recursive(JSON_LEAVES, st.lists, max_leaves=4), max_size=3),
)


@given(STATES)
@settings(deadline=None)
def test_what_is_packed_comes_back(state: State) -> None:
    """Breaks if a sort of field loses a bit, its type, its order, or that it is None."""
    assert equal(unpack(State, through_a_file(pack(state))), state)


@given(STATES, st.data())
@settings(deadline=None)
def test_a_dictionary_that_is_not_whole_is_ignored(state: State, data: st.DataObject) -> None:
    """Breaks if a cut or foreign checkpoint ends a resumed job with a traceback, or is half believed."""
    whole = pack(state)
    name = data.draw(st.sampled_from(sorted(whole)))
    assert unpack(State, {key: value for key, value in whole.items() if key != name}) is None
    assert unpack(State, {**whole, "foreign": np.zeros(3)}) is None
    assert unpack(Inner, whole) is None
    assert unpack(State, {}) is None


def test_another_set_of_fields_is_another_format() -> None:
    """Breaks if a checkpoint of the release before is read as one of today."""
    kept = pack(Inner(np.zeros(3), "a"))
    assert unpack(Longer, kept) is None
    assert unpack(Longer, {**kept, "more": np.array(1)}) is None
    assert unpack(Inner, {**kept, FORMAT_KEY: np.zeros(64)}) is None
    assert fingerprint(Inner) == fingerprint(Inner) != fingerprint(Longer)


def test_a_text_in_place_of_a_number_is_ignored() -> None:
    """Breaks if a value of another type than its field's gets into a state."""
    kept = pack(
        State(
            1,
            0.5,
            True,
            "",
            Colour.RED,
            np.zeros(0),
            Inner(np.zeros(0), ""),
            None,
            None,
            (),
            (0.0, Colour.RED),
            {},
            {},
            {},
        )
    )
    for name, wrong in (
        ("count", np.array(1.0)),
        ("share", np.zeros(2)),
        ("text", np.zeros(2)),
        ("colour", kept["text"]),
    ):
        assert unpack(State, {**kept, name: wrong}) is None


def test_a_field_that_no_checkpoint_holds_is_refused() -> None:
    """Breaks if a developer's new field is dropped in silence."""

    @dataclass(frozen=True)
    class Odd:
        value: complex

    with pytest.raises(TypeError, match="complex"):
        pack(Odd(1j))
    with pytest.raises(TypeError, match="objects"):
        pack(Inner(np.array([None]), ""))


def example(kind: Any, rng: np.random.Generator) -> Any:
    """Make up a value of a type."""
    inner = get_args(kind)
    if is_dataclass(kind):
        hints = get_type_hints(kind)
        return kind(**{field.name: example(hints[field.name], rng) for field in fields(kind)})
    if type(None) in inner:
        return example(inner[0], rng)
    if get_origin(kind) is tuple:
        return tuple(example(each, rng) for each in (inner[:1] * 2 if inner[-1] is Ellipsis else inner))
    if get_origin(kind) is dict:
        keys = ("a", "b") if inner[0] is str else (example(inner[0], rng),)
        return {key: 0.1 if inner[1] is Any else example(inner[1], rng) for key in keys}
    if issubclass(kind, Enum):
        return list(kind)[-1]
    return {np.ndarray: rng.normal(size=(7, 3)), float: float(rng.normal()), int: 3, bool: True, str: "scan: a, b"}[
        kind
    ]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_checkpoint_comes_back_only_for_its_inputs(kind: type) -> None:
    """Breaks if a stage's state holds what the codec cannot keep, or one of another input is taken up."""
    rng = np.random.default_rng(0)
    state, kept, start = example(kind, rng), {}, rng.normal(size=(7, 3))
    save(Hooks(save_checkpoint=lambda name, found: kept.update({name: through_a_file(found)})), "at", state, start, 800)
    hooks = Hooks(load_checkpoint=kept.get)
    assert equal(load(hooks, "at", kind, start, 800), state)
    for inputs in ((start + 1e-15, 800), (start, 801), (start,), (start[:6], 800)):
        assert load(hooks, "at", kind, *inputs) is None
    assert load(hooks, "elsewhere", kind, start, 800) is None
    old = Hooks(load_checkpoint=lambda name: {"points": start, "texts": np.zeros(3, np.uint8)})
    assert load(old, "at", kind, start, 800) is None


def test_an_empty_dictionary_of_the_release_before_is_read() -> None:
    """Breaks if stored results whose patterns were kept without what their files held beyond them open no more."""

    @dataclass(frozen=True)
    class Kept:
        extra: dict[str, Any]

    kept = pack(Kept({"a": [1, None]}))
    assert unpack(Kept, kept) == Kept({"a": [1, None]})
    del kept["extra"]
    assert unpack(Kept, kept) is None
    assert unpack(Kept, {**kept, "extra:#": np.array(0), "extra#": np.array(0)}) == Kept({})
