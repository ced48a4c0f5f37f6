#!/usr/bin/env python3
"""What the GitHub Action psplit-encode runs, with an archive of a release that is made of the command:
action_test.py SOURCE COMMAND"""
import hashlib, os, pathlib, platform, re, subprocess, sys, tarfile, tempfile

source, command = pathlib.Path(sys.argv[1]), sys.argv[2]
with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    archive = folder / f"gltf-psplit-7.8.9-linux-{platform.machine()}.tar.gz"
    with tarfile.open(archive, "w:gz") as packed:
        packed.add(command, "gltf-psplit-7.8.9/bin/gltf-psplit")
    sums = folder / "SHA256SUMS"
    sums.write_text(f"{hashlib.sha256(archive.read_bytes()).hexdigest()}  {archive.name}\n{'0' * 64}  another.tar.gz\n")
    (folder / "assets/inner").mkdir(parents=True)
    for asset in ("blob.glb", "inner/other.glb"):
        subprocess.run([command, "generate", "-q", folder / "assets" / asset, "--shape", "blob", "--faces", "3000"], check=True)
    # GitHub may keep the action in a folder whose name has spaces.
    action = folder / "an action"
    action.symlink_to(source / ".github/actions/psplit-encode")
    step = re.search(r"^      run: '(.*)'$", (action / "action.yml").read_text(), re.M).group(1)
    environment = {**os.environ, "GITHUB_ACTION_PATH": str(action), "PSPLIT_ARCHIVES": name,
                   "PSPLIT_FILES": "assets/inner assets/*.glb", "PSPLIT_OUT": "out", "PSPLIT_OPTIONS": "--profile speed --threads 1", "RUNNER_TEMP": name}
    run = lambda: subprocess.run(["bash", "-c", step], cwd=folder, env=environment, capture_output=True, text=True)
    done = run()
    encoded = sorted(path.name for path in (folder / "out").rglob("*.glb"))
    if done.returncode != 0 or encoded != ["blob.glb", "other.glb"] or "\"encoded\"" not in (folder / "psplit-encode.json").read_text():
        sys.exit(f"exits with {done.returncode}, encoded {encoded}: {done.stdout}{done.stderr}")
    # A file that is not what the checksums say is not run.
    sums.write_text(sums.read_text().replace(sums.read_text()[:8], "00000000"))
    done = run()
    if done.returncode == 0 or "FAILED" not in done.stdout + done.stderr:
        sys.exit(f"a wrong checksum: exits with {done.returncode}: {done.stdout}{done.stderr}")
print(f"the action encodes {encoded}")
