"""vcmm explain: an effect, a geometric error or a figure of a standard in words, with formula, sign, source.

Figures of certificates and standards in words: what each symbol says, where it is defined, and its former symbols.
"""

from __future__ import annotations

from dataclasses import dataclass
from inspect import cleandoc
from typing import NamedTuple, Protocol

from vcmm.core.axes import is_location
from vcmm.core.effect import Effect, key_fields, parameter_fields, place_fields, unit_at
from vcmm.core.error_names import DescribedError, canonical, describe_error, is_known
from vcmm.core.errors import UsageError
from vcmm.face.cli.options import Json
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.physics import BY_NAME, find
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import RotaryLocation, Squareness
from vcmm.show.console.terminal import show_table
from vcmm.show.tables.table import listing


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


def explain_command(word: str, *, json: Json = False) -> int:
    """Explain an effect (backlash), a geometric error (EXX, xty, C0Y) or a figure (E0_MPE, A): sign, unit, source, how to write it.

    Parameters
    ----------
    word
        Name of an effect (see `vcmm list effects`), of an error in any literature (`vcmm list aliases`), of a figure.
    json
        Print one JSON document.
    """
    return run_job(ExplainJob(word), Flags(json))


class Explanation(Protocol):
    """Meaning of a word: as a document without its frame, and in words."""

    def body(self) -> dict[str, object]: ...
    def show(self) -> None: ...


@dataclass(frozen=True)
class ExplainJob(Job[Explanation, Explanation]):
    """One word explained. Nothing is computed: what is loaded is the answer."""

    word: str
    schema = "vcmm.explain/1"

    def load(self) -> Explanation:
        return explanation_of(self.word)

    def run(self, loaded: Explanation, report: Progress) -> Explanation:
        return loaded

    def record(self, loaded: Explanation, result: Explanation) -> Record:
        return Record(result.body(), ())

    def show(self, loaded: Explanation, result: Explanation) -> None:
        result.show()


def explanation_of(word: str) -> Explanation:
    """Return an effect before a figure, a figure before an error. Raises UsageError, with similar names."""
    if word in BY_NAME:
        return EffectWords(find(word))
    if figures := standard_figures(word):
        return FigureWords(word, figures)
    if is_known(word):
        return ErrorWords(describe_error(canonical(word)))
    try:
        return EffectWords(find(word))
    except UsageError as error:
        raise UsageError(
            f"{error} Errors such as EYX or C0Y and figures such as E0_MPE are explained too"
        ) from None


@dataclass(frozen=True)
class FigureWords:
    """A figure of one standard or several."""

    word: str
    figures: tuple[StandardFigure, ...]

    def body(self) -> dict[str, object]:
        return {"figure": self.word, "meanings": [f._asdict() for f in self.figures]}

    def show(self) -> None:
        for figure in self.figures:
            former = ", ".join(figure.former)
            print(
                f"{figure.symbol}\n\n{figure.words}\n\nsource    {figure.source}"
                + (f"\nalso      {former}" if former else "")
                + "\n"
            )


@dataclass(frozen=True)
class ErrorWords:
    """A geometric error of ISO 230-1."""

    row: DescribedError

    @property
    def kind(self) -> type[Effect]:
        """The effect that states it in a machine file."""
        if self.row.name.startswith("E"):
            return ComponentTable
        return RotaryLocation if is_location(self.row.name) else Squareness

    @property
    def key(self) -> str:
        return next(f.name for f in place_fields(self.kind))

    def body(self) -> dict[str, object]:
        row = self.row
        return {
            "error": row.name, "text": row.words, "also": row.also, "sign": row.sign, "unit": row.unit,
            "effect": self.kind.name, "key": self.key,
        }  # fmt: skip

    def show(self) -> None:
        row, kind = self.row, self.kind
        print(
            f"{row.name}\n\n{row.words}\n\n"
            f"sign      {row.sign} (machine axes; the tip error that follows: vcmm field)\n"
            f"unit      {row.unit}\nsource    ISO 230-1\nalso      {row.also}\n\n"
            f'in a machine file: effect = "{kind.name}" with {self.key} = "{row.name}"; see vcmm explain {kind.name}'
        )


@dataclass(frozen=True)
class EffectWords:
    """An effect by its own declaration."""

    kind: type[Effect]

    @property
    def text(self) -> str:
        return cleandoc(self.kind.__doc__ or "")

    @property
    def sign(self) -> str:
        return "reading: indicated - true" if self.kind().link == "reading" else "tip error: actual - nominal"

    def parameters(self) -> list[list[str]]:
        """Name, unit and meaning of each."""
        back = {v: k for k, v in self.kind.about.aliases.items()}
        return [
            [
                back.get(f.name, f.name),
                f.metadata["unit"],
                f.metadata["doc"]
                + (f", {f.metadata['shape']}" if f.metadata["shape"] else "")
                + (" (scanned)" if f.metadata["scan"] else ""),
            ]
            for f in parameter_fields(self.kind)
        ]

    def places(self) -> list[list[str]]:
        return [[f.name, str(f.metadata["doc"])] for f in place_fields(self.kind)]

    def keys(self) -> list[list[str]]:
        return [
            [f.name, str(f.metadata.get("doc", "further key of the table"))] for f in key_fields(self.kind)
        ]

    def body(self) -> dict[str, object]:
        kind = self.kind
        return {
            "effect": kind.name, "text": self.text, "sign": self.sign, "per": kind.per, "needs": list(kind.needs), "cites": kind.about.cites,
            "parameters": [dict(zip(("name", "unit", "doc"), p)) for p in self.parameters()],
            "places": [dict(zip(("key", "doc"), p)) for p in self.places()],
            "keys": [dict(zip(("key", "doc"), k)) for k in self.keys()],
        }  # fmt: skip

    def show(self) -> None:
        kind, parameters = self.kind, self.parameters()
        print(f"{kind.name}\n\n{self.text}\n")
        print(
            f"sign      {self.sign}\nsource    {kind.about.cites}\nper       {kind.per}\n"
            f"needs     {', '.join(kind.needs) or 'positions only'}\n"
        )
        turned = {u: unit_at(kind, u, axis="C") for _, u, _ in parameters}
        units = {u: u if other == u else f"{u} ({other} of a rotary axis)" for u, other in turned.items()}
        rows = [["place", *p] for p in self.places()]
        rows += [["parameter", n, f"{units[u]}: {d}"] for n, u, d in parameters]
        rows += [["key", *k] for k in self.keys()]
        show_table(listing("keys of the [[effects]] table", ["", "key", "meaning"], rows, words=(0, 1, 2)))
