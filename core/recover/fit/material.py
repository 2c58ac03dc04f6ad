"""Fit a registered garment's bending stiffness, and estimate what one drape shows of the other parameters."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ...cloth.fabric import Fabric, FabricEstimate
from ...cloth.fabrics import load_fabrics
from ...garment.pattern import Pattern
from ...run.checkpoints import load, save
from ...run.hooks import SILENT_HOOKS, Hooks
from .settings import MaterialSettings
from .shape import ShapeProblem, seam_null_space

if TYPE_CHECKING:
    from ...cloth.statics import Drape

MEMBRANE_STIFFNESSES = ("H00", "H01", "H11", "H22")
"""The membrane stiffnesses, in the order of the posterior's parameters; k follows them."""

_MAX_FOLDING_SIGMA_COUNT = 3.0
"""Number of standard deviations by which the folding of the nearest drape may be off before folds and misfit count as
contradicting each other: k then replaces something that the simulator lacks, and is not identified."""

_MIN_DRAPE_COUNT = 3
"""Smallest number of drapes at rest from which k is estimated: with fewer a curve has no minimum."""

FOUND_BENDING_SUFFIX = ", bending found from the scan"
"""End of a fabric's title where its k is not the named fabric's."""

_MAX_IDENTIFIED_STD_SHARE = 0.5
"""Largest share of the prior's standard deviation at which a parameter counts as identified: the drape halves it."""


def ratio_prior(name: str, settings: MaterialSettings) -> tuple[float, float]:
    """Return mean and standard deviation of ln(parameter / density) over the library, the deviation widened."""
    logs = np.log([getattr(fabric, name) / fabric.density for fabric in load_fabrics()])
    return float(logs.mean()), settings.widen * float(logs.std())


def measure_folding(problem: ShapeProblem, nodes: np.ndarray) -> float:
    """Return the bending energy of nodes [m] per unit of k, a pure number: the amount of folding, independent of place.

    S = sum_h 2 c_h (1 - cos((theta_h - theta0_h) / 2)), notation of `cloth/bending.py`. It falls steadily as k grows,
    also where the drape has other folds than the target and distances give no evidence.
    """
    from ...cloth.energy import Energy
    from ...cloth.scene import Scene

    only = replace(problem.fabric, H00=0.0, H01=0.0, H11=0.0, H22=0.0, k=1.0, density=0.0)
    return Energy(Scene(problem.scene.first.topology, only)).value(nodes)


@dataclass(frozen=True)
class _TriedStiffness:
    """Describe the drape of a stiffness that was tried.

    Attributes:
        ratio: ln(k / density).
        folding: Logarithm of its folding [1].
        loss: Logarithm of its loss.
        at_rest: Whether it came to rest.
        nodes: Positions [m], shape [node_count, 3].
    """

    ratio: float
    folding: float
    loss: float
    at_rest: bool
    nodes: np.ndarray


@dataclass(frozen=True)
class _TriedStiffnesses:
    """Describe the stiffnesses tried so far (checkpoint `fit.fabric`)."""

    tried: tuple[_TriedStiffness, ...]


def _list_at_rest(tried: list[_TriedStiffness]) -> np.ndarray:
    """Return ln(k / density), ln folding and ln loss of the drapes at rest, in ascending order, shape [n, 3]."""
    return np.array(sorted((one.ratio, one.folding, one.loss) for one in tried if one.at_rest)).reshape(-1, 3)


