"""The state on disk: track.toml for people, track.npz beside it with every number in full.

A recording is known by its file, its date and the SHA-256 of its rows, so that a recording that was changed afterwards is detected.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from vcmm import __version__
from vcmm.core.errors import DataError
from vcmm.core.whole_files import write_files
from vcmm.files.toml import check_version, find_file, read_toml
from vcmm.learn.tracking.compress import SeenRecording
from vcmm.learn.tracking.follow import FollowedCheck, FollowedMachine
from vcmm.learn.tracking.kalman import GaussianState
from vcmm.learn.tracking.quantities import TrackedMachine
from vcmm.learn.tracking.rates import GroupRates

TEXT, NUMBERS = "track.toml", "track.npz"
SHAPES = 4  # of what changes: 2 gives tables a straight line first, 3 leaves out coefficients that a control was given, 4 has numbers of its own for what passes
PLAIN = tuple(k for k in SeenRecording.__dataclass_fields__ if k not in ("columns", "value"))
CHECK_KEYS = {
    "rms_predicted": "predicted",
    "rms_unchanged": "unchanged",
}  # number of a check -> its key in the file, where they differ


@dataclass(frozen=True)
class KnownFile:
    """A recording that the state holds: its path from the folder, its date, the hash of its content."""

    name: str
    date: str
    sha256: str


def hash_of(path: Path) -> str:
    """Return the hash of a TOML file and of the files beside it that it names."""
    digest = hashlib.sha256(path.read_bytes())
    for text in sorted(set(_texts(read_toml(path).data))):
        there = find_file(text, path.parent)
        if there is not None:
            digest.update(there.read_bytes())
    return digest.hexdigest()


def _texts(value: Any) -> list[str]:
    if isinstance(value, str):
        return [value]
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    return [t for v in inner for t in _texts(v)]


def recording_hash(path: Path, content: dict[str, Any]) -> str:
    """Return the hash of a recording: of its file, which was read before (`content`), and its data, not of the machine file that it names."""
    data = {k: v for k, v in content.items() if k != "machine"}
    digest = hashlib.sha256(json.dumps(data, sort_keys=True, default=str).encode())
    for text in sorted(set(_texts(data))):
        there = find_file(text, path.parent)
        if there is not None:
            digest.update(there.read_bytes())
    return digest.hexdigest()


def write_state(folder: Path, followed: FollowedMachine, machine: str, files: tuple[KnownFile, ...]) -> None:
    """Write both files, each whole: the text names the hash of the numbers. machine: hash of the machine file."""
    folder.mkdir(parents=True, exist_ok=True)
    arrays = {"mean": followed.state.mean, "factor": followed.state.factor}
    for i, recording in enumerate(followed.recordings):
        arrays |= {f"columns_{i}": recording.columns, f"value_{i}": recording.value}
    stream = io.BytesIO()
    np.savez(stream, **arrays)  # type: ignore[arg-type]
    content = stream.getvalue()
    waiting = folder / f"{NUMBERS}.part"
    waiting.write_bytes(content)
    os.replace(waiting, folder / NUMBERS)
    text = _text(followed, machine, files, hashlib.sha256(content).hexdigest())
    write_files(folder, {TEXT: text})


def _text(followed: FollowedMachine, machine: str, files: tuple[KnownFile, ...], numbers: str) -> str:
    lines = [
        'vcmm = "track/1"',
        f'version = "{__version__}"',
        f'machine_sha256 = "{machine}"',
        f'numbers_sha256 = "{numbers}"',
        f"alpha = {followed.alpha!r}",
        f"shapes = {SHAPES}",
    ]
    for name, rate in zip(followed.tracked.groups, followed.rates):
        lines += [
            "",
            f"[[rates]]                      # {rate.words}, usual sizes",
            f"group = {json.dumps(name)}",
        ]
        lines += [f"{k} = {v}" for k, v in asdict(rate).items()]
    for file, recording, check in zip(files, followed.recordings, followed.checks):
        lines += ["", "[[recordings]]", f"file = {json.dumps(file.name)}", f'date = "{file.date}"']
        lines += [f'sha256 = "{file.sha256}"', f"alarm = {'true' if check.alarm else 'false'}"]
        lines += [f"seen = {_table({k: getattr(recording, k) for k in PLAIN})}"]
        plain = {CHECK_KEYS.get(k, k): v for k, v in asdict(check).items() if k != "suspects"}
        lines += [f"check = {_table(plain)}"]
        suspects = ", ".join(f"[{json.dumps(n)}, {p!r}]" for n, p in check.suspects)
        lines += [f"suspects = [{suspects}]"]
    return "\n".join(lines) + "\n"


def _table(values: dict[str, Any]) -> str:
    texts = (f"{k} = {json.dumps(v) if isinstance(v, str) else repr(v)}" for k, v in values.items())
    return f"{{ {', '.join(texts)} }}"


def read_state(
    folder: Path, tracked: TrackedMachine, machine: str
) -> tuple[FollowedMachine, tuple[KnownFile, ...]] | None:
    """Read the state of a folder; None where there is none. Raises DataError for one of another machine file, or that does not fit together."""
    path = folder / TEXT
    if not path.is_file():
        return None
    document = read_toml(path)
    check_version(document, "track")
    data = document.data
    if data.get("machine_sha256") != machine:
        raise DataError(
            f"{path}: this state belongs to another machine file, or the file was changed since; --replay works everything out anew, or give "
            "another folder with --out"
        )
    if any(not GroupRates.__dataclass_fields__.keys() <= r.keys() for r in data.get("rates", [])):
        raise DataError(
            f"{path}: an earlier version wrote this state, without trends and seasons; --replay works everything out anew"
        )
    if data.get("shapes") != SHAPES:
        raise DataError(
            f"{path}: another version wrote this state, with other shapes of what changes; --replay works everything out anew"
        )
    numbers = folder / NUMBERS
    if not numbers.is_file() or hashlib.sha256(numbers.read_bytes()).hexdigest() != data["numbers_sha256"]:
        raise DataError(
            f"{numbers} is not the file that {TEXT} was written with; --replay works everything out anew"
        )
    with np.load(numbers) as arrays:
        recordings = data.get("recordings", [])
        compressed = tuple(
            SeenRecording(columns=arrays[f"columns_{i}"], value=arrays[f"value_{i}"], **r["seen"])
            for i, r in enumerate(recordings)
        )
        state = GaussianState(arrays["mean"], arrays["factor"])
    names = {key: name for name, key in CHECK_KEYS.items()}
    checks = tuple(
        FollowedCheck(
            suspects=tuple((n, p) for n, p in r["suspects"]),
            **{names.get(k, k): v for k, v in r["check"].items()},
        )
        for r in recordings
    )
    rates = tuple(GroupRates(**{k: r[k] for k in GroupRates.__dataclass_fields__}) for r in data["rates"])
    files = tuple(KnownFile(r["file"], r["date"], r["sha256"]) for r in recordings)
    return FollowedMachine(tracked, float(data["alpha"]), rates, state, compressed, checks), files
