"""Time the simulator's derivatives and hold them against central differences, beside the thesis' table 3.1.

Run with one thread: OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 NUMBA_NUM_THREADS=1 python benchmarks/derivative.py
"""

from __future__ import annotations

import sys
import time
from dataclasses import replace

import numpy as np
from garmentq.core.cloth.derivative import FactoredEquilibrium, ImplicitDerivative
from garmentq.core.cloth.energy import Inertia
from garmentq.core.cloth.linearised import LinearisedSteps
from garmentq.core.cloth.parameters import Parameters
from garmentq.core.cloth.sensitivity import FABRIC_PARAMETERS
from garmentq.core.cloth.solver import make_solver
from garmentq.core.cloth.unrolled import UnrolledSteps
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import LinearOperator, eigsh
from sheet import SIDES, THESIS, Laid, cpu, quickest, sheet_on_ball

GOALS = {"1K": (20.0, 2.2), "3K": (90.0, 6.5), "8K": (350.0, 30.0)}
"""To stay under: gradient after the factor [CPU ms]; thesis mode, 20 steps forward and reverse [CPU s]. Six shape
parameters are to be known to 1 % in 0.6, 8 and 40 s."""

CHANGE = np.array([0.01, -0.01, 0.005, 0.005, 0.01, -0.005])
"""What is changed of the pattern at its corners [m]: up to 3 % of its half width."""

AROUND = (0.94, 0.97, 1.0, 1.03, 1.06)
"""Factors on the change over which solved steps are averaged: the sheet buckles anew, and which way it takes to rest
hangs on the last digits, so that one run takes up to twice as long as another."""

TIED, ROUGHLY = 4, 1e-2
"""First steps of Gauss-Newton whose cloth is tied to the target, and the force left then [a node's weight]: they only
have to bring the pattern near. After two, one changed by 10 mm could still buckle, by chance of the last digits."""

STEPS = {
    "20 x 0.05 s": (20, 0.05, 1.0),
    "the same, damped": (20, 0.05, 0.6),
    "80 x 0.05 s": (80, 0.05, 1.0),
    "20 x 0.2 s": (20, 0.2, 1.0),
}
"""Steps, length [s] and share of velocity kept, of which the gradient is held against that at rest. 0.6 damps a sway of
1 s just critically at 0.05 s: (1 + d)^2 = 4 d (1 + w^2 dt^2)."""


def drape(count: int) -> Laid:
    """Lay a sheet off-centre over a ball of 15 cm and bring it to rest; shape parameters in metres at its corners."""
    scene, nodes, flat = sheet_on_ball(count, (-0.28, -0.31))
    u, v = flat.T / 0.3
    fields = [(u, 0 * u), (0 * u, v), (v, 0 * u), (0 * u, u), (u * v, 0 * u), (0 * u, u * v)]
    shape = np.stack([np.stack(field, axis=1)[scene.topology.faces].ravel() for field in fields], axis=1)
    return Laid.at_rest(scene, nodes, Parameters(csr_matrix(shape), FABRIC_PARAMETERS))


def worst_error(laid: Laid, nodes: np.ndarray, found: np.ndarray, up: np.ndarray) -> float:
    """Return the largest relative error of a gradient against central differences of converged equilibria.

    Steps of 1e-7 m and 1e-5 of the fabric: the error of the quotient falls with the square of the step down to there.
    """
    solver, parameters, worst = make_solver(laid.scene.topology.pattern), laid.parameters, 0.0
    for n in range(parameters.count):
        step = np.zeros(parameters.count)
        step[n] = 1e-7 if n < parameters.shape.shape[1] else 1e-5
        ends = laid.ends(ImplicitDerivative(tolerance=0.0), step, nodes, solver)
        expected = float((up * (ends[0] - ends[1])).sum()) / (2 * step[n])
        worst = max(worst, abs(found[n] - expected) / abs(expected))
    return worst


def slowest_sway(rest: FactoredEquilibrium) -> float:
    """Return the longest period of small motions about an equilibrium [s]: K v = w^2 M v."""
    root = np.sqrt(np.repeat(rest.scene.masses, 3))
    turned = LinearOperator((len(root),) * 2, matvec=lambda v: root * rest.solver.solve(root * np.ravel(v)))
    longest = eigsh(turned, k=1, which="LM", v0=np.ones(len(root)), return_eigenvectors=False, tol=1e-6)
    return float(2.0 * np.pi * np.sqrt(longest[0]))


