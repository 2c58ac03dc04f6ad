"""The wearer: a mesh with joints, bones, skinning weights and a signed distance."""

from .body import JOINTS, PARENTS, Body

__all__ = ["JOINTS", "PARENTS", "Body"]
