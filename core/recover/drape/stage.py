"""Drape a template on the wearer before grading, and the graded pattern to equilibrium after it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from ...body.body import Body
from ...body.hanging_arms import find_hanging_arms
from ...body.projection import project_outside
from ...body.skinning import skin, unskin, weights_at
from ...body.untangling import untangle_outside
from ...cloth.collision.self_contact import SelfContact
from ...cloth.fabric import Fabric
from ...cloth.locking import reduce_membrane_stiffness
from ...cloth.scene import Scene, SteadyRotation
from ...cloth.settings import STANDARD_GRAVITY, SolveSettings
from ...cloth.statics import Drape, StopCallback, equilibrium
from ...cloth.topology import Topology
from ...garment.garment import Garment
from ...garment.pattern import Pattern
from ...garment.resampling import resample
from ...garment.sewing import mesh_pattern
from ...geometry.geometry import deformation_gradients, principal_stretches
from ...run.best import choose_best
from ...run.hooks import SILENT_HOOKS, Hooks
from ...scan.contours.contours import name_contours
from ...scan.contours.loop import smoothed_length
from ...scan.contours.target import Target
from .dress import DressSettings, dress, place_panels
from .front_placement import FRONT_EDGES, pin_front, place_pinned
from .layer_contact import LayerContact
from .pbd import DistanceConstraints, PbdSettings, PbdState, build_distance_constraints, simulate_pbd
from .pose_path import pose_cloth
from .waist import flat_lengths, waist_loop
from .waist_placement import pin_waist, place_waist
from .wearer import WearerGeometry
from .worn_contours import count_borders, name_worn_contours

MIDDLE_PLANE_DISTANCE = 0.1
"""Distance of placed panels from the middle plane while contours are named [m]: more than bones deviate from it."""

MAX_DRESSED_STRETCH = 1.5
"""Stretch [1], exceeded by a thousandth of the faces of a dressed pattern at rest, above which it is dressed again on a
finer mesh, because cloth is caught. A caught T-shirt had 4.7, wide trousers with legs caught in each other 3.0,
trousers with hems caught under the feet 1.65 (1.1 from the finer mesh), 102 others at most 1.4: five of these, from
1.31 on, have 1.32 to 1.52 on the finer mesh, too."""

EASED_GRAVITY = 0.5
"""Gravity on eased cloth [m/s2], a twentieth of the real one: unstretched cloth hangs alike, skirts do not float."""


@dataclass(frozen=True)
class DrapeSettings:
    """Describe both drapes.

    Attributes:
        template_vertices: Number of vertices of the template's mesh; 1500 resolve a T-shirt with edges of 2.5 cm,
            enough for the measures that grading takes, and dress in under 2 s.
        pose_steps: Number of position-based steps that settle the skinned cloth on the posed body.
        ease_steps: Number of position-based steps under little weight that remove the stretch of a template in the
            pose. Under its own weight the sweeps do not converge: a dress hung 12 cm too low, its straps stretched to
            1.6, its waist seam on the hips. 40 steps leave 1 to 3 % of that.
        settle_steps: Number of position-based steps without weight before Newton. The registered mesh is stretched by
            up to half in places; 15 steps bring every edge within a quarter. Under weight the sweeps, which do not
            converge on 4000 vertices, would stretch the cloth by 7 % and Newton would take 30 iterations to undo it.
        self_contact: The cloth does not pass through itself at rest. Off where a pattern is graded or fitted later.
        dress: The first drape.
        follow: The position-based steps in the pose.
        solve: The equilibrium.
    """

    template_vertices: int = 1500
    pose_steps: int = 60
    ease_steps: int = 0
    settle_steps: int = 15
    self_contact: bool = False
    dress: DressSettings = field(default_factory=DressSettings)
    follow: PbdSettings = field(default_factory=PbdSettings)
    solve: SolveSettings = field(default_factory=SolveSettings)

    def eased(self) -> DrapeSettings:
        """Return the settings for a template whose stretch would be graded."""
        return replace(self, ease_steps=40)


def waist_height(target: Target, body: Body) -> float | None:
    """Return the height of the target's waist contour carried back to the T-pose [m], or None without a waist."""
    waist = target.waist
    if waist is None:
        return None
    points = target.vertices[waist.vertices]
    return float(unskin(points, weights_at(body, points, rest=False), body.transforms)[:, 1].mean())


