"""Feet below long trousers: what holds the legs where they stand."""

from __future__ import annotations

import numpy as np
from garmentq.core.body.body import JOINTS
from garmentq.core.body.fit import FitState
from garmentq.core.body.person import PersonFit, refit_person
from garmentq.core.body.registration import body_of_state, pose_model
from garmentq.core.body.template import load_template, rotations_of
from garmentq.core.geometry.geometry import vertex_normals
from garmentq.core.people.part import PARTS, Part
from garmentq.core.people.separate import to_point_weights

TEMPLATE = load_template()
WIDE = 0.11
"""Radius of the trousers' legs [m]: wide ones, that tell little of the legs."""


def test_shoes_hold_the_feet_of_a_suits_wearer() -> None:
    """Broken where shoes hardly count: legs then go where they like within wide trousers (ankles 3 to 6 cm off)."""
    state = FitState(np.zeros(10), rotations_of(np.zeros((24, 3))), np.zeros(3))
    body = body_of_state(TEMPLATE, state, 0.0)
    skin, normals = pose_model(TEMPLATE, state)
    joint = np.array(JOINTS)[TEMPLATE.weights.argmax(axis=1)]
    label = np.full(len(skin), int(Part.UPPER))
    label[np.isin(joint, ("head", "neck", "left_wrist", "right_wrist", "left_hand", "right_hand"))] = Part.SKIN
    label[np.isin(joint, ("left_hip", "right_hip", "left_knee", "right_knee"))] = Part.LOWER
    label[np.isin(joint, ("left_ankle", "right_ankle", "left_foot", "right_foot"))] = Part.SHOES
    lift = np.select([label == Part.SHOES, label >= Part.UPPER], [0.006, 0.015], 0.0)
    points = skin + lift[:, None] * normals
    for side in ("left", "right"):
        hip, ankle = body.joint(f"{side}_hip"), body.joint(f"{side}_ankle")
        bone = (ankle - hip) / np.linalg.norm(ankle - hip)
        leg = np.isin(joint, (f"{side}_hip", f"{side}_knee")) & (skin[:, 1] < hip[1] - 0.1)
        across = points[leg] - hip - ((points[leg] - hip) @ bone)[:, None] * bone
        radius = np.linalg.norm(across, axis=1)
        points[leg] += (np.maximum(WIDE - radius, 0.01) / radius)[:, None] * across
    posterior = (label[:, None] == np.array(PARTS)).astype(np.float64)
    fit = PersonFit(body, state, 0.0, 0.0, 1.0, 0.0)
    for _ in range(2):
        fit = refit_person(fit, points, vertex_normals(points, TEMPLATE.faces), to_point_weights(posterior))
    for name in ("left_ankle", "right_ankle"):
        assert np.linalg.norm(fit.body.joint(name) - body.joint(name)) < 0.015