def fit_bending(
    problem: ShapeProblem, settings: MaterialSettings | None = None, hooks: Hooks = SILENT_HOOKS
) -> tuple[Fabric, FabricEstimate]:
    """Estimate k of the cloth of a registered garment, at the density of the problem's fabric.

    Equilibria from the registered nodes over the library's range of k / density, widened; then
        -ln posterior(ln k) = (ln S(k) - ln S_target)^2 / (2 s^2) + n/2 ln L(k) + (ln k - mean)^2 / (2 spread^2)
    with S `measure_folding`, L the registered loss, its noise unknown, and the library's prior; both curves
    interpolated. Two more equilibria beside the best sharpen it; they start from the nearest stiffness' drape, whose
    folds they have. Drapes that do not come to rest are no evidence: caught cloth has the folds in which it was caught.

    **Deviation**: the thesis descends by gradient. Folds jump from branch to branch, and the loss with them; a search
    over the range with a measure that is independent of the folds' places has no local minima.

    Returns:
        The fabric with the found k, or unchanged where the drape does not identify k; and its estimate. Where the
        nearest drape folds far more or less than the target, its k is returned, but not as identified.
    """
    settings = settings or MaterialSettings()
    fabric = problem.fabric
    mean, spread = ratio_prior("k", settings)
    ratios = np.log([each.k / each.density for each in load_fabrics()])
    low, high = float(ratios.min()) - settings.below, float(ratios.max()) + settings.above
    target = np.log(measure_folding(problem, problem.garment.nodes))
    kept = load(hooks, "fit.fabric", _TriedStiffnesses, problem.garment.nodes)
    tried = [] if kept is None else list(kept.tried)

    def sample(at: float, start: np.ndarray) -> None:
        if any(abs(one.ratio - at) < 1e-9 for one in tried):
            return
        stiffer = problem.with_fabric(replace(fabric, k=fabric.density * float(np.exp(at))))
        drape = stiffer.drape(problem.garment.pattern, start, hooks)
        folds, loss = (
            float(np.log(value)) for value in (measure_folding(problem, drape.nodes), problem.loss.value(drape.nodes))
        )
        tried.append(_TriedStiffness(at, folds, loss, drape.at_rest, drape.nodes))
        save(hooks, "fit.fabric", _TriedStiffnesses(tuple(tried)), problem.garment.nodes)

    def cost(fine: np.ndarray) -> np.ndarray:
        from scipy.interpolate import PchipInterpolator

        known = _list_at_rest(tried)
        folds, losses = (PchipInterpolator(known[:, 0], known[:, n])(fine) for n in (1, 2))
        misfit = (folds - target) / settings.folding_spread
        return np.asarray(0.5 * misfit**2 + 0.5 * settings.observations * losses + 0.5 * ((fine - mean) / spread) ** 2)

    grid = np.linspace(low, high, settings.values)
    for n, at in enumerate(grid):
        hooks.progress("fit", 0.3 * n / len(grid), "looking for the cloth's bending stiffness")
        sample(float(at), problem.garment.nodes)
    known = _list_at_rest(tried)
    if len(known) < _MIN_DRAPE_COUNT:
        note = "not identifiable, the given fabric's: the cloth does not come to rest on the body at other stiffnesses"
        return fabric, FabricEstimate("k", fabric.k, spread, spread, False, note)
    low, high = known[0, 0], known[-1, 0]
    fine = np.linspace(low, high, 801)
    best = float(fine[np.argmin(cost(fine))])
    for side in (-1.0, 1.0):
        at = float(np.clip(best + 0.25 * side * (grid[1] - grid[0]), low, high))
        sample(at, min((one for one in tried if one.at_rest), key=lambda one: abs(one.ratio - at)).nodes)
    value, std = _moments(fine, cost(fine))
    std = max(std, settings.least_std)
    identified = std < _MAX_IDENTIFIED_STD_SHARE * spread
    if not identified:
        note = (
            f"not identifiable, the given fabric's: one drape leaves it open by a factor {np.exp(std):.1f} either way"
        )
        return fabric, FabricEstimate("k", fabric.k, std, spread, False, note)
    k = fabric.density * float(np.exp(value))
    bound = "" if low + std < value < high - std else ", at the end of the range that was searched"
    bias = float(np.interp(value, *_list_at_rest(tried)[:, :2].T) - target) / settings.folding_spread
    if abs(bias) > _MAX_FOLDING_SIGMA_COUNT:
        bound += f"; not identifiable: the nearest drape folds {'more' if bias > 0.0 else 'less'} than the scan"
    return _report_bending(fabric, k, FabricEstimate("k", k, std, spread, abs(bias) <= _MAX_FOLDING_SIGMA_COUNT, bound))


def refine_bending(
    fabric: Fabric, k: float, std: float, estimate: FabricEstimate, settings: MaterialSettings | None = None
) -> tuple[Fabric, FabricEstimate]:
    """Return k as fitted through the simulator, `std` its standard deviation.

    Returns:
        The fabric with that k, and its estimate, as `fit_bending` returns them.
    """
    settings = settings or MaterialSettings()
    return _report_bending(fabric, k, replace(estimate, std=max(std, settings.least_std), note=""))


def _report_bending(fabric: Fabric, k: float, estimate: FabricEstimate) -> tuple[Fabric, FabricEstimate]:
    """Return the fabric with a found k, and the estimate; its previous note ends the new one."""
    within = f"within a factor {np.exp(estimate.std):.1f} (one standard deviation)"
    note = f"fitted: ratio to the assumed weight, {within}{estimate.note}"
    kept = tuple(pair for pair in fabric.sources if pair[0] != "k")
    title = fabric.title or fabric.name
    if not title.endswith(FOUND_BENDING_SUFFIX):
        title += FOUND_BENDING_SUFFIX
    return replace(fabric, title=title, k=k, sources=(*kept, ("k", note))), replace(estimate, value=k, note=note)


