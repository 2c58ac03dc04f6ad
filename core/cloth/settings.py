"""Settings of a simulation, with the reason for every default."""

from __future__ import annotations

from dataclasses import dataclass

from ..run.errors import BadInput

__all__ = ["ContactSettings", "SelfContactSettings", "SettingsBad", "SolveSettings"]

STANDARD_GRAVITY = (0.0, -9.81, 0.0)
"""Standard gravity, y up [m/s2]."""

MAX_REST_RESIDUAL = 1.0
"""Largest force on a node of cloth at rest [mean weight of a node]. The search stops at a thousandth of it
(`SolveSettings.tolerance`), or where nothing moves by `SolveSettings.rest_motion` any more. The second comes first
where friction and cloth in a crease of the body keep each other in motion (`statics._FRICTION_FREEZE_RUNS`); the forces
left are then below the cloth's own weight. A node with a larger force that does not move is stuck. docs/lab/simulate.md
has the residuals of 45 searches."""


class SettingsBad(BadInput):
    """A simulation setting is outside its range; see `ContactSettings` and `SolveSettings`."""

    code = "simulate.settings_bad"


@dataclass(frozen=True)
class ContactSettings:
    """Describe contact of cloth with a body: part of the `Scene`.

    Attributes:
        thickness: Distance to the body below which contact pushes back [m]. With edges of 1.5 cm a face centre is 0.8
            mm nearer to a limb of 5 cm radius than its nodes, so 4 mm keeps it outside and leaves room for the penalty.
        stiffness: Pressure per squared depth below `thickness` [N/m4]. 1e8: the cloth's own weight (2 Pa) sinks 0.14
            mm, a tight waistband (1 kPa) 3.2 mm, so neither reaches the skin.
        friction: False switches Coulomb friction off.
        slip: Tangential displacement at which friction is fully mobilised [m]; below it friction is a spring, so that
            cloth at rest stays at rest. 0.5 mm is below what a scan resolves.
    """

    thickness: float = 4e-3
    stiffness: float = 1e8
    friction: bool = True
    slip: float = 5e-4

    def __post_init__(self) -> None:
        """Check every value; raise `SettingsBad` where one is not positive."""
        _check_positive(self, "thickness", "stiffness", "slip")

    @property
    def law(self) -> tuple[float, float]:
        """Return stiffness and thickness as the contact's kernel takes them."""
        return float(self.stiffness), float(self.thickness)


@dataclass(frozen=True)
class SelfContactSettings:
    """Describe contact of cloth with cloth: part of `SelfContact`.

    Attributes:
        thickness: Distance of two sheets below which they push each other apart [m]. 2 mm, half of the distance to the
            body, so that two sheets fit between touching limbs; on fine meshes it is less (`SelfContact.reach`).
        stiffness: Pressure of the law [Pa]. 100: one sheet on another (2 Pa) sinks by a tenth of the thickness, a tight
            waistband (1 kPa) to an eighth of it.
        friction: Coefficient of friction of cloth on cloth [1]; 0 for none. 0.4: woven cotton on itself is reported at
            0.3 to 0.6.
        slip: Displacement at which friction is fully mobilised [m], as of `ContactSettings`.
    """

    thickness: float = 2e-3
    stiffness: float = 100.0
    friction: float = 0.4
    slip: float = 5e-4

    def __post_init__(self) -> None:
        """Check every value; raise `SettingsBad` where one is not positive, or friction negative."""
        _check_positive(self, "thickness", "stiffness", "slip")
        if not self.friction >= 0:
            raise SettingsBad(f"friction must not be negative, not {self.friction}.")


@dataclass(frozen=True)
class SolveSettings:
    """Describe how an equilibrium or a time step is computed: part of the call.

    Attributes:
        damping: Share of velocity kept from one time step to the next; 0.9 damps a swing of 0.5 s within 20 steps.
        newton_per_step: Largest number of Newton iterations in one time step. States between steps need no accuracy;
            two keep the cloth from stretching visibly.
        max_step: Largest displacement of a node in one Newton iteration [m]. Without a clamp a static step on slack
            cloth diverges; 5 cm was found to be safe.
        tolerance: Largest force left on a node [mean weight of a node]. 1e-3: accelerations of 1 cm/s2.
        steps_per_factor: Number of quasi-Newton steps per factored matrix in the search for equilibrium. At 4000 nodes
            a factor costs as much as five steps; five garments took 29 s of CPU with 5, 24 s with 8, 28 s with 12.
        rest_motion: Motion of the fastest node per iteration below which the drape counts as at rest [m]: 0.1 mm is an
            eighth of what registration resolves. 0: only `tolerance` counts.
        max_iterations: Largest number of factorisations of `equilibrium`; 120 take about 16 s at 4000 nodes, and twelve
            garments needed 26 to 69 (3.5 to 9 s).
        max_cpu_seconds: CPU time [s] after which equilibrium stops with its present state, or None, the default,
            because a limit makes the result depend on the machine.
    """

    damping: float = 0.9
    newton_per_step: int = 2
    max_step: float = 0.05
    tolerance: float = 1e-3
    steps_per_factor: int = 8
    rest_motion: float = 1e-4
    max_iterations: int = 120
    max_cpu_seconds: float | None = None

    def __post_init__(self) -> None:
        """Check every value; raise `SettingsBad` where one is outside its range."""
        _check_positive(self, "max_step", "tolerance")
        if not 0 <= self.damping <= 1:
            raise SettingsBad(f"damping must lie in 0 to 1, not {self.damping}.")
        for name in ("newton_per_step", "steps_per_factor", "max_iterations"):
            if getattr(self, name) < 1:
                raise SettingsBad(f"{name} must be at least 1, not {getattr(self, name)}.")


def _check_positive(settings: ContactSettings | SelfContactSettings | SolveSettings, *names: str) -> None:
    """Raise `SettingsBad` where one of these is not positive."""
    for name in names:
        if not getattr(settings, name) > 0:
            raise SettingsBad(f"{name} must be positive, not {getattr(settings, name)}.")
