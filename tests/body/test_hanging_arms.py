"""The hollow under an arm that hangs beside the trunk."""

from __future__ import annotations

import numpy as np
import pytest
from garmentq.core.body.body import Body
from garmentq.core.body.builtin import builtin_body
from garmentq.core.body.hanging_arms import find_hanging_arms, lies_under_arm


@pytest.fixture(scope="module")
def hanging() -> Body:
    """Stand the built-in body with its arms down."""
    return builtin_body("builtin:female,pose=arms-down")


@pytest.mark.parametrize(("pose", "sides"), [("T", ()), ("A", ()), ("arms-down", ("left", "right"))])
def test_arms_hang_where_the_pose_says_so(pose, sides):
    """Broken where another bone is taken, or the angle is measured from the vertical of another body."""
    assert find_hanging_arms(builtin_body(f"builtin:female,pose={pose}")) == sides


def test_only_what_lies_between_arm_and_trunk_is_under_the_arm(hanging):
    """Broken where a shoulder or the outside of an arm, both near to arm and trunk, count as an armpit."""
    side = np.sign(hanging.joint("left_shoulder")[0])
    shoulder, front = hanging.joint("left_shoulder"), np.array([0.0, 0.0, 1.0])
    near = np.abs(hanging.vertices[:, 1] - (shoulder[1] - 0.12)) < 0.02
    out = side * hanging.vertices[:, 0]
    arm = hanging.weights[:, [18, 16] if side > 0 else [19, 17]].sum(axis=1) > 0.5
    trunk = hanging.weights[:, [0, 3, 6, 9]].sum(axis=1) > 0.9
    gap = np.array([side * 0.5 * (out[near & arm].min() + out[near & trunk].max()), shoulder[1] - 0.12, shoulder[2]])
    above = shoulder + 0.08 * np.array([0.0, 1.0, 0.0])
    points = np.array([gap, above, shoulder + 0.1 * front, gap + 0.3 * front])
    assert lies_under_arm(points, hanging).tolist() == [True, False, False, False]


def test_nothing_is_under_an_arm_that_is_raised():
    """Broken where the armpit of an A pose, which a scanner sees, is taken for hidden."""
    body = builtin_body("builtin:female,pose=A")
    assert not lies_under_arm(body.vertices, body).any()
