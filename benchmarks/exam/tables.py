"""All tables of docs/exam.md, as markdown, from the rows of result files: `python -m benchmarks.exam summarise FILES`."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from benchmarks.exam import bars, calibration, plans
from benchmarks.exam.folds import EXCITED
from benchmarks.exam.results import Row, grouped
from benchmarks.exam.score import bound, confusion, summarise


def markdown(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    return "\n".join(lines + ["| " + " | ".join(str(c) for c in row) + " |" for row in rows])


def _told(met: bool | None) -> str:
    return "" if met is None else "met" if met else "**missed**"


def sample(rows: Sequence[Row]) -> str:
    seeds = ", ".join(str(s) for s in sorted({r["seed"] for r in rows}))
    wrong = [r for r in rows if r.get("error")]
    text = f"{len(rows)} cases, seed {seeds}; {len(wrong)} failed to run."
    text += "".join(f"\nfailed: {r['block']} {r['case']}: {r['error'][:200]}" for r in wrong)
    parts = [(r, k, v) for r in rows for k, v in r.get("not_done", {}).items()]
    return text + "".join(f"\nnot done: {r['block']} {r['case']}, {k}: {v[:200]}" for r, k, v in parts)


def bars_table(rows: Sequence[Row]) -> str:
    body = []
    for f in bars.figures(rows):
        if f.n:
            sign = "at least" if f.high else "at most"
            bar = "" if f.bar is None else f"{sign} {f.bar:g}"
            body.append([f.block, f.what, f"{f.hits} of {f.n}", f"{f.rate:.3f}", f"{sign} {f.bound:.3f}", bar, _told(f.met)])  # fmt: skip
    return markdown(["block", "figure", "count", "rate", "95 % bound", "bar", ""], body)


def set_table(rows: Sequence[Row]) -> str:
    body = [
        [block, n, f"{mean:.2f}", "" if bar is None else f"at most {bar:g}", _told(None if bar is None else mean <= bar)]
        for block, n, mean, bar in bars.set_sizes(rows)
    ]  # fmt: skip
    return markdown(["block", "sets", "mean names in the set", "bar", ""], body)


def interval_lines(rows: Sequence[Row]) -> str:
    from scipy.stats import beta

    found = bars.across(rows)[1]
    out = []
    if found.n:
        low = float(beta.ppf(0.025, found.hits, found.n - found.hits + 1)) if found.hits else 0.0
        high = 1.0 if found.hits == found.n else float(beta.ppf(0.975, found.hits + 1, found.n - found.hits))
        out.append(f"Intervals: {found.hits} of {found.n} parameters inside ({found.rate:.3f}; two-sided 95 %: {low:.3f} to {high:.3f}); "
                   "bar 0.93 to 0.97 over 1000.")  # fmt: skip
    errors = bars.relative_errors(rows)
    if errors:
        out.append(f"Relative error of {len(errors)} effects with one parameter, times delta: median {np.median(errors):.2f}; bar 0.8.")  # fmt: skip
    return "\n\n".join(out)


def held_out_lines(rows: Sequence[Row]) -> str:
    out = []
    folds = [f for f in bars.folds_left(rows, EXCITED) if f["left"] is not None]
    if folds:
        left = np.array([f["left"] for f in folds])
        worse = [f for f in folds if f["worse"]]
        out.append(f"Folds held out by the command in which the truth has delta {EXCITED:g} or more: {len(folds)}; effect energy left "
                   f"(as printed, noise subtracted) median {np.median(left):.3f}, 0.1 or less in {np.mean(left <= 0.1):.2f}; worse than "
                   f"before in {len(worse)} (at most {bound(len(worse), len(folds), False):.3f}).")  # fmt: skip
        out += [
            f"worse: {f['case']} {f['effect']}, fold {f['fold']}, strength {f['strength']:.1f}" for f in worse
        ]
    new = [
        (r["new_recording_energy_left"], r["concealed"][0]["effect"], r["case"])
        for r in bars.visible(rows)
        if r.get("new_recording_energy_left") is not None
    ]
    if new:
        left = np.array([n[0] for n in new])
        worse_new = [n for n in new if n[0] > 1]
        out.append(f"New recordings of the same machine (other poses, times, temperatures), predicted by the improved machine file: {len(new)}; "
                   f"effect energy left median {np.median(left):.3f}, 0.1 or less in {np.mean(left <= 0.1):.2f}, worse than before in "
                   f"{len(worse_new)} (at most {bound(len(worse_new), len(new), False):.3f}); bar: median at most 0.03, none worse.")  # fmt: skip
        out += [f"worse: {effect}, case {case}, {value:.2f}" for value, effect, case in worse_new]
    return "\n\n".join(out)


def calibration_lines(rows: Sequence[Row]) -> str:
    out = []
    for title, blocks in (
        ("concealed effects with a name, decoys and nulls (A B D F G H)", "ABDFGH"),
        ("all blocks, physics without a name and stale calibrations included (A to H)", "ABCDEFGH"),
    ):
        found = calibration.claims([r for r in rows if r["block"] in blocks])
        if not found:
            continue
        error, (mean, most) = calibration.error_of(calibration.bins(found)), calibration.by_chance(found)
        hits, n, low = calibration.sure(found)
        head = ["stated", "answers", "mean stated", "right", "95 % interval"]
        out += [f"Names of {title}: {len(found)}", markdown(head, calibration.table(found)),
                f"Calibration error {error:.3f} (bar 0.03; perfectly calibrated answers: mean {mean:.3f}, 95 % point {most:.3f}). "
                f"Stated 0.99 or more: right {hits} of {n}" + (f" = {hits / n:.3f}, at least {low:.3f}" if n else "") + "; bar 0.985."]  # fmt: skip
    return "\n\n".join(out)


def _share(rows: Sequence[Row], test: Callable[[Row], bool]) -> str:
    hits = sum(bool(test(r)) for r in rows)
    return f"{hits} of {len(rows)}" + (f" (at least {bound(hits, len(rows), True):.2f})" if rows else "")


def next_lines(rows: Sequence[Row]) -> str:
    """Block F with the recommended measurement taken."""
    asked = [(r, r["next"]) for r in rows if r.get("next")]
    if not asked:
        return ""
    told = Counter(str(n["status"]) for _, n in asked)
    pairs = [(r, n) for r, n in asked if n["status"] == "taken"]
    out = [f"Sets with rivals: {len(asked)}; " + ", ".join(f"{k} {v}" for k, v in told.most_common()) + "."]
    if pairs:
        joint = [{"b": r, "a": n} for r, n in pairs]
        out.append("Next measurement taken: right name first before " + _share(joint, lambda j: j["b"]["right"]) + ", after "
                   + _share(joint, lambda j: j["a"]["right"]) + "; truth in the set after " + _share(joint, lambda j: j["a"]["in_set"])
                   + "; set smaller " + _share(joint, lambda j: 0 < j["a"]["set_size"] < j["b"]["set_size"])
                   + "; the rival gone that was to be told apart " + _share(joint, rival_gone)
                   + f"; mean set {np.mean([r['set_size'] for r, _ in pairs]):.2f} before, "
                   f"{np.mean([n['set_size'] for _, n in pairs]):.2f} after.")  # fmt: skip
        body = [
            [r["concealed"][0]["effect"], ", ".join(r["sets"][0]), n["do"], ", ".join(n["sets"][0]) if n["sets"] else n["verdict"],
             "yes" if n["right"] else "no"] for r, n in pairs
        ]  # fmt: skip
        out.append(markdown(["concealed", "set before", "recommended", "set after", "right first"], body))
    return "\n\n".join(out)


def rival_gone(joint: Row) -> bool:
    """Of the two names to be told apart only one is left in the set."""
    left = {n for s in joint["a"]["sets"] for n in s}
    return len(left & set(joint["a"]["separates"])) == 1


def cost_lines(rows: Sequence[Row]) -> str:
    body = [
        [r["case"], r["rows"], " / ".join(f"{s:.1f}" for s in r["cost"]["wall_s"]),
         " / ".join(f"{s:.1f}" for s in r["cost"]["processor_s"]), "yes" if r["cost"]["same_document"] else "**no**",
         "yes" if r["cost"]["same_report"] else "**no**"] for r in rows if r.get("cost")
    ]  # fmt: skip
    head = ["case", "rows", "wall s, two runs", "processor s", "same document", "same report"]
    return markdown(head, body) if body else ""


def baseline_table(rows: Sequence[Row]) -> str:
    """Plain methods and the command on the same cases of A and B."""
    body = []
    for (block, delta), mine in grouped([r for r in bars.valid(rows) if r.get("baselines")]).items():
        figures = summarise(mine)["baselines"]
        key, own = ("right", "right") if block == "A" else ("false_alarm", "anything")
        if block in "AB":
            command = sum(bool(r.get(own)) for r in mine)
            body.append([f"{block}, delta {delta:g}", key.replace("_", " "), len(mine), command]
                        + [figures[n][key]["hits"] for n in ("lasso", "stepwise", "refit", "stlsq", "gp")])  # fmt: skip
    head = ["block", "count of", "cases", "vcmm diagnose", "lasso-BIC", "stepwise BIC", "free refit, stepwise", "sequential thresholding", "Gaussian process"]  # fmt: skip
    return markdown(head, body) if body else ""


def confusion_table(rows: Sequence[Row]) -> str:
    """Concealed against answered first, per block with concealed effects; sorted by name."""
    out = []
    for (block, delta), mine in grouped(bars.valid(rows)).items():
        if block in "DM":  # with two effects, first against first says nothing; see what failed
            continue
        body = []
        for name, inner in sorted(confusion(mine).items()):
            answers = sorted(inner.items(), key=lambda kv: (-kv[1], kv[0]))
            body.append([f"`{name}`", sum(inner.values()), ", ".join(f"`{k}` {v}" for k, v in answers)])
        what = {
            "B": " (nothing concealed)",
            "C": " (concealed: a stale calibration)",
            "D": " (the first of two)",
        }.get(block, "")
        out += [
            f"Block {block}{what}, delta {delta:g}",
            markdown(["concealed", "cases", "answered first"], body),
        ]
    return "\n\n".join(out)


def family_lines(rows: Sequence[Row]) -> str:
    """Block A at delta 10: how many families reach 0.85, and the rate per kind of recording."""
    ten = [r for r in bars.visible(rows) if r["block"] == "A" and r["delta_asked"] == 10]
    if not ten:
        return ""
    per: dict[str, list[bool]] = {}
    kinds: dict[str, list[bool]] = {}
    for r in ten:
        per.setdefault(r["concealed"][0]["effect"], []).append(bool(r["right"]))
        kinds.setdefault(r["design"], []).append(bool(r["right"]))
    short = {n: v for n, v in per.items() if np.mean(v) < 0.85}
    said = ", ".join(f"`{n}` {sum(v)} of {len(v)}" for n, v in sorted(short.items()))
    body = [[k, f"{sum(v)} of {len(v)}"] for k, v in sorted(kinds.items(), key=lambda kv: -len(kv[1]))]
    text = f"Families with a right name in at least 0.85 of their cases: {len(per) - len(short)} of {len(per)}; below: {said or 'none'}."
    return text + "\n\n" + markdown(["recording", "right name first"], body)


def alias_lines(rows: Sequence[Row]) -> str:
    """Names counted as right that are not the concealed one, and names that stood in a set beside the truth."""
    other, beside = Counter[str](), Counter[str]()
    for r in bars.visible(rows):
        if not r.get("right") or not r["concealed"] or not r["answered"] or r["block"] in "CH":
            continue
        truth = [c["effect"] for c in r["concealed"]]
        if r["answered"][0] not in truth:
            other[f"`{r['answered'][0]}` for `{truth[0]}`"] += 1
        if len(truth) == 1:
            beside.update(f"`{n}` beside `{truth[0]}`" for n in set(r["sets"][0]) - {truth[0]})
    ranked = [sorted(c.items(), key=lambda kv: (-kv[1], kv[0])) for c in (other, beside)]
    text = [", ".join(f"{k} {v}" for k, v in one) or "none" for one in ranked]
    return f"Counted as right under a simpler name or an alias: {text[0]}.\n\nIn the set of a right answer: {text[1]}."


def failures(rows: Sequence[Row]) -> str:
    body = []
    for r in bars.visible(rows):
        bad = {
            "A": not (r.get("right") and r.get("in_set")), "B": r["anything"], "C": r.get("right") is False or r.get("other_named"),
            "D": not r.get("exact"), "E": not r.get("flagged"), "F": not r.get("in_set"), "G": not r.get("right"), "H": not r.get("right"),
        }.get(r["block"], False)  # fmt: skip
        if bad:
            truth = " + ".join(
                f"{c['effect']} {' '.join(c['where'].values())}".strip() for c in r["concealed"]
            )
            stale = f"stale x {r['stale']:.1f} (delta {r['stale_delta']:.1f})" if r["block"] == "C" else ""
            said = ", ".join(f"{n} {p:.2f}" for n, p in zip(r["answered"], r["probabilities"]))
            said += (
                f"; mistake {r['mistake']['component']} {r['mistake']['what']}" if r.get("mistake") else ""
            )
            said += "; unknown over " + " ".join(r["unknown"]["covariates"]) if r.get("unknown") else ""
            inside = "yes" if r.get("all_in_sets") else ""
            body.append([f"{r['block']} {r['delta_asked']:g} {r['case']}", r["design"], truth or stale or r["world"],
                         said.strip("; ") or "nothing", r["verdict"], inside])  # fmt: skip
    return markdown(["case", "design", "concealed", "answered", "verdict", "in the set"], body)


def size_lines(rows: Sequence[Row]) -> str:
    """Processor seconds per case, and hours of the overnight plan on two cores."""
    took: dict[str, list[float]] = {}
    for r in bars.valid(rows):
        if r.get("processor_s") and r["block"] != "M":
            took.setdefault(r["block"], []).append(r["processor_s"])
    if not took:
        return ""
    every = [s for v in took.values() for s in v]
    per = {b: float(np.mean(v)) for b, v in took.items()}
    hours = {
        name: sum(per.get(b, float(np.mean(every))) for b, *_ in plans.asked(name)) / 3600
        for name in plans.PLANS
    }
    text = ", ".join(f"{b} {s:.1f}" for b, s in sorted(per.items()))
    return f"Processor seconds per case (recording, answer, scoring): {text}.\n\nHours of processor of the plans: " + ", ".join(
        f"{n} {plans.size(n)} cases, {h:.1f} h" for n, h in hours.items()
    ) + "."  # fmt: skip


def pages(rows: Sequence[Row]) -> str:
    """Everything, with headings."""
    parts = (
        ("Sample", sample), ("Bars", bars_table), ("Sets", set_table), ("Families", family_lines), ("Intervals", interval_lines), ("Held out", held_out_lines),
        ("Probabilities", calibration_lines), ("Next measurement", next_lines), ("Cost", cost_lines),
        ("Plain methods", baseline_table), ("Answers against the truth", confusion_table), ("Names", alias_lines),
        ("What failed", failures), ("Sizes", size_lines),
    )  # fmt: skip
    told = [(title, make(rows)) for title, make in parts]
    return "\n\n".join(f"### {title}\n\n{text}" for title, text in told if text)
