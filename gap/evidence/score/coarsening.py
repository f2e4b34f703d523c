"""How much logs count for, when no model is quite right.

A model that is right up to what honest models leave is off by that at every reversal, in every window, and always the same way.
A wrong name that follows a part of it gains with every window, in all of them alike, so neither more data nor random weights of windows
(bootstrap) take that back. So logs count as a limited number of windows, however many they are: evidence is raised to the power

    ζ = 1 / (1 + n R),    R = (v + (1 − v) u) / COUNT          n windows

which is the posterior of models whose distribution lies within an unknown distance of that of the logs, exponential with mean R a window
(Miller and Dunson 2019, "Robust Bayesian inference via coarsening", eq 2.4 and sec. 2.3). How far a right model is away hangs on how
friction yields (u, gap.evidence.noise.other_form): where the logs show the model's own form nothing of it repeats. And on what else acts
(v): the part of the discrepancy's variance that is beyond what honest models leave. It is no noise either, windows with the same motion
have it alike, and nothing is known of it.
"""

from __future__ import annotations

from gap.evidence.deciding_numbers import COUNT


def power(windows: int, form: float, excess: float = 0.0) -> float:
    """ζ: the part of its ln Z that logs of so many windows count for; `form` u of the friction has another form, and `excess` v of the
    discrepancy's variance is more than honest models leave."""
    return 1.0 / (1.0 + windows * distance(form, excess))


def distance(form: float, excess: float = 0.0) -> float:
    """What a right model is expected to be away from the logs by, as a relative entropy a window."""
    return (excess + (1.0 - excess) * form) / COUNT
