#!/usr/bin/env python3
"""Runs gltf-psplit on every file of a corpus:

  run_corpus.py --psplit COMMAND --same-mesh COMMAND --corpus FOLDER [--validator FOLDER] [--only TEXT] [--malformed]
                [--from BYTES] [--below BYTES]

A well-formed file must encode, validate, decode, and be the same mesh as before: same_mesh and the command itself
(`diff`) must both say so. This is done twice: with the default options, where no value may be off by more than half a
step of the grid that the drawn values of its mesh call for; and split, condensed and lossless, with every face and point kept (kSplit below), in patches of one of three sizes.
Then libdraco must decode the same patches, expanded, to the same bytes. Or the file must be refused exactly as
expected_refusals.txt says. In glTF's JSON only what asset_difference.py lists may change.

A file of the malformed folder must be refused, with exit code 2, 3 or 5 and a message that names it, or must load if
expected_loads.txt lists it. --validator names a folder with validate.mjs and its node_modules. Outputs then must pass the
official validator, except for errors of the input (glTF's own, or those in expected_errors.txt). --from and --below choose
files by their size, to which that of a .gltf's folder counts.

Well-formed .drc files and assets with stock KHR_draco_mesh_compression must inspect, and decode to the same bytes with
--backend cpu and --backend draco. Only libdraco decodes .drc files of bitstreams before 2.2; for these the backends are auto
and draco.

The corpus is not part of the project. Without it the exit code is 77 (skipped).
"""
import argparse, concurrent.futures, fnmatch, gzip, json, pathlib, shutil, subprocess, sys, tempfile, zlib
from asset_difference import differences

here = pathlib.Path(__file__).resolve().parent
parser = argparse.ArgumentParser()
parser.add_argument("--psplit", type=pathlib.Path, required=True)
parser.add_argument("--same-mesh", type=pathlib.Path, required=True)
parser.add_argument("--corpus", type=pathlib.Path, required=True)
parser.add_argument("--validator", type=pathlib.Path)
parser.add_argument("--only", default="", help="only files whose paths contain this")
parser.add_argument("--malformed", action="store_true", help="only the malformed files")
parser.add_argument("--from", dest="least", type=int, default=0, help="only files of so many bytes or more")
parser.add_argument("--below", type=int, default=sys.maxsize, help="only files of fewer bytes")
parser.add_argument("--timeout", type=int, default=300, help="seconds for one command")
options = parser.parse_args()
kDefault = []
kSplit = ["--lossless", "--always-patches", "--keep-degenerate", "--keep-unused", "--patch-faces"]
kPatchFaces = [440, 1200, 4800]
kLoadable = {".gltf", ".glb", ".ply", ".obj", ".stl", ".drc", ".off"}


class Failure(Exception):
    pass


def read_expected(name):
    """The (code, path pattern) of each line; a line also has a reason."""
    lines = (here / name).read_text().splitlines()
    fields = (line.split(None, 2) for line in lines if line and not line.startswith("#"))
    return [(code, pattern) for code, pattern, reason in fields]


def expected_codes(table, path):
    return [code for code, pattern in table if fnmatch.fnmatchcase(path, pattern)]


def run(what, *command):
    """The exit code, and stdout and stderr together. A signal or a time-out is always a failure."""
    try:
        done = subprocess.run([str(part) for part in command], capture_output=True, timeout=options.timeout)
    except subprocess.TimeoutExpired:
        raise Failure(f"{what} took over {options.timeout} s")
    said = (done.stdout + done.stderr).decode(errors="replace").strip()
    if done.returncode < 0:
        raise Failure(f"{what} died of signal {-done.returncode}: {said[-400:]}")
    return done.returncode, said


def must(what, *command):
    code, said = run(what, *command)
    if code != 0:
        raise Failure(f"{what} exits with {code}: {said[-400:]}")
    return said


def decode_stock(source, folder):
    """Checks that both backends decode stock Draco alike. Returns the kind of file (a key of stock_files; None without stock
    Draco) and the number of its streams."""
    content = source.read_bytes()
    is_drc = source.suffix.lower() == ".drc"
    if not is_drc and b"KHR_draco_mesh_compression" not in content:
        return None, 0
    older = is_drc and content[5:7] != b"\x02\x02"
    inspect = [options.psplit, "inspect", "-q", "-j", 1, source, "--format", "json", "--backend"]
    decode = [options.psplit, "decode", "-q", "-j", 1, source, folder / "stock.glb", "--backend"]
    inspected, decoded = [], []
    for backend in ("auto" if older else "cpu", "draco"):
        inspected.append(must(f"inspect --backend {backend}", *inspect, backend))
        must(f"decode --backend {backend}", *decode, backend)
        decoded.append((folder / "stock.glb").read_bytes())
    if inspected[0] != inspected[1] or decoded[0] != decoded[1]:
        raise Failure("the backends describe its streams differently, or decode them to different bytes")
    if older and (run("inspect", *inspect, "cpu")[0] != 5 or run("decode", *decode, "cpu")[0] != 5):
        raise Failure("--backend cpu does not refuse a bitstream before 2.2")
    count = sum(primitive["storage"] == "draco" for primitive in json.loads(inspected[0])["primitives"])
    if count == 0:
        return None, 0
    return "older .drc" if older else ".drc" if is_drc else "glTF", count


