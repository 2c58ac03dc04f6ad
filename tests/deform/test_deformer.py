"""The whole deformer on a tube: what it reaches, what it keeps, and what it must not do."""

from __future__ import annotations

import pickle
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from garmentq.core.body.exposed import ExposedSurface, penetration_depth
from garmentq.core.recover.deform.deformer import deform
from garmentq.core.recover.deform.settings import DeformSettings
from garmentq.core.run.errors import Cancelled
from garmentq.core.run.hooks import Hooks

ROOT = Path(__file__).parents[2]

QUICK = DeformSettings(iterations=40, polish_iterations=5)


def stretch_range(garment, nodes):
    corners, rest = nodes[garment.faces], garment.rest
    spatial = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
    flat = np.stack([rest[:, 1] - rest[:, 0], rest[:, 2] - rest[:, 0]], axis=2)
    values = np.linalg.svd(spatial @ np.linalg.inv(flat), compute_uv=False)
    return values[:, 1].min(), values[:, 0].max()


def test_recovers_a_smooth_deformation(scene, fitted, rms):
    """Breaks if any stage stops short: 12 mm apart at the start, 0.8 and 1.2 mm at the end, with sound triangles.

    What is left is the chord error of 2.5 cm edges on folds 11 cm long.
    """
    garment, target, _ = scene
    assert min(rms(garment.nodes, garment.faces, target)) > 10.0
    ahead, back = rms(fitted.nodes, garment.faces, target)
    assert ahead < 0.8 and back < 1.2
    low, high = stretch_range(garment, fitted.nodes)
    assert low > 0.7 and high < 1.4
    assert fitted.flipped_faces[1] == 0 and fitted.self_intersecting_faces == (0, 0)
    assert fitted.matched == ("hem", "waist") and not fitted.normals_reversed and fitted.warnings == ()
    assert (
        len(fitted.losses["total"]) == fitted.iterations
        and fitted.losses["total"][-1] < 0.1 * fitted.losses["total"][0]
    )


def test_matched_contours_end_on_each_other(scene, fitted):
    """Breaks if a border slides along the surface: without contours the hem ends centimetres off."""
    garment, target, _ = scene
    for own, other in zip(garment.contours, target.contours, strict=True):
        assert own.name == other.name
        gap = np.linalg.norm(fitted.nodes[own.vertices][:, None] - target.vertices[other.vertices][None], axis=2)
        height = fitted.nodes[own.vertices, 1] - target.vertices[other.vertices[gap.argmin(axis=1)], 1]
        assert np.abs(height).max() < 2e-3


def test_a_garment_on_its_target_stays(scene, to_target):
    """Breaks if bending, strain or the polish pull a garment off a target that it already covers."""
    garment, _, body = scene
    same = to_target(garment.nodes, garment.faces, garment.contours)
    found = deform(garment, same, body, settings=QUICK)
    assert np.linalg.norm(found.nodes - garment.nodes, axis=1).max() < 1e-3


def test_going_on_from_the_target_stays_on_it(scene, fitted, rms):
    """Breaks if the short stage throws off what lies on the target already: 0.1 mm further off than the long one."""
    garment, target, body = scene
    settings = DeformSettings().for_folds()
    found = deform(garment.at(fitted.nodes), target, body, settings=settings)
    assert found.iterations <= settings.iterations < DeformSettings().iterations // 2
    for now, before in zip(
        rms(found.nodes, garment.faces, target), rms(fitted.nodes, garment.faces, target), strict=True
    ):
        assert now < before + 0.1


def test_going_on_keeps_the_strains_share_of_the_steps():
    """Breaks if the shorter stage ends before strain sets in, as the thesis' setting did, whose strain waits."""
    for whole in (DeformSettings(), DeformSettings.thesis()):
        short = whole.for_folds()
        assert short.strain_from / short.iterations == pytest.approx(whole.strain_from / whole.iterations, abs=0.01)


def moved(scene, matrix, shift):
    garment, target, body = scene
    return (
        garment.at(garment.nodes @ matrix.T + shift),
        replace(target, vertices=target.vertices @ matrix.T + shift, normals=target.normals @ matrix.T),
        ExposedSurface(body.vertices @ matrix.T + shift, body.faces),
    )


def test_result_moves_and_turns_with_the_scene(scene):
    """Breaks if a step depends on the axes or the origin. Ties of closest points leave a few hundredths of a mm."""
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    shift = np.array([1.0, -2.0, 0.5])
    straight = deform(*scene, settings=QUICK).nodes
    turned = deform(*moved(scene, turn, shift), settings=QUICK).nodes
    assert np.sqrt((((turned - shift) @ turn - straight) ** 2).sum(1).mean()) < 1e-4


def test_same_input_gives_the_same_bits(scene):
    """Breaks if anything depends on chance, threads or the order of a set."""
    first, second = (deform(*scene, settings=QUICK) for _ in range(2))
    assert np.array_equal(first.nodes, second.nodes)


