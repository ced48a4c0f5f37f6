"""docs/measured/condensed.md: bytes and times of condensed patches, beside ordinary patches and one stock stream."""
from benchmarks.pages import join, page, rows_by_subject, span, table
from benchmarks.ratios import repetitions_of, spread_of

kStandardSpeed = 5


def cases_of(report, mesh, samples, threads=1):
    """What decode_benchmark says, one case for each sample that is there without and with `/condensed`, unless condensing leaves it as it
    is, as one patch at speed 0. `samples`: the report's milliseconds of all repetitions, by benchmark."""
    bytes_of = {name: int(entry["bytes"]) for name, entry in repetitions_of(report)}
    cases = []
    for name in bytes_of:
        attributes, size, speed, *rest = name.split("/")
        if rest != ["cpu", f"threads:{threads}"]:
            continue
        condensed = name.replace(f"/{speed}/", f"/{speed}/condensed/")
        if bytes_of[condensed] == bytes_of[name]:
            continue
        cases.append({"mesh": mesh + (", all attributes" if "+" in attributes else ""), "speed": int(speed.removeprefix("speed")),
                      "size": 0 if size == "whole" else int(size), "patches": bytes_of[name], "condensed": bytes_of[condensed],
                      "ms": samples[name], "condensed_ms": samples[condensed],
                      "stock": bytes_of[f"{attributes}/whole/{speed}/cpu/threads:{threads}"]})
    return sorted(cases, key=lambda case: (case["mesh"], -case["speed"], case["size"]))


def over(case, what):
    """The percentage of bytes above one stock stream."""
    return 100 * (case[what] / case["stock"] - 1)


def faster(case):
    return min(case["ms"]) / min(case["condensed_ms"]) if case["ms"] else None


def change(percentages):
    """"4.7 to 12.7 % fewer", "2.2 % fewer to 3.0 % more" or "3.1 to 6.8 % more"."""
    low, high = min(percentages), max(percentages)
    if low >= 0:
        return f"{span(percentages, 1)} % more"
    return f"{span([-each for each in percentages], 1)} % fewer" if high < 0 else f"{-low:.1f} % fewer to {high:.1f} % more"


def findings(cases):
    """Sentences: first the times, since condensed patches may be slower; then bytes."""
    cut = [faster(case) for case in cases if case["size"] and case["ms"]]
    alone = [faster(case) for case in cases if not case["size"] and case["ms"]]
    sizes = join([f"{size:,}" for size in sorted({case["size"] for case in cases if case["size"] and case["ms"]})])
    sentences = [f"On one thread condensed patches of {sizes} faces decode at {span(cut)} times the speed of ordinary patches, and one condensed "
                 f"patch alone at {span(alone)} times."]
    if slow := [over(case, "condensed") for case in cases if case["size"] and case["speed"] == 0]:
        sentences.append(f"At speed 0 condensed patches take {change(slow)} bytes than one stock stream.")
    for size in sorted({case["size"] for case in cases if case["size"]}, reverse=True):
        at = [case for case in cases if case["size"] == size and case["speed"] == kStandardSpeed and not is_lossless(case)]
        sentences.append(f"At speed {kStandardSpeed} condensed patches of {size:,} faces take {change([over(case, 'condensed') for case in at])} bytes than "
                         f"one stock stream, ordinary ones {change([over(case, 'patches') for case in at])}.")
    lossless = [over(case, "condensed") for case in cases if is_lossless(case)]
    return sentences + [f"Lossless ones take {change(lossless)} than one lossless stream."]


def is_lossless(case):
    return case["mesh"].endswith("lossless")


def where_savings_come_from(saved):
    """A sentence. `saved`: for each mesh, bytes by part, of patches of 440 faces."""
    share = lambda *parts: span([100 * sum(of[part] for part in parts) / sum(of.values()) for of in saved], 0)
    return (f"At 440 faces a patch, {share('directory', 'fields')} % of the saving of positions come from the directory and from fields that each "
            f"Draco stream repeats, {share('symbols')} % from the symbols of connectivity, and {share('values')} % from values, whose tables "
            "are shared, and which borders store once.")


def text_of(cases, saved, rounds, **how):
    rows = {}
    for case in cases:
        bytes_of = lambda what: f"{case[what]:,}" + (f" ({over(case, what):+.1f} %)" if case["size"] or what == "condensed" else "")
        times = [f"{min(case[what]):.1f}" for what in ("ms", "condensed_ms")] + [f"{faster(case):.2f}"] if case["ms"] else [""] * 3
        rows.setdefault(case["mesh"], []).append([case["speed"], f"{case['size']:,}" if case["size"] else "whole", bytes_of("patches"),
                                                  bytes_of("condensed"), *times])
    lines = ["Bytes of whole containers, with directory, head and stitch map, and the difference to one stock Draco stream of that speed:",
             "at speed 5 the row of the whole mesh. Positions have 14 bits, normals 10, texture coordinates 12. Times are of one thread, the least",
             f"of {rounds} rounds in turn, milliseconds. One patch alone cannot overlap the chains of its coder with chains of other patches.",
             "", where_savings_come_from(saved), "",
             *table(["mesh", "speed", "faces a patch", "patches, bytes", "condensed, bytes", "patches, ms", "condensed, ms", "times as fast"],
                    rows_by_subject(rows))]
    spreads = [spread_of(case[what]) for case in cases for what in ("ms", "condensed_ms") if case["ms"]]
    return page("Condensed patches", findings(cases), lines, spreads, **how)
