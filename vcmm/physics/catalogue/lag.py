"""Lag: an axis runs behind its command, or a position is read out late. Both grow with speed."""

from __future__ import annotations

from dataclasses import dataclass

from vcmm.core.axes import is_rotary
from vcmm.core.declaration import About, ChoosesColumns, ForDiagnosis, Opposite, Prior, Trade, Typical, Words
from vcmm.core.effect import Effect, at, motion, param, required
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class ServoLag(Effect, ChoosesColumns):
    """-v_a lag e_a, lag = the departure of 1/Kv from the nominal gain: positive is a slower axis, further behind.

    Compared at the same point of the path. What all axes share only delays the motion; what they do not share bends
    it: on a circle of two axes, an oval at 45 degrees that turns over with the direction.
    """

    name = "servo_lag"
    about = About(
        cites="ISO 230-4:2022 circular tests; Andolfatto, Lavernhe & Mayer, Int. J. Mach. Tools Manuf. 51 (2011) 787",
        trade=Trade("lag of the drive {where}", "a lower feed, or the gain of the drive measured"),
        words=Words(
            seen="{where} runs further behind its command than its nominal gain says (1/Kv longer by {1/Kv})",
            causes="position gain not matched to the other axes",
            confirm="a circular test in both directions at two feeds",
            opposite=Opposite(
                "1/Kv",
                "{where} runs less far behind its command than its nominal gain says (1/Kv shorter by {1/Kv})",
            ),
        ),
        aliases={"1/Kv": "lag", "lag": "lag"},  # both are read, the last is written
    )
    diagnosis = ForDiagnosis(
        special_case_of=("lost_motion_speed",),  # of power 1
    )
    per = "axis"
    needs = ("speed_{axis}_mm_s",)
    axis: str = at("X", "linear or rotary axis")
    lag: float = param(
        0.0,
        "ms",
        '1/Kv less its nominal value; `"1/Kv"` is read too',
        typical=Typical(1e-4, "gains 1/Kv = 15-60 ms matched to 1 %: 5 um at 50 mm/s", most=0.06),
    )

    @property
    def link(self) -> str:
        return self.axis

    def required(self) -> tuple[str, ...]:
        return (f"speed_{self.axis}_{'mm' if self.axis in 'XYZ' else 'rad'}_s",)

    def error_motion(self, run: Run) -> Array:
        return motion(run, **{self.axis: -self.lag * run.column(required(self)[0])})


@dataclass(frozen=True, eq=False)
class ReadoutDelay(Effect):
    """-v delay, v = speeds of X, Y, Z: all axes are read late by the same time, so the indication runs ahead of the tip.

    The speeds are taken along the workpiece axes.
    """

    name = "readout_delay"
    per = "machine"
    needs = ("speed_X_mm_s", "speed_Y_mm_s", "speed_Z_mm_s")
    about = About(
        cites="Weckenmann et al., CIRP Annals 53 (2004) 657: probing systems; distance = speed x delay",
        words=Words(
            seen="position and probe are read at different times ({delay})",
            causes="delay in the electronics or in a filter",
            confirm="repeat at three speeds; at rest the error must vanish",
            opposite=Opposite(
                "delay", "the position is read before the probe, or corrected for too long a delay ({delay})"
            ),
        ),
    )
    diagnosis = ForDiagnosis(
        # a touch is latched by its trigger: late axes are the rarer cause
        prior=Prior(rare_in=("probe",)),
    )
    delay: float = param(
        0.0,
        "ms",
        "time between passing a point and reading the axes",
        typical=Typical(1e-4, "one cycle of a control or interface: 0.05-1 ms"),
    )

    @property
    def link(self) -> str:
        return "tip"

    def error_motion(self, run: Run) -> Array:
        x, y, z = run.vector(*self.needs).T
        return motion(run, X=-self.delay * x, Y=-self.delay * y, Z=-self.delay * z)


@dataclass(frozen=True, eq=False)
class RotaryReadoutDelay(Effect):
    """-w delay about the axis, w = its speed in rad/s: its angle is read late, and so runs ahead of the axis.

    The second form of readout_delay, and reported as such: a resolver and a step counter that are read at different
    times differ by this; at rest they agree, which backlash does not.
    """

    name = "readout_delay_rotary"
    diagnosis = ForDiagnosis(
        family="readout_delay",
        prior=Prior(rare_in=("probe",)),
    )
    per = "axis"
    needs = ("speed_{axis}_rad_s",)
    about = About(
        cites="angle = speed x delay; Weckenmann et al., CIRP Annals 53 (2004) 657 for the linear axes",
    )
    axis: str = at("C", "rotary axis")
    delay: float = param(
        0.0,
        "ms",
        "time between passing an angle and reading it",
        typical=Typical(1e-4, "one cycle of a converter or bus: 0.05-1 ms; faults reach 30 ms", most=0.1),
    )

    def __post_init__(self) -> None:
        if not is_rotary(self.axis):
            raise UsageError(
                f'readout_delay_rotary: axis = "{self.axis}" is no rotary axis; write axis = "C", or readout_delay for X, Y, Z'
            )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        return motion(run, **{self.axis: -self.delay * run.column(f"speed_{self.axis}_rad_s")})
