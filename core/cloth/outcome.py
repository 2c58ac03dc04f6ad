"""Outcomes of the search for an equilibrium, each with advice."""

from __future__ import annotations

from enum import StrEnum


class Outcome(StrEnum):
    """Describe how the search for an equilibrium ended.

    Attributes:
        advice: What that means and what to do.
        converged: True where the forces are within the tolerance or nothing moves any more, stuck or not;
            `Drape.at_rest` also checks the forces left.
    """

    advice: str
    converged: bool

    CONVERGED = "converged", "at rest: all forces are balanced.", True
    STILL = "still", "at rest by motion, forces not fully balanced: set rest_motion to 0 for more.", True
    STUCK = "stuck", "not at rest: no step lowers the energy; settle for longer first, or soften contact."
    ITERATIONS = "iterations", "not at rest: raise max_iterations, settle for longer, or pin a contour that slides."
    TIME = "time", "not at rest: raise max_cpu_seconds or take fewer vertices."
    STOPPED = "stopped", "not at rest: the search was stopped by the caller."

    def __new__(cls, value: str, advice: str = "", converged: bool = False) -> Outcome:
        """Return a member whose value is its name in lower case."""
        member = str.__new__(cls, value)
        member._value_ = value
        member.advice, member.converged = advice, converged
        return member
