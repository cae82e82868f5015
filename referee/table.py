"""The table of a count as Markdown."""

import json
from pathlib import Path

from referee.count import bounds

LEAST = 0.93  # of claims held, in every family
HEAD = (
    "| kind | task | characteristic | family | machine | n | claimed | held | bounds 95 % | accepted | bad | bounds 95 % "
    "| length um | oracle um | fits um | seed | commit | remark |"
)


def share(right: int, count: int) -> str:
    """A share with its exact bounds."""
    if not count:
        return "| - "
    low, high = bounds(right, count)
    return f"{right / count:.3f} | {low:.3f} to {high:.3f}"


def number(value: float | None) -> str:
    """Three digits, or nothing."""
    return "" if value is None else f"{value:.3g}"


def latest(path: Path) -> list[dict]:
    """Rows of a file; of a cell that was counted again the later ones."""
    rows = [json.loads(line) for line in path.read_text().splitlines() if line.strip()]
    last = {row["cell"]: (row["parts"], row["seed"], row["commit"], row["seconds"]) for row in rows}
    return [r for r in rows if last[r["cell"]] == (r["parts"], r["seed"], r["commit"], r["seconds"])]


def markdown(path: Path) -> str:
    """All rows of a file; `held` is the share among the claimed ones, `bad` among the accepted ones.

    Of a `decide` row `claimed` is the number of parts that p_conform promises and `held` the share that conforms.
    """
    lines = [HEAD, "|" + "---|" * (HEAD.count("|") - 1)]
    for row in latest(path):
        claimed = row.get("claimed", 0)
        among = row["n"] if row["kind"] == "decide" and "held" in row else claimed
        cells = [
            row["kind"],
            row["task"],
            row["characteristic"],
            row["family"],
            row["machine"],
            str(row["n"]),
        ]
        cells += [str(claimed), share(row.get("held", 0), among)]
        cells += [str(row.get("accepted", "")), share(row.get("bad", 0), row.get("accepted", 0))]
        cells += [number(row.get(k)) for k in ("length_um", "oracle_um", "fits_um")]
        remark = row.get("failed") or row.get("why") or ""
        cells += [str(row["seed"]), row["commit"], " ".join(remark.replace("|", "/").split())[:160]]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


BRIEF = "| kind | task | characteristic | family | machine | n | claimed | held | bounds 95 % | accepted | bad | length um | oracle um |"


def brief(path: Path) -> str:
    """All rows of a file with the columns that a page shows, below a line that says how they are and under which seeds and commits."""
    rows = latest(path)
    claimed = [r for r in rows if r["kind"] in ("evaluate", "uncertainty") and r.get("claimed")]
    short = [r for r in claimed if r["held"] < LEAST * r["claimed"]]
    accepted, bad = (sum(r.get(k) or 0 for r in claimed) for k in ("accepted", "bad"))
    marks = ", ".join(sorted({f"seed {r['seed']}, commit {r['commit']}" for r in rows}))
    lines = [
        f"{len({r['cell'] for r in rows})} cells ({marks}), {len(claimed)} rows with claims; {len(short)} hold less than {LEAST}. Accepted parts {accepted}, "
        f"{bad} of them bad ({share(bad, accepted).replace(' | ', ', bounds ') if accepted else 'none'}).",
        "",
        BRIEF,
        "|" + "---|" * (BRIEF.count("|") - 1),
    ]
    for row in rows:
        cells = [row[k] for k in ("kind", "task", "characteristic", "family", "machine")]
        cells += [str(row["n"]), str(row.get("claimed", 0)), share(row.get("held", 0), row.get("claimed", 0))]
        accepted = row.get("accepted")
        cells += [
            "" if accepted is None else str(accepted),
            f"{(row.get('bad') or 0) / accepted:.3f}" if accepted else "",
        ]
        cells += [number(row.get(k)) for k in ("length_um", "oracle_um")]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)
