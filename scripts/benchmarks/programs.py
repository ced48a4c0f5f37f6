"""Builds the benchmarks, and says where they run."""
import json, os, pathlib, platform, re, shlex, subprocess, sys, tempfile

root = pathlib.Path(__file__).resolve().parent.parent.parent
kCorpus = root / "../shared/corpus"
kDragon = kCorpus / "mesh/dra/dragon_vrip.ply.gz"
kShortRepetition = 0.02  # seconds; of many short ones the least disturbed is taken


def build(targets, *options, folder="build/bench"):
    """Builds programs of bench/ in `folder`, and returns their folder. `options` are CMake's."""
    print(f"building {folder}", file=sys.stderr, flush=True)
    for command in (["scripts/setup", "--benchmarks"],
                    ["cmake", "-S", ".", "-B", folder, "-G", "Ninja", "-DPSPLIT_BUILD_BENCHMARKS=ON", *options],
                    ["cmake", "--build", folder, "--target", *targets]):
        done = subprocess.run(command, cwd=root, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            sys.exit(f"{shlex.join(command)} fails:\n{done.stdout[-4000:]}")
    return root / folder / "bench"


def mesh_title(path):
    """How pages name a mesh file."""
    return {"dragon_vrip": "Dragon"}.get(name := path.name.partition(".")[0], name.replace("_", " "))


def environment_of(mesh):
    """The environment of a program that measures this mesh, or its built-in one."""
    return {**{name: value for name, value in os.environ.items() if name != "PSPLIT_BENCH_MESH"},
            **({"PSPLIT_BENCH_MESH": str(mesh)} if mesh else {})}


def run_benchmark(program, pattern, repetitions, mesh=None, min_time=0.1):
    """What a program of Google Benchmark measures of the benchmarks whose names match, in turn, on `mesh` instead of the one that
    PSPLIT_BENCH_MESH names: its JSON; None if none matches. `min_time`: seconds of each repetition at least."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder, "report.json")
        command = [program, f"--benchmark_out={out}", "--benchmark_out_format=json", f"--benchmark_repetitions={repetitions}",
                   f"--benchmark_filter={pattern}", "--benchmark_enable_random_interleaving=true", f"--benchmark_min_time={min_time}"]
        print(f"running {program.name}{f' with {mesh.name}' if mesh else ''}", file=sys.stderr, flush=True)
        done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                              env=os.environ | ({"PSPLIT_BENCH_MESH": str(mesh)} if mesh else {}))
        if done.returncode != 0:
            sys.exit(f"{program.name} fails:\n{done.stdout[-4000:]}")
        # If the filter matches nothing, there is no JSON.
        return json.loads(out.read_text()) if out.exists() and out.stat().st_size > 0 else None


def add_meshoptimizer_option(parser):
    parser.add_argument("--meshoptimizer", type=pathlib.Path, action="append", default=[], metavar="FOLDER",
                        help="also measure the meshoptimizer that is installed there, as by `cmake --install`; may be repeated")


def builds_by_meshoptimizer(targets, prefixes):
    """The folders of programs that are built with the system's meshoptimizer, and with each meshoptimizer that `prefixes` name."""
    folders = [build(targets, "-DPSPLIT_CUDA=OFF")]
    for number, prefix in enumerate(prefixes):
        folders.append(build(targets, "-DPSPLIT_CUDA=OFF", "-DPSPLIT_BUILD_TESTS=OFF", "-DPSPLIT_BUILD_C=OFF",
                             f"-Dmeshoptimizer_ROOT={prefix.resolve()}", folder=f"build/bench-meshoptimizer-{number + 1}"))
    return folders


def processor_name():
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    found = re.search(r"model name\s*: (.*)", cpuinfo.read_text()) if cpuinfo.exists() else None
    return found[1] if found else platform.machine()
