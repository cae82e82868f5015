"""Twins of published studies: packages of Python files that lie beside their scenarios, outside the package.

    gaska = vcmm.twin("gaska2014")     # scenarios/gaska2014/*.py
    gaska.twin.run(vcmm.load_scenario(vcmm.example("gaska2014")))

A twin is a user of vcmm like any other. Its files import one another by relative imports, and none of them is read before
the twin is requested.
"""

from __future__ import annotations

import importlib
import sys
from pathlib import Path
from types import ModuleType

from vcmm.core.errors import UsageError, choose_from
from vcmm.files.own.library import folder

PACKAGE = "vcmm_twins"  # the name under which Python knows the folder of scenarios


def names() -> list[str]:
    """Return the twins that can be run: every folder beside the scenarios that holds a twin.py."""
    return sorted(path.parent.name for path in folder().glob("*/twin.py"))


def files(name: str) -> list[Path]:
    """Return the Python files of a twin."""
    return sorted((folder() / name).glob("*.py"))


def open_folder() -> None:
    """Make the folder of scenarios importable as the package `vcmm_twins`; repeated calls change nothing."""
    if PACKAGE not in sys.modules:
        package = ModuleType(PACKAGE, "Twins of published studies, each in a folder beside its scenario.")
        package.__path__ = [str(folder())]
        sys.modules[PACKAGE] = package


def twin(name: str) -> ModuleType:
    """Return the package of a twin of a published study, which lies beside its scenario.

    Parameters
    ----------
    name
        Such as "gaska2014".

    Returns
    -------
    module
        The package, with its modules as attributes.

    Raises
    ------
    UsageError
        There is no twin of this name; the closest is named.
    """
    if name not in names():
        raise UsageError(f'there is no twin "{name}".{choose_from(name, names())}')
    open_folder()
    package = importlib.import_module(f"{PACKAGE}.{name}")
    for file in files(name):
        if file.stem != "__init__":
            importlib.import_module(f"{PACKAGE}.{name}.{file.stem}")
    return package
