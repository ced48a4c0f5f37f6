#!/usr/bin/env python3
"""Every file of a corpus through gltf-psplit:

  run_corpus.py --psplit COMMAND --same-mesh COMMAND --corpus FOLDER [--validator FOLDER] [--only TEXT] [--malformed]

Well-formed files must encode, validate, decode and compare equal (same_mesh), with the default options and with
--lossless, or be refused exactly as expected_refusals.txt says. Files of the malformed folder must load or be
refused: exit code 2, 3 or 5 with a message. --validator names a folder with validate.mjs and its node_modules:
outputs then pass the official validator, errors of the input (glTF's own, or those in expected_errors.txt) aside.

Exits 77 (skipped) where there is no corpus: it is not part of the project.
"""
import argparse, concurrent.futures, fnmatch, gzip, pathlib, shutil, subprocess, sys, tempfile

here = pathlib.Path(__file__).resolve().parent
parser = argparse.ArgumentParser()
parser.add_argument("--psplit", type=pathlib.Path, required=True)
parser.add_argument("--same-mesh", type=pathlib.Path, required=True)
parser.add_argument("--corpus", type=pathlib.Path, required=True)
parser.add_argument("--validator", type=pathlib.Path)
parser.add_argument("--only", default="", help="only paths that contain this")
parser.add_argument("--malformed", action="store_true", help="only the malformed files")
parser.add_argument("--timeout", type=int, default=300, help="seconds that one command may take")
options = parser.parse_args()
kLoadable = {".gltf", ".glb", ".ply", ".obj", ".stl", ".drc", ".off"}


class Failure(Exception):
    pass


def read_expected(name):
    """Lines of: code, path pattern, reason."""
    lines = (here / name).read_text().splitlines()
    fields = (line.split(None, 2) for line in lines if line and not line.startswith("#"))
    return [(code, pattern) for code, pattern, reason in fields]


def expected_codes(table, path):
    return [code for code, pattern in table if fnmatch.fnmatchcase(path, pattern)]


def run(what, *command):
    """Exit code and all that was said; a signal or a time-out is a failure whatever was expected."""
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


def round_trip(path, source, folder, malformed, lossless):
    """What became of the file: "equal", "loaded" (malformed, so there is nothing to compare with) or "refused"."""
    encoded, decoded = folder / "encoded.glb", folder / "decoded.glb"
    code, said = run("encode", options.psplit, "encode", "-q", "-j", 1, "--patch-faces", 1200, *lossless, source, encoded)
    expected = expected_codes(refusals, path)
    if code != 0:
        if not said or code not in (2, 3, 5):
            raise Failure(f"encode exits with {code}: {said[-400:]}")
        if encoded.exists():
            raise Failure("encode refused the file, and left an output")
        if not malformed and str(code) not in expected:
            raise Failure(f"encode refuses it with {code}: {said[-400:]}")
        return "refused"
    if expected and not malformed:
        raise Failure("is listed in expected_refusals.txt, and loads")
    must("validate", options.psplit, "validate", "-q", "-j", 1, encoded)
    must("decode", options.psplit, "decode", "-q", "-j", 1, encoded, decoded)
    if malformed:
        return "loaded"
    must("same_mesh", options.same_mesh, *lossless, source, decoded)
    if options.validator and not lossless:
        known = ["--like", source] if source.suffix in (".glb", ".gltf") else []
        known += [word for code in expected_codes(errors, path) for word in ("--allow", code)]
        must("gltf-validator", "node", options.validator / "validate.mjs", *known, encoded, decoded)
    return "equal"


def kind(path):
    return pathlib.Path(path.stem if path.suffix == ".gz" else path.name).suffix.lower()


def check(file):
    path = file.relative_to(options.corpus).as_posix()
    malformed = path.startswith("malformed/")
    outcome = None
    try:
        with tempfile.TemporaryDirectory(prefix="psplit-corpus-") as name:
            folder, source = pathlib.Path(name), file
            if source.suffix == ".gz":
                source = folder / source.stem
                with gzip.open(file) as packed, open(source, "wb") as plain:
                    shutil.copyfileobj(packed, plain)
            for lossless in ([], ["--lossless"]):
                (folder / "out").mkdir()
                outcome = round_trip(path, source, folder / "out", malformed, lossless)
                shutil.rmtree(folder / "out")
                if outcome == "refused" or malformed:
                    break
    except Failure as failure:
        return path, "failed", failure
    return path, outcome, None


if not options.corpus.is_dir():
    print(f"corpus: skipped, there is none at {options.corpus}")
    sys.exit(77)
refusals, errors = read_expected("expected_refusals.txt"), read_expected("expected_errors.txt")
root = options.corpus / "malformed" if options.malformed else options.corpus
files = [p for p in root.rglob("*") if p.is_file() and kind(p) in kLoadable and options.only in str(p)]
files.sort(key=lambda p: (-p.stat().st_size, p))
outcomes = {}
with concurrent.futures.ThreadPoolExecutor(max_workers=2) as pool:
    for path, outcome, failure in pool.map(check, files):
        outcomes[outcome] = outcomes.get(outcome, 0) + 1
        if failure:
            print(f"FAILED  {path}: {failure}", flush=True)
print("corpus: " + (", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items())) or "nothing to do"))
sys.exit(1 if "failed" in outcomes or not files else 0)
