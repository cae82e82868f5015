"""Which names hold others as special cases by what they are, on any recording; of these the simplest that the data can
resolve counts. A name that holds an answer only because this recording is poor is a rival, not a generalisation.
"""

from __future__ import annotations

from collections.abc import Mapping

GEOMETRY = ("scale_factor", "squareness", "map_mistake")  # and any edit of a table of one axis
HOLDS: Mapping[str, tuple[str, ...]] = {
    # a curve over one axis in any of its six components: its slope is a scale or a squareness, its shape any table
    "geometric_change": (
        *GEOMETRY,
        "abbe_offset",
        "abbe_counted_twice",
        "cross_axis_flexure",
        "map_interpolation",
        "screw_pitch",
        "rotary_location",
        "rotary_cyclic",
    ),
    "map_interpolation": (*GEOMETRY, "geometric_change", "screw_pitch", "encoder_interpolation"),
    "lost_motion": ("backlash",),  # g0 + g1 q + curve, all but g0 zero
    "hysteresis": ("backlash", "lost_motion"),  # a step that takes a way of its own
    "abbe_offset": ("abbe_counted_twice", "map_mistake"),  # an arm of any length
}


def generalises(large: str, small: str) -> bool:
    """Is every motion of `small` a motion of `large`, whatever was recorded?"""
    return small in HOLDS.get(large, ())
