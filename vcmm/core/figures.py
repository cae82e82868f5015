"""Figures of certificates and standards in words: what each symbol says, where it is defined, and its former symbols."""

from __future__ import annotations

from typing import NamedTuple


class StandardFigure(NamedTuple):
    """symbol as vcmm writes it; words: what it says; source: standard; former: symbols of earlier editions and other spellings."""

    symbol: str
    words: str
    source: str
    former: tuple[str, ...] = ()


CMM, PROBE = "ISO 10360-2:2009", "ISO 10360-5:2010"
FIGURES = (
    StandardFigure("E0", "error of a measured length, the ram-axis stylus tip offset being 0: indicated - calibrated", CMM, ("E",)),
    StandardFigure("E0_MPE", "largest error of a measured length that the maker permits, ram-axis stylus tip offset 0; A + L / K", CMM, ("MPE_E", "E0,MPE", "E_0,MPE", "MPEE")),
    StandardFigure("E150", "error of a measured length with a ram-axis stylus tip offset of 150 mm", CMM, ("E_150",)),
    StandardFigure("E150_MPE", "largest permitted error of a measured length with a stylus tip offset of 150 mm; A + L / K", CMM, ("E150,MPE", "E_150,MPE")),
    StandardFigure("R0", "repeatability range of the errors of three measurements of one length", CMM),
    StandardFigure("R0_MPL", "largest permitted repeatability range of a measured length", CMM, ("R0,MPL", "R_0,MPL")),
    StandardFigure("P_Form_Sph_1x25", "form error of the probing system: range of 25 points on a test sphere about their least-squares sphere", PROBE, ("P_FTU", "PFTU", "PForm.Sph.1x25", "P", "MPE_P", "MPEP")),
    StandardFigure("P_Size_Sph_1x25", "size error of the probing system: diameter from 25 points on a test sphere minus the calibrated one", PROBE, ("P_STU", "PSTU", "PSize.Sph.1x25")),
    StandardFigure("A", "bi-directional accuracy of positioning: from the lowest mean - 2 s to the highest mean + 2 s of both directions", "ISO 230-2:2014"),
    StandardFigure("E", "bi-directional systematic error of positioning: range of the mean errors of both directions", "ISO 230-2:2014"),
    StandardFigure("M", "mean bi-directional positioning error: range of the means of both directions", "ISO 230-2:2014"),
    StandardFigure("R", "bi-directional repeatability of positioning: largest spread of 4 s, reversal included", "ISO 230-2:2014"),
    StandardFigure("B", "reversal error: largest difference between the means of the two directions", "ISO 230-2:2014"),
    StandardFigure("G", "circular deviation: smallest radial separation of two concentric circles about the actual path", "ISO 230-4:2005"),
    StandardFigure("H", "circular hysteresis: largest radial difference of a clockwise and an anticlockwise path", "ISO 230-4:2005"),
    StandardFigure("F", "radial deviation: of the actual path from the nominal circle, about the nominal centre", "ISO 230-4:2005"),
    StandardFigure("u", "standard uncertainty: standard deviation of what is known of a quantity", "JCGM 100:2008 (GUM)"),
    StandardFigure("U", "expanded uncertainty, k u: half the width of the coverage interval", "JCGM 100:2008 (GUM)"),
    StandardFigure("k", "coverage factor, U / u", "JCGM 100:2008 (GUM)"),
    StandardFigure("p_conform", "probability that the true value lies within its limits", "JCGM 106:2012"),
)  # fmt: skip


def standard_figures(word: str) -> tuple[StandardFigure, ...]:
    """Return every figure of a symbol, past or present; spelled in any case where no other figure is meant. Empty where there is none."""
    exact = [f for f in FIGURES if word == f.symbol or word in f.former]
    if exact:
        return tuple(exact)
    loose = [f for f in FIGURES if word.lower() in {name.lower() for name in (f.symbol, *f.former)}]
    return tuple(loose) if len(loose) == 1 else ()
