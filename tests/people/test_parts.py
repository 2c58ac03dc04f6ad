"""The pieces that telling parts apart is made of: smoothing, colours, crumbs, outfits, marks, labels, hints."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.people.colour import fit_colours, is_painted
from garmentq.core.people.confidence import LabelsUnsure, NoCloth, apply_temperature, check_confidence, check_garments
from garmentq.core.people.diffusion import Links, diffuse, link_points
from garmentq.core.people.garments import choose_part_category
from garmentq.core.people.hints import HintBad, parse_mark, parse_wearing
from garmentq.core.people.lab import to_lab
from garmentq.core.people.labels import has_names, read_parts, write_labels
from garmentq.core.people.limbs import BodyPlace, Limb
from garmentq.core.people.outfit import condition_on_outfit, marginalise_outfits, outfit_probabilities, rank_outfits
from garmentq.core.people.part import GARMENTS, PARTS, Part
from garmentq.core.people.separation import FoundContour, FoundGarment, Outfit
from garmentq.core.people.small_pieces import relabel_beyond_skin, relabel_small_pieces
from garmentq.core.scan.contours.legs import split_legs
from garmentq.core.scan.contours.target import Contour
from garmentq.core.scan.refusal import LabelsUnreadable

UP = np.array([0.0, 1.0, 0.0])


def sheet(side: int = 60, spacing: float = 0.007) -> np.ndarray:
    """Lay points out in a level square."""
    u, v = np.meshgrid(np.arange(side), np.arange(side), indexing="ij")
    return spacing * np.stack([u.ravel(), np.zeros(side**2), v.ravel()], axis=1)


def test_diffusion_keeps_a_posterior_and_takes_out_noise():
    """Broken where rows leave the simplex, or salt and pepper of a quarter of the points survives."""
    points, rng = sheet(), np.random.default_rng(0)
    links = link_points(points, np.tile(UP, (len(points), 1)))
    truth = (points[:, 0] > 0.21).astype(int)
    seen = np.where(rng.random(len(points)) < 0.25, 1 - truth, truth)
    smooth = diffuse(np.eye(2)[seen], links)
    np.testing.assert_allclose(smooth.sum(axis=1), 1.0)
    assert smooth.min() >= 0.0
    assert (smooth.argmax(axis=1) == truth).mean() > 0.97


def test_belief_does_not_pass_an_edge_of_colour():
    """Broken where the weights of the links are ignored: then the step between two halves is blurred."""
    points = sheet()
    half = (points[:, 0] > 0.21).astype(float)
    links = link_points(points, np.tile(UP, (len(points), 1)))
    beside = np.flatnonzero(np.abs(points[:, 0] - 0.21) < 0.005)
    start = np.eye(2)[half.astype(int)]
    blurred, sharp = diffuse(start, links), diffuse(start, links.weakened(50.0 * half, 10.0))
    assert np.abs(sharp - start)[beside].max() < 1e-3 < 0.1 < np.abs(blurred - start)[beside].max()


def test_sheets_that_face_away_are_not_linked():
    """Broken where an arm that touches the trunk shares its label."""
    points = np.concatenate([sheet(10), sheet(10) + [0.0, 0.004, 0.0]])
    links = link_points(points, np.repeat([-UP, UP], 100, axis=0))
    assert ((links.pairs < 100).sum(axis=1) != 1).all() and len(links.pairs)


def test_lab_of_known_colours():
    """Broken where the matrix is transposed or the curve is left out: reference values of sRGB's corners."""
    known = to_lab(np.array([[1.0, 1.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]))
    expected = [[100.0, 0.0, 0.0], [53.24, 80.09, 67.20], [32.30, 79.19, -107.86], [0.0, 0.0, 0.0]]
    np.testing.assert_allclose(known, expected, atol=0.1)


def two_colours(second: tuple[float, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Make 400 points of an upper in blue and 400 of a lower in another colour, sure by geometry."""
    rng = np.random.default_rng(1)
    rgb = np.repeat([(0.2, 0.3, 0.7), second], 400, axis=0) + rng.normal(0.0, 0.02, (800, 3))
    posterior = np.zeros((800, len(PARTS)))
    posterior[:400, PARTS.index(Part.UPPER)] = posterior[400:, PARTS.index(Part.LOWER)] = 0.95
    return to_lab(rgb.clip(0.0, 1.0)), posterior


@pytest.mark.parametrize(("second", "decides"), [((0.6, 0.5, 0.3), True), ((0.2, 0.3, 0.7), False)])
def test_colours_decide_where_they_differ(second, decides):
    """Broken where a model is fitted to the wrong points, or one cloth's colour is held for one garment's alone."""
    lab, posterior = two_colours(second)
    asked = fit_colours(lab, posterior, np.ones(posterior.shape, bool)).ask(lab)
    gain = asked[:, PARTS.index(Part.UPPER)] - asked[:, PARTS.index(Part.LOWER)]
    if decides:
        assert gain[:400].min() > 1.0 and gain[400:].max() < -1.0
    else:
        assert np.abs(gain).max() == 0.0


def test_a_painted_back_is_noticed():
    """Broken where a scan made of one photograph has its colours believed, or every shirt is called painted."""
    lab, posterior = two_colours((0.8, 0.6, 0.5))
    posterior[:, PARTS.index(Part.UPPER)] = 0.95
    posterior[:, PARTS.index(Part.LOWER)] = 0.0
    front = np.arange(800) < 400
    assert is_painted(lab, front, posterior, PARTS)
    assert not is_painted(lab, np.arange(800) % 2 == 0, posterior, PARTS)


def test_crumbs_go_to_what_is_around_them():
    """Broken where a pocket of 5 cm2 stays, or a piece of 30 cm2 goes."""
    points = sheet()
    links = link_points(points, np.tile(UP, (len(points), 1)))
    column = np.zeros(len(points), int)
    small = np.linalg.norm(points - points[620], axis=1) < 0.0126
    large = np.linalg.norm(points - points[2440], axis=1) < 0.031
    column[small], column[large] = 3, 4
    given = relabel_small_pieces(column, points, np.full(len(points), 0.007**2), links)
    assert (given[small] == 0).all() and (given[large] == 4).all() and (given[~small & ~large] == 0).all()


def spread(**shares: float) -> np.ndarray:
    """Return one row of a posterior."""
    row = np.full(len(PARTS), 1e-3)
    for name, share in shares.items():
        row[PARTS.index(Part[name])] = share
    return row / row.sum()


def test_outfits_are_ranked_by_what_is_seen():
    """Broken where a dress's points speak for top and skirt, or a marked garment is left out."""
    skin, above = spread(SKIN=1.0), np.linspace(0.0, 1.0, 100)
    dress = np.array([skin] * 40 + [spread(ONE_PIECE=0.8, UPPER=0.1, LOWER=0.1)] * 60)
    assert rank_outfits(dress, above)[0].parts == (Part.ONE_PIECE,)
    both = np.array([skin] * 40 + [spread(UPPER=1.0)] * 30 + [spread(LOWER=1.0)] * 30)
    assert rank_outfits(both, above)[0].parts == (Part.UPPER, Part.LOWER)
    assert rank_outfits(dress, above, marked=(Part.UPPER, Part.LOWER))[0].parts == (Part.UPPER, Part.LOWER)
    assert rank_outfits(dress, above, wearing=(Part.LOWER,)) == (Outfit((Part.LOWER,), 0.0),)


def test_a_dress_read_as_two_is_cut_at_the_waist():
    """Broken where probability is lost between readings, or all of a dress becomes the top."""
    row, above = np.array([spread(ONE_PIECE=1.0)] * 2), np.array([0.999, 0.001])
    read = condition_on_outfit(row, (Part.UPPER, Part.LOWER), above)
    np.testing.assert_allclose(read.sum(axis=1), 1.0, atol=2e-3)  # an outer layer's share
    assert [PARTS[k] for k in read.argmax(axis=1)] == [Part.UPPER, Part.LOWER]
    assert PARTS[condition_on_outfit(read, (Part.ONE_PIECE,), above).argmax(axis=1)[0]] is Part.ONE_PIECE


@pytest.mark.parametrize("odds", [0.6, 0.8])
def test_doubt_of_the_outfit_is_doubt_of_each_point(odds):
    """Broken where thousands of points that repeat one fact make it sure, or a label is surer than its reading."""
    rest = (1.0 - odds) / 2
    posterior = np.array([spread(SKIN=1.0)] * 40 + [spread(ONE_PIECE=odds, UPPER=rest, LOWER=rest)] * 60)
    above = np.linspace(0.0, 1.0, 100)
    outfits = rank_outfits(posterior, above)
    assert outfits[0].parts == (Part.ONE_PIECE,)
    assert outfits[0].score - outfits[1].score == pytest.approx(np.log(odds / (1.0 - odds)), abs=0.05)
    believed = marginalise_outfits(posterior, outfits, above)
    np.testing.assert_allclose(believed.sum(axis=1), 1.0)
    assert believed[60:, PARTS.index(Part.ONE_PIECE)].mean() == pytest.approx(odds, abs=0.06)
    assert believed[:40, PARTS.index(Part.SKIN)].min() > 0.99
    assert outfit_probabilities(outfits).sum() == pytest.approx(1.0)


def test_tempering_keeps_order_and_softens():
    """Broken where a temperature above 1 makes surer."""
    posterior = np.array([[0.7, 0.2, 0.1]])
    np.testing.assert_allclose(apply_temperature(posterior, 1.0), posterior)
    soft = apply_temperature(posterior, 2.0)[0]
    assert soft[0] < 0.7 and (np.diff(soft) < 0).all()


def check(garments: tuple[FoundGarment, ...], outfits: tuple[Outfit, ...]):
    """Return whether each garment is recovered, the warnings, and the person's problem."""
    checked = check_garments(garments, outfits)
    return [garment.problem is None for garment in checked], *check_confidence(checked, outfits, is_given=False)


def test_doubt_stays_with_the_garment():
    """Broken where a doubtful garment is recovered in silence, or keeps a sure one from being recovered."""
    sure = FoundGarment(Part.UPPER, 0.95, "tshirt", (FoundContour("neck", 0.1, True),))
    weak = FoundGarment(Part.LOWER, 0.3, "skirt")
    outfits = (Outfit((Part.UPPER, Part.LOWER), -1.0), Outfit((Part.ONE_PIECE,), -4.0))
    recovered, warnings, problem = check((sure,), outfits[:1])
    assert recovered == [True] and problem is None and "neck" in warnings[0]
    recovered, warnings, problem = check((sure, weak), outfits)
    assert recovered == [True, False] and problem is None
    assert any("lower is not recovered" in text and "unsure" in text for text in warnings)
    recovered, warnings, problem = check((weak,), outfits)
    assert recovered == [False] and isinstance(problem, LabelsUnsure)
    assert not any("not recovered" in text for text in warnings)  # the problem says it
    coat = FoundGarment(Part.OUTER, 0.95, "long_sleeve_tshirt", (FoundContour("neck", 0.9, False),))
    trousers = FoundGarment(Part.LOWER, 0.95, "trousers")
    assert check((sure, trousers, coat), outfits[:1])[0] == [False, True, True]  # the top is hardly seen
    ends = tuple(FoundContour(f"armhole.{side}", 0.1, True) for side in ("left", "right"))
    recovered, warnings, problem = check((FoundGarment(Part.UPPER, 0.95, "tank", ends),), outfits[:1])
    assert recovered == [True] and "armhole.left, armhole.right" in warnings[0]  # the gate `ends` doubts it


def test_doubtful_readings_keep_what_they_share():
    """Broken where trousers are kept back because it is open what is worn above them, or one of two cuts is guessed."""
    top, trousers = FoundGarment(Part.UPPER, 0.7, "tank"), FoundGarment(Part.LOWER, 0.95, "trousers")
    worn = Outfit((Part.UPPER, Part.LOWER), -1.0)
    recovered, warnings, problem = check((top, trousers), (worn, Outfit((Part.LOWER,), -1.5)))
    assert recovered == [False, True] and problem is None and "may be lower" in warnings[0]
    recovered, _, problem = check((top, trousers), (worn, Outfit((Part.ONE_PIECE,), -1.5)))
    assert recovered == [False, False] and "one-piece" in problem.message


def test_the_user_is_not_asked_twice():
    """Broken where a user who said what is worn is asked again, or nothing worn is silent."""
    weak = FoundGarment(Part.LOWER, 0.3, "skirt")
    outfits = (Outfit((Part.LOWER,), 0.0), Outfit((), -1.0))
    assert check_confidence((weak,), outfits, is_given=True)[1] is None
    assert isinstance(check_confidence((), outfits, is_given=False)[1], NoCloth)
    assert check_confidence((), (Outfit((), 0.0),), is_given=True) == ((), None)


def test_labels_round_trip(tmp_path):
    """Broken where a part's number or word changes between writing and reading."""
    label = np.array([int(part) for part in PARTS], np.uint8)
    path = write_labels(label, np.full(len(label), 0.5), tmp_path / "labels.npz")
    assert has_names(path)
    np.testing.assert_array_equal(read_parts(path), label)


def test_foreign_names_are_refused(tmp_path):
    """Broken where a label without a name, or a name that is no part, is taken for skin."""
    for label, names in (([0, 1], ["skin"]), ([0, 1], ["skin", "cape"]), ([-1], ["skin"])):
        np.savez(tmp_path / "labels.npz", label=np.array(label), names=np.array(names))
        with pytest.raises(LabelsUnreadable):
            read_parts(tmp_path / "labels.npz")
    np.savez(tmp_path / "plain.npz", label=np.array([0, 1]))
    assert not has_names(tmp_path / "plain.npz")


def test_hints_are_read():
    """Broken where garments come in the order typed, or a broken word is guessed at."""
    assert parse_wearing("lower, upper") == (Part.UPPER, Part.LOWER)
    mark = parse_mark("one-piece=0.1,1.2,-0.05")
    assert mark.part is Part.ONE_PIECE and mark.place.tolist() == [0.1, 1.2, -0.05]
    for word in ("skin", "", "upper;lower", "nothing,upper"):
        with pytest.raises(HintBad):
            parse_wearing(word)
    for word in ("upper", "upper=1,2", "upper=1,2,nan", "cape=1,2,3"):
        with pytest.raises(HintBad):
            parse_mark(word)
    assert parse_wearing("nothing") == ()
    assert set(parse_wearing(",".join(part.word for part in GARMENTS))) == set(GARMENTS)


def test_touching_legs_are_two():
    """Broken where a skirt's hem is split, or the hems of two legs that touch are one: an eight, and an oval."""
    t = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    oval = np.stack([0.3 * np.cos(t), np.zeros(400), 0.12 * np.sin(t)], axis=1)
    assert split_legs(oval) is None
    pinched = oval * np.stack([np.ones(400), np.ones(400), 0.04 + np.abs(np.cos(t))], axis=1)
    first, second = split_legs(pinched)
    assert abs(len(first) - len(second)) < 8
    assert np.sign(pinched[first, 0].mean()) != np.sign(pinched[second, 0].mean())
    folded = 3.0 * oval * np.stack([np.ones(400), np.ones(400), 0.22 + np.abs(np.cos(t))], axis=1)
    assert split_legs(folded) is None  # 16 cm between two folds of a hem of 4 m: short beside it, but no touch


def test_a_ragged_hem_is_one():
    """Broken where noise, which makes a loop longer and its chords no longer, splits a skirt's flat hem."""
    t = np.linspace(0.0, 2.0 * np.pi, 300, endpoint=False)
    flat = np.stack([0.3 * np.cos(t), np.zeros(300), 0.075 * np.sin(t)], axis=1)
    ragged = flat + np.random.default_rng(0).normal(0.0, 0.004, flat.shape)
    assert np.linalg.norm(np.roll(ragged, 1, axis=0) - ragged, axis=1).sum() > 2.3  # flat: 1.28
    assert split_legs(ragged) is None


@pytest.mark.parametrize(
    ("part", "names"), [(Part.UPPER, ("neck", "leg.left", "leg.right")), (Part.LOWER, ("cuff.left", "waist"))]
)
def test_a_top_with_legs_is_doubted(part, names):
    """Broken where a top that swallowed the trousers is sure to be a jumpsuit, worn with something below."""
    contours = tuple(Contour(name, np.arange(3), 0.5, ()) for name in names)
    assert choose_part_category(part, contours, None, None) == ""
    problem = check((FoundGarment(part, 0.9, ""),), (Outfit((part,), 0.0),))[2]
    assert isinstance(problem, LabelsUnsure)


def draw_leg(pieces: list[tuple[float, float, Part]]) -> tuple[np.ndarray, BodyPlace, Links]:
    """Return columns, places and links of samples along a leg that hold parts between stations [m]."""
    station = np.repeat(np.arange(0.0, 0.9, 0.01), 8)
    column = np.full(len(station), PARTS.index(Part.SKIN))
    for first, last, part in pieces:
        column[(station >= first) & (station < last)] = PARTS.index(part)
    count = len(station)
    place = BodyPlace(
        limb=np.full(count, Limb.LEFT_LEG), station=station,
        **{name: np.zeros((count, 3)) for name in BodyPlace.__annotations__ if name not in ("limb", "station")},
    )  # fmt: skip
    first = np.arange(count - 8)
    pairs = np.stack([first, first + 8], axis=1)
    ring = np.stack([np.arange(count), np.arange(count) // 8 * 8 + (np.arange(count) + 1) % 8], axis=1)
    pairs = np.concatenate([pairs, ring])
    return column, place, Links(pairs, np.ones(len(pairs)), count)


@pytest.mark.parametrize(
    ("pieces", "is_kept"),
    [
        ([(0.0, 0.3, Part.LOWER), (0.6, 0.75, Part.LOWER)], False),
        ([(0.0, 0.6, Part.ONE_PIECE), (0.6, 0.75, Part.LOWER)], True),
        ([(0.0, 0.3, Part.LOWER), (0.3, 0.6, Part.HAIR), (0.6, 0.75, Part.LOWER)], True),
        ([(0.0, 0.75, Part.LOWER)], True),
        ([(0.1, 0.2, Part.UPPER), (0.6, 0.75, Part.LOWER)], True),
    ],
)
def test_what_bare_skin_separates_is_no_part_of_a_garment(pieces, is_kept):
    """Broken where boots in the shorts' colour lengthen them, or trousers below a dress or beside hair lose a piece."""
    column, place, links = draw_leg(pieces)
    posterior = np.full((len(column), len(PARTS)), 0.1)
    posterior[:, PARTS.index(Part.SHOES)] = 0.2
    posterior[:, PARTS.index(Part.LOWER)] = 0.3
    found = relabel_beyond_skin(column, posterior, place, links)
    low = (place.station >= 0.6) & (place.station < 0.75)
    assert (found[~low] == column[~low]).all()
    assert (found[low] == PARTS.index(Part.LOWER if is_kept else Part.SHOES)).all()
