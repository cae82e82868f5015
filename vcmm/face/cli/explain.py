"""vcmm explain: an effect, a geometric error or a figure of a standard in words, with formula, sign, source."""

from __future__ import annotations

from dataclasses import dataclass
from inspect import cleandoc
from typing import Protocol

from vcmm.core.axes import is_location
from vcmm.core.effect import Effect, key_fields, parameter_fields, place_fields, unit_at
from vcmm.core.error_names import DescribedError, canonical, describe_error, is_known
from vcmm.core.errors import UsageError
from vcmm.core.figures import StandardFigure, standard_figures
from vcmm.face.cli.options import Json
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.physics import BY_NAME, find
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import RotaryLocation, Squareness
from vcmm.show.console.terminal import show_table
from vcmm.show.tables.table import listing


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
