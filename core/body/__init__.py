"""The wearer: a mesh with joints, bones, skinning weights and a signed distance."""
