"""Encoding: `gltf-psplit encode` beside draco_encoder on mesh files, the encoder of one stream beside libdraco's, and small assets in
a batch. Makes docs/measured/encoding.md."""
import os, pathlib, re, shutil, statistics, subprocess, sys, tempfile, time

from benchmarks.pages import join, page_by_processor, span, table, value_of
from benchmarks.programs import build, processor_name, run_benchmark
from benchmarks.ratios import samples_of, spread_of, summarize

# Assets of the two batches whose difference tells what one asset takes.
kFewAssets, kManyAssets = 100, 400

kRival = "draco_encoder -cl 5 -qp 14"
kHead = ["wall clock, s", "of draco_encoder's", "processor, s", "processor, of draco_encoder's", "MB"]
kCounts = ["instructions, millions", "of the partition"]


def stop(words):
    sys.exit(f"bench: {words}")


def commands(mesh, folder, psplit, before):
    """What runs in turn, by name; the rival is first."""
    rival = shutil.which("draco_encoder") or stop("draco_encoder is missing (Debian: draco)")
    found = {kRival: [rival, "-i", mesh, "-o", folder / "a.drc", "-cl", "5", "-qp", "14"]}
    for name, program in (("gltf-psplit encode", psplit), ("before", before)):
        for more in ([], ["--condense"]):
            for threads in (1, 2) if program else ():
                words = [program, "encode", "-q", "-j", str(threads), *more, mesh, folder / "a.glb"]
                found[" ".join([name, *more, f"-j {threads}"])] = words
    return {name: [str(word) for word in words] for name, words in found.items()}


def run(words):
    """Seconds of the wall clock, seconds of the processor, and megabytes."""
    begin = time.monotonic()
    process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    errors = process.stderr.read().decode(errors="replace")
    _, status, usage = os.wait4(process.pid, 0)
    wall = time.monotonic() - begin
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        stop(f"{' '.join(words)} exits with {process.returncode}:\n{errors}")
    return wall, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


def count_instructions(words, folder, part=None):
    """Millions of instructions of a command and its children, and of the function `part` with all that it calls."""
    done = subprocess.run(["valgrind", "--tool=callgrind", "--trace-children=yes",
                           f"--callgrind-out-file={folder / 'count.%p'}", *map(str, words)],
                          cwd=folder, capture_output=True, text=True)
    counts = [int(count) for count in re.findall(r"Collected : (\d+)", done.stderr)]
    if done.returncode != 0 or not counts:
        stop(f"valgrind fails:\n{done.stderr}")
    of_part = 0
    for file in folder.glob("count.*"):
        if part:
            rows = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", file], capture_output=True, text=True)
            lines = [line for line in rows.stdout.splitlines() if f"{part}(" in line]
            of_part = max([of_part, *(int(line.split("(")[0].replace(",", "")) for line in lines)])
        file.unlink()
    return sum(counts) / 1e6, of_part / 1e6


