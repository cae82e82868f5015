"""Placement: fixtures, freedoms and goals, and the search itself on a scenario that a program made."""

from __future__ import annotations

from vcmm.answer.placing.placement import place
from vcmm.answer.placing.result import PlacementResult, place_json, pose_json
from vcmm.answer.placing.words import pose_text
from vcmm.show.pages.place import maps
from vcmm.task.measuring.fixture import Fixture, Freedom, Goal, six_of

__all__ = [
    "Fixture",
    "Freedom",
    "Goal",
    "PlacementResult",
    "maps",
    "place",
    "place_json",
    "pose_json",
    "pose_text",
    "six_of",
]
