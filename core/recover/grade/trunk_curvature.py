"""Compute the Gaussian curvature of the cloth around the trunk: it is not zero at curved seams and ends of darts."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ...body.body import Body
from ...body.skinning import rest_body
from ...garment.measures import BodyMeasures
from ...geometry.connectivity import HalfEdges
from ...geometry.geometry import angle_defects, unit, vertex_normals
from ...scan.contours.target import Target
from ..drape.sizing import measure_wearer


@dataclass(frozen=True)
class TrunkCurvature:
    """Describe the Gaussian curvature of a garment's cloth in the axes of its wearer's trunk.

    Between its seams a panel is developable: its curvature is zero, unlike at curved seams and ends of darts.

    Attributes:
        points: Vertices [m]: to the wearer's left, upwards from the resting body's feet, forwards, shape [n, 3].
        curvature: Of each, 2 pi less the sum of the angles around it [rad], shape [n]; 0 on open contours.
        on_rim: Vertices of open contours and of holes, shape [n].
        faces_up: Vertices whose normal is within 60 degrees of upwards, shape [n].
        measures: Of the wearer.
        shoulders: The wearer's left and right shoulder joint, shape [2, 3].
        axes: Unit vectors to the wearer's left, upwards and forwards, shape [3, 3].
        origin: The middle of the body at its feet's height, in the target's axes [m], shape [3].
    """

    points: np.ndarray
    curvature: np.ndarray
    on_rim: np.ndarray
    faces_up: np.ndarray
    measures: BodyMeasures
    shoulders: np.ndarray
    axes: np.ndarray
    origin: np.ndarray

    @classmethod
    def of(cls, target: Target, body: Body) -> TrunkCurvature:
        """Compute the curvature of a target around its wearer."""
        sideways = unit((body.joint("left_hip") - body.joint("right_hip"))[None])[0]
        upwards = unit((body.joint("neck") - body.joint("pelvis"))[None])[0]
        axes = np.stack([sideways, upwards, np.cross(sideways, upwards)])
        origin = body.joint("pelvis") - rest_body(body).joint("pelvis")[1] * upwards
        joints = np.stack([body.joint("left_shoulder"), body.joint("right_shoulder")])
        return cls(
            points=(target.vertices - origin) @ axes.T,
            curvature=angle_defects(target.vertices, target.faces),
            on_rim=HalfEdges.of(target.faces, len(target.vertices)).border_vertices,
            faces_up=vertex_normals(target.vertices, target.faces) @ upwards > 0.5,
            measures=measure_wearer(body),
            shoulders=(joints - origin) @ axes.T,
            axes=axes,
            origin=origin,
        )

    def gather(self, places: np.ndarray, counted: np.ndarray, reach: float) -> np.ndarray:
        """Return the curvature around places [rad], shape [m]: a vertex at distance d counts by (1 - (d / reach)^2)^3.

        The share falls smoothly, so that noise, which adds at one vertex what it takes from its neighbours, cancels.

        Args:
            places: In the trunk's axes [m], shape [m, 3].
            counted: Vertices that count, shape [n].
            reach: Beyond which none counts [m].
        """
        pair = cKDTree(places).sparse_distance_matrix(cKDTree(self.points[counted]), reach, output_type="coo_matrix")
        share = (1.0 - (pair.data / reach) ** 2) ** 3
        return np.bincount(pair.row, share * self.curvature[counted][pair.col], minlength=len(places))
