"""Machines and programs with rotary axes, as files: a horizontal centre, a rotary table about X, a tilting head."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import vcmm
from vcmm.shop.machining.job import patch
from vcmm.shop.machining.maps import net
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import PreparedCut
from vcmm.shop.machining.result import Patch

HEAD = "%\nO1 (ROTARY)\nG21 G17 G40 G49 G80 G90 G94\nT1 M6\nG54 S3000 M3\n"
FOOT = "G0 Z300.\nM30\n%\n"
SETUP = """\
vcmm = "setup/1"
dialect = "fanuc"
[offsets]
G54 = ["0 mm", "0 mm", "-400 mm"]
[tools.1]
length = "100 mm"
"""
LINEAR = '[axes.X]\ntravel = ["-500 mm", "500 mm"]\n[axes.Y]\ntravel = ["-500 mm", "500 mm"]\n[axes.Z]\ntravel = ["-500 mm", "300 mm"]\n'


def machine(structure: str, more: str) -> str:
    """A machine file; more: its rotary axes, then its effects."""
    return (
        f'vcmm = "machine/1"\nname = "mill"\nkind = "machine-tool"\nstructure = "{structure}"\n{LINEAR}{more}'
    )


def axis(letter: str, centre: str = "0 0 -400") -> str:
    words = centre.split()
    inside = ", ".join(f'"{w} mm"' for w in words)
    return f'[axes.{letter}]\ntravel = ["-400 deg", "400 deg"]\ncentre = [{inside}]\n'


def write(
    folder: Path, mill: str, program: str, features: str, tool: str, cut: str = "", more: str = ""
) -> Path:
    """The scenario file. cut: lines of [cut]; more: further tables."""
    (folder / "part.nc").write_text(HEAD + program + FOOT)
    (folder / "setup.toml").write_text(SETUP + tool)
    (folder / "mill.toml").write_text(mill)
    path = folder / "part.toml"
    path.write_text(
        f'vcmm = "scenario/1"\nmachine = "mill.toml"\n[cut]\nprogram = "part.nc"\nsetup = "setup.toml"\n{cut}\n'
        f"[part.features]\n{features}\n{more}\n[job]\ntrials = 2000\n"
    )
    return path


def shop_of(path: Path) -> PreparedCut:
    return set_up(vcmm.load_cut(path))


def patches(path: Path, across: int = 9) -> dict[str, Patch]:
    """Feature -> cut surface over a coarse net."""
    shop = shop_of(path)
    nets = [net(f, across) for f in shop.scenario.part.features.values()]
    return {n.feature: patch(shop, n) for n in nets if n is not None}


def about(letter: str, angle: float | np.ndarray) -> np.ndarray:
    """Rotation matrix (3, 3, ...) about X, Y or Z for A, B or C, written out."""
    c, s = np.cos(angle), np.sin(angle)
    one, no = np.ones_like(c), np.zeros_like(c)
    return {
        "A": np.array([[one, no, no], [no, c, -s], [no, s, c]]),
        "B": np.array([[c, no, s], [no, one, no], [-s, no, c]]),
        "C": np.array([[c, -s, no], [s, c, no], [no, no, one]]),
    }[letter]
