"""Set a garment up as sewn cloth in Blender: `blender --python THIS_FILE`, or run it in the text editor.

The panels are one mesh that is cut along the seams; loose edges join both sides of each seam, which Blender's cloth
uses as sewing threads. The flat panels are the rest shape. START is the cloth's first place: with "worn" the mesh is
worn in the first frame alone and flat from the second on, because a dynamic mesh has its rest lengths from there. Mass
is the fabric's. Blender's stiffnesses have no physical units and are not changed.
"""

import os

import bpy

FOLDER = ""
"""Where the files are; empty: beside this file, beside the .blend file, or in the current folder."""

STEM = ""
"""Beginning of the files' names."""

VERTEX_MASS = 0.0
"""Mass of a vertex [kg]."""

START = "worn"
"""`worn`: where the garment was at rest; `flat`: panels beside the body, which the threads pull together."""


def find_folder() -> str:
    """Find the folder with the files."""
    places: list[str] = [FOLDER, os.path.dirname(globals().get("__file__", "")), bpy.path.abspath("//"), os.getcwd()]
    for place in places:
        if place and os.path.isfile(os.path.join(place, STEM + "_sewing.obj")):
            return place
    raise FileNotFoundError(f"{STEM}_sewing.obj is not found; set FOLDER at the top of this script.")


def load(folder: str, part: str) -> "bpy.types.Object":
    """Import an OBJ of metres, y up, and return its object."""
    bpy.ops.wm.obj_import(filepath=os.path.join(folder, f"{STEM}_{part}.obj"), forward_axis="NEGATIVE_Z", up_axis="Y")
    found = bpy.context.selected_objects[0]
    found.name = f"{STEM}_{part}"
    return found


def set_up() -> "bpy.types.Object":
    """Make the garment and the body, and return the garment."""
    folder = find_folder()
    body, flat, worn = load(folder, "body"), load(folder, "sewing"), load(folder, "worn")
    body.modifiers.new("Collision", "COLLISION")
    body.collision.thickness_outer = 0.002
    places = [vertex.co.copy() for vertex in worn.data.vertices]
    bpy.data.objects.remove(worn)
    flat.shape_key_add(name="flat", from_mix=False)
    key = flat.shape_key_add(name="worn", from_mix=False)
    for point, place in zip(key.data, places, strict=True):
        point.co = place
    if START == "worn":
        for frame, value in ((1, 1.0), (2, 0.0)):
            key.value = value
            key.keyframe_insert("value", frame=frame)
    cloth = flat.modifiers.new("Cloth", "CLOTH")
    cloth.settings.use_sewing_springs = True
    cloth.settings.mass = VERTEX_MASS
    cloth.settings.use_dynamic_mesh = True
    cloth.settings.quality = 12
    cloth.collision_settings.distance_min = 0.002
    return flat


if __name__ == "__main__":
    set_up()