def _moments(fine: np.ndarray, cost: np.ndarray) -> tuple[float, float]:
    """Return mean and standard deviation of exp(-cost) over an even grid."""
    weight = np.exp(cost.min() - cost)
    weight /= weight.sum()
    middle = float(weight @ fine)
    return middle, float(np.sqrt(weight @ (fine - middle) ** 2))


def posterior(
    problem: ShapeProblem,
    fabric: Fabric,
    pattern: Pattern,
    drape: Drape,
    loss: float,
    settings: MaterialSettings | None = None,
) -> tuple[np.ndarray, tuple[FabricEstimate, ...], float]:
    """Estimate the uncertainty of control points, k and membrane stiffnesses by the Gauss-Newton matrix and residual.

        covariance = (n / (2 L) J^T W J + prior^-1)^-1
    over effective control points (seams kept) and ln H00, H01, H11, H22, ln k: J = dx*/dp. The noise's size follows
    from the misfit L itself, n from its correlation (`count_independent`). Reported stiffnesses are `fabric`'s.

    Returns:
        Standard deviations of control points [m], [point_count, 2]; estimates of membrane stiffnesses; std of ln k.
    """
    from scipy.linalg import block_diag

    settings = settings or MaterialSettings()
    names = (*MEMBRANE_STIFFNESSES, "k")
    parameters = replace(problem.scene.parameters, fabric=names)
    rest = problem.scene.linearise(problem.difference(pattern, problem.fabric), drape.nodes, drape.anchors)
    moves = rest.push(*parameters.rates(rest.scene))
    shape_count = parameters.count - len(names)
    spreads = np.array([ratio_prior(name, settings)[1] for name in names])
    if problem.bending is not None:
        spreads[-1] = problem.bending
    matrix = 0.5 * problem.observations(drape.nodes) / loss * problem.loss.curvature(moves)
    matrix += block_diag(problem.precision[:shape_count, :shape_count], np.diag(1.0 / spreads**2))
    seams = seam_null_space(pattern, problem.scene.base, problem.scene.locked)
    free = np.zeros((parameters.count, seams.shape[1] + len(names)))
    free[:shape_count, : seams.shape[1]] = seams
    free[shape_count:, seams.shape[1] :] = np.eye(len(names))
    covariance = free @ np.linalg.inv(free.T @ matrix @ free) @ free.T
    expand = problem.scene.symmetry.matrix.toarray()
    points = np.einsum("ip,pq,iq->i", expand, covariance[:shape_count, :shape_count], expand)
    left = np.sqrt(np.diag(covariance)[shape_count:])
    estimates = tuple(
        _report_membrane(fabric, name, float(left[n]), float(spreads[n])) for n, name in enumerate(MEMBRANE_STIFFNESSES)
    )
    return np.sqrt(np.maximum(points, 0.0)).reshape(-1, 2), estimates, float(left[-1])


def _report_membrane(fabric: Fabric, name: str, std: float, spread: float) -> FabricEstimate:
    """Return the estimate of a membrane stiffness as given, which is not fitted."""
    reason = (
        "the drape leaves it open"
        if std >= _MAX_IDENTIFIED_STD_SHARE * spread
        else "the drape depends on it, but it is not fitted"
    )
    return FabricEstimate(name, getattr(fabric, name), std, spread, False, f"library's ratio to weight; {reason}")


def report_density(fabric: Fabric) -> FabricEstimate:
    """Return the estimate of the density: a drape at rest depends only on ratios to it."""
    note = "not identifiable: a drape at rest fixes only the other parameters' ratios to it; the library's value"
    logs = np.log([each.density for each in load_fabrics()])
    return FabricEstimate("density", fabric.density, float(logs.std()), float(logs.std()), False, note)


def nearest_fabrics(fabric: Fabric, count: int = 3) -> tuple[str, ...]:
    """Return the library's fabrics with the most similar bending under their own weight: nearest in ln(k / density)."""
    at = np.log(fabric.k / fabric.density)

    def away(other: Fabric) -> float:
        return abs(float(np.log(other.k / other.density) - at))

    return tuple(each.name for each in sorted(load_fabrics(), key=away)[:count])
