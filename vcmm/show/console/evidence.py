"""Evidence packs: all inputs of a result in one zip, so that another person can run it again and get the same numbers.

evidence.json   covered influences, command, versions, SHA-256 of every file (schema vcmm.evidence/1)
document.json   the result
files/...       all files that were read
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import lzma
import math
import os
import platform
import struct
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Any

from vcmm import __version__
from vcmm.core.errors import DataError, Environment, UsageError
from vcmm.core.text import brief

if TYPE_CHECKING:
    from vcmm.answer.evaluation.declaration import DeclaredInfluence

SCHEMA = "vcmm.evidence/1"
EVIDENCE, DOCUMENT, FILES = "evidence.json", "document.json", "files"
MOST_UNPACKED_BYTES, MOST_FILES = 1 << 30, 2000  # bytes unpacked, files: beyond that it is no evidence pack
TOLERANCE = 1e-6  # relative: what other libraries on another computer may change
ARCHIVE_ERRORS = (  # what zipfile and its decompressors raise of an archive that was spoilt
    zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError, OSError, RuntimeError, NotImplementedError, ValueError, OverflowError,
    struct.error,
)  # fmt: skip
NOT_COMPARED = ("version", "inputs", "warnings", "warning_texts")  # they hold paths and the version


@dataclass(frozen=True)
class ComparedNumber:
    """A value that differs when the command is run again."""

    key: str
    was: Any
    now: Any

    @property
    def relative(self) -> float:
        """Relative difference; infinite where one of the two is no finite number."""
        if not (_is_finite(self.was) and _is_finite(self.now)):
            return math.inf
        return abs(self.was - self.now) / max(abs(self.was), abs(self.now), 1e-12)


def _is_finite(value: Any) -> bool:
    """Return whether it is a number that a float can hold."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def write_pack(
    path: Path,
    words: Sequence[str | Path],
    content: dict[str, Any],
    files: Sequence[Path],
    influences: Sequence[DeclaredInfluence],
) -> None:
    """Write a pack. words: the command after `vcmm`, files as Path."""
    root = Path(os.path.commonpath([f.resolve().parent for f in files]))
    names = {f.resolve(): str(PurePosixPath(FILES, *f.resolve().relative_to(root).parts)) for f in files}
    record = {
        "schema": SCHEMA, "version": __version__, "python": platform.python_version(), "libraries": libraries(),
        "platform": platform.platform(), "command": [names[w.resolve()] if isinstance(w, Path) else w for w in words],
        "seed": content.get("seed"), "influences": [asdict(i) for i in influences],
        "files": [{"file": n, "sha256": _sha(f.read_bytes())} for f, n in names.items()],
    }  # fmt: skip
    members = {EVIDENCE: _text(record), DOCUMENT: _text(content)} | {
        n: f.read_bytes() for f, n in names.items()
    }
    draft = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with zipfile.ZipFile(draft, "w", zipfile.ZIP_DEFLATED) as pack:
            for name, data in members.items():
                pack.writestr(zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0)), data, zipfile.ZIP_DEFLATED)
        draft.replace(path)
    except OSError as error:
        raise Environment(f"{path} cannot be written ({error.strerror}); choose another place") from None
    finally:
        with contextlib.suppress(OSError):
            draft.unlink(missing_ok=True)


def check_pack_place(path: Path) -> None:
    """Refuse, before any work, the name of a folder or of a file that is no pack. Raises UsageError where the name is that of a folder or
    of a file that is no pack."""
    if path.is_dir():
        raise UsageError(f"--evidence {path} is a folder; name a file in it, such as {path / 'pack.zip'}")
    if (path.exists() or path.is_symlink()) and not zipfile.is_zipfile(path):
        raise UsageError(
            f"--evidence {path}: there is a file of that name that is no pack; it would be lost, choose another name"
        )


def command_words(verb: str, scenario: Path, options: Mapping[str, Any]) -> list[str | Path]:
    """Return the command after `vcmm`: options by their name, those that were not given left out."""
    out: list[str | Path] = [verb, scenario]
    for name, value in options.items():
        if value is None or value is False:
            continue
        out.append(f"--{name.replace('_', '-')}")
        if value is not True:
            out.append(value if isinstance(value, Path) else str(value))
    return out


def libraries() -> dict[str, str]:
    """Return the versions of the libraries that calculate."""
    import numpy
    import scipy

    return {"numpy": numpy.__version__, "scipy": scipy.__version__}


def _text(content: dict[str, Any]) -> bytes:
    return json.dumps(content, indent=1, allow_nan=False).encode()


