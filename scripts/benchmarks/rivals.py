"""What scripts/typical and scripts/rivals compute from the times and bytes of psplit, libdraco and meshoptimizer."""
import math, re, statistics

from benchmarks.pages import span, value_of

kForms = {"plain": "alone", "zstd": "zstd", "brotli": "brotli"}  # what compresses meshoptimizer's bytes once more
kSmallFaces = 10000  # assets of fewer faces are small


def mean(values):
    """The geometric mean."""
    return math.exp(sum(map(math.log, values)) / len(values))


def name_of(rival):
    return f"{rival['version']}, codec {rival['codec']}"


def merge(runs):
    """One asset of the runs of several builds, which have different meshoptimizers: psplit and libdraco of the first, and in
    `rivals`, for each meshoptimizer and form, psplit's time and bytes over its. Both are of one run."""
    asset = {key: value for key, value in runs[0].items() if key != "meshoptimizer"}
    asset["rivals"] = {}
    for run in runs:
        rival = run["meshoptimizer"]
        asset["rivals"][name_of(rival)] = {form: {"time": run["psplit_ms"] / rival[form]["ms"], "bytes": run["bytes"] / rival[form]["bytes"]}
                                           for form in kForms if form in rival}
    return asset


def is_small(asset):
    return asset["faces"] < kSmallFaces


def of_rival(assets, rival, form, what):
    return [asset["rivals"][rival][form][what] for asset in assets if form in asset["rivals"].get(rival, {})]


def rivals_of(assets):
    """The names of all meshoptimizers, in the order of the builds."""
    return list(dict.fromkeys(name for asset in assets for name in asset["rivals"]))


def forms_of(assets, rival):
    return [form for form in kForms if of_rival(assets, rival, form, "bytes")]


def rival_rows(assets):
    """For each meshoptimizer and form: names, and psplit's time and bytes over its: the means, the means of small assets, and how
    many assets meshoptimizer makes smaller."""
    small = [asset for asset in assets if is_small(asset)]
    rows = []
    for rival in rivals_of(assets):
        for form in forms_of(assets, rival):
            times, sizes = of_rival(assets, rival, form, "time"), of_rival(assets, rival, form, "bytes")
            small_sizes = of_rival(small, rival, form, "bytes")
            rows.append([rival, kForms[form], f"{mean(times):.2f}", f"{min(times):.2f}", f"{mean(sizes):.2f}",
                         f"{mean(small_sizes):.2f}" if small_sizes else "", f"{sum(size > 1 for size in sizes)} of {len(sizes)}"])
    return rows


def where_the_rival_wins(assets):
    """The first sentence of a page: of the newest meshoptimizer, with what makes its files smallest."""
    rival = rivals_of(assets)[-1]
    form = forms_of(assets, rival)[-1]
    times, sizes = of_rival(assets, rival, form, "time"), of_rival(assets, rival, form, "bytes")
    small = of_rival([asset for asset in assets if is_small(asset)], rival, form, "bytes")
    smaller = sum(size > 1 for size in sizes)
    which = f"meshoptimizer {rival.split(',')[0]}" + ("" if form == "plain" else f" with {form}")
    faster = sum(time > 1 for time in times)
    text = (f"{which} decodes faster than psplit on one thread in {faster} of {len(times)} assets (of all, at {min(times):.1f} to "
            f"{max(times):.1f} times its speed), and makes {smaller} of them smaller; psplit's streams take {mean(sizes):.2f} times its bytes")
    return text + (f", and {mean(small):.2f} times where an asset has fewer than {kSmallFaces:,} faces." if small else ".")


# ---- Assets in patches: what `gltf-psplit compare --format json` says ----

def is_cut(split):
    return split["directory_bytes"] > 0


def way_of(split):
    cut = f"{split['patches']:,} patch{'' if split['patches'] == 1 else 'es'}" if is_cut(split) else "one stream a primitive"
    return f"{cut}, condensed" if split.get("condensed") else cut


def contenders(report):
    """The rows of a table of one report of `compare`, as {name: (bytes, milliseconds on one thread, on several or None)}."""
    stock = report["stock"]
    rows = {f"libdraco, one stream a primitive, speed {stock['speed']}": (stock["bytes"], stock["decode_ms"], None)}
    for split in report["splits"]:
        ours = {row["threads"]: row["median_ms"] for row in split["decode"] if row["backend"] == "cpu"}
        many = [ours[threads] for threads in ours if threads > 1]
        rows[f"psplit, {way_of(split)}"] = (split["bytes"], ours[1], min(many, default=None))
    for form in kForms:
        row = report.get({"plain": "meshopt_plain", "zstd": "meshopt", "brotli": "meshopt_brotli"}[form])
        if row:
            more = "" if form == "plain" else f", {form}"
            rows[f"meshoptimizer {row['version']}, codec {row['codec_version']}{more}"] = (row["bytes"], row["decode_ms"], None)
    return rows


