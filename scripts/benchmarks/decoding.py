"""docs/measured/decoding.md: psplit and libdraco decode containers of a mesh; times, stages and peaks of memory."""
import pathlib, re, subprocess, tempfile

from benchmarks.pages import page, span, table
from benchmarks.programs import build, environment_of, kShortRepetition, mesh_title, run_benchmark
from benchmarks.ratios import repetitions_of, samples_of, spread_of

kAttributes = {"positions": "positions", "positions+normals+texcoords": "with normals, texcoords"}
kSizes = {"4800": "4,800", "1200": "1,200", "whole": "whole"}  # faces of a patch
kSpeeds = (0, 5)
kStaged = ("positions/4800/speed0", "positions/4800/speed5", "positions+normals+texcoords/4800/speed5")
kStages = ("1 connectivity", "2 seams", "3 traversal, symbols", "4 prediction", "5 output", "3-5 attributes")


def kinds():
    """The names of the samples, as in bench/samples.h."""
    return [f"{attributes}/{size}/speed{speed}" for attributes in kAttributes for size in kSizes for speed in kSpeeds]


def stages_of(report):
    """{benchmark: {stage: milliseconds}} of the fastest repetition. libdraco's last stages are one."""
    found = {}
    for name, entry in repetitions_of(report):
        found.setdefault(name, []).append(entry)
    return {name: {stage: min(entries, key=lambda entry: entry["real_time"])[stage] for stage in kStages} for name, entries in found.items()}


def peaks_of(program, mesh):
    """{(sample, decoder): megabytes}: what one decode adds to the peak of a new process."""
    peaks = {}
    with tempfile.TemporaryDirectory() as folder:
        for kind in kinds():
            sample = pathlib.Path(folder, "sample")
            subprocess.run([program, "--write", kind, sample], env=environment_of(mesh), check=True)
            for decoder in ("cpu", "draco"):
                done = subprocess.run([program, "--peak", decoder, sample], stdout=subprocess.PIPE, text=True, check=True)
                peaks[kind, decoder] = float(done.stdout)
    return peaks


def measure(mesh, rounds):
    folder = build(["decode_benchmark", "stage_benchmark"], "-DPSPLIT_CUDA=OFF")
    exactly = lambda names: "^(" + "|".join(map(re.escape, names)) + ")"
    whole = run_benchmark(folder / "decode_benchmark", exactly(kinds()) + "/(cpu|draco)/", rounds, mesh, kShortRepetition)
    staged = run_benchmark(folder / "stage_benchmark", exactly(kStaged) + "/(core_in_step|draco)/", rounds, mesh, kShortRepetition)
    return {"mesh": mesh_title(mesh), "rounds": rounds, "samples": samples_of(whole), "stages": stages_of(staged),
            "stage_samples": samples_of(staged), "peaks": peaks_of(folder / "stage_benchmark", mesh)}


def rows_of(results):
    """For each sample: the least times on one thread and on all, both of psplit and libdraco, and peaks of memory."""
    rows = []
    for kind in kinds():
        attributes, size, speed = kind.split("/")
        times = {key: [min(results["samples"][f"{kind}/{decoder}/threads:{threads}"]) for decoder in ("cpu", "draco")]
                 for key, threads in (("one", 1), ("all", threads_of(results))) if f"{kind}/cpu/threads:{threads}" in results["samples"]}
        rows.append({"attributes": kAttributes[attributes], "size": kSizes[size], "speed": speed.removeprefix("speed"), **times,
                     "peaks": [results["peaks"][kind, decoder] for decoder in ("cpu", "draco")]})
    return rows


def threads_of(results):
    return max(int(name.rpartition(":")[2]) for name in results["samples"])


def findings(results):
    """Sentences: the first about memory, which whole streams need more of than libdraco; then times."""
    rows = rows_of(results)
    whole, cut = ([row for row in rows if (row["size"] == "whole") == is_whole] for is_whole in (True, False))
    memory = [span([row["peaks"][0] / row["peaks"][1] for row in of]) for of in (whole, cut)]
    speed = [span([row["one"][1] / row["one"][0] for row in of]) for of in (cut, whole)]
    threads = span([row["one"][0] / row["all"][0] for row in cut])
    slower = [f"{ratio:.2f} times for `{name}`" for name in kStaged if (ratio := connectivity(results, name)) > 1]
    return [f"psplit takes {memory[0]} times libdraco's memory for whole streams, and {memory[1]} times for patches.",
            *([f"Its connectivity alone takes longer than libdraco's in some cases: {', '.join(slower)}."] if slower else []),
            f"On one thread it decodes patches of 4,800 and 1,200 faces {speed[0]} times as fast as libdraco, and whole streams {speed[1]} times.",
            f"Patches decode {threads} times as fast on {threads_of(results)} threads as on one."]


def connectivity(results, name):
    return results["stages"][f"{name}/core_in_step"][kStages[0]] / results["stages"][f"{name}/draco"][kStages[0]]


def stage_rows(results):
    rows = []
    for name in kStaged:
        for decoder, title in (("core_in_step", "psplit"), ("draco", "libdraco")):
            times = results["stages"][f"{name}/{decoder}"]
            rows.append([f"`{name}`" if title == "psplit" else "", title, *(f"{ms:.1f}" if ms else "" for ms in times.values()),
                         f"{min(results['stage_samples'][f'{name}/{decoder}']):.1f}"])
    return rows


def text_of(results, **how):
    many = threads_of(results)
    rows = []
    for row in rows_of(results):
        (ours, theirs), both = row["one"], row.get("all")
        rows.append([row["attributes"], row["size"], row["speed"], f"{ours:.1f}", f"{theirs:.1f}", f"{theirs / ours:.2f}",
                     *([f"{both[0]:.1f}", f"{both[1]:.1f}", f"{ours / both[0]:.2f}"] if both else [""] * 3),
                     *(f"{peak:.1f}" for peak in row["peaks"])])
    lines = [f"Containers of the {results['mesh']} become meshes, by psplit and by libdraco on the same patches and as many threads, in turn: the least",
             f"of {results['rounds']} rounds, milliseconds. Positions have 14 bits, normals 10, texture coordinates 12; the mesh gets smooth normals, and as",
             "texture coordinates longitude and latitude, with a seam. MB is what decoding on one thread adds to the process, result",
             "included. [Rivals](rivals.md) has meshoptimizer beside psplit.", "",
             *table(["attributes", "faces a patch", "speed", "psplit", "libdraco", "ratio", f"psplit, {many} threads", f"libdraco, {many}",
                     f"psplit, 1 : {many}", "psplit, MB", "libdraco, MB"], rows), "",
             "## By stage", "",
             "One thread, without the container, stitching and, for libdraco, the copy out of its mesh. psplit decodes three patches in",
             "lock-step. libdraco's last three stages are one.", "",
             *table(["sample", "", "connectivity", "seams", "traversal, symbols", "prediction", "output", "last three", "all"],
                    stage_rows(results), 2)]
    return page("Decoding: speeds, attributes, memory, stages", findings(results), lines,
                [spread_of(times) for times in results["samples"].values()], **how)