def round_trip(path, source, folder, malformed, lossless, has_stock):
    """The outcome: "equal", "loaded" (a malformed file has nothing to be compared with) or "refused"."""
    encoded, decoded = folder / "encoded.glb", folder / "decoded.glb"
    ways = kDefault
    if lossless:
        ways = [*kSplit, kPatchFaces[zlib.crc32(path.encode()) % len(kPatchFaces)]]
        # Stock Draco would be condensed as it is, with all of its points, of which same_mesh wants equal ones merged.
        ways += [] if has_stock else ["--condense"]
    code, said = run("encode", options.psplit, "encode", "-q", "-j", 1, *ways, source, encoded)
    expected = expected_codes(refusals, path)
    if code != 0:
        if not said or code not in (2, 3, 5):
            raise Failure(f"encode exits with {code}: {said[-400:]}")
        if source.name not in said:
            raise Failure(f"encode refuses it with a message that does not name it: {said[-400:]}")
        if encoded.exists():
            raise Failure("encode refused the file but left an output")
        if str(code) not in expected and (expected_codes(loads, path) or not malformed):
            raise Failure(f"encode refuses it with {code}: {said[-400:]}")
        return "refused"
    if expected:
        raise Failure("loads, but is listed in expected_refusals.txt")
    if malformed and not expected_codes(loads, path):
        raise Failure("loads, but is malformed and not listed in expected_loads.txt")
    if source.suffix in (".glb", ".gltf") and not malformed:
        found = differences(source, encoded)
        if found:
            raise Failure("encode changes what it must not change: " + "; ".join(found)[:400])
    must("validate", options.psplit, "validate", "-q", "-j", 1, encoded)
    must("decode", options.psplit, "decode", "-q", "-j", 1, encoded, decoded)
    if lossless:
        expanded, by_draco = folder / "expanded.glb", folder / "by-draco.glb"
        must("decode --backend draco", options.psplit, "decode", "-q", "-j", 1, "--backend", "draco", encoded, by_draco)
        if decoded.read_bytes() != by_draco.read_bytes():
            raise Failure("libdraco decodes the expanded patches to other bytes")
        must("expand", options.psplit, "expand", "-q", "-j", 1, encoded, expanded)
        must("validate", options.psplit, "validate", "-q", "-j", 1, expanded)
    if malformed:
        return "loaded"
    must("same_mesh", options.same_mesh, *(["--lossless"] if lossless else []), source, decoded)
    exactly = ["--tolerance", 0]
    for pair in ([source, encoded] + (exactly if lossless else []), [encoded, decoded] + exactly):
        code, said = run("diff", options.psplit, "diff", "-q", "-j", 1, *pair)
        if code != 0 and not (code == 5 and "in a buffer without a uri" in said):
            raise Failure(f"diff exits with {code}: {said[-400:]}")
    if options.validator and not lossless:
        known = ["--like", source] if source.suffix in (".glb", ".gltf") else []
        known += [word for code in expected_codes(errors, path) for word in ("--allow", code)]
        must("gltf-validator", "node", options.validator / "validate.mjs", *known, encoded, decoded)
    return "equal"


def kind(path):
    return pathlib.Path(path.stem if path.suffix == ".gz" else path.name).suffix.lower()


def size_of(file):
    if file.suffix != ".gltf":
        return file.stat().st_size
    return sum(other.stat().st_size for other in file.parent.iterdir() if other.is_file())


def check(file):
    path = file.relative_to(options.corpus).as_posix()
    malformed = path.startswith("malformed/")
    outcome, stock = None, (None, 0)
    try:
        with tempfile.TemporaryDirectory(prefix="psplit-corpus-") as name:
            folder, source = pathlib.Path(name), file
            if source.suffix == ".gz":
                source = folder / source.stem
                with gzip.open(file) as packed, open(source, "wb") as plain:
                    shutil.copyfileobj(packed, plain)
            if not malformed and not expected_codes(refusals, path):
                stock = decode_stock(source, folder)
            for lossless in (False, True):
                (folder / "out").mkdir()
                outcome = round_trip(path, source, folder / "out", malformed, lossless, stock[0] is not None)
                shutil.rmtree(folder / "out")
                if outcome == "refused" or malformed:
                    break
    except Failure as failure:
        return path, "failed", failure, stock
    return path, outcome, None, stock


if not options.corpus.is_dir():
    print(f"corpus: skipped, {options.corpus} does not exist")
    sys.exit(77)
refusals, loads, errors = map(read_expected, ("expected_refusals.txt", "expected_loads.txt", "expected_errors.txt"))
root = options.corpus / "malformed" if options.malformed else options.corpus
files = [p for p in root.rglob("*") if p.is_file() and kind(p) in kLoadable and options.only in str(p)
         and options.least <= size_of(p) < options.below]
files.sort(key=lambda p: (-size_of(p), p))
outcomes = {}
stock_files = {"glTF": 0, ".drc": 0, "older .drc": 0}
stock_streams = dict(stock_files)
with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
    for path, outcome, failure, (holder, streams) in pool.map(check, files):
        outcomes[outcome] = outcomes.get(outcome, 0) + 1
        if holder:
            stock_files[holder] += 1
            stock_streams[holder] += streams
        if failure:
            print(f"FAILED  {path}: {failure}", flush=True)
print("corpus: " + (", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items())) or "nothing to do"))
if any(stock_files.values()):
    print(f"stock Draco: {stock_streams['glTF']} streams in {stock_files['glTF']} glTF assets, and {stock_files['.drc']} "
          f".drc files, decode to the same bytes with both backends; libdraco alone decodes {stock_files['older .drc']} "
          ".drc files before 2.2")
sys.exit(1 if "failed" in outcomes or not files else 0)
