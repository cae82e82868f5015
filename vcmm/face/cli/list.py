"""vcmm list: lists of available names."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Literal

from vcmm.face.cli.options import Json
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.show.console.terminal import show_table
from vcmm.show.tables.table import listing

if TYPE_CHECKING:
    from vcmm.core.effect import Effect

TopicName = Literal[
    "scenarios",
    "effects",
    "features",
    "strategies",
    "characteristics",
    "criteria",
    "laws",
    "aliases",
    "units",
]


def list_command(what: TopicName = "scenarios", *, json: Json = False) -> int:
    """List scenarios, effects, features, strategies, characteristics, criteria, laws, aliases of error names, or units.

    Parameters
    ----------
    what
        What to list.
    json
        Print one JSON document.
    """
    return run_job(ListJob(what), Flags(json))


Rows = tuple[list[str], list[list[str]]]


@dataclass(frozen=True)
class ListJob(Job[Rows, Rows]):
    """One list: headings and rows. Nothing is computed: the loaded data are the answer."""

    what: TopicName
    schema = "vcmm.list/1"

    def load(self) -> Rows:
        return _TABLES[self.what]()

    def run(self, loaded: Rows, report: Progress) -> Rows:
        return loaded

    def record(self, loaded: Rows, result: Rows) -> Record:
        columns, rows = result
        return Record({"what": self.what, "items": [dict(zip(columns, row)) for row in rows]}, ())

    def show(self, loaded: Rows, result: Rows) -> None:
        columns, rows = result
        show_table(listing(self.what, columns, rows, words=range(len(columns))))


def _scenarios() -> Rows:
    from vcmm.files.own.library import scenarios

    return ["name", "what it shows"], [[name, text] for name, text in scenarios().items()]


def _effects() -> Rows:
    from vcmm.core.effect import parameter_fields
    from vcmm.physics import ALL

    def parameters(kind: type[Effect]) -> str:
        back = {v: k for k, v in kind.about.aliases.items()}
        return ", ".join(f"{back.get(f.name, f.name)} ({f.metadata['show']})" for f in parameter_fields(kind))

    rows = [[e.name, e.per, parameters(e), (e.__doc__ or "").strip().split("\n")[0]] for e in ALL]
    return ["effect", "per", "parameters", "what"], rows


def _features() -> Rows:
    from vcmm.files.own.features import TABLES

    rows = [[name, ", ".join(k for k in model.model_fields if k != "type")] for name, model in TABLES.items()]
    return ["feature", "keys"], rows


def _strategies() -> Rows:
    from vcmm.task.measuring.strategies import PATTERNS

    rows = []
    for kind, patterns in PATTERNS.items():
        for name, pattern in patterns.items():
            rows.append(
                [
                    kind,
                    name,
                    ", ".join(f.name for f in fields(pattern)),
                    (pattern.__doc__ or "").split(": ", 1)[-1].split("\n")[0],
                ]
            )
    return ["feature", "strategy", "keys", "what"], rows


def _characteristics() -> Rows:
    from vcmm.part.part import TYPES

    return ["characteristic", "of", "between", "datums"], [
        [t, *(_count(roles) for roles in (r.of, r.between, r.datums))] for t, r in TYPES.items()
    ]


def _count(roles: tuple[int, int]) -> str:
    """Return how many features: "1", "0 to 3", "" for none."""
    least, most = roles
    if most == 0:
        return ""
    return f"{least}" if least == most else f"{least} or more" if most > 9 else f"{least} to {most}"


def _criteria() -> Rows:
    from vcmm.part.fit.criteria import CRITERIA, SUITS
    from vcmm.part.gps.characteristics import SIZES as ROUND_SIZES
    from vcmm.part.gps.criteria import LOCAL, RANKS, SIZES

    def sizes_of(word: str) -> str:
        kinds = LOCAL[word] if word in LOCAL else tuple(k for k in SUITS[word[1]] if k in ROUND_SIZES)
        return ", ".join(kinds)

    rows = [
        [
            letter,
            "feature, datum" if letter == "T" else "feature, datum, form",
            ", ".join(SUITS[letter]),
            text,
        ]
        for letter, text in CRITERIA.items()
    ]
    rows += [[word, "size", sizes_of(word), text] for word, text in SIZES.items()]
    rows += [
        [f"LP {word}, LS {word}", "size", "as LP, LS", f"{text} of the local sizes"]
        for word, (text, _) in RANKS.items()
    ]
    return ["criterion", "of", "features", "what"], rows


def _laws() -> Rows:
    keys = {
        "normal": "u", "t": "scale, dof", "uniform": "half_width or u", "triangular": "half_width or u",
        "trapezoidal": "half_width or u, top (share of the half width)", "arcsine": "half_width or u",
        "samples": "values", "multivariate": "covariance",
    }  # fmt: skip
    return ["law", "keys"], [[k, v] for k, v in keys.items()]


def _aliases() -> Rows:
    from vcmm.core.error_names import table

    return ["ISO 230-1", "VDI 2617-3", "delta/epsilon literature", "plain words"], [
        list(row) for row in table()
    ]


def _units() -> Rows:
    from vcmm.core.units import EXAMPLES, UNITS

    rows = [["units", " ".join(UNITS)]] + [[name, text] for name, text in EXAMPLES.items()]
    return ["quantity", "example"], rows


_TABLES = {
    "scenarios": _scenarios, "effects": _effects, "features": _features, "strategies": _strategies,
    "characteristics": _characteristics, "criteria": _criteria, "laws": _laws, "aliases": _aliases, "units": _units,
}  # fmt: skip