def test_holes_in_the_target_do_not_pull(scene, fitted, rms):
    """Breaks if a hole's rim is taken for a contour, or drags the nodes that cover it to its edge."""
    garment, target, body = scene
    centre = target.vertices[target.faces].mean(axis=1)
    holes = [[0.0, 0.93, 0.16], [0.16, 0.95, 0.0], [-0.1, 0.97, -0.12]]
    keep = np.min([np.linalg.norm(centre - h, axis=1) for h in holes], axis=0) > 0.05
    assert 0.05 < 1 - keep.mean() < 0.25
    found = deform(garment, replace(target, faces=target.faces[keep]), body)
    ahead, back = rms(found.nodes, garment.faces, target)
    assert ahead < 2.0 and back < 2.0
    assert stretch_range(garment, found.nodes)[0] > 0.6


def test_a_cut_off_hem_is_left_free(scene):
    """Breaks if an untrusted contour pulls: the hem would rise by the 6 cm that are missing."""
    garment, target, body = scene
    keep = target.vertices[target.faces].mean(axis=1)[:, 1] > 0.87
    cut = replace(
        target, faces=target.faces[keep], contours=(replace(target.contours[0], trusted=False), target.contours[1])
    )
    found = deform(garment, cut, body)
    assert found.matched == ("waist",) and any("'hem'" in w for w in found.warnings)
    hem = found.nodes[garment.contours[0].vertices, 1]
    assert hem.mean() < 0.83


def test_reversed_scan_gives_the_same_garment(scene, fitted, rms):
    """Breaks if reversed normals turn the garment inside out."""
    garment, target, body = scene
    inside_out = replace(target, faces=target.faces[:, ::-1], normals=-target.normals)
    found = deform(garment, inside_out, body)
    assert found.normals_reversed and found.flipped_faces[1] == 0
    assert np.sqrt(((found.nodes - fitted.nodes) ** 2).sum(1).mean()) < 5e-4


def test_body_is_not_penetrated_even_by_a_target_inside_it(scene, rms):
    """Breaks if the clean-up misses a node or a face centre: the body is 4 mm thicker than the target's waist."""
    garment, target, body = scene
    middle = [0.0, 0.95, 0.0]
    thick = ExposedSurface((body.vertices - middle) * [1.37, 1.0, 1.37] + middle, body.faces)
    assert penetration_depth(target.vertices, target.faces, thick) > 2e-3
    found = deform(garment, target, thick)
    assert penetration_depth(found.nodes, garment.faces, thick) < 5e-4
    assert found.body_depth < 5e-4 and found.flipped_faces[1] == 0
    assert max(rms(found.nodes, garment.faces, target)) < 3.0


def test_cancellation_stops_within_a_step(scene):
    """Breaks if a stage forgets to ask its hooks."""
    asked = []

    def is_cancelled():
        asked.append(1)
        return len(asked) > 7

    with pytest.raises(Cancelled):
        deform(*scene, hooks=Hooks(is_cancelled=is_cancelled))
    assert len(asked) == 8


def test_progress_rises_to_one(scene):
    """Breaks if a stage reports a fraction that falls back."""
    seen = []
    deform(*scene, settings=QUICK, hooks=Hooks(on_progress=lambda stage, fraction, _: seen.append((stage, fraction))))
    fractions = [f for _, f in seen]
    assert {s for s, _ in seen} == {"deform"} and fractions == sorted(fractions) and fractions[-1] == 1.0


@pytest.mark.slow
def test_thesis_setting_does_not_snap_back(scene, rms):
    """Breaks if the strain is weighed against a mean instead of a sum: the fit would be lost when it sets in."""
    garment, target, body = scene
    settings = replace(DeformSettings.thesis(), iterations=240, strain_from=120, learning_rate=8e-3)
    found = deform(garment, target, body, settings=settings)
    assert not found.polished and found.losses["strain"][:120].max() == 0 and found.losses["strain"][-1] > 0
    assert max(rms(found.nodes, garment.faces, target)) < 6.0


def test_the_room_is_light_to_import():
    """Breaks if the command line would load torch for its help."""
    code = "import sys, garmentq.core.recover.deform; assert not {'torch', 'igl', 'numba'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_no_recovery_by_the_default_settings_needs_torch(scene, tmp_path):
    """Breaks if a stage of the default method, or a module that it imports, loads torch: 170 MB and a second."""
    garment, target, body = scene
    path = tmp_path / "scene.pickle"
    path.write_bytes(pickle.dumps((garment, target, body.vertices, body.faces)))
    code = f"""if True:
        import pickle, sys
        import garmentq, garmentq.core.recover.pipeline, garmentq.core.recover.methods
        from garmentq.core.body.exposed import ExposedSurface
        from garmentq.core.recover.deform.deformer import deform
        from garmentq.core.recover.deform.settings import DeformSettings
        garment, target, *skin = pickle.load(open({str(path)!r}, "rb"))
        found = deform(garment, target, ExposedSurface(*skin), settings=DeformSettings(iterations=4))
        assert found.iterations == 4
        assert "torch" not in sys.modules, "torch was imported"
    """
    subprocess.run([sys.executable, "-c", code], check=True)


def test_torch_is_imported_for_derivatives_alone():
    """Breaks if a module of the package but the two that differentiate through a drape imports torch, even late."""
    needs = re.compile(r"^\s*(?:import torch|from torch)\b", re.MULTILINE)
    found = {
        path.relative_to(ROOT).as_posix()
        for layer in ("core", "service", "workers", "cli")
        for path in (ROOT / layer).rglob("*.py")
        if needs.search(path.read_text(encoding="utf-8"))
    }
    assert found == {"core/cloth/hessian_form.py", "core/cloth/torch_bridge.py"}