def drape_template(
    pattern: Pattern,
    wearer: WearerGeometry,
    target: Target | None = None,
    *,
    carry: bool = False,
    settings: DrapeSettings = DrapeSettings(),
    hooks: Hooks = SILENT_HOOKS,
) -> Garment:
    """Mesh, sew and dress a base pattern on the wearer, in the wearer's pose, and name its contours.

    The first drape is on the T-pose; the cloth is then carried into the pose with the skin around it and settles on the
    wearer's own mesh. Where the target has a waist, the garment's waist is tied to it. If an opening does not surround
    a part of the body, the wearer is dressed again with seams that are free in the middle plane.

    Args:
        pattern: The base pattern.
        wearer: The wearer's geometry.
        target: The scan, which gives the place of the waist, or None for the body's own waist.
        carry: Carry also what hangs from a target's waist, and sleeves of hanging arms, with the skin. Skinning
            suffices to start grading and is a second faster, but can pinch cloth between legs or in armpits.
        settings: Resolution and steps.
        hooks: Progress and cancellation.

    Returns:
        The draped garment; `contours` named on the wearer.
    """
    garment = mesh_pattern(pattern, settings.template_vertices)
    threads = build_distance_constraints(garment, settings.dress.follow.bending)
    hooks.progress("template", 0.1, "dressing the T-pose")
    hung = _dress(garment, threads, wearer, target, settings.dress, hooks)
    loops = count_borders(garment)
    # Posing is expensive, so openings are counted before it.
    if settings.dress.outline and _count_openings(hung, garment, wearer.rest) < loops:
        # On bodies of loose parts (mannequins) a seam can be pushed along an arm: an opening then surrounds nothing.
        free = _dress(garment, threads, wearer, target, replace(settings.dress, outline=False), hooks)
        tried = {"outline held": hung, "outline free": free}
        hung = choose_best("dressing", tried, lambda nodes: -float(_count_openings(nodes, garment, wearer.rest)), hooks)
    worn = _pose_garment(garment, threads, hung, wearer, target, carry, settings, hooks)
    lost = settings.dress.outline and len(worn.contours) < loops
    return name_contours_as_placed(worn, wearer.rest) if lost else worn


def _count_openings(nodes: np.ndarray, garment: Garment, body: Body) -> int:
    """Count the openings that surround a part of the body."""
    return len(name_contours(nodes, garment.faces, body)[0])


def _dress(
    garment: Garment,
    threads: DistanceConstraints,
    wearer: WearerGeometry,
    target: Target | None,
    settings: DressSettings,
    hooks: Hooks,
) -> np.ndarray:
    """Dress the T-pose, the waist where the target has it; return the nodes [m], shape [node_count, 3]."""
    return dress(
        garment,
        wearer.rest,
        wearer.rest_grid,
        waist_height=None if target is None else waist_height(target, wearer.body),
        settings=settings if target is None else replace(settings, unfold=False),
        hooks=hooks,
        threads=threads,
    )


def _pose_garment(
    garment: Garment,
    threads: DistanceConstraints,
    nodes: np.ndarray,
    wearer: WearerGeometry,
    target: Target | None,
    carry: bool,
    settings: DrapeSettings,
    hooks: Hooks,
) -> Garment:
    """Carry cloth on the T-pose (nodes [m], shape [node_count, 3]) into the wearer's pose; name its contours."""
    hooks.progress("template", 0.6, "taking the pose")
    body = wearer.body
    waist = waist_loop(garment)
    if target is None or carry or (waist is None and not has_hanging_sleeves(target, body)):
        nodes, _ = pose_cloth(threads, nodes, wearer.way, wearer.grid, pins=waist)
    else:  # skinned: enough to start grading, though in places pinched between legs or under arms
        nodes = skin(nodes, weights_at(body, nodes, rest=True), body.transforms)
    pinned = waist
    if waist is not None and target is not None:
        nodes[waist] = place_waist(nodes[waist], target, flat_lengths(garment, waist))
    elif target is not None and target.contour(FRONT_EDGES[0]) is not None:
        front = pin_front(garment.at(nodes, name_worn_contours(garment, nodes, body)), target, body)
        if front is not None:
            nodes, pinned = place_pinned(nodes, front), front.nodes
    if pinned is not None and target is not None:
        start, steps, weight = PbdState.at_rest(nodes), settings.pose_steps, -STANDARD_GRAVITY[1]
        nodes = simulate_pbd(
            threads, start, wearer.grid, steps, settings=settings.follow, gravity=weight, pins=pinned
        ).nodes
    if settings.ease_steps:
        start, steps = PbdState.at_rest(nodes), settings.ease_steps
        nodes = simulate_pbd(
            threads, start, wearer.grid, steps, settings=settings.follow, gravity=EASED_GRAVITY, pins=waist
        ).nodes
    return garment.at(nodes, name_worn_contours(garment, nodes, body))


def has_hanging_sleeves(target: Target, body: Body) -> bool:
    """Return whether the wearer has hanging arms in sleeves.

    Carrying pushes cloth 7 cm down out of the closed armpit; without self-contact sleeves and sides cross there.
    """
    return bool(find_hanging_arms(body)) and any(contour.name.startswith("cuff") for contour in target.contours)


def name_contours_as_placed(worn: Garment, rest: Body) -> Garment:
    """Name a worn garment's contours by its placed panels around the T-pose, where that names more of them.

    Trousers far too long for their wearer crumple about the feet, and the ends of their legs then surround nothing;
    flat, they hang over the feet. Lengths are those of the worn contours.
    """
    contours = name_worn_contours(worn, place_panels(worn, rest, flatten=MIDDLE_PLANE_DISTANCE), rest)
    if len(contours) <= len(worn.contours):
        return worn
    lengths = [smoothed_length(worn.nodes[contour.vertices]) for contour in contours]
    return worn.at(worn.nodes, tuple(replace(c, length=length) for c, length in zip(contours, lengths, strict=True)))


