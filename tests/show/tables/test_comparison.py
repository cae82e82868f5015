"""Names of machine files in a table, short and yet told apart."""

from __future__ import annotations

from vcmm.show.tables.comparison import short_names


def test_every_file_of_several_recordings_is_told_from_the_others():
    own, other = "/shop/mcuA/machine.toml, /shop/mcuB/machine.toml", "/shop/better/machine.toml"
    assert short_names([own, other]) == ["mcuA/machine.toml, mcuB/machine.toml", "better/machine.toml"]
    assert short_names(["/a/one.toml", "/a/two.toml"]) == ["one.toml", "two.toml"]
    assert short_names(["one.toml", "one.toml"]) == ["one.toml", "one.toml"]
