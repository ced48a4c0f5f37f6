"""docs/measured/partition.md: psplit's partition, METIS, the paper's method, and meshoptimizer's meshlets."""
import json, subprocess, sys

from benchmarks.pages import page, rows_by_subject, span, table
from benchmarks.programs import build, environment_of, kCorpus, kDragon, mesh_title
from benchmarks.ratios import spread_of

kMeshes = (kDragon, kCorpus / "mesh/si/BrainMesh_ICBM152.ply.gz", kCorpus / "mesh/ode/skull.ply.gz")
kGeneratedFaces = 1_000_000


def measure(meshes, rounds):
    """{mesh: lines of partition_benchmark}, with a generated mesh."""
    program = build(["partition_benchmark"], "-DPSPLIT_CUDA=OFF") / "partition_benchmark"
    results = {}
    for mesh in [*meshes, None]:
        print(f"running partition_benchmark with {mesh.name if mesh else 'a generated mesh'}", file=sys.stderr, flush=True)
        done = subprocess.run([program, str(rounds), *([] if mesh else [str(kGeneratedFaces)])], stdout=subprocess.PIPE, text=True,
                              env=environment_of(mesh))
        if done.returncode != 0:
            sys.exit(f"partition_benchmark fails with {mesh}")
        results[mesh_title(mesh) if mesh else "generated"] = list(map(json.loads, done.stdout.splitlines()))
    return results


def milliseconds(contender, threads):
    return min(contender[f"{threads}_ms"])


def findings(results):
    """Sentences: first which method replicates fewer points than psplit, and in what time; then METIS."""
    cases = [(f"{name}, {line['patch_faces']:,} faces", line) for name, lines in results.items() for line in lines]
    better = lambda method: [line for _, line in cases if line[method]["replication"] < line["psplit"]["replication"]]
    paper = better("paper")
    slower = span([milliseconds(line["paper"], "two_threads") / milliseconds(line["psplit"], "two_threads") for _, line in cases], 1)
    points = span([100 * (line["psplit"]["replication"] - line["paper"]["replication"]) for line in paper], 2) if paper else ""
    metis = [title for title, line in cases if line in better("METIS")]
    times = span([milliseconds(line["psplit"], "one_thread") / milliseconds(line["METIS"], "one_thread") for _, line in cases])
    apart = sum(line["psplit"]["apart"] for _, line in cases)
    return [f"The paper's method replicates fewer points than psplit in {len(paper) or 'none'} of {len(cases)} cases"
            + (f", by {points} % of a mesh's points" if paper else "") + f", in {slower} times the time.",
            f"METIS replicates fewer in {len(metis) or 'none'} of {len(cases)}" + (f" ({'; '.join(metis)})" if metis else "")
            + f"; on one thread psplit takes {times} of its time.",
            f"{'None' if apart == 0 else apart} of psplit's patches {'has' if apart in (0, 1) else 'have'} several components."]


def rows_of(results):
    share = lambda contender: f"{100 * contender['replication']:.2f} %"
    return rows_by_subject({f"{name}, {lines[0]['faces']:,} faces": [
        [f"{line['patch_faces']:,}", share(line["psplit"]), share(line["METIS"]), share(line["paper"]),
         *(f"{milliseconds(line[method], threads):,.0f}" for method, threads in (
             ("psplit", "one_thread"), ("METIS", "one_thread"), ("psplit", "two_threads"), ("paper", "two_threads"))),
         f"{line['psplit']['balance']:.3f}", line["METIS"]["apart"]] for line in lines]
        for name, lines in results.items()})


def text_of(results, rounds, **how):
    meshlets = [line["meshlets"] for lines in results.values() for line in lines if "meshlets" in line]
    share = span([100 * each["replication"] for each in meshlets], 1)
    lines = ["METIS k-way runs on one thread and gets its graph ready-made; the times of psplit include its graph. They run in turn: the least of",
             f"{rounds} rounds, milliseconds. The paper's method, with geodesic distances and borders by minimum cuts (`--distance geodesic`), runs",
             "twice, on two threads. Replication is how many more points all patches have than the mesh. The balance",
             "is psplit's largest patch by the mean, METIS's is at most "
             f"{max(line['METIS']['balance'] for lines in results.values() for line in lines):.3f}; the last column has its patches of several components.",
             f"meshoptimizer's meshlets of at most {results[next(iter(results))][-1]['patch_faces']} faces replicate {share} %, "
             f"{sum(each['apart'] for each in meshlets):,} of {sum(each['patches'] for each in meshlets):,} in several components.", "",
             *table(["mesh", "faces a patch", "psplit", "METIS", "paper's method", "psplit, 1 thread, ms", "METIS, 1", "psplit, 2 threads",
                     "paper's method, 2", "balance", "METIS's patches apart"], rows_of(results))]
    spreads = [spread_of(line[method][f"{threads}_ms"]) for lines in results.values() for line in lines
               for method, threads in (("psplit", "one_thread"), ("psplit", "two_threads"), ("METIS", "one_thread"))]
    return page("The partition", findings(results), lines, spreads, **how)
