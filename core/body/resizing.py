"""Change a wearer's girths and height, and keep the figure otherwise."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from .body import Body
from .builtin import named_pose, pose_template
from .girths import TapeMeasure
from .measured import TargetMeasures, nearest_shape
from .registration import register_body
from .template import Template, load_template


def resize_body(body: Body, growth: Mapping[str, float], ratio: float = 1.0, pose: str = "A") -> Body:
    """Return a body with a wearer's figure but other girths and another height.

    It is of the built-in model: the shape nearest to the wearer's that has the measures, each girth within 3 mm.

    Args:
        body: The wearer; the built-in model is first fitted to a body of another model.
        growth: Increase of some of `GIRTHS` over the wearer's [m].
        ratio: Height relative to the wearer's.
        pose: One of `POSES`.

    Raises:
        MeasureRange: where the model has no body with these measures.
    """
    template = load_template()
    if not np.array_equal(body.rest_faces, template.faces):
        body = register_body(body.rest_vertices, body.rest_faces)
    shape = np.zeros(template.shape_count)
    coefficients = body.parameters["shape"]
    shape[: len(coefficients)] = coefficients
    tape, tall = TapeMeasure.of(body), float(np.ptp(body.rest_vertices[:, 1]))
    girths = {name: tape.measure(name).value + more for name, more in growth.items()}
    fitted = nearest_shape(template, shape, TargetMeasures(_find_gender(template, shape), ratio * tall, None, girths))
    return pose_template(template, fitted, named_pose(pose), "resized")


def _find_gender(template: Template, shape: np.ndarray) -> str:
    """Return the gender whose mean is nearer to a shape, each by its own covariance."""
    apart = {}
    for name, mean in template.means.items():
        off = shape - mean
        apart[name] = float(off @ np.linalg.solve(template.covariances[name], off))
    return min(apart, key=lambda name: (apart[name], name))
