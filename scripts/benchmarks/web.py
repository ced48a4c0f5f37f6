"""What scripts/web-bench makes of the lines of JSON that the programs of bench/web print.

Samples are milliseconds, one of each round. In a round all decoders took turns, so a ratio is the median of the rounds' ratios.
"""
import statistics

from benchmarks.pages import join, page, rows_by_subject, span, table
from benchmarks.ratios import spread_of
from benchmarks.rivals import mean

kMebibyte = 2 ** 20
kDraco, kThree, kMeshopt = "draco3d 1.5.7", "three's draco_decoder", "meshopt_decoder"
kDropIn, kStream, kPatches = "psplit/draco", "psplit, one stream", "psplit, patches"
kLoader, kTwoWorkers = "three's DRACOLoader, 1 worker", "psplit, patches, 2 workers"


def times(one, other):
    """How many times the time of the other: the median of the rounds' ratios."""
    return statistics.median(a / b for a, b in zip(one, other))


def ms(samples):
    middle = statistics.median(samples)
    return f"{middle:,.0f}" if middle >= 10 else f"{middle:.1f}"


def find(lines, what, name=None):
    return [line for line in lines if line["what"] == what and name in (None, line["name"])]


def named(decoders, begin):
    """The full name, with a version."""
    return next(name for name in decoders if name.startswith(begin))


def cost(decoder):
    """CPU time of the page's thread, and of the busiest worker."""
    return [sum(both) for both in zip(decoder["main"], decoder["busiest"])]


def first_mesh_cells(lines, name):
    return [ms(line["ms"][name]) if name in line["ms"] else "" for line in find(lines, "page")]


def first_mesh_head(lines):
    return [f"first mesh: {line['name']}, ms" for line in find(lines, "page")]


def over_draco(line, name):
    """How many times as fast as draco3d a decoder is in its own thread."""
    return times(line["decoders"][kDraco]["main"], line["decoders"][name]["main"])


def thread_table(lines):
    assets, meshes = find(lines, "asset"), find(lines, "thread")
    last, rows = meshes[-1], []
    head = ["decoder", "assets, mean", "least", *(line["name"] for line in meshes), f"bytes of {last['name']}",
            f"heap of {last['name']}, MiB", *first_mesh_head(lines)]
    for name, of in last["decoders"].items():
        ratios = [over_draco(line, name) for line in assets if name in line["decoders"]]
        of_assets = [f"{mean(ratios):.2f}", f"{min(ratios):.2f}"] if ratios else ["", ""]
        heap = f"{of['heap'] / kMebibyte:.1f}" if "heap" in of else ""
        rows.append([name, *of_assets, *(f"{over_draco(line, name):.2f}" for line in meshes), f"{of['bytes']:,}", heap,
                     *first_mesh_cells(lines, name)])
    return table(head, rows)


def over_loader(line, name):
    """How many times as fast as DRACOLoader a loader is in both threads."""
    return times(cost(line["decoders"][kLoader]), cost(line["decoders"][name]))


def workers_table(lines):
    meshes, rows = find(lines, "workers"), []
    for name in meshes[0]["decoders"]:
        cells = []
        for line in meshes:
            main, busiest = (statistics.median(line["decoders"][name][thread]) for thread in ("main", "busiest"))
            cells.append(f"{main:.1f} + {busiest:.1f} ({over_loader(line, name):.2f})")
        rows.append([name, *cells, *first_mesh_cells(lines, name)])
    return table(["page's thread + busiest worker, ms", *(line["name"] for line in meshes), *first_mesh_head(lines)], rows)


kContainers = ("patches", "condensed")


def encoders_table(lines):
    rows = []
    for line in find(lines, "encoders"):
        draco, ours = line["encoders"]["draco3d"], line["encoders"][kDropIn]
        containers = [line["encoders"][way] for way in kContainers if way in line["encoders"]]
        cells = [cell for of in containers for cell in (f"{times(of['ms'], draco['ms']):.1f}", f"{of['bytes'] / draco['bytes']:.2f}")]
        attributes = " ".join(semantic[0] for semantic in line["attributes"])
        rows.append([f"{line['name']}: {line['faces']:,}, {attributes}", line["speed"], ms(draco["ms"]), f"{times(draco['ms'], ours['ms']):.2f}",
                     f"{ours['heap'] / draco['heap']:.2f}", *(cells or [""] * 4)])
    return table(["mesh, faces, attributes", "speed", "draco3d, CPU ms", "psplit/draco, times as fast", "its heap", "encodeMesh, time", "bytes",
                  "condensed, time", "bytes"], rows)