def recover_shape(laid: Laid, start: np.ndarray, change: np.ndarray) -> tuple[float, float]:
    """Recover a changed pattern from its drape by Gauss-Newton; every equilibrium is looked for from that drape.

    A wrong pattern would buckle into other folds, and an equilibrium that starts from there stays in them. So each
    starts on the target, and the first `TIED` are tied to it by inertia, as one implicit Euler step from it is.

    Gives the CPU time until all parameters together are known to 1 % [s], inf where they never are, and their relative
    error at the end.
    """
    scene, friction, shape = laid.scene, laid.friction, replace(laid.parameters, fabric=())
    solver, implicit = make_solver(scene.topology.pattern), ImplicitDerivative()
    target = implicit.solve(shape.move(scene, change), start, solver, friction=friction).nodes
    tie, roughly = Inertia(target, 1.0 / UnrolledSteps.dt**2), ImplicitDerivative(tolerance=ROUGHLY)
    found, begun, reached = np.zeros(len(change)), time.process_time(), np.inf
    for n in range(10):
        moved, tied = shape.move(scene, found), tie if n < TIED else None
        rest = (roughly if tied else implicit).solve(moved, target, solver, friction=friction, inertia=tied)
        slopes = rest.push(*shape.rates(moved)).reshape(-1, len(change))
        step = np.linalg.lstsq(slopes, (target - rest.nodes).ravel(), rcond=None)[0]
        found = found + step
        error = float(np.linalg.norm(found - change) / np.linalg.norm(change))
        if error < 0.01:
            reached = min(reached, time.process_time() - begun)
        if n >= TIED and np.linalg.norm(step) < 1e-3 * np.linalg.norm(found):
            break
    return reached, error


def measure(name: str) -> dict[str, float]:
    """Measure one size."""
    laid = drape(SIDES[name])
    scene, friction, parameters = laid.scene, laid.friction, laid.parameters
    solver = make_solver(scene.topology.pattern)
    rest = ImplicitDerivative(tolerance=0.0).solve(scene, laid.nodes, solver, friction=friction)
    up = np.sin(9 * rest.nodes[:, [1, 2, 0]] + [0.3, 0.5, 0.7])
    rates = parameters.rates(scene)
    one = parameters.pull(scene, rest.pull(up))
    found = {
        "gradient [ms]": quickest(lambda: parameters.pull(scene, rest.pull(up))),
        "12 columns [ms]": quickest(lambda: rest.push(*rates)),
        "Hessian+factor [ms]": quickest(
            lambda: ImplicitDerivative(tolerance=1.0).solve(scene, rest.nodes, solver, friction=friction)
        ),
        "error": worst_error(laid, rest.nodes, one, up),
    }
    found["slowest sway [s]"] = slowest_sway(rest)
    for title, way in STEPS.items():
        two = parameters.pull(scene, UnrolledSteps(*way).solve(scene, rest.nodes, solver, friction=friction).pull(up))
        found[f"1 - cosine, {title}"] = 1.0 - float(one @ two / np.linalg.norm(one) / np.linalg.norm(two))
    solved = UnrolledSteps(steps=20)
    for share in (1.0, 0.1):
        changed = replace(parameters, fabric=()).move(scene, share * CHANGE)
        LinearisedSteps(1).solve(changed, rest.nodes, solver, friction=friction).pull(
            up
        )  # torch is imported on the way
        forward, moved = cpu(lambda e=changed: LinearisedSteps(20).solve(e, rest.nodes, solver, friction=friction))
        reverse, _ = cpu(lambda m=moved: m.pull(up))
        change = f", {10 * share:.0f} mm"
        found[f"linearised forward{change} [s]"], found[f"linearised reverse{change} [s]"] = forward, reverse
        found[f"linearised / goal{change}"] = (forward + reverse) / GOALS[name][1]
    for share in (1.0, 0.1):
        times = []
        for factor in AROUND:
            changed = replace(parameters, fabric=()).move(scene, factor * share * CHANGE)
            forward, moved = cpu(lambda e=changed: solved.solve(e, rest.nodes, solver, friction=friction))
            times.append((forward, cpu(lambda m=moved: m.pull(up))[0]))
        change = f", {10 * share:.0f} mm [s]"
        found["forward" + change], found["reverse" + change] = np.mean(times, axis=0)
        found["longest" + change] = float(np.sum(times, axis=1).max())
    for share in (1.0, 0.1):
        way = f", {10 * share:.0f} mm"
        found[f"6 shapes to 1 %{way} [s]"], found[f"their error{way}"] = recover_shape(laid, rest.nodes, share * CHANGE)
    found["gradient / goal"] = found["gradient [ms]"] / GOALS[name][0]
    for change in (", 10 mm", ", 1 mm"):
        ours = (found[f"forward{change} [s]"], found[f"reverse{change} [s]"])
        found[f"steps / goal{change}"] = sum(ours) / GOALS[name][1]
        for n, way in enumerate(("fwd", "rev")):
            linear = found[f"linearised {('forward', 'reverse')[n]}{change} [s]"]
            known = THESIS[name][n] if name in THESIS else float("nan")
            found[f"thesis/{way}{change}"], found[f"thesis/linearised {way}{change}"] = known / ours[n], known / linear
    return found


def main(names: list[str]) -> None:
    """Print the table."""
    found = {}
    for name in names:
        found[name] = measure(name)
        print(name, {key: float(f"{value:.3g}") for key, value in found[name].items()}, flush=True)
    print(f"{'CPU, one thread':28}" + "".join(f"{name:>12}" for name in found))
    for key in next(iter(found.values())):
        print(f"{key:28}" + "".join(f"{found[name][key]:12.3g}" for name in found))
    print("thesis: assembly and solve alone on an RTX 3090 (table 3.1); ours: everything on one CPU core.")


if __name__ == "__main__":
    main(sys.argv[1:] or list(SIDES))
