"""Names of machine files in a table, short and yet told apart."""

from __future__ import annotations

from types import SimpleNamespace

from vcmm.show.tables.answers import compare_answers
from vcmm.show.tables.comparison import short_names


def test_every_file_of_several_recordings_is_told_from_the_others():
    own, other = "/shop/mcuA/machine.toml, /shop/mcuB/machine.toml", "/shop/better/machine.toml"
    assert short_names([own, other]) == ["mcuA/machine.toml, mcuB/machine.toml", "better/machine.toml"]
    assert short_names(["/a/one.toml", "/a/two.toml"]) == ["one.toml", "two.toml"]
    assert short_names(["one.toml", "one.toml"]) == ["one.toml", "one.toml"]


def test_the_rest_depends_on_what_is_least_by_chance():
    """Of p = 0.04 over X and 1e-6 over time the answer names time; the file with the smaller rms comes first."""
    over = [SimpleNamespace(covariate="X", p=0.04), SimpleNamespace(covariate="time", p=1e-6)]
    rows = [
        SimpleNamespace(rms=2e-3, noise=1e-3, angle=False, parts=[SimpleNamespace(depends_on=over)]),
        SimpleNamespace(rms=1e-3, noise=1e-3, angle=False, parts=[]),
    ]
    first, second = compare_answers(rows, ["old.toml", "new.toml"])  # type: ignore[arg-type]
    assert first.verdict == "leaves least"
    assert second.because == "the rest depends on time"
