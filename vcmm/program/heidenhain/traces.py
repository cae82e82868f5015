"""Places of the words of a Klartext block, and the block without Q parameters, labels and jumps."""

from __future__ import annotations

from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.trace import TextCut, Tracing, WordAt
from vcmm.program.tracer import word_at, written_out

FLOW = ("LBL", "CALL", "FN")


def words_of(reader: KlartextReader, tracer: Tracing) -> dict[str, WordAt]:
    """Return KlartextWords by address: IX is "X" with the mode IC; "path" is the word that the block begins with."""
    out: dict[str, WordAt] = {}
    if not reader.tokens:
        return out
    head = reader.tokens[0]
    out["path"] = WordAt(
        "path", head.column, head.column + len(head.text), head.text.upper(), False, None, line=head.line
    )
    for name, (word, begin, end) in reader.spans.items():
        first, value, last = reader.tokens[word], reader.tokens[begin], reader.tokens[end - 1]
        stop = last.column + len(last.text)
        relative = len(name) == 2 and name[0] == "I" and name[1] in "XYZ"
        text = tracer.lines[value.line - 1] if first.line == value.line == last.line else ""
        if text:
            out[name[1] if relative else name] = word_at(
                name, text, value.line, (first.column, stop), (value.column, stop), "IC" if relative else ""
            )
    return out


def cuts_of(reader: KlartextReader) -> list[TextCut]:
    """Return the replacements when the block is written out at its execution."""
    tokens = reader.tokens
    word = tokens[0].text.upper() if tokens else ""
    assigned = len(tokens) > 2 and word in ("Q", "QL", "QR") and tokens[2].text == "="
    if word in FLOW or assigned or (word[:2] == "FN" and word != "FN"):
        last = tokens[-1]
        return [TextCut(tokens[0].line, tokens[0].column, last.column + len(last.text), "")]
    out = []
    for begin, end, value in reader.computed:
        first, last = tokens[begin], tokens[end - 1]
        signed = first.text in ("+", "-") or word not in ("TOOL",)
        out.append(
            TextCut(first.line, first.column, last.column + len(last.text), written_out(value, signed))
        )
    return out
