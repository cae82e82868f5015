"""Tokens put together again are the text."""

from __future__ import annotations

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.program.oracle import folder
from vcmm.program.tokens import split_lines, tokenize

# the same examples every time; a busy machine is no fault of the code
quick = settings(
    max_examples=60, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)


pieces = st.sampled_from(
    [
        "G1",
        "g 1",
        "X-.5",
        "Y+5.",
        "X 1 0",
        "#<a b>",
        "[1+2]",
        "(c (x)",
        ";e",
        "\r\n",
        "\r",
        "\n",
        " ",
        "\t",
        "%",
        "é",
        "SIN",
        "O1",
        "/",
    ]
)


@quick
@given(st.lists(pieces | st.text(max_size=6)).map("".join))
def test_tokens_are_lossless(text: str):
    tokens = list(tokenize(text))
    assert "".join(t.text for t in tokens) == text
    assert all(t.text for t in tokens)
    lines = split_lines(text)
    for t in tokens:
        if t.kind != "end":
            assert lines[t.line - 1][t.column - 1 : t.column - 1 + len(t.text)] == t.text


def test_tokens_of_the_corpus_are_lossless():
    files = [p for p in folder().rglob("*") if p.suffix in (".nc", ".ngc", ".gcode", ".mpf", ".h")]
    assert len(files) > 20
    for file in files:
        text = file.read_bytes().decode("utf-8")
        assert "".join(t.text for t in tokenize(text)) == text
