"""Model the motion of the tip by temperatures and a running spindle, from recordings with sensors.

    reading = baseline of the machine + sum c_i g_i(tau_i) + zero ... + noise        tau_i continuous

One term per direction and sensor (its temperature behind a lag; two lags where that pays), per axis whose scale has a sensor,
and for a spindle. Amounts are linear and projected out, lags are searched (variable projection, Golub & Pereyra 1973), readings
that stand out from their neighbours in time left out. Terms are chosen by the Bayesian information criterion (Schwarz, Ann. Stat. 6
(1978) 461) of as many readings as say something new: noise that stays the same for a while repeats them 1 + 2 sum of its
correlations times (Sokal 1997). The covariance allows for that too, and for terms that predict a block of time that was held out
worse than those they were fitted to, by the ratio of the mean squares.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.core.valid_range import trained_range
from vcmm.learn.calibration.result import rms
from vcmm.learn.calibration.thermal_search import ThermalFit, ordinary, repeating, select_terms
from vcmm.learn.calibration.thermal_terms import Term, candidates, sensors_of, warm_readings
from vcmm.task.response.recording import Recording


@dataclass(frozen=True, eq=False)
class ThermalModel:
    """terms with amount and tau (s); covariance (2 t, 2 t) of amounts and lags (a lag that does not count has zeros).

    before, after: rms of all readings with nuisance, mm; held_out: rms of blocks of time predicted from the others, before and
    after; trained: sensor -> (low, high) degC; unused_sensors: sensor -> why; repeats: number of readings with the same information; outliers:
    outlying readings, which no figure includes.
    """

    terms: tuple[Term, ...]
    amounts: Array
    lags: Array
    covariance: Array
    before: float
    after: float
    held_out: tuple[float, float]
    trained: dict[str, tuple[float, float]]
    unused_sensors: dict[str, str]
    repeats: float
    outliers: int
    fit: ThermalFit  # the readings, and the terms with the lags at which the search ended

    def effects(self) -> list[Effect]:
        """Return the terms as effects of a machine, with the range that they were learnt from."""
        made = [t.make(float(a), float(lag)) for t, a, lag in zip(self.terms, self.amounts, self.lags)]
        return [
            replace(e, trained=trained_range(*self.trained[t.sensor])) if hasattr(e, "trained") else e  # type: ignore[call-arg]
            for e, t in zip(made, self.terms)
        ]


def thermal_model(
    recordings: Sequence[Recording], machine: Machine, sensors: Sequence[str] = ()
) -> ThermalModel:
    """See the head of this file. sensors: the only ones to look at; all that vary where none is named.

    Raises UsageError: no sensor varies, a name that no recording has, no term predicts what was held out.
    """
    parts = [warm_readings(r, machine) for r in recordings]
    trained, unused = sensors_of(parts)
    for name in sensors:
        if name not in trained:
            raise UsageError(
                f'--sensors names "{name}", {unused.get(name, "which no recording has")}; there are {", ".join(trained) or "none"}'
            )
    chosen = list(sensors or trained)
    unused |= {s: "not among those named" for s in trained if s not in chosen}
    if not chosen and not candidates(parts, chosen):
        raise UsageError(
            "no temperature varies in the recordings; a thermal model needs columns temp_<sensor>_C that follow warming up"
        )
    fit = select_terms(ThermalFit(parts, (), np.zeros(0)), candidates(parts, chosen))
    if not fit.terms:
        raise UsageError(
            f"no sensor of {', '.join(chosen)} predicts readings that were held out better than chance does; nothing is written"
        )
    unused |= {s: "adds nothing to the others" for s in chosen if all(t.sensor != s for t in fit.terms)}
    return _model(fit, {s: r for s, r in trained.items() if s in chosen}, unused)


def _model(fit: ThermalFit, trained: dict[str, tuple[float, float]], unused: dict[str, str]) -> ThermalModel:
    """Return the amounts, lags and their covariance."""
    weight = fit.weights()
    amounts, left = fit.solve(fit.lags, weight)
    kept = ordinary(fit, left)
    plain = ThermalFit(fit.parts, (), np.zeros(0))
    before, after = rms(np.concatenate(fit.held_out())), rms(np.concatenate(kept))
    return ThermalModel(
        terms=fit.terms,
        amounts=amounts,
        lags=fit.lags,
        covariance=fit.covariance(amounts, left, weight) * repeating(kept) * max(1.0, before / after) ** 2,
        before=rms(np.concatenate(ordinary(fit, plain.solve(plain.lags, weight)[1]))),
        after=after,
        held_out=(rms(np.concatenate(plain.held_out())), before),
        trained=trained,
        unused_sensors=unused,
        repeats=repeating(kept),
        outliers=int(sum((w == 0).sum() for w in weight)),
        fit=fit,
    )
