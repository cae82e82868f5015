"""The numbers that decide an answer: every threshold, prior and gate of the comparison of models, each with its reason.

Nats are natural logarithms of odds. Numbers that set the resolution of searches (draws, grids, how many competitors), what a
readable recording is (see sanity) and how results are printed are defined where they are used; `python tools/count_numbers.py` counts
all of them.
"""

from __future__ import annotations

from math import log, sqrt
from statistics import NormalDist

# odds
FALSE_ALARM = 0.01  # of null recordings that one search may name; names, shapes and neighbours together keep the 3 % of docs/exam.md
SECURE = 0.95  # with which a simulated quantile is not below the true one: the usual coverage probability
STRONG = 3.0  # nats, odds of 20: "strong" (Kass & Raftery, J. Am. Stat. Assoc. 90 (1995) 777); within it names are rivals
VERY_STRONG = 5.0  # nats, odds of 150: "very strong" there; at most 0.7 % of nulls reach it (Markov)
SIMPLER = 2.0  # nats by which a larger answer must beat one that it holds: "positive" there (1 to 3)
EVEN_ODDS = 0.5  # a name below it, with its exact aliases, is more probably wrong than right: no finding
OUTSIDE = 0.026  # odds of a mechanism that no catalogue holds where the account closes: 11 of 466 sure claims of the exam were wrong
OUTSIDE_OPEN = 1.42  # the same where something is left: 26 of 44 were wrong; each half fitted, the other tested (docs/exam.md)
RARER = 0.1  # prior of an effect where it is rare (vcmm.core.declaration.Prior): chosen, one recording in ten

# what chance does
FAR_SIGMAS = 3.0  # standard deviations, 1 of 370 of the normal law: rows beyond are pulled in, statements beyond are contradicted
OUTLYING = 4.5  # standard deviations, 1 of 150 000: in a recording of 1000 rows chance makes none
CHANCE = 0.999  # the same of the scatter itself, tested in every recording, named or not
HEAVY = 4.0  # degrees of freedom of a t law with heavy tails: the most at which a fourth moment is infinite
STRONG_CORRELATION = 0.7  # a neighbour tells half of the variance from here on: the rows move together
STRUCTURE_CORRELATION = 0.9  # the same, 81 % of the variance: a movement and no scatter
UNSTATED_RATIO = 3.0  # times the stated noise: eight ninths of the variance have another cause

# templates: no shape, time constant or thermometer is quite right
MISMATCH = 0.05  # of a signal that its template may leave: chosen on concealed mechanisms that are no formula (docs/exam.md)
EXACT = 0.01  # of a signal, a fifth of MISMATCH: a term that leaves no more describes the same signal
MOSTLY = 0.5  # of the energy: a part of more than half names the whole
SECURE_DELTA = 7.0  # delta at which the right name is first in 95 % of recordings (docs/exam.md)
LEAST_SPREAD = 1.0  # nats: the gain of a fold in simulated recordings is not believed to be better known
FEW = 3  # numbers of a name, a vector; with more it is a shape of its own

# sizes
MOST_TERMS = 6  # names of one recording; no recording of the exam needed more
CLOSING = 2  # names of one number that may close the account of the noise: with more, any would
MOST_SHAPES = 10  # lines of a spectrum, kinds of mistakes that are looked at one by one: chosen
FEWEST = 20  # observations of a fold: their scatter is known to 16 %
BLOCKS = 10  # along an axis, every second one held out: each is a third of the far zone, so that they lie between rows
VANISHING_SHARE = 1e-3  # of a signal that must survive nuisance and calibration: of 1 mm that is 1 um
LEAST_FRACTION = 1e-300  # in place of a zero below a fraction

# consequences
UNSEEN = VANISHING_SHARE**2  # of an energy, what VANISHING_SHARE is of a length; far above rounding
SUREST = -log(UNSEEN)  # nats that a field or names may have over one another: odds of a million
LOWEST = UNSEEN**2  # of a chance: beyond seven standard deviations the normal law itself is not believed
RESOLUTION_DELTA = sqrt(2.0 * STRONG)  # delta s from which STRONG nats separate two names
DEVIATIONS = NormalDist().inv_cdf(1.0 - FALSE_ALARM)  # of the mean square of noise in a null recording
MAD = 1.0 / NormalDist().inv_cdf(0.75)  # standard deviations per median of the absolute value, normal law
LEAST_PRINTED = 1.0 - CHANCE  # probability below which no digits are printed: templates are not better known
QUANTILE = 1.0 - 2.0 * NormalDist().cdf(-FAR_SIGMAS)  # of a statistic of nulls: the chance of FAR_SIGMAS
RELEVANT = sqrt(1.0 / MOSTLY)  # times the stated noise, from where most of the variance has another cause
ALIAS = FAR_SIGMAS * MISMATCH  # of a signal: a larger name that leaves no more holds the simpler one
SAME_SHARE = 1.0 - (2.0 * MISMATCH) ** 2  # of a signal, twice MISMATCH left: then a span holds it
FORGIVEN = 2.0 * MISMATCH  # of what a term wins in the other folds: fit and prediction both err by MISMATCH
EXCITATION_DELTA = sqrt(2.0 * SIMPLER)  # delta in the rows of a fold worth SIMPLER nats: less says nothing
