"""Every number that decides in the search by evidence, with its meaning. HONEST is what simulated machines without a missing effect leave,
OTHER_FORM a first guess; COUNT was chosen on measured data and on a few of those machines (docs/decisions/score/0021 and 0034)."""

from __future__ import annotations

from math import log

MEMORY_S = 0.03  # median of the discrepancy's correlation time
SPREAD = 1.0  # standard deviation of the logarithm of what is known by its magnitude alone: that time, and the times s of δ in a window
HONEST = 0.003  # scale of δ in root mean squares of a channel's changes over MEMORY_S, as honest models leave it
LEAST_DISCREPANCY = 0.3  # least scale of δ's prior, in noise: quantisation and coloured noise leave as much
OTHER_FORM = 0.3  # scale of η's half-normal prior: shares of the friction that act through elements of another form
COUNT = 2.0  # windows that logs count for, were there ever so many, where all friction has another form or what is left acts unexplained
EXPECTED = 1.0  # effects missing before anything is seen: each of M candidates has the odds of 1 in M
RANGE_SDS = 3.0  # prior standard deviations to the far end of an effect's plausible range
CHANGED_TIMES = 10.0  # as many times its stated value a constant that a fault changes may be, and as small a part of it
ALIKE_MASS = 0.95  # of the posterior at one place that the look-alikes named hold; a set with less than the rest of it is negligible
CONFIRMED = 0.99  # probability from which a name is confirmed; a discrepancy beyond what so many honest models leave puts it in doubt
UNEXPLAINED = 4.0  # scales of δ beyond which something else acts: of 150 right sets five left more, of 16 effects of no library one less

NEGLIGIBLE = log(1.0 - ALIKE_MASS)  # of a set's ln Z beside the best one's: such a set is not worth a fit, and one window brings none there
