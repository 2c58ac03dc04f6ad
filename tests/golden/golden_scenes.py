"""Ten small scenes that the gate runs: what each is given, what it runs, and what is measured of it."""

from __future__ import annotations

import json
import shutil
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
from garmentq.cli.bench.packs import read_packs, read_true_pattern
from garmentq.cli.bench.pattern_match import PATTERN_METRICS
from garmentq.cli.bench.pattern_match import measure_pattern as measure_beside_true_pattern
from garmentq.cli.bench.truth import measure_recovery as measure_beside_truth
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.exposed import ExposedSurface
from garmentq.core.body.motion.read import load_motion
from garmentq.core.body.motion.shipped import find_shipped_motion
from garmentq.core.cloth.fabrics import get_fabric
from garmentq.core.deliver.formats.grading import grade_sizes
from garmentq.core.deliver.formats.options import ExportOptions
from garmentq.core.garment.garmentcode import load_pattern
from garmentq.core.garment.pattern import Pattern
from garmentq.core.garment.pieces.make import make_pieces
from garmentq.core.garment.pieces.numbers import describe_pieces
from garmentq.core.garment.templates import draft_template, list_templates
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.judge.penetration import measure_penetration
from garmentq.core.judge.true_pattern import TruePattern
from garmentq.core.people.garments import build_person_surface, extract_garment
from garmentq.core.people.hints import Hints
from garmentq.core.people.part import Part
from garmentq.core.people.separate import label_person
from garmentq.core.recover.drape.sizing import measure_wearer
from garmentq.core.recover.pipeline import recover
from garmentq.core.recover.recovery import Request
from garmentq.core.recover.settings import RecoverySettings
from garmentq.core.reuse.animate.animate_garment import animate_garment
from garmentq.core.reuse.animate.settings import AnimateSettings
from garmentq.core.reuse.edit.redraping import drape_edit
from garmentq.core.reuse.wear.dressing import dress_body
from garmentq.core.reuse.wear.refit import make_to_measure
from garmentq.core.reuse.wear.worn import WornGarment
from garmentq.core.run.clock import Clock
from garmentq.core.run.hooks import SILENT_HOOKS
from garmentq.core.scan.open3d_library import load_open3d
from garmentq.core.scan.raw import RawScan
from golden_numbers import (
    CM,
    Measured,
    measure_all,
    measure_contours,
    measure_draft,
    measure_gates,
    measure_pattern,
    measure_recovery,
    measure_separation,
    pick,
)
from worn_template import load_worn_template

SCENES_FOLDER = Path(__file__).parent / "scenes"

VERTICES = 1000
"""Of a recovered garment: edges of 3 cm, a quarter of the default's."""

SAMPLES = 20_000
"""Of each surface whose distance is measured."""

OTHER_BODY = "builtin:male,height=1.80,pose=A"
"""Who is dressed in what was made for somebody else."""


WALK, LEAD = 0.2, 0.4
"""Of the motion and of the way into it [s]: five frames after ten that are not kept."""


@dataclass(frozen=True)
class Shift:
    """Move the points of a scene's input at random, to see how its numbers scatter.

    Attributes:
        size: Standard deviation of each coordinate [m]; 0: nothing moves.
        seed: Of the generator.
    """

    size: float = 0.0
    seed: int = 0

    def move(self, points: np.ndarray) -> np.ndarray:
        """Return points [m], shape [n, 3], moved."""
        if self.size == 0.0:
            return points
        return points + np.random.default_rng(self.seed).normal(0.0, self.size, points.shape)


