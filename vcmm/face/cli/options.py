"""Options that several verbs have; `vcmm.face.job` uses them. What is done with them: `vcmm.face.job`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

InputFile = Annotated[
    Path, "a file that is read"
]  # looked at before the verb is imported: vcmm.face.cli.inputs
InputPath = Annotated[Path, "a file or a folder that is read"]
InputName = Annotated[Path, "a file that is read, or a name without an ending, such as that of a twin"]
Seed = Annotated[int, Parameter(validator=Number(gte=0, lt=2**63))]  # the streams take 64 bits
CountOption = Annotated[int | None, Parameter(validator=Number(gte=1))]  # 0 would be taken for "not given"
Decimals = Annotated[int | None, Parameter(validator=Number(gte=0, lte=9))]  # a control reads no more
Workers = Annotated[int | None, Parameter(name="--workers")]
Cluster = Annotated[str | None, Parameter(name="--cluster")]
Shard = Annotated[str | None, Parameter(name="--shard")]
Json = Annotated[bool, Parameter(name="--json")]
Require = Annotated[Literal["conforms"] | None, Parameter(name="--require")]


def _pack_place(kind: object, path: Path | None) -> None:
    if path is not None:
        from vcmm.show.console.evidence import check_pack_place

        check_pack_place(path)


Evidence = Annotated[Path | None, Parameter(name="--evidence", validator=_pack_place)]