def findings(lines):
    assets, meshes, workers, encoders = (find(lines, what) for what in ("asset", "thread", "workers", "encoders"))
    last, large = meshes[-1]["decoders"], [line for line in meshes if line["name"] != "small"]
    meshopt = named(last, kMeshopt)
    faster = {name: span([over_draco(line, name) for line in large]) for name in (meshopt, kPatches)}
    of_assets = {name: [over_draco(line, name) for line in assets] for name in (kDropIn, kStream)}
    of_draco = [(line["encoders"], line["encoders"]["draco3d"]) for line in encoders]
    encodes = span([times(draco["ms"], of[kDropIn]["ms"]) for of, draco in of_draco])
    heap = span([of[kDropIn]["heap"] / draco["heap"] for of, draco in of_draco])
    patches, condensed = (span([times(of[way]["ms"], draco["ms"]) for of, draco in of_draco if way in of], 1) for way in kContainers)
    return [f"On one thread {meshopt} decodes large meshes {faster[meshopt]} times as fast as {kDraco}, and psplit's patches "
            f"{faster[kPatches]} times; its bytes in brotli are {last[meshopt]['bytes'] / last[kPatches]['bytes']:.2f} times those of patches.",
            f"Stock streams of {len(assets)} assets decode {mean(of_assets[kDropIn]):.2f} times as fast as with {kDraco} by psplit/draco, and "
            f"{mean(of_assets[kStream]):.2f} times by `decodeDraco`, at least {min(map(min, of_assets.values())):.2f} times.",
            f"Two workers decode patches {span([over_loader(line, kTwoWorkers) for line in workers])} times as fast as three's DRACOLoader in "
            "one.",
            f"psplit/draco encodes {encodes} times as fast as draco3d, in {heap} of its heap; `encodeMesh` takes {patches} times as long as draco3d "
            f"for one stream, and {condensed} times for condensed patches."]


def spreads(lines):
    decoders = [(name, of["main"]) for what in ("asset", "thread", "workers") for line in find(lines, what) for name, of in line["decoders"].items()]
    encoders = [(name, of["ms"]) for line in find(lines, "encoders") for name, of in line["encoders"].items() if name != "draco3d"]
    return [spread_of(samples) for name, samples in decoders if name.startswith("psplit")] + [spread_of(samples) for _, samples in encoders]


def web_page(lines, rounds, versions, **how):
    """docs/measured/web.md. `versions`: of node, three and so on, a sentence."""
    faces = find(lines, "encoders")[-1]["faces"]
    text = [f"{versions} All decode the same meshes, in turn. Numbers without a unit are CPU time of {kDraco}",
            f"over the decoder's, medians of {rounds} rounds; those in brackets are of the page's thread and the busiest worker together, over",
            "three's DRACOLoader. Assets are those of the command, each primitive in one stream of speed 5. *small* has 5,000 faces,",
            f"*terrain* {faces:,}, both with normals and texture coordinates, *blob* as many with positions only. meshopt_decoder has",
            "version 1 of its codec; its bytes are in brotli, whose decoding is not measured. *First mesh*: wall time in Chromium from the",
            "begin of a page until the arrays are there, with loading and compiling.", ""]
    sections = [*text, *thread_table(lines), "", *workers_table(lines), "",
                "psplit/draco writes draco3d's bytes; `encodeMesh` cuts, and decodes what it wrote. Heaps, times and bytes are over draco3d's.",
                "P are positions of 14 bits, N normals of 10, T texture coordinates of 12.", "", *encoders_table(lines)]
    return page("The npm package beside other decoders", findings(lines), sections, spreads(lines), **how)


# ---- While a file arrives ----

kStreaming, kCharacter = "loadStreaming", "encode --condense --meshopt, loadStreaming"


def streaming_rows(lines):
    """By asset: a row for each loader, with the cells of each line speed."""
    rows = {}
    for asset in dict.fromkeys(line["name"] for line in find(lines, "streaming")):
        of_asset = find(lines, "streaming", asset)
        for name, of in of_asset[0]["loaders"].items():
            cells = []
            for line in of_asset:
                draco = next(iter(line["loaders"].values()))["all"]
                for key in ("first", "all"):
                    samples = line["loaders"][name][key]
                    cells.append(f"{ms(samples)} ({times(samples, draco):.2f})")
            rows.setdefault(f"{asset}, {of_asset[0]['faces']:,} faces", []).append([name, f"{of['bytes']:,}", *cells])
    return rows


