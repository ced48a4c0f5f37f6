"""Our time divided by the rival's of the same run, and what got slower than a baseline.

A time means little on another day or machine; the ratio of two programs that ran in turn means more. A spread is the
interquartile range divided by the median: half of all repetitions are inside that range.
"""
import re, statistics

kUnitsMs = {"ns": 1e-6, "us": 1e-3, "ms": 1.0, "s": 1e3}
kThreshold = 0.05   # smaller changes are ignored
kMostSpread = 0.25  # if the allowance is above this, "same" becomes "noisy"


def rival_of(name):
    """The benchmark that this one is compared with; None if it has no rival or is one."""
    for ours, rival in (("cpu", "draco"), ("core", "draco"), ("core_in_step", "draco")):
        replaced = re.sub(f"/{ours}(?=/|$)", f"/{rival}", name)
        if replaced != name:
            return replaced
    encoder = re.fullmatch(r"(encode/.*)/(stream|patches/threads:\d+)", name)
    if encoder:
        return encoder[1] + "/draco"
    return re.sub(r"/psplit/threads:\d+$", "/metis", name) if re.search(r"/psplit/threads:\d+$", name) else None


def repetitions_of(report):
    """(name of the benchmark, entry) of every repetition in Google Benchmark's JSON. An error of the benchmark is a ValueError."""
    for entry in report["benchmarks"]:
        if entry.get("run_type", "iteration") != "iteration":
            continue
        if entry.get("error_occurred"):
            raise ValueError(f"{entry['name']}: {entry.get('error_message', 'failed')}")
        # Google Benchmark appends how it ran to the name.
        yield re.sub(r"/(repeats:\d+|real_time|process_time|min_time:[\d.]+)", "", entry.get("run_name", entry["name"])), entry


def samples_of(*reports):
    """Milliseconds of every repetition, by benchmark."""
    samples = {}
    for report in reports:
        for name, entry in repetitions_of(report):
            samples.setdefault(name, []).append(entry["real_time"] * kUnitsMs[entry["time_unit"]])
    return samples


def spread_of(samples):
    if len(samples) < 2:
        return 0.0
    low, _, high = statistics.quantiles(samples, n=4, method="inclusive")
    return (high - low) / statistics.median(samples)


def summarize(samples):
    """A row for each benchmark whose rival ran too."""
    rows = []
    for name, ours in sorted(samples.items()):
        rival = rival_of(name)
        if rival not in samples:
            continue
        theirs = samples[rival]
        median, rival_median = statistics.median(ours), statistics.median(theirs)
        rows.append({"name": name, "rival": rival, "median_ms": median, "spread": spread_of(ours),
                     "rival_median_ms": rival_median, "rival_spread": spread_of(theirs), "ratio": median / rival_median})
    return rows


def allowance(row, before, threshold=kThreshold):
    """How much the ratio may grow: the threshold, or the four spreads added in quadrature if that is more."""
    spread = sum(each[key] ** 2 for each in (row, before) for key in ("spread", "rival_spread")) ** 0.5
    return max(threshold, spread)


def compare(rows, baseline_rows, threshold=kThreshold):
    """Returns a list, and the names that only the baseline has. The list has for each row: (row, the baseline's row or None,
    change, allowance, verdict). A verdict is `slower`, `faster`, `same`, `noisy` (the spreads are too wide to tell) or
    `new` (not in the baseline)."""
    before_of = {row["name"]: row for row in baseline_rows}
    compared = []
    for row in rows:
        before = before_of.pop(row["name"], None)
        if before is None:
            compared.append((row, None, None, None, "new"))
            continue
        change, allowed = row["ratio"] / before["ratio"] - 1, allowance(row, before, threshold)
        verdict = ("slower" if change > allowed else "faster" if change < -allowed
                   else "noisy" if allowed > kMostSpread else "same")
        compared.append((row, before, change, allowed, verdict))
    return compared, sorted(before_of)


def table_of(compared):
    header = ["benchmark", "ms", "spread", "rival ms", "spread", "ratio", "baseline", "change", "allowed", ""]
    lines = [header]
    for row, before, change, allowed, verdict in compared:
        lines.append([row["name"], f"{row['median_ms']:.2f}", f"{row['spread']:.1%}", f"{row['rival_median_ms']:.2f}",
                      f"{row['rival_spread']:.1%}", f"{row['ratio']:.3f}",
                      "" if before is None else f"{before['ratio']:.3f}", "" if change is None else f"{change:+.1%}",
                      "" if allowed is None else f"{allowed:.1%}", "" if verdict == "same" else verdict])
    widths = [max(len(line[i]) for line in lines) for i in range(len(header))]
    return "\n".join("  ".join(cell.ljust(width) if i in (0, len(header) - 1) else cell.rjust(width)
                               for i, (cell, width) in enumerate(zip(line, widths))).rstrip() for line in lines)