def spreads_of(report):
    """How far half of the rounds of psplit's times differ, over the median."""
    return [(row["upper_quartile_ms"] - row["lower_quartile_ms"]) / row["median_ms"] for split in report["splits"] for row in split["decode"]
            if row["backend"] == "cpu"]


def medians_of(reports, with_older=False):
    """{name: figures} of several reports of one asset, by builds with different meshoptimizers in several rounds. Times are medians of
    the reports, and ratios, to stock Draco's of the same report, are medians of the reports' ratios. Of meshoptimizer, there is the
    newest, of the last report, with zstd or brotli, as a server sends its bytes; `with_older`: the others with zstd as well."""
    rows, newest = {}, contenders(reports[-1])
    for report in reports:
        of_report = contenders(report)
        stock = next(iter(of_report.values()))
        for name, (size, one, many) in of_report.items():
            is_shown = name in newest and name.endswith(tuple(kForms.values())) or with_older and name.endswith(kForms["zstd"])
            if name.startswith("meshoptimizer") and not is_shown:
                continue
            row = rows.setdefault(name, {"bytes": size, "of_stock": size / stock[0], "one": [], "ratio": [], "many": [], "many_ratio": []})
            row["one"].append(one)
            row["ratio"].append(one / stock[1])
            if many is not None:
                row["many"].append(many)
                row["many_ratio"].append(many / stock[1])
    return {name: {what: statistics.median(value) if value else None for what, value in row.items() if isinstance(value, list)} |
            {"bytes": row["bytes"], "of_stock": row["of_stock"]} for name, row in rows.items()}


def size_cells(row):
    return [f"{row['bytes']:,}", f"{100 * (row['of_stock'] - 1):+.1f} %"]


def summarize(reports):
    """The rows of a table: name, bytes, bytes over stock Draco's, milliseconds on one thread, over stock Draco's, and on several."""
    return [[name, *size_cells(row), f"{row['one']:.2f}", f"{row['ratio']:.2f}", f"{row['many']:.2f}" if row["many"] else ""]
            for name, row in medians_of(reports).items()]


# ---- One asset on several processors ----

kSpeedUpHead = ["codec", "bytes", "of stock Draco's", "ms, one thread", "times stock Draco's speed", "ms, two threads",
                "on two, times stock Draco's speed"]


def usual_splits(splits):
    """Of splits, with and without condensed streams, those that users choose: one stream, the default number of patches, these
    condensed, and the patches of --profile speed."""
    plain = [split for split in splits if not split["condensed"]][:3]
    return [split for split in splits if split in plain or split["condensed"] and split["patches"] == plain[1]["patches"]]


def speed_up_rows(reports):
    """Rows under kSpeedUpHead."""
    reports = [report | {"splits": usual_splits(report["splits"])} for report in reports]
    return [[name, *size_cells(row), f"{row['one']:.1f}", f"{1 / row['ratio']:.2f}",
             *([f"{row['many']:.1f}", f"{1 / row['many_ratio']:.2f}"] if row["many"] else ["", ""])]
            for name, row in medians_of(reports, with_older=True).items()]


def more_bytes(cell):
    """"+1.4 %" as "1.4 % more bytes"."""
    return f"{cell.lstrip('+-')} {'fewer' if cell.startswith('-') else 'more'} bytes"


def speed_up_findings(tables):
    """Sentences about the tables of several processors under kSpeedUpHead: first where a rival wins. Bytes are those of the first."""
    size, over, one, two = (kSpeedUpHead[i] for i in (1, 2, 4, 6))
    newest = tables[0]
    ours = next(name for name in newest if re.fullmatch(r"psplit, [\d,]+ patches", name))
    patches, condensed = ours.removeprefix("psplit, "), f"{ours}, condensed"
    rivals = [name for name in newest if name.startswith("meshoptimizer")]
    fastest = max(rivals, key=lambda name: value_of(newest[name][one]))
    smallest = min(rivals, key=lambda name: value_of(newest[name][size]))
    gains = [value_of(table[fastest][one]) / value_of(table[ours][one]) for table in tables if fastest in table]

    def speeds(name, column):
        return span([value_of(table[name][column]) for table in tables if name in table])

    def bytes_over(rival):
        return f"{value_of(newest[rival][size]) / value_of(newest[ours][size]):.2f} times"

    return [f"{fastest}, decodes {span(gains, 1)} times as fast as psplit's {patches} on one thread, and takes {bytes_over(fastest)} the "
            f"bytes; {smallest}, takes {bytes_over(smallest)}.",
            f"psplit's {patches} decode {speeds(ours, one)} times as fast as stock Draco on one thread, and {speeds(ours, two)} times on two, "
            f"for {more_bytes(newest[ours][over])}.",
            f"Condensed, they take {more_bytes(newest[condensed][over])} than stock Draco, and decode {speeds(condensed, one)} times as fast as it on one thread."]


