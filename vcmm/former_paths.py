"""Module paths that the documentation of version 0.1.0 named: they stay importable and mean the modules of today."""

from __future__ import annotations

import importlib
import importlib.abc
import importlib.machinery
import sys
from collections.abc import Mapping, Sequence
from types import ModuleType

FORMER: Mapping[str, str] = {
    "vcmm.effect": "vcmm.core.effect",
    "vcmm.errors": "vcmm.core.errors",
    "vcmm.fixture": "vcmm.measuring.fixture",
    "vcmm.kinematics": "vcmm.core.kinematics",
    "vcmm.laws": "vcmm.core.laws",
    "vcmm.machine": "vcmm.core.machine",
    "vcmm.machining.shop": "vcmm.machining.preparation",
    "vcmm.nc.toolpath": "vcmm.motion.toolpath",
    "vcmm.pages.shown": "vcmm.tables.table",
    "vcmm.pages.test_piece": "vcmm.cases.test_piece_page",
    "vcmm.run": "vcmm.core.run",
    "vcmm.twins.abbe_milling": "vcmm.papers.abbe_milling.twin",
    "vcmm.twins.gaska2014": "vcmm.papers.gaska2014.twin",
    "vcmm.twins.gaska2014_placement": "vcmm.papers.gaska2014.placement",
    "vcmm.twins.marin2004": "vcmm.papers.marin2004.twin",
    "vcmm.twins.marin2004_day": "vcmm.papers.marin2004.day",
    "vcmm.twins.test_piece": "vcmm.cases.test_piece",
    "vcmm.twins.test_piece_errors": "vcmm.cases.test_piece_errors",
    "vcmm.twins.virtual_cut": "vcmm.papers.virtual_cut",
    "vcmm.twins.worn_cmm": "vcmm.cases.worn_cmm",
    "vcmm.units": "vcmm.core.units",
}
ROOMS = ("vcmm.twins",)  # former packages, of which only the modules above are left


class FormerPaths(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Answers for the names in FORMER with the module of today: one object under both names."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> importlib.machinery.ModuleSpec | None:
        if fullname not in FORMER and fullname not in ROOMS:
            return None
        return importlib.machinery.ModuleSpec(fullname, self, is_package=fullname in ROOMS)

    def create_module(self, spec: importlib.machinery.ModuleSpec) -> ModuleType | None:
        if spec.name in ROOMS:
            return None  # an empty package
        module = importlib.import_module(FORMER[spec.name])
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """The module has run under its own name, and keeps what it says of itself."""
        spec = module.__spec__
        if spec is not None and spec.loader_state is not None:
            module.__spec__ = spec.loader_state


def install() -> None:
    """Ask this finder after all others, once."""
    if not any(isinstance(finder, FormerPaths) for finder in sys.meta_path):
        sys.meta_path.append(FormerPaths())
