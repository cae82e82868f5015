"""Which names hold others as special cases by what they are, on any recording; of these the simplest that the data can
resolve counts. A name that holds an answer only because this recording is poor is a rival, not a generalisation.
"""

from __future__ import annotations

from vcmm.learn.diagnosis.mistakes import MISTAKE
from vcmm.physics import BY_NAME
from vcmm.physics.structure.geometric_change import GeometricChange


def generalises(large: str, small: str) -> bool:
    """Is every motion of `small` a motion of `large`, whatever was recorded? A mistake is an edit of a table of one axis."""
    if small == MISTAKE:
        return large in BY_NAME and BY_NAME[large].diagnosis.holds_table_edits
    return small in BY_NAME and large in BY_NAME[small].diagnosis.special_case_of


def is_stale(effect: str, component: object) -> bool:
    """Is an answer the calibration as a whole? Its size is a covariance, not a number: the tables anew say how well each is known."""
    return component == "all" and effect == GeometricChange.name