def newest_rival(reports):
    """A sentence about the newest meshoptimizer, of the last report, with what makes its bytes fewest, beside the first
    split in patches, or the only one."""
    report = reports[-1]
    splits = report["splits"]
    split = next(filter(is_cut, splits), splits[0])
    ours = contenders({**report, "splits": [split]})
    rivals = {name: row for name, row in ours.items() if name.startswith("meshoptimizer")}
    name = min(rivals, key=lambda name: rivals[name][0])
    _, (size, one, _) = next((name, row) for name, row in ours.items() if name.startswith("psplit"))
    times = []
    for other in reports:
        rows = contenders({**other, "splits": [next(s for s in other["splits"] if s["patches"] == split["patches"])]})
        if name in rows:
            times.append(next(row[1] for key, row in rows.items() if key.startswith("psplit")) / rows[name][1])
    ratio, bytes_ratio = statistics.median(times), rivals[name][0] / size
    speed = f"decodes {ratio:.1f} times as fast as" if ratio >= 1 else f"takes {1 / ratio:.1f} times as long to decode as"
    return f"{name} {speed} psplit's {way_of(split)} on one thread, and takes {bytes_ratio:.2f} times the bytes."


# ---- First decodes: rounds of {decoder: a line of first_decode} ----

kMoments = ("first_ms", "warm_ms", "woken_ms")


def median_ratio(rounds, over, under, moment):
    return statistics.median(of[over][moment] / of[under][moment] for of in rounds)


def first_decode_rows(rounds):
    """For each decoder, of meshoptimizers the newest: milliseconds, their ratios to libdraco's in the same round, and page faults; all medians."""
    *others, newest = rounds[0]
    return [[name, *(f"{statistics.median(of[name][moment] for of in rounds):.2f}" for moment in kMoments),
             *(f"{median_ratio(rounds, name, 'libdraco', moment):.2f}" for moment in kMoments),
             f"{statistics.median(of[name]['faults'] for of in rounds):,.0f}"]
            for name in [*(name for name in others if not name.startswith("meshoptimizer")), newest]]


def first_decode_findings(results):
    """Sentences: first what the newest meshoptimizer gains, then what psplit gains over libdraco, and what threads cost."""
    rival = list(next(iter(results.values()))[0])[-1]
    ours, two = "psplit, 1 thread", "psplit, 2 threads"
    gains = [median_ratio(rounds, ours, rival, "first_ms") for rounds in results.values()]
    text = f"The first decode by {rival}, is {min(gains):.1f} to {max(gains):.1f} times as fast as psplit's on one thread."
    over = {moment: [median_ratio(rounds, "libdraco", ours, moment) for rounds in results.values()] for moment in kMoments}
    shares = [f"{min(over[moment]):.1f} to {max(over[moment]):.1f} times as fast {when}" for moment, when in
              (("first_ms", "in the first decode of a process"), ("warm_ms", "warm"), ("woken_ms", "after a pause"))]
    threads = [median_ratio(rounds, two, ours, "first_ms") for rounds in results.values()]
    return [text, f"psplit on one thread is, over libdraco, {shares[0]}, {shares[1]}, and {shares[2]}.",
            f"With two threads, which the first decode starts, it takes {min(threads):.2f} to {max(threads):.2f} times the time of one."]


def first_decode_spreads(results):
    """How far half of psplit's first and warm times differ, over the median."""
    spreads = []
    for rounds in results.values():
        for name in rounds[0]:
            for moment in ("first_ms", "warm_ms"):
                times = [of[name][moment] for of in rounds]
                if name.startswith("psplit") and len(times) > 1:
                    low, middle, high = statistics.quantiles(times, n=4, method="inclusive")
                    spreads.append((high - low) / middle)
    return spreads
