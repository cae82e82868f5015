"""The data of a followed path: what the script draws."""

from __future__ import annotations

import json
import re

from vcmm.show.report.path import PathPicture, path_picture


def picture(error, name=""):
    points = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (2.0, 0.0, 0.0)]
    return PathPicture(
        points,
        [1, 2],
        [1, 1],
        [None, 500.0],
        [True, False],
        {1: "G0 </script>", 2: "G1"},
        error=error,
        name=name,
    )


def data(markup):
    return json.loads(re.search(r'application/json">(.*?)</script>', markup, re.S)[1])


def test_two_paths_share_one_scale():
    made = path_picture(picture([None, 4.0], "before"), picture([None, 0.5], "after"), caption="a < b")
    found = data(made)
    assert [p["error"] for p in found["paths"]] == [[None, 4.0], [None, 0.5]]
    assert (found["error"]["levels"][0], found["error"]["levels"][-1]) == (0.0, 4.0)
    assert len(found["error"]["colours"]) == len(found["error"]["levels"]) - 1
    assert re.findall(r"<option[^>]*>(.*?)</option>", made) == ["error", "feed", "tool", "before", "after"]
    assert "<figcaption>a &lt; b" in made
    assert made.count("</script>") == 2  # the text of a line cannot end it


def test_one_path_without_errors_is_drawn_by_feed_or_tool():
    made = path_picture(picture(()))
    assert "error" not in data(made)
    assert re.findall(r"<option[^>]*>(.*?)</option>", made) == ["feed", "tool"]


def test_the_program_stands_beside_its_path_and_is_searched():
    made = path_picture(picture(()))
    assert data(made)["text"] == {"1": "G0 </script>", "2": "G1"}
    assert '<input type="search" aria-label="search the program"' in made
    assert '<ol tabindex="0" aria-label="program;' in made
    assert '<div data-scale="tool"' in made
