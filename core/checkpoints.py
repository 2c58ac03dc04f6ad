"""Keep the two dear intermediate results, so that a job that is run again goes on where it was stopped."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from .body import Body
from .hooks import Arrays, Hooks
from .pattern import Garment, Pattern, mesh_pattern
from .segment import name_contours
from .simulate import Drape, Outcome, SteadyRotation

_BODY_ARRAYS = tuple(f.name for f in fields(Body) if f.name not in ("parameters", "source", "fit_rms"))


def keep_body(hooks: Hooks, body: Body) -> None:
    """Save a registered body under the name `body`."""
    arrays = {name: getattr(body, name) for name in _BODY_ARRAYS}
    arrays |= {f"parameter.{name}": np.asarray(value) for name, value in body.parameters.items()}
    hooks.save_checkpoint("body", {**arrays, "source": _text(body.source), "fit_rms": np.array(body.fit_rms)})


def kept_body(hooks: Hooks) -> Body | None:
    """Give the body that an earlier run of the job registered, or None."""
    kept = hooks.load_checkpoint("body")
    if kept is None:
        return None
    parameters = {name.partition(".")[2]: kept[name] for name in kept if name.startswith("parameter.")}
    arrays = {name: kept[name] for name in _BODY_ARRAYS}
    return Body(**arrays, parameters=parameters, source=_read(kept["source"]), fit_rms=float(kept["fit_rms"]))


def keep_drape(hooks: Hooks, garment: Garment, drape: Drape, warnings: list[str]) -> None:
    """Save the graded pattern's control points and its drape under the name `drape`."""
    hooks.save_checkpoint(
        "drape",
        {
            "points": garment.pattern.points,
            "garment": garment.nodes,
            "nodes": drape.nodes,
            "anchors": drape.anchors,
            "numbers": np.array([drape.residual, drape.iterations, drape.energy]),
            "spin": np.zeros(0) if drape.rotation is None else np.array([drape.rotation.rate, *drape.rotation.centre]),
            "texts": _text("\n".join([drape.outcome, *warnings])),
        },
    )


def kept_drape(hooks: Hooks, base: Pattern, vertex_count: int, body: Body) -> tuple[Garment, Drape, list[str]] | None:
    """Give the garment, drape and warnings that an earlier run of the job reached, or None.

    The mesh is made again: the same control points and vertex count give the same mesh.
    """
    kept: Arrays | None = hooks.load_checkpoint("drape")
    if kept is None:
        return None
    garment = mesh_pattern(base.with_points(kept["points"]), vertex_count)
    contours, _ = name_contours(kept["garment"], garment.faces, body)
    residual, iterations, energy = kept["numbers"]
    outcome, *warnings = _read(kept["texts"]).split("\n")
    rotation = [float(value) for value in kept.get("spin", ())]
    drape = Drape(
        nodes=kept["nodes"],
        residual=float(residual),
        iterations=int(iterations),
        energy=float(energy),
        outcome=Outcome(outcome),
        anchors=kept["anchors"],
        rotation=SteadyRotation(rotation[0], (rotation[1], rotation[2], rotation[3])) if rotation else None,
    )
    return garment.at(kept["garment"], contours), drape, warnings


def _text(text: str) -> np.ndarray:
    return np.frombuffer(text.encode(), dtype=np.uint8)


def _read(codes: np.ndarray) -> str:
    return bytes(np.asarray(codes, dtype=np.uint8)).decode()
