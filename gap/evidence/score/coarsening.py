"""How much logs count for, when no model is quite right.

A model that is right up to what honest models leave is off by that at every reversal, in every window, and always the same way.
A wrong name that follows a part of it gains with every window, in all of them alike, so neither more data nor random weights of windows
(bootstrap) take that back. So logs count as a limited number of windows, however many they are: evidence is raised to the power

    ζ = 1 / (1 + n / COUNT)          n windows

which is the posterior of models whose distribution lies within an unknown distance of that of the logs, exponential with mean 1 / COUNT a
window (Miller and Dunson 2019, "Robust Bayesian inference via coarsening", eq 2.4 and sec. 2.3).
"""

from __future__ import annotations

from gap.evidence.deciding_numbers import COUNT


def power(windows: int) -> float:
    """ζ: the part of its ln Z that a log of so many windows counts for."""
    return 1.0 / (1.0 + windows / COUNT)
