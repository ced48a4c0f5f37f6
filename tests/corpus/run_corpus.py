#!/usr/bin/env python3
"""Every file of the corpus through the command: encode, validate, decode, compare; or a clean refusal.

run_corpus.py GLTF_PSPLIT SAME_MESH CORPUS
Exits 77 (skipped) when there is no corpus. Files that are refused must be named in expected_refusals.txt.
"""
import concurrent.futures, gzip, pathlib, shutil, subprocess, sys, tempfile

psplit, same_mesh, corpus = sys.argv[1], sys.argv[2], pathlib.Path(sys.argv[3])
LOADABLE = {".gltf", ".glb", ".ply", ".obj", ".stl", ".drc"}
REFUSED = {2: "I/O", 3: "invalid", 5: "unsupported"}

if not corpus.is_dir():
    print(f"corpus: skipped, there is none at {corpus}")
    sys.exit(77)

refusals = {}
for line in (pathlib.Path(__file__).parent / "expected_refusals.txt").read_text().splitlines():
    if line.strip() and not line.startswith("#"):
        name, code, reason = line.split(maxsplit=2)
        refusals[name] = (int(code), reason)

def run(*command):
    return subprocess.run([str(c) for c in command], capture_output=True, text=True, errors="replace", timeout=300)

def unpacked(path, folder):
    if path.suffix != ".gz": return path
    out = folder / path.stem
    with gzip.open(path) as source, open(out, "wb") as target: shutil.copyfileobj(source, target)
    return out

def loads(path):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        source = unpacked(path, folder)
        relative = path.relative_to(corpus).as_posix()
        for options in ([], ["--lossless"]):
            patched, plain = folder / "patched.glb", folder / "plain.glb"
            encoded = run(psplit, "encode", source, patched, "--keep-duplicates", "--patch-faces", "1200", "-j", "1", *options)
            if encoded.returncode in REFUSED and not patched.exists() and encoded.stderr.strip():
                if refusals.get(relative, (None,))[0] == encoded.returncode: return None
                return f"refused ({encoded.returncode}): {encoded.stderr.strip()[-300:]}"
            for step in (encoded, run(psplit, "validate", patched), run(psplit, "decode", patched, plain),
                         run(same_mesh, source, plain, *options)):
                if step.returncode != 0:
                    return f"{' '.join(step.args[:2])} {options} exits {step.returncode}: {(step.stderr + step.stdout).strip()[-300:]}"
        if relative in refusals: return "loads, but expected_refusals.txt says it does not"
        return None

def refuses_or_loads(path):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        out = folder / "out.glb"
        step = run(psplit, "encode", unpacked(path, folder), out)
        if step.returncode == 0 and out.exists(): return None
        if step.returncode in REFUSED and step.stderr.strip() and not out.exists(): return None
        return f"exits {step.returncode}: {step.stderr.strip()[-300:]}"

def kind(path):
    return pathlib.Path(path.stem if path.suffix == ".gz" else path.name).suffix.lower()

def guarded(check, path):
    try:
        return path, check(path)
    except subprocess.TimeoutExpired as error:
        return path, f"takes longer than {error.timeout} s"

files = sorted(p for p in corpus.rglob("*") if p.is_file() and kind(p) in LOADABLE)
tasks = [(refuses_or_loads if p.relative_to(corpus).parts[0] == "malformed" else loads, p) for p in files]
tasks.sort(key=lambda task: -task[1].stat().st_size)
failed = 0
with concurrent.futures.ThreadPoolExecutor(2) as pool:
    for path, problem in pool.map(lambda task: guarded(*task), tasks):
        if problem:
            failed += 1
            print(f"FAILED {path.relative_to(corpus).as_posix()}: {problem}")
print(f"{len(tasks) - failed} passed, {failed} failed")
sys.exit(1 if failed or not tasks else 0)
