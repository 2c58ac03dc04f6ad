"""From the colours of a scan to a texture on a garment's flat panels."""

from .bake import BakedTexture, bake_texture, check_texel
from .fill import fill_gaps, spread_border
from .lookup import colour_vertices
from .texels import Texels, find_texels

__all__ = [
    "BakedTexture",
    "Texels",
    "bake_texture",
    "check_texel",
    "colour_vertices",
    "fill_gaps",
    "find_texels",
    "spread_border",
]