def recover_foreign(name: str, shift: Shift, *, own_base: bool, method: str = "deform") -> Measured:
    """Recover a garment that others drafted and another simulator draped, on a body that is not the built-in one.

    Args:
        name: Of the scene's folder.
        shift: How far the scan is moved.
        own_base: Whether the maker's pattern is the base pattern; otherwise the library's are chosen from.
        method: Of the recovery; `hybrid` fits pattern and fabric through the simulator, too.
    """
    with tempfile.TemporaryDirectory() as folder:
        pack = Path(folder) / name
        pack.mkdir()
        for path in (SCENES_FOLDER / name).glob("*.json"):
            shutil.copy(path, pack)
        for source, target in (((SCENES_FOLDER / name), "garment"), (SCENES_FOLDER, "body")):
            with np.load(source / f"{target}.npz") as kept:
                vertices, faces = kept["vertices"].astype(np.float64), kept["faces"].astype(np.int64)
            moved = shift.move(vertices) if target == "garment" else vertices
            _write_mesh(moved, faces, pack / f"{target}.ply")
        target = read_packs(pack)[0]
        template = target.template if own_base else None
        settings = RecoverySettings(method=method, vertex_count=VERTICES)
        recovery = recover(Request(target.garment, target.body, template, settings))
        metrics, _ = measure_beside_truth(recovery, target, own_base, samples=SAMPLES)
        given = Measured({}) if template is None else _measure_base(load_pattern(template), read_true_pattern(target))
    return given | measure_recovery(recovery, metrics)


def _measure_base(base: Pattern, truth: TruePattern | None) -> Measured:
    """Return how far the base pattern is from the truth before anything is recovered: what no fold decides."""
    assert truth is not None
    return name_under("base", pick(measure_beside_true_pattern(base, truth), PATTERN_METRICS))


def _write_mesh(vertices: np.ndarray, faces: np.ndarray, path: Path) -> None:
    """Write a mesh in double precision, in which a shift by rounding is kept."""
    open3d = load_open3d()
    mesh = open3d.geometry.TriangleMesh(
        open3d.utility.Vector3dVector(vertices), open3d.utility.Vector3iVector(faces.astype(np.int32))
    )
    open3d.io.write_triangle_mesh(str(path), mesh)


def take_person_apart(name: str, shift: Shift, wearing: tuple[Part, ...] | None = None) -> Measured:
    """Find wearer, parts and garments of a simulated raw scan; where it is said what is worn, recover the last one."""
    with np.load(SCENES_FOLDER / f"{name}.npz") as kept:
        points, faces = kept["points"].astype(np.float64), kept["faces"].astype(np.int64)
        truth, true_body = kept["label"], kept["body_vertices"].astype(np.float64)
    every = np.arange(len(points))
    points = shift.move(points)
    normals = vertex_normals(points, faces)
    raw = RawScan(points, faces, normals, True, None, None, every, every, name)
    separation = label_person(raw, Hints(wearing=wearing), SILENT_HOOKS)
    found = measure_separation(separation, truth, true_body)
    if wearing is None:
        return found
    garment = separation.garments[-1]
    reading = extract_garment(build_person_surface(raw, separation.body), separation, garment.part)
    settings = RecoverySettings(method="deform", vertex_count=VERTICES)
    recovery = recover(Request(Path(name), settings=settings, reading=reading))
    return found | measure_recovery(recovery, recovery.report.metrics)


def wear(template: str, shift: Shift) -> WornGarment:
    """Return a shipped drape, its nodes moved."""
    worn = load_worn_template(template, get_fabric("cotton_poplin"))
    assert worn is not None
    return replace(worn, garment=worn.garment.at(shift.move(worn.garment.nodes)))


def dress_another(shift: Shift) -> Measured:
    """Dress a man in a woman's skirt, and make it to his measures; before, see how deep in him it would lie."""
    skirt, body = wear("skirt", shift), builtin_body(OTHER_BODY)
    depths = measure_penetration(skirt.garment.nodes, skirt.garment.faces, ExposedSurface.of(body))
    found = name_under("before", measure_all(depths))
    for word, wear_again in (("dressed", dress_body), ("refitted", make_to_measure)):
        one = wear_again(skirt, body, None, Clock())
        found |= name_under(word, measure_all(one.report.metrics) | measure_gates(one.report.gates))
        found |= name_under(word, measure_contours(one.worn.garment) | measure_pattern(one.worn.pattern))
    return found


