#!/usr/bin/env python3
"""The command for Windows writes the bytes that the command of this system writes:

    same_bytes.py HERE THERE.exe FOLDER...

Both encode all assets of the folders by `batch`, decode the results and validate them. What one refuses, the other refuses too,
except that the build for Windows may lack meshoptimizer and libdraco, which decodes older streams."""
import json, os, pathlib, shutil, subprocess, sys, tempfile

KINDS = {".gltf", ".glb", ".ply", ".obj", ".stl", ".off", ".drc"}


def batch(command, work, verb, items):
    """The report of a batch, whose outputs are in a folder of its name."""
    plan = work / f"{verb}.jsonl"
    plan.write_text("".join(json.dumps({"input": str(path), "name": name}) + "\n" for path, name in items))
    report = work / f"{verb}.json"
    subprocess.run(command + ["batch", "--manifest", str(plan), "-o", str(work / verb), "--command", verb, "--report",
                              str(report), "-q"], stderr=subprocess.DEVNULL)
    return json.loads(report.read_text())


def outputs(work, verb):
    folder = work / verb
    return {f.relative_to(folder).as_posix(): f for f in sorted(folder.rglob("*"))
            if f.is_file() and ".gltf-psplit-batch" not in f.parts}


def run(command, work, inputs):
    work.mkdir()
    reports = {"encode": batch(command, work, "encode", inputs)}
    encoded = [(file, name) for name, file in outputs(work, "encode").items()]
    for verb in "decode", "validate":
        reports[verb] = batch(command, work, verb, encoded)
    return reports


here, there, *folders = sys.argv[1:]
inputs = []
for folder in map(pathlib.Path, folders):
    for path in sorted(folder.resolve().rglob("*")):
        if path.suffix.lower() in KINDS:
            inputs.append((path, f"{folder.name}/{path.relative_to(folder.resolve()).as_posix()}.glb"))
wine = shutil.which("wine64") or shutil.which("wine") or "/usr/lib/wine/wine64"
wrong = []
with tempfile.TemporaryDirectory() as folder:
    work = pathlib.Path(folder)
    ours, theirs = run([here], work / "here", inputs), run([wine, there], work / "there", inputs)
    lacking = {os.path.basename(row["input"]) for row in theirs["encode"]["assets"]
               if any(word in row.get("error", {}).get("message", "") for word in ("meshoptimizer", "is older than 2.2"))}
    for verb in "encode", "decode":
        first, second = outputs(work / "here", verb), outputs(work / "there", verb)
        same = {name for name in first if name in second and first[name].read_bytes() == second[name].read_bytes()}
        print(f"{verb}: {len(same)} of {len(first)} files are the same, {sum(first[n].stat().st_size for n in same)} bytes")
        wrong += [f"{verb}: {name} differs" for name in sorted(set(first) | set(second)) if name not in same
                  and os.path.basename(name).removesuffix(".glb") not in lacking]
    for verb in "encode", "decode", "validate":
        print(f"{verb}: {ours[verb]['failed']} and {theirs[verb]['failed']} of {len(ours[verb]['assets'])} assets failed")
    if theirs["validate"]["failed"] != ours["validate"]["failed"]:
        wrong.append("validate: other results")
print("\n".join(wrong) or f"all the same; {len(lacking)} assets need meshoptimizer or libdraco")
sys.exit(1 if wrong else 0)
