"""The rows of encoding: `gltf-psplit encode` beside draco_encoder on mesh files, and 10,000 small assets, as tables for
docs/measured/encoding.md."""
import os, pathlib, re, shutil, statistics, subprocess, sys, tempfile, time

from benchmarks.programs import build, processor_name

# Assets of the two batches whose difference tells what one asset takes.
kFewAssets, kManyAssets = 100, 400


def stop(words):
    sys.exit(f"bench: {words}")


def commands(mesh, folder, psplit, before):
    """What runs in turn, by name; the rival is first."""
    rival = shutil.which("draco_encoder") or stop("draco_encoder is missing (Debian: draco)")
    found = {"draco_encoder -cl 5 -qp 14": [rival, "-i", mesh, "-o", folder / "a.drc", "-cl", "5", "-qp", "14"]}
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
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        all_words = commands(mesh.resolve(), folder, psplit, before)
        measured = [{name: run(words) for name, words in all_words.items()} for _ in range(rounds + 1)][1:]
        middle = {name: [statistics.median(of[name][i] for of in measured) for i in range(3)] for name in all_words}
        base = next(iter(middle.values()))
        counted = ["instructions, millions", "of the partition"] if instructions else []
        print("| " + " | ".join([mesh.name, "processor, s", "of draco_encoder", "wall clock, s", "of draco_encoder", "MB", *counted]) + " |")
        print("|---|" + "--:|" * (5 + len(counted)))
        for name, (wall, processor, memory) in middle.items():
            cells = [f"`{name}`", f"{processor:.2f}", f"{processor / base[1]:.2f}", f"{wall:.2f}", f"{wall / base[0]:.2f}", f"{memory:.0f}"]
            if instructions:
                # What other threads do for the partition is not below it.
                part = "psplit::partition_faces" if name.endswith("-j 1") else None
                count, of_partition = count_instructions(all_words[name], folder, part)
                cells += [f"{count:,.0f}", f"{of_partition / count:.2f}" if of_partition else ""]
            print("| " + " | ".join(cells) + " |", flush=True)
        print()


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


def print_encode_rows(meshes, psplit=None, before=None, rounds=7, instructions=False):
    psplit = pathlib.Path(psplit or build(["gltf-psplit"]) / "../gltf-psplit").resolve()
    print(f"{processor_name()}, {os.cpu_count()} threads; medians of {rounds} rounds in turn\n")
    for mesh in meshes:
        compare_on_mesh(mesh, psplit, before and before.resolve(), rounds, instructions)
    if instructions:
        print("| small assets, in a batch on one thread | instructions an asset, millions |\n|---|--:|")
        for name, program in (("`gltf-psplit batch`", psplit), ("before", before)):
            if program:
                print(f"| {name} | {count_for_small_assets(program.resolve()):.2f} |", flush=True)
