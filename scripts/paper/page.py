"""The page docs/paper.md: table 1 and figure 12 of the paper, with our figures beside the paper's, as Markdown."""
import textwrap

from paper.models import kModels, kPaperSpeedups, kPatches

kCodings = ("lossless", "quantized")
kColumns = 120


def table(header, rows):
    """A table whose text is readable too: columns are as wide as their widest cell, and all except the first are aligned right."""
    widths = [max(len(row[i]) for row in [header, *rows]) for i in range(len(header))]

    def line(cells):
        first, *rest = (cell.ljust(width) if i == 0 else cell.rjust(width)
                        for i, (cell, width) in enumerate(zip(cells, widths)))
        return "| " + " | ".join([first, *rest]) + " |"

    rule = "|" + "|".join("-" * (width + 1) + (":" if i else "-") for i, width in enumerate(widths)) + "|"
    return "\n".join([line(header), rule, *map(line, rows)])


def percent(ratio):
    return f"{100 * (ratio - 1):+.1f} %"


def megabytes(count, whole=None):
    """`count` bytes in MB, and how much that is above `whole`, the bytes of the mesh as one stream."""
    digits = 1 if count >= 1e6 else 3
    return f"{count / 1e6:.{digits}f}" + ("" if whole is None else f" ({percent(count / whole)})")


def paper_cells(sequential, parallel):
    return [f"{sequential:.1f}"] + [
        "–" if size is None else f"{size:.1f} ({percent(size / sequential)})" for size in parallel]


def size_rows(results):
    for model in kModels:
        runs = results["models"][model.name]["runs"]
        faces = results["models"][model.name]["faces"] / 1e6
        for refined, figures in ((True, model.parallel), (False, model.unprocessed)):
            if not figures:
                continue
            title = model.title if refined else f"{model.title}, unprocessed"
            yield [title, "paper", f"{model.faces:.1f}", *paper_cells(model.sequential, figures)]
            for coding in kCodings:
                run = runs[run_name(coding, refined)]
                whole = run["stock"]["bytes"]
                yield ["", f"psplit, {coding}", f"{faces:.2f}" if faces >= 0.1 else f"{faces:.4f}", megabytes(whole),
                       *(megabytes(split["bytes"], whole) for split in run["splits"])]


def run_name(coding, refined):
    return coding if refined else f"{coding}, unprocessed"


def decoders(results):
    """The timed decoders, (backend, threads), each on all threads. Trends and charts show the last one."""
    run = results["models"][kModels[0].name]["runs"]["lossless"]
    rows = [(row["backend"], row["threads"]) for row in run["splits"][0]["decode"] if row["backend"] != "draco"]
    return [max(row for row in rows if row[0] == backend) for backend in ("cpu", "cuda") if backend in dict(rows)]


def decoder_name(backend, threads):
    return "GPU" if backend == "cuda" else f"CPU, {threads} thread" + ("s" if threads > 1 else "")


def timing(median):
    return f"{median:.{1 if median >= 10 else 2}f} ms"


def decode_of(split, decoder):
    return next(row for row in split["decode"] if (row["backend"], row["threads"]) == decoder)


def speed_rows(results):
    for model in kModels:
        runs = results["models"][model.name]["runs"]
        for refined in (True, False) if model.unprocessed else (True,):
            title = model.title if refined else f"{model.title}, unprocessed"
            stated = [kPaperSpeedups.get((model.name, patches)) if refined else None for patches in kPatches]
            if any(stated):
                yield [title, "paper, GeForce GTX 580", "", *("not in the text" if s is None else f"{s}x" for s in stated)]
                title = ""
            for coding in kCodings:
                run = runs[run_name(coding, refined)]
                stock = run["stock"]
                for i, decoder in enumerate(decoders(results)):
                    whole = timing(stock["decode_ms"]) if i == 0 else ""
                    cells = []
                    for split in run["splits"]:
                        row = decode_of(split, decoder)
                        cells.append(f"{row['speedup']:.2f}x ({timing(row['median_ms'])})")
                    yield [title, f"psplit, {coding}, {decoder_name(*decoder)}", whole, *cells]
                    title = ""


