"""Builds the benchmarks, and says where they run."""
import pathlib, platform, re, shlex, subprocess, sys

root = pathlib.Path(__file__).resolve().parent.parent.parent


def build(targets, *options):
    """Builds programs of bench/ in build/bench, and returns their folder. `options` are CMake's."""
    print("building build/bench", file=sys.stderr, flush=True)
    for command in (["scripts/setup", "--benchmarks"],
                    ["cmake", "-S", ".", "-B", "build/bench", "-G", "Ninja", "-DPSPLIT_BUILD_BENCHMARKS=ON", *options],
                    ["cmake", "--build", "build/bench", "--target", *targets]):
        done = subprocess.run(command, cwd=root, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            sys.exit(f"{shlex.join(command)} fails:\n{done.stdout[-4000:]}")
    return root / "build/bench/bench"


def processor_name():
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    found = re.search(r"model name\s*: (.*)", cpuinfo.read_text()) if cpuinfo.exists() else None
    return found[1] if found else platform.machine()
