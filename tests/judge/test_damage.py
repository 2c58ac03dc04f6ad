"""What each damage does to a mesh, on a tube whose truth is known."""

import numpy as np
import pytest
from garmentq.cli.bench.damage import DAMAGES
from garmentq.core.scan.repair import repair_surface

BY_NAME = {damage.name: damage for damage in DAMAGES}


def tube() -> tuple[np.ndarray, np.ndarray]:
    """Return an open tube of 0.2 m radius and 0.6 m height, outward, 60 x 41 vertices."""
    around, up = 60, 41
    angle, height = np.meshgrid(2 * np.pi * np.arange(around) / around, np.linspace(0.4, 1.0, up))
    vertices = np.stack([0.2 * np.sin(angle), height, 0.2 * np.cos(angle)], axis=-1).reshape(-1, 3)
    row, step = np.meshgrid(np.arange(up - 1), np.arange(around), indexing="ij")
    a, b = row * around + step, row * around + (step + 1) % around
    faces = np.stack([a, b, b + around, a, b + around, a + around], axis=-1).reshape(-1, 3)
    return vertices, faces


def apply(name: str, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Damage the tube."""
    return BY_NAME[name].apply(*tube(), np.random.default_rng(seed))


@pytest.mark.parametrize("name", sorted(BY_NAME))
def test_damage_is_seeded_and_leaves_its_input_alone(name: str) -> None:
    """Fails if two runs of the study saw other damage, or the clean mesh were changed in place."""
    vertices, faces = tube()
    before = vertices.copy(), faces.copy()
    first = BY_NAME[name].apply(vertices, faces, np.random.default_rng(7))
    again = BY_NAME[name].apply(vertices, faces, np.random.default_rng(7))
    assert all(np.array_equal(a, b) for a, b in zip(first, again, strict=True))
    assert np.array_equal(vertices, before[0]) and np.array_equal(faces, before[1])


def test_amounts_are_as_named() -> None:
    """Fails if millimetres were metres, or a share of the area one of the faces of a fifth."""
    vertices, faces = tube()
    moved = apply("noise_5mm")[0] - vertices
    assert moved.std() == pytest.approx(0.005, rel=0.05)
    assert (apply("noise_10mm")[0] - vertices).std() == pytest.approx(0.010, rel=0.05)
    assert 0.10 <= 1 - len(apply("holes_10")[1]) / len(faces) <= 0.13
    thrown = np.linalg.norm(apply("outliers_3")[0] - vertices, axis=1)
    assert np.mean(thrown > 0) == pytest.approx(0.03, abs=0.01)
    assert np.allclose(thrown[thrown > 0], 0.05)
    cut_vertices, cut = apply("hem_cut")
    used = cut_vertices[np.unique(cut)]
    assert used[:, 1].min() > 0.44 and used[:, 1].max() == 1.0


@pytest.mark.parametrize("name", ["flipped_all", "flipped_30"])
def test_turned_faces_are_turned_back_exactly(name: str) -> None:
    """Fails if the repair gave another mesh than the clean one: then the study could not share the clean figures."""
    vertices, faces = tube()
    damaged = apply(name)[1]
    assert not np.array_equal(damaged, faces)
    assert np.array_equal(repair_surface(vertices, damaged).faces, repair_surface(vertices, faces).faces)