def edit_hem(shift: Shift) -> Measured:
    """Lengthen a skirt by a tenth and drape it back."""
    worn = wear("skirt", shift)
    longer = worn.pattern.with_points(worn.pattern.points * np.array([1.0, 1.1]))
    edited = drape_edit(worn, longer, worn.pattern, Clock())
    return (
        measure_all(edited.report.metrics)
        | measure_pattern(edited.worn.pattern)
        | measure_contours(edited.worn.garment)
        | measure_gates(edited.report.gates)
    )


def animate_walk(shift: Shift) -> Measured:
    """Move a skirt with its wearer into the shipped walk, and through the first frames of it."""
    path = find_shipped_motion("walk")
    assert path is not None
    settings = AnimateSettings(fps=24.0, end=WALK, lead=LEAD)
    moved = animate_garment(wear("skirt", shift), load_motion(path), "walk", settings, Clock())
    found = measure_all(moved.report.metrics) | measure_gates(moved.report.gates)
    for n, nodes in enumerate(moved.animation.frames):
        low, high = nodes.min(axis=0), nodes.max(axis=0)
        own = {f"frame{n}.{axis}_cm": CM * float(size) for axis, size in zip("xyz", high - low, strict=True)}
        own |= {f"frame{n}.low_cm": CM * float(low[1]), f"frame{n}.ahead_cm": CM * float(nodes[:, 2].mean())}
        found |= Measured(own) | name_under(f"frame{n}", measure_contours(moved.animation.worn.garment.at(nodes)))
    return found


def export_pieces(shift: Shift) -> Measured:
    """Cut a T-shirt's pieces, grade it to three sizes for the wearer's measures, and draft each template for these."""
    worn = wear("tshirt", shift)
    measures = measure_wearer(worn.body)
    pieces, numbers = describe_pieces(make_pieces(worn.pattern))
    found = measure_all(numbers)
    for one in pieces:
        found |= Measured({f"{one.name}.cloth_cm2": 1e4 * one.cloth, f"{one.name}.quantity": float(one.quantity)})
    height = float(np.ptp(worn.body.rest_vertices[:, 1]))
    options = ExportOptions(format="pdf", step=4.0, first=-1, last=1)
    for size in grade_sizes(worn.pattern, worn.template, measures, height, options):
        found |= name_under(size.name, measure_pattern(size.pattern))
    for info in list_templates():
        found |= name_under(f"drafted.{info.name}", measure_draft(draft_template(info.name, measures)))
    return found


def name_under(word: str, measured: Measured) -> Measured:
    """Return what was measured, each name below a word."""
    numbers = {f"{word}.{name}": value for name, value in measured.numbers.items()}
    return Measured(numbers, {f"{word}.{name}": value for name, value in measured.words.items()})


SCENES: Mapping[str, Callable[[Shift], Measured]] = MappingProxyType(
    {
        "foreign_tshirt": lambda shift: recover_foreign("foreign_tshirt", shift, own_base=True),
        "foreign_skirt": lambda shift: recover_foreign("foreign_skirt", shift, own_base=False),
        "foreign_trousers": lambda shift: recover_foreign("foreign_trousers", shift, own_base=False),
        "foreign_tank": lambda shift: recover_foreign("foreign_tank", shift, own_base=True, method="hybrid"),
        "person_one": lambda shift: take_person_apart("person_one", shift),
        "person_two": lambda shift: take_person_apart("person_two", shift, (Part.UPPER, Part.LOWER)),
        "dress": dress_another,
        "edit": edit_hem,
        "animate": animate_walk,
        "export": export_pieces,
    }
)
"""Each scene's run by name."""


def list_provenance() -> dict[str, dict[str, str]]:
    """Return what the provenance file says of each file of the scenes."""
    found: dict[str, dict[str, str]] = json.loads((SCENES_FOLDER / "provenance.json").read_text())
    return found