def compare_on_mesh(mesh, psplit, before, rounds, instructions):
    """A table of the commands on a mesh, and the spreads of their wall-clock times."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        all_words = commands(mesh.resolve(), folder, psplit, before)
        measured = []
        for number in range(rounds + 1):
            print(f"{mesh.name}: round {number} of {rounds}", file=sys.stderr, flush=True)
            measured.append({name: run(words) for name, words in all_words.items()})
        of = {name: [[of[name][i] for of in measured[1:]] for i in range(3)] for name in all_words}
        middle = {name: [statistics.median(values) for values in columns] for name, columns in of.items()}
        rival_wall, rival_processor, _ = middle[kRival]
        rows = []
        for name, (wall, processor, memory) in middle.items():
            cells = [f"`{name}`", f"{wall:.2f}", f"{wall / rival_wall:.2f}", f"{processor:.2f}", f"{processor / rival_processor:.2f}", f"{memory:.0f}"]
            # What other threads do for the partition is not below it.
            if instructions and not name.endswith("-j 2"):
                count, of_partition = count_instructions(all_words[name], folder, "psplit::partition_faces" if name != kRival else None)
                cells += [f"{count:,.0f}", f"{of_partition / count:.2f}" if of_partition else ""]
            rows.append(cells + [""] * (len(kCounts) if instructions and name.endswith("-j 2") else 0))
        return table([mesh.name, *kHead, *(kCounts if instructions else [])], rows), [spread_of(columns[0]) for columns in of.values()]


def count_for_small_assets(psplit):
    """Millions of instructions that one more asset takes in a batch of the assets of bench/small_assets, on one thread."""
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        (folder / "in").mkdir()
        for i in range(kManyAssets):
            words = [psplit, "generate", folder / f"in/{i:03}.glb", "--faces", "200", "--seed", str(i % 50), "-q"]
            subprocess.run(words, check=True)
        counts = []
        for count in (kFewAssets, kManyAssets):
            pattern = f"in/{'0' if count == kFewAssets else '*'}*.glb"
            words = [psplit, "batch", pattern, "-o", f"out{count}", "-q", "-j", "1", "--report", os.devnull]
            counts.append(count_instructions(words, folder)[0])
        return (counts[1] - counts[0]) / (kManyAssets - kFewAssets)


def command(psplit):
    return pathlib.Path(psplit or build(["gltf-psplit"]) / "../gltf-psplit").resolve()


def print_encode_rows(meshes, psplit, before, rounds, instructions):
    """The rows of two builds of the command."""
    psplit, before = command(psplit), before.resolve()
    print(f"{processor_name()}, {os.cpu_count()} threads; medians of {rounds} rounds in turn\n")
    for mesh in meshes:
        print("\n".join([*compare_on_mesh(mesh, psplit, before, rounds, instructions)[0], ""]), flush=True)
    if instructions:
        print("\n".join(table(["small assets, in a batch on one thread", "instructions an asset, millions"],
                              [[name, f"{count_for_small_assets(program):.2f}"] for name, program in (("`gltf-psplit batch`", psplit), ("before", before))])))


# ---- docs/measured/encoding.md ----

kStreamSpeeds = (0, 5, 10)  # Draco's
kStreams = {"encode/positions": "positions", "encode/positions+normals+texcoords": "with normals and texture coordinates",
            "encode/cloud/positions": "its points as a cloud", "encode/cloud/positions+normals+texcoords": "as a cloud, with normals and texture coordinates"}


def stream_rows(rows):
    """The ratios of encode_benchmark's rows, as benchmarks/ratios.py has them, by mesh and speed."""
    ratios = {row["name"]: f"{row['ratio']:.2f}" for row in rows}
    return [[words, *(ratios[f"{name}/speed{speed}/stream"] for speed in kStreamSpeeds)] for name, words in kStreams.items()]


def encode_findings(tables):
    """Sentences about the tables of several processors under kHead: first where the rival wins, if it does."""
    ours = [f"`gltf-psplit encode{more} -j {threads}`" for more in ("", " --condense") for threads in (1, 2)]
    times = {name: [value_of(table[name][kHead[1]]) for table in tables] for name in ours}
    memory = {name: [value_of(table[name][kHead[4]]) / value_of(table[f"`{kRival}`"][kHead[4]]) for table in tables] for name in ours}
    losses = [f"{name} takes up to {max(of[name]):.2f} times the {what} of `draco_encoder`" for of, what in ((times, "time"), (memory, "memory"))
              for name in ours if max(of[name]) > 1]
    return [*([f"{join(losses)}."] if losses else []),
            f"`encode`, which verifies what it writes, takes {span(times[ours[0]])} of the time of `draco_encoder` on one thread, and "
            f"{span(times[ours[1]])} on two; with `--condense` {span(times[ours[2]])} and {span(times[ours[3]])}."]


def text_of_encoding(meshes, psplit, rounds, instructions, before):
    """The page. `before`: its old text."""
    psplit = command(psplit)
    lines, spreads = [f"Medians of {rounds} rounds in turn."], []
    for mesh in meshes:
        rows, of_mesh = compare_on_mesh(mesh, psplit, None, rounds, instructions)
        lines += ["", *rows]
        spreads += of_mesh
    program = build(["encode_benchmark"]) / "encode_benchmark"
    speeds = "|".join(map(str, kStreamSpeeds))
    report = run_benchmark(program, f"speed({speeds})/(draco|stream)", 5, meshes[0].resolve())
    lines += ["", *table([f"one stream of {meshes[0].name}: of the time of libdraco's encoder, on one thread", *(f"speed {speed}" for speed in kStreamSpeeds)],
                         stream_rows(summarize(samples_of(report))))]
    introduction = ["The commands read a mesh file and write an asset: `encode` by default in patches. Of one stream, libdraco's encoder and",
                    "`encode_stream` get the mesh in memory, in the order in which the stream decodes, which is best for both; at speed 10 clouds",
                    "are sequential. Where page faults are slow, `draco_encoder` loses most: `encode` asks for large pages, and keeps memory."]
    return page_by_processor("Encoding", encode_findings, introduction, lines, before, spreads)
