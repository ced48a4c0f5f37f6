#!/usr/bin/env python3
"""`compare` reports the bytes and patches that `encode` writes:

  compare_bytes.py --psplit COMMAND --corpus FOLDER [--most N]

Takes the N smallest well-formed files of the corpus that `compare` accepts (no compressed ones), and
compares `compare --patches 3,9` with `encode --morph-targets sparse --patches 3` and 9: stock Draco, with
which it compares, has no morph targets. Exits with 77 (skipped) if there is no
corpus: it is not part of the project.
"""
import argparse, concurrent.futures, json, pathlib, subprocess, sys, tempfile

parser = argparse.ArgumentParser()
parser.add_argument("--psplit", type=pathlib.Path, required=True)
parser.add_argument("--corpus", type=pathlib.Path, required=True)
parser.add_argument("--most", type=int, default=150)
options = parser.parse_args()
if not options.corpus.is_dir():
    print(f"no corpus at {options.corpus}")
    sys.exit(77)
kCounts = (3, 9)


def run(*command):
    done = subprocess.run([str(part) for part in (options.psplit, *command)], capture_output=True, timeout=120)
    return done.returncode, done.stdout, done.stderr.decode(errors="replace")


def encoded(file, count, output):
    code, report, said = run("encode", "-q", "-j", 1, "--morph-targets", "sparse", "--patches", count,
                             file, output, "--report", "-")
    if code != 0:
        return f"encode exits with {code}: {said}"
    total = json.loads(report)["total"]
    return total["patches"], total["bytes"]["total"]


def check(file):
    """Returns None if `compare` refuses the file, else a text: its differences, or nothing."""
    code, report, said = run("compare", "-q", "-j", 1, "--repeat", 1, "--backend", "draco", "--stock-speeds", 5, "--patches",
                             ",".join(map(str, kCounts)), "--format", "json", file)
    if code in (2, 3, 5):
        return None
    if code != 0:
        return f"compare exits with {code}: {said}"
    compared = [(split["patches"], split["bytes"]) for split in json.loads(report)["splits"]]
    with tempfile.TemporaryDirectory(prefix="psplit-compare-") as folder:
        written = [encoded(file, count, pathlib.Path(folder) / "out.glb") for count in kCounts]
    return "" if compared == written else f"compare says {compared}, and encode {written} (patches, bytes)"


def candidates():
    kinds = {".gltf", ".glb", ".ply", ".obj", ".stl", ".off", ".drc"}
    files = [file for file in options.corpus.rglob("*") if file.suffix in kinds
             and "malformed" not in file.relative_to(options.corpus).parts]
    # A .gltf is as large as its folder.
    size = {file: sum(other.stat().st_size for other in file.parent.iterdir() if other.is_file())
            if file.suffix == ".gltf" else file.stat().st_size for file in files}
    return sorted(files, key=lambda file: (size[file], file))


checked, failures = 0, []
with concurrent.futures.ThreadPoolExecutor(2) as pool:
    files = candidates()
    for start in range(0, len(files), 50):
        batch = files[start:start + 50]
        for file, wrong in zip(batch, pool.map(check, batch)):
            checked += wrong is not None
            if wrong:
                failures.append(f"{file.relative_to(options.corpus)}: {wrong}")
        if checked >= options.most:
            break
print("\n".join(failures) or f"{checked} files: compare reports the bytes that encode writes")
if checked == 0:
    sys.exit("compare accepts no file")
sys.exit(1 if failures else 0)