def _sha(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def unpack_evidence(pack: Path, folder: Path) -> dict[str, Any]:
    """Return the evidence of a pack, its files laid into `folder`. DataError: no such pack, a file changed, missing or unexpected."""
    try:
        with zipfile.ZipFile(pack) as archive:
            _check_members(pack, archive)
            data = {i.filename: archive.read(i) for i in archive.infolist() if not i.is_dir()}
    except ARCHIVE_ERRORS as error:
        raise DataError(
            f"{pack}: this is no evidence pack ({error}); --evidence pack.zip of a job writes one"
        ) from None
    if EVIDENCE not in data or DOCUMENT not in data:
        raise DataError(
            f"{pack}: {EVIDENCE} or {DOCUMENT} is missing; --evidence pack.zip of a job writes a pack"
        )
    record = _read(pack, EVIDENCE, data)
    if record.get("schema") != SCHEMA:
        raise DataError(
            f'{pack}: {EVIDENCE} has the schema "{record.get("schema")}"; this version reads {SCHEMA}'
        )
    _check_hashes(pack, record, data)
    for name in (entry["file"] for entry in record["files"]):
        target = folder / name
        try:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data[name])
        except (OSError, ValueError):
            raise DataError(f"{pack}: {name[:80]!r} cannot be the name of a file here") from None
    return record | {"document": _read(pack, DOCUMENT, data)}


def _check_members(pack: Path, archive: zipfile.ZipFile) -> None:
    infos = archive.infolist()
    if len(infos) > MOST_FILES or sum(i.file_size for i in infos) > MOST_UNPACKED_BYTES:
        raise DataError(
            f"{pack}: more than {MOST_FILES} files or {MOST_UNPACKED_BYTES >> 30} GB unpacked; this is no evidence pack"
        )
    for i in infos:
        parts = PurePosixPath(i.filename.replace("\\", "/"))
        if parts.is_absolute() or ".." in parts.parts or ":" in i.filename:
            raise DataError(f'{pack}: "{i.filename}" lies outside the pack; nothing was unpacked')


def _read(pack: Path, name: str, data: dict[str, bytes]) -> dict[str, Any]:
    try:
        content = json.loads(data[name])
        json.dumps(content)  # refuses what is too deep to be compared
    except (ValueError, RecursionError) as error:
        raise DataError(f"{pack}: {name} is no JSON ({brief(str(error), 100)})") from None
    if not isinstance(content, dict):
        raise DataError(f"{pack}: {name} holds no document")
    return content


def _check_hashes(pack: Path, record: dict[str, Any], data: dict[str, bytes]) -> None:
    problems = []
    files = record.get("files")
    if not isinstance(files, list) or not all(
        isinstance(entry, dict)
        and isinstance(entry.get("file"), str)
        and isinstance(entry.get("sha256"), str)
        for entry in files
    ):
        raise DataError(f"{pack}: {EVIDENCE} lists no files with their SHA-256")
    listed = {entry["file"]: entry["sha256"] for entry in files}
    for name, sha in listed.items():
        if name not in data:
            problems.append(f"{pack}: {name} is listed and missing")
        elif _sha(data[name]) != sha:
            problems.append(f"{pack}: {name} was changed after the pack was made (SHA-256 differs)")
    problems += [
        f"{pack}: {n} is not listed" for n in data if n not in listed and n not in (EVIDENCE, DOCUMENT)
    ]
    if not isinstance(record.get("command"), list) or not all(isinstance(w, str) for w in record["command"]):
        problems.append(f"{pack}: {EVIDENCE} states no command")
    due = {"version": str, "libraries": dict, "influences": list}
    problems += [
        f"{pack}: {EVIDENCE} lacks {k}" for k, kind in due.items() if not isinstance(record.get(k), kind)
    ]
    named = {"influence", "status"}
    if not problems and not all(isinstance(i, dict) and named <= set(i) for i in record["influences"]):
        problems.append(f"{pack}: {EVIDENCE} lists influences without name and status")
    if problems:
        raise DataError(problems)


def differences(was: Any, now: Any, key: str = "") -> Iterator[ComparedNumber]:
    """Yield every value that differs, by its key; paths, versions and warnings are not compared."""
    if isinstance(was, dict) and isinstance(now, dict):
        for name in dict.fromkeys((*was, *now)):
            if key or name not in NOT_COMPARED:
                yield from differences(was.get(name), now.get(name), f"{key}.{name}".lstrip("."))
    elif isinstance(was, list) and isinstance(now, list) and len(was) == len(now):
        for i, (a, b) in enumerate(zip(was, now)):
            yield from differences(a, b, f"{key}[{i}]")
    elif isinstance(was, bool) is not isinstance(now, bool) or was != now:
        yield ComparedNumber(key, was, now)
