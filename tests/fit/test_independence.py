"""How many independent things a misfit tells, against fields whose correlation is known."""

import numpy as np
import pytest
from garmentq.core.recover.fit.independence import count_independent

SIDE = 30
"""Places along a metre of flat cloth: about 3 cm apart."""


def flat_cloth() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return places, normals and areas of a square metre of flat cloth, the places anywhere in the cells of a grid."""
    grid = np.stack(np.meshgrid(np.arange(SIDE), [0.0], np.arange(SIDE)), axis=-1).reshape(-1, 3)
    places = (grid + np.random.default_rng(3).uniform(0.0, 1.0, grid.shape) * [1.0, 0.0, 1.0]) / SIDE
    return places, np.tile([0.0, 1.0, 0.0], (SIDE**2, 1)), np.full(SIDE**2, 1.0 / SIDE**2)


def smooth_field(places: np.ndarray, width: float, rng: np.random.Generator) -> np.ndarray:
    """Draw a field whose correlation at distance s is exp(-s^2 / (2 width^2)): 200 random waves."""
    waves = rng.normal(0.0, 1.0 / width, (200, 3))
    phases = rng.uniform(0.0, 2.0 * np.pi, 200)
    return np.asarray(np.cos(places @ waves.T + phases).sum(1) / np.sqrt(100.0))


@pytest.mark.parametrize("width", [0.04, 0.06])
def test_a_field_of_known_correlation(width: float) -> None:
    """The integral of exp(-s^2 / w^2) is pi w^2; a lost square, area or 2 pi breaks this."""
    places, normals, areas = flat_cloth()
    rng = np.random.default_rng(0)
    found = [count_independent(places, normals, smooth_field(places, width, rng), areas) for _ in range(10)]
    assert np.median(found) == pytest.approx(1.0 / (np.pi * width**2), rel=0.2)


def test_mean_squares_scatter_as_their_count_says() -> None:
    """Counts that are not degrees of freedom break this: 400 mean squares scatter by sqrt(2 / n) of themselves."""
    places, normals, areas = flat_cloth()
    rng = np.random.default_rng(1)
    fields = [smooth_field(places, 0.06, rng) for _ in range(400)]
    squares = np.array([areas @ field**2 for field in fields])
    count = np.median([count_independent(places, normals, field, areas) for field in fields[:20]])
    assert squares.std() / squares.mean() == pytest.approx(np.sqrt(2.0 / count), rel=0.2)


def test_what_is_missed_alike_everywhere_is_one_of_a_few() -> None:
    """A garment that lies a centimetre off as a whole tells five things a square metre, not a thousand."""
    places, normals, areas = flat_cloth()
    found = count_independent(places, normals, np.full(SIDE**2, 0.01), areas)
    assert found == pytest.approx(1.0 / (np.pi * 0.25**2), rel=1e-6)


def test_noise_tells_much_and_front_and_back_are_no_neighbours() -> None:
    """Pairs through the cloth break this: a front and a back that miss opposite ways are two smooth fields."""
    places, normals, areas = flat_cloth()
    rng = np.random.default_rng(2)
    assert count_independent(places, normals, rng.normal(size=SIDE**2), areas) > 300.0
    field = smooth_field(places, 0.06, rng)
    both = count_independent(
        np.concatenate([places, places + [0.0, 0.01, 0.0]]),
        np.concatenate([-normals, normals]),
        np.concatenate([field, -field]),
        np.concatenate([areas, areas]),
    )
    assert both == pytest.approx(2.0 * count_independent(places, normals, field, areas), rel=0.1)


def test_no_misfit_at_all() -> None:
    """A division by the misfit's size breaks this."""
    places, normals, areas = flat_cloth()
    assert count_independent(places, normals, np.zeros(SIDE**2), areas) == SIDE**2