def remesh(garment: Garment, vertex_count: int) -> Garment:
    """Mesh a garment's pattern again with a number of vertices, nodes on the garment's present surface."""
    mesh = mesh_pattern(garment.pattern, vertex_count)
    return mesh.at(resample(garment, garment.nodes, mesh))


def drape_graded(
    garment: Garment,
    wearer: WearerGeometry,
    fabric: Fabric,
    target: Target,
    *,
    rotation: SteadyRotation | None = None,
    stop: StopCallback | None = None,
    settings: DrapeSettings = DrapeSettings(),
    hooks: Hooks = SILENT_HOOKS,
) -> tuple[Garment, Drape]:
    """Drape a graded pattern at full resolution, to equilibrium, outside the wearer's exact mesh.

    A garment with creases keeps apart from itself whatever the settings: a fall would sink into its stand.

    Args:
        garment: The graded pattern's mesh, nodes near the target, from which the search starts.
        wearer: The wearer's geometry.
        fabric: The cloth.
        target: The scan; its waist, or the edges of its open front, if any, hold the garment's.
        rotation: The rotation in which the wearer turns, or None for cloth under its weight alone.
        stop: Called after each leg of the equilibrium; returns whether to stop.
        settings: Steps.
        hooks: Progress and cancellation.

    Returns:
        The garment at rest with named contours, and the drape with its residual.
    """
    nodes, pins = garment.nodes, pin_waist(garment, target) or pin_front(garment, target, wearer.body)
    nodes = nodes if pins is None else place_pinned(nodes, pins)
    hooks.progress("drape", 0.1, "settling")
    threads = build_distance_constraints(garment, settings.follow.bending)
    fixed = None if pins is None else pins.nodes
    start, steps = PbdState.at_rest(nodes), settings.settle_steps
    layers = LayerContact() if threads.is_creased else None
    nodes = simulate_pbd(threads, start, wearer.grid, steps, settings=settings.follow, pins=fixed, layers=layers).nodes
    hooks.progress("drape", 0.3, "equilibrium")
    topology = Topology.from_garment(garment)
    keeps_apart = settings.self_contact or threads.is_creased
    contact = SelfContact.of(topology) if keeps_apart else None
    scene = Scene(topology, reduce_membrane_stiffness(fabric), wearer.grid, pins, rotation, self_contact=contact)
    drape = equilibrium(scene, nodes, settings=settings.solve, hooks=hooks, stop=stop)
    nodes = project_outside(drape.nodes, wearer.exposed, garment.faces)
    nodes = untangle_outside(nodes, wearer.exposed, garment.faces) if keeps_apart else nodes
    return garment.at(nodes, name_worn_contours(garment, nodes, wearer.body)), drape


def measure_stretch(worn: Garment) -> float:
    """Return the stretch that a thousandth of a worn garment's faces exceeds."""
    stretches = principal_stretches(deformation_gradients(worn.nodes, worn.faces, worn.rest))
    return float(np.quantile(stretches[:, 0], 0.999))


def redrape(
    garment: Garment,
    wearer: WearerGeometry,
    fabric: Fabric,
    target: Target,
    *,
    rotation: SteadyRotation | None = None,
    settings: DrapeSettings = DrapeSettings(self_contact=True),
    hooks: Hooks = SILENT_HOOKS,
) -> tuple[Garment, Drape]:
    """Dress the wearer in a recovered pattern from its rest placement, as if only the pattern were known.

    Only the waist of a garment that hangs from it, or how far its front is open, is taken from the scan. The folds may
    differ from those of a drape that starts on the scan; the result shows the quality of the pattern alone. The cloth
    keeps apart from itself.

    Args:
        garment: The pattern's mesh; the result has its topology, its nodes are not used.
        wearer: The wearer's geometry.
        fabric: The cloth.
        target: The scan; its waist, or the edges of its open front, if any, hold the garment's.
        rotation: The rotation in which the wearer turns, or None for cloth under its weight alone.
        settings: Steps.
        hooks: Progress and cancellation.

    Returns:
        The garment at rest outside the wearer's exact mesh, contours named, and the drape with its residual.
    """

    def dress_and_settle(chosen: DrapeSettings) -> tuple[Garment, Drape]:
        worn = drape_template(garment.pattern, wearer, target, carry=True, settings=chosen, hooks=hooks)
        placed = garment.at(resample(worn, worn.nodes, garment))
        return drape_graded(placed, wearer, fabric, target, rotation=rotation, settings=chosen, hooks=hooks)

    tried = {"usual": dress_and_settle(settings)}
    if measure_stretch(tried["usual"][0]) > MAX_DRESSED_STRETCH:
        # a sleeve of few faces can be caught beside an arm, a leg on the other; what is caught stays caught at rest
        tried["finer"] = dress_and_settle(replace(settings, template_vertices=2 * settings.template_vertices))
    return choose_best("mesh that is dressed", tried, lambda found: measure_stretch(found[0]), hooks)
