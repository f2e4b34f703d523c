"""Every number that decides in the search by evidence, with its meaning. HONEST is a first guess, not calibrated yet."""

from __future__ import annotations

MEMORY_S, MEMORY_SPREAD = 0.03, 1.0  # of the discrepancy's correlation time: median and standard deviation of its logarithm
HONEST = 0.02  # scale of δ's half-normal prior, in root mean squares of what the channel's signal does within a window
EXPECTED = 1.0  # effects missing before anything is seen: each of M candidates has the odds of 1 in M
OTHER_FORM = 0.3  # scale of η's half-normal prior: shares of the friction that act through elements of another form
RANGE_SDS = 3.0  # prior standard deviations to the far end of an effect's plausible range
CHANGED_TIMES = 10.0  # as many times its stated value a constant that a fault changes may be, and as small a part of it
MOST_EFFECTS = 4  # in one set
NEGLIGIBLE = -9.0  # ln of the posterior share, beside the best set's, below which a set is not worth a fit: 1 in 8000
LEAST_DISCREPANCY = 0.3  # least scale of δ's prior, in noise: quantisation and coloured noise leave as much
ALIKE_MASS = 0.95  # of the posterior at one place that the look-alikes named hold
CONFIRMED, TENTATIVE = 0.99, 0.5  # probabilities from which a name is confirmed, and is said at all
UNEXPLAINED = 2.576  # prior scales of δ beyond which something acts that nothing known explains: 1 % of honest models
