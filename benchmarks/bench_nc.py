"""100 000 plain lines, 20 000 arcs, tokens, against a naive reader in the same run: python benchmarks/bench_nc.py"""

from __future__ import annotations

import random
import time
import tracemalloc
from collections.abc import Callable

from vcmm.program.interpret import interpret
from vcmm.program.tokens import tokenize

LINES, ARCS = 100_000, 20_000


def plain() -> str:
    rng = random.Random(1)
    words = [
        f"G1 X{rng.uniform(0, 99):.3f} Y{rng.uniform(0, 99):.3f} Z{rng.uniform(-9, 0):.3f}"
        for _ in range(LINES)
    ]
    return "\n".join(["G21 G90 G17 F1000.", *words, "M30"])


def arcs() -> str:
    pair = "G2 X10. Y0. I5. J0.\nG2 X0. Y0. I-5. J0.\n"
    return f"G21 G90 G17 F1000.\n{pair * (ARCS // 2)}M30"


def naive(text: str) -> list[tuple[float, ...]]:
    """What one writes first: every character looked at, words collected, the last X Y Z kept. No checks, no modes."""
    out, at, word = [], {"X": 0.0, "Y": 0.0, "Z": 0.0}, ""
    for line in text.split("\n"):
        moved = False
        for character in [*line, " "]:
            if character.isalpha() or character == " ":
                if word[:1] in at:
                    at[word[0]] = float(word[1:])
                    moved = True
                word = character.strip()
            else:
                word += character
        if moved:
            out.append(tuple(at.values()))
    return out


def timed(work: Callable[[], object]) -> float:
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def main() -> None:
    text, circles = plain(), arcs()
    interpret(text[:5000].rsplit("\n", 1)[0] + "\nM30", "fanuc")  # warm-up
    assert [m.end for m in interpret(text, "linuxcnc").moves] == naive(text)
    for name in ("linuxcnc", "fanuc"):
        seconds = timed(lambda name=name: interpret(text, name))
        print(f"{name:9} {LINES} lines: {seconds:6.2f} s, {LINES / seconds:9.0f} lines/s")
    seconds = timed(lambda: naive(text))
    print(
        f"naive     {LINES} lines: {seconds:6.2f} s, {LINES / seconds:9.0f} lines/s (no arcs, no modes, no checks)"
    )
    seconds = timed(lambda: interpret(circles, "fanuc"))
    print(f"arcs      {ARCS} lines: {seconds:6.2f} s, {ARCS / seconds:9.0f} lines/s")
    seconds = timed(lambda: sum(1 for _ in tokenize(text)))
    print(f"tokens    {LINES} lines: {seconds:6.2f} s, {LINES / seconds:9.0f} lines/s")
    seconds = timed(lambda: interpret(circles, "fanuc", trace=True))
    print(f"traced    {ARCS} arcs:  {seconds:6.2f} s, {ARCS / seconds:9.0f} lines/s")
    tracemalloc.start()
    moves = interpret(text, "fanuc").moves
    print(
        f"memory    {tracemalloc.get_traced_memory()[0] / len(moves):.0f} bytes per move, text {len(text) / 1e6:.1f} MB"
    )


if __name__ == "__main__":
    main()