def character_rows(line):
    """Least times: what else runs only adds to them."""
    rows, of_first = [], next(iter(line["ways"].values()))
    for name, of in line["ways"].items():
        cells = [cell for time in ("second", "first") for cell in (f"{min(of[f'{time}_loaded']):,.0f}",
                 f"{min(of[f'{time}_drawn']):,.0f} ({min(of[f'{time}_drawn']) / min(of_first[f'{time}_drawn']):.2f})")]
        rows.append([name, f"{of['bytes']:,}", *cells])
    return rows


def streaming_findings(lines):
    """First what the rivals win."""
    losses, gains = [], []
    for asset in dict.fromkeys(line["name"] for line in find(lines, "streaming")):
        shares, sooner = [], []
        for line in find(lines, "streaming", asset):
            loaders, draco = line["loaders"], next(iter(line["loaders"].values()))["all"]
            ours, rival = loaders[kStreaming], loaders[named(loaders, "meshoptimizer")]
            shares.append(f"{times(ours['first'], draco):.2f} and {times(ours['all'], draco):.2f} at {line['mbits']} Mbit/s")
            if times(rival["all"], ours["first"]) < 1:
                sooner.append(f"{times(rival['all'], ours['first']):.2f} (at {line['mbits']} Mbit/s)")
        if sooner:
            losses.append(f"meshoptimizer's file of {asset} is shown sooner than the first triangles by `loadStreaming`: in {join(sooner)} of "
                          "their time.")
        gains.append(f"`loadStreaming` shows the first triangles of {asset}, and all, in this share of the time of three's DRACOLoader: "
                     f"{join(shares)}.")
    for line in find(lines, "character"):
        least = {name: min(of["second_drawn"]) for name, of in line["ways"].items()}
        gltfpack, plain = next(iter(least)), kCharacter.removesuffix(", loadStreaming")
        is_lost = least[gltfpack] < max(least[plain], least[kCharacter])
        text = (f"{line['name']}, by `{plain}`, is drawn in {least[plain] / least[gltfpack]:.2f} of the time of {gltfpack}'s file, and with "
                f"`loadStreaming` in {least[kCharacter] / least[gltfpack]:.2f}.")
        (losses if is_lost else gains).append(text)
    return losses + gains


def streaming_spreads(lines):
    ours = lambda name: name.startswith(("PsplitPlugin", kStreaming))
    return [spread_of(of[key]) for line in find(lines, "streaming") for name, of in line["loaders"].items() if ours(name) for key in ("first", "all")]


def streaming_page(lines, rounds, versions, **how):
    """docs/measured/streaming.md."""
    speeds = dict.fromkeys(line["mbits"] for line in find(lines, "streaming"))
    head = ["asset", "loader", "bytes", *(f"{when} at {mbits} Mbit/s, ms" for mbits in speeds for when in ("first triangles", "all"))]
    sections = [f"{versions} A server on the same machine sends what a page asks",
                "for, at this many Mbit/s together. Times begin with the load, and end when triangles are in the scene, medians of",
                f"{rounds} rounds; each load has a page of its own, whose code and decoders are there before. In brackets: over all triangles of",
                "DRACOLoader. meshoptimizer's file is glTF-Transform's (`meshopt`, level high, as many bits), sent in brotli. GLTFLoader hands",
                "out a scene when each mesh has begun and its textures are there, so an asset whose textures are at its end is shown late.", "",
                *table(head, rows_by_subject(streaming_rows(lines)), 2)]
    for line in find(lines, "character"):
        sections += ["", "## A character on a page", "",
                     f"{line['name']} at {line['mbits']} Mbit/s, with normals of 8 bits, as gltfpack's. *Loaded*: the loader has the scene; *drawn*: its",
                     "picture is there. Each page loads and draws the file twice; the *first* time loads and compiles decoders, workers and shaders,",
                     "too. Least times; in brackets: of the first row's. The plugin decodes when the file is whole, `loadStreaming` while it",
                     "arrives.", "",
                     *table(["made by", "bytes", "loaded, ms", "drawn, ms", "first loaded, ms", "first drawn, ms"], character_rows(line))]
    return page("While a file arrives", streaming_findings(lines), sections, streaming_spreads(lines), **how)


# ---- Sizes, for docs/web.md ----

def size_tables(line):
    return [*table(["decoder", "bytes", "brotli"], [[name, f"{size:,}", f"{packed:,}"] for name, size, packed in line["decoders"]]), "",
            *table(["encoder", "bytes", "brotli"], [[name, f"{size:,}", f"{packed:,}"] for name, size, packed in line["encoders"]])]