def cut_rows(results):
    for model in kModels:
        for name, run in results["models"][model.name]["runs"].items():
            if name.startswith("quantized"):
                continue  # its patches are those of lossless
            title = model.title + (", unprocessed" if "unprocessed" in name else "")
            middle = run["splits"][len(run["splits"]) // 2]
            yield [title, *(f"{100 * split['replication']:.1f} %" for split in run["splits"]), f"{middle['partition_ms'] / 1000:.2f} s",
                   f"{middle['encode_ms'] / 1000:.2f} s", f"{run['stock']['encode_ms'] / 1000:.2f} s"]


def patches_header(results):
    return [f"{count:,} patches" for count in results["patches"]]


def size_table(results):
    return table(["model", "MB", "M faces", "sequential", *patches_header(results)], list(size_rows(results)))


def speed_table(results):
    return table(["model", "", "sequential", *patches_header(results)], list(speed_rows(results)))


def cut_table(results):
    counts = [f"{count:,}" for count in results["patches"]]
    return table(["model", f"replication, {counts[0]} patches", *counts[1:], f"partition, {counts[len(counts) // 2]} patches",
                  "encoding in all", "sequential encoding"], list(cut_rows(results)))


def trend_lines(results):
    """What the paper's text says about figure 12, and our result with the last decoder."""
    decoder = decoders(results)[-1]

    def speedups(model, name):
        return [decode_of(split, decoder)["speedup"] for split in results["models"][model]["runs"][name]["splits"]]

    def by_coding(say):
        return "; ".join(f"{coding} {say(coding)}" for coding in kCodings) + "."

    def growing(coding):
        rising = [model.title for model in kModels if speedups(model.name, coding) == sorted(speedups(model.name, coding))]
        return f"for {len(rising)} of {len(kModels)} models" + (f" ({', '.join(rising)})" if rising else "")

    def ratios(ours, others):
        return ", ".join(f"{a / b:.2f}" for a, b in zip(ours, others))

    yield ("It \"gets higher when there are more partitions\". Ours grows from each number of patches to the next: " + by_coding(growing))
    yield ("That of the unprocessed Happy Buddha \"is much lower\". Ours, unprocessed divided by processed: " + by_coding(
        lambda coding: ratios(speedups("happy", run_name(coding, False)), speedups("happy", coding))))
    yield ("The scene's \"is lower than the 3D models with similar size\". Ours, scene divided by statue: " + by_coding(
        lambda coding: ratios(speedups("scene", coding), speedups("statue", coding))))


def source_lines(results):
    for model in kModels:
        entry = results["models"][model.name]
        line = f"**{model.title}**: {entry['source']}, {entry['faces']:,} faces, {entry['points']:,} points"
        if abs(entry["faces"] / (model.faces * 1e6 * results["faces_scale"]) - 1) > 0.03:
            line += f"; the paper has {model.faces} million"
        yield line


def method_lines(results):
    machine = results["machine"]
    yield ("**lossless**: every float stays, as in the paper. **quantized**: positions at 14 bits, psplit's default. "
           "**unprocessed**: the partition before refinement (`--no-refine`).")
    yield ("**sequential**: stock Draco, one stream for each mesh at speed 5, decoded by libdraco on one thread. "
           f"{machine['draco']}")
    yield ("The paper measured on a 2.8 GHz Phenom II and a GeForce GTX 580. Its patches refer to one shared array; ours are Draco "
           "streams, each with its own header, entropy tables and values of its border. So percentages can be compared, "
           "megabytes only roughly. The paper's two figures of Happy Buddha are taken as those of 512 and 2,048 patches.")
    yield ("A speed-up is the sequential time divided by the patches' time, from bytes in the host's memory to a stitched mesh in new "
           "memory of the host"
           + (", including transfers to and from the device. The paper's time is of the decompression on the GPU alone."
              if machine["gpu"] else "."))
    rounds = f"{results['repeat']} interleaved rounds" if results["repeat"] != 1 else "One interleaved round"
    yield (f"{rounds} after a warm-up round, in one process for each model and coding; times are medians.")


def prose(words):
    return textwrap.fill(words, kColumns, break_long_words=False, break_on_hyphens=False)


def items(lines):
    return "\n".join(textwrap.fill(line, kColumns, initial_indent="- ", subsequent_indent="  ", break_long_words=False,
                                   break_on_hyphens=False) for line in lines)


def page(results, chart=None):
    machine = results["machine"]
    gpu = machine["gpu"]
    whose = f"those of the GPU, {gpu}, beside the CPU backend's" if gpu else \
        f"those of the CPU backend, on {machine['threads']} threads, because there was no CUDA device"
    scaled = "" if results["faces_scale"] == 1 else (
        f"\n**Not the paper's sizes:** models and numbers of patches are {results['faces_scale']:g} times as large.\n")
    stand_ins = "" if all("stand-in" not in entry["source"] for entry in results["models"].values()) else "\n" + prose(
        "Stand-ins are generated surfaces without noise and holes of a scan, so their bytes are not those of the paper's "
        "models.") + "\n"
    picture = f"\n![Speed-ups by number of patches]({chart})\n\nDashed lines with (*) are unprocessed, as in the paper.\n" \
        if chart else ""
    return f"""# The paper's measurements, and ours

{prose("`scripts/reproduce-paper` writes this page: table 1 and figure 12 of Zhao, Tang, Tong, *Connectivity-Based Segmentation for "
       f"GPU-Accelerated Mesh Decompression* (2012), beside ours. Speed-ups are {whose}.")}
{scaled}
```sh
{results['command']}
```

{prose(f"{machine['cpu']}, {machine['threads']} threads{', ' + gpu if gpu else ''}; psplit {results['version']}; "
       f"{results['date']}.")}

## What was measured

{items(source_lines(results))}
{stand_ins}
{items(method_lines(results))}

## Table 1: bytes

MB are millions of bytes. In brackets: how much more the patches take than one stream.

{size_table(results)}

## Figure 12: speed-ups of decoding

The paper shows them in a picture; its text gives one figure, up to 48.5x.

{speed_table(results)}
{picture}
What the paper says about the speed-up, and our result:

{items(trend_lines(results))}

## Partition

{prose('The paper: "We used several minutes to partition and compress these large 3D models." Ours, lossless: "encoding in all" '
       f"includes the partition and runs on {machine['threads']} threads, sequential encoding on one.")}

{cut_table(results)}
"""
