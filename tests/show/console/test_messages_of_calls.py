"""What a call, an option, a unit and a bracket are told: the thing that is wrong, where it is, and what to do."""

from __future__ import annotations

from pathlib import Path

import pytest

import vcmm
from vcmm.core.errors import DataError, OptionError, UsageError
from vcmm.core.units import quantity
from vcmm.face.cli import run as command
from vcmm.files.own.library import example
from vcmm.files.toml import read_toml


def test_a_path_is_loaded(few_parts: None) -> None:
    file = example("plate")
    assert vcmm.measure(file)["bore diameter"].value == vcmm.measure(str(file))["bore diameter"].value
    assert vcmm.uncertainty(file, trials=1000)["bore diameter"].u > 0
    for verb in (vcmm.uncertainty, vcmm.measure, vcmm.place):
        with pytest.raises(
            UsageError, match=r"expected a scenario or the path of its file, not int; vcmm.load_scenario"
        ):
            verb(3)


def test_an_option_is_not_blamed_on_a_line_of_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "plate.toml"
    file.write_bytes(example("plate").read_bytes())
    for verb in ("uncertainty", "place"):
        assert command([verb, str(file), "--trials", "12"]) == 2
        said = capsys.readouterr().err
        assert said.startswith("vcmm: 12 trials are too few")
        assert "plate.toml" not in said
    with pytest.raises(OptionError, match="12 trials"):
        vcmm.load_scenario(file).settings.with_changes(trials=12)


@pytest.mark.parametrize(
    ("text", "dimension", "offered", "not_offered"),
    [("2 mn", "length", 'Did you mean "mm"', "min"), ("2 mi", "time", '"min"', "mm"), ("20 C", "temperature", "degC", "cm")],
)  # fmt: skip
def test_units_of_the_right_dimension_are_offered(
    text: str, dimension: str, offered: str, not_offered: str
) -> None:
    with pytest.raises(UsageError) as told:
        quantity(text, dimension)
    assert offered in str(told.value)
    assert not_offered not in str(told.value).replace(text, "")


@pytest.mark.parametrize(
    ("text", "line", "until"),
    [
        ("v = 1\na = [1, 2\nb = 4\n", 2, " before line 3"),
        ("a = [\n  [1, 2],\n  3\n\nb = 4\n", 1, " before line 5"),
        ("a = 1\nb = { x = [1, 2 }\n", 2, ""),
        ('a = "[["\nb = [1\n', 2, ""),
    ],
)
def test_an_open_bracket_is_found_where_it_stands(tmp_path: Path, text: str, line: int, until: str) -> None:
    file = tmp_path / "a.toml"
    file.write_text(text)
    with pytest.raises(DataError) as told:
        read_toml(file)
    assert f'a.toml:{line}: not valid TOML: the "[" is not closed{until}:' in str(told.value)


def test_memory_without_a_size_is_said_so(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    from vcmm.face import cli

    def full(words: object) -> int:
        raise MemoryError

    monkeypatch.setattr(cli, "_dispatch", full)
    assert command(["list"]) == 3
    assert "more memory than there is (no size stated)" in capsys.readouterr().err
