"""`garmentq bodies`: the built-in wearers."""

from __future__ import annotations

from pathlib import Path

import click

from .options import json_option
from .output import NewFile, writing


@click.group("bodies")
def command() -> None:
    """List the built-in bodies, and write a body as a mesh or by its parameters.

    \b
    Example:
      garmentq bodies list
      garmentq bodies export builtin:female,height=1.70 -o body.ply
    """


@command.command("list")
@json_option
def list_bodies(as_json: bool) -> None:
    """List the built-in bodies with their parameters.

    \b
    Example:
      garmentq bodies list
    """
    from ..core.body.builtin import describe_bodies
    from .terminal import print_json, print_table

    bodies = describe_bodies()
    if as_json:
        for body in bodies:
            print_json(body)
        return
    rows = [
        [body["spec"], *(f"{low:g} to {high:g} ({usual:g})" for low, high, usual in body["ranges"]), body["poses"]]
        for body in bodies
    ]
    print_table(["body", "height m", "weight kg", "pose"], [[*row[:3], ", ".join(row[3])] for row in rows])


@command.command("export")
@click.argument("spec")
@click.option("-o", "--out", required=True, type=NewFile(), help="File: .ply, or .json of Anny's parameters.")
@json_option
def export(spec: str, out: Path, as_json: bool) -> None:
    """Write a body as a mesh, and its joints as JSON beside it.

    SPEC is builtin:female|male[,height=1.70][,weight=62][,pose=T|A|arms-down], or the file of a body model: SMPL's,
    SMPL-X's, MHR's or SOMA's .npz, or Anny's parameters, .json or .npz. A body by these is also written as .json.

    \b
    Example:
      garmentq bodies export builtin:female,height=1.70 -o body.ply
      garmentq bodies export anny.npz -o anny.json
    """
    from ..core.body.body import JOINTS
    from ..core.body.builtin import builtin_body
    from ..core.body.models.model_file import load_body_model
    from ..core.body.spec import is_body_model
    from ..core.deliver.export.meshes import write_ply
    from .terminal import print_json, print_note

    if out.suffix.lower() not in (".ply", ".json"):
        raise click.UsageError(f"'{out.name}' ends neither in .ply nor in .json; bodies are written as these.")
    body = load_body_model(Path(spec)) if is_body_model(spec) else builtin_body(spec)
    if out.suffix.lower() == ".json":
        from ..core.body.models.anny_file import write_anny

        text = write_anny(body)
        with writing(out):
            out.write_text(text, encoding="utf-8")
        if as_json:
            print_json({"file": str(out), "source": body.source})
        else:
            print_note(f"{out}: Anny's parameters")
        return
    joints = {name: [round(float(x), 6) for x in place] for name, place in zip(JOINTS, body.joints, strict=True)}
    beside = out.with_name(f"{out.stem}_joints.json")
    with writing(out):
        write_ply(body.vertices, body.faces, out)
        beside.write_text(_dump(joints), encoding="utf-8")
    if as_json:
        print_json({"file": str(out), "joints_file": str(beside), "source": body.source, "joints_m": joints})
    else:
        print_note(f"{out}: {len(body.vertices)} vertices, {len(body.faces)} faces; joints in {beside.name}")


def _dump(joints: dict[str, list[float]]) -> str:
    import json

    return json.dumps(joints, indent=1) + "\n"
