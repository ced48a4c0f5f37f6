#!/usr/bin/env python3
"""Runs what contrib/kubernetes and contrib/aws-batch run, without their engines:  contrib_test.py GLTF_PSPLIT

The environment of a task comes from this script. In place of S3 there is a folder, and in place of the AWS command line a script
with its `s3 cp`."""
import json, os, pathlib, re, shutil, subprocess, sys, tempfile

program = pathlib.Path(sys.argv[1]).resolve()
contrib = pathlib.Path(__file__).resolve().parents[2] / "contrib"
folder = pathlib.Path(tempfile.mkdtemp(prefix="psplit-contrib-"))
os.symlink(program, folder / "gltf-psplit")
path = f"{folder}:{os.environ['PATH']}"

# Only what run-shard uses: files and, with --recursive, folders, from and to s3://.
(folder / "aws").write_text(f"""#!/usr/bin/env python3
import fnmatch, pathlib, shutil, sys
words = sys.argv[1:]
assert words.pop(0) == "s3" and words.pop(0) == "cp", sys.argv
options = {{"--only-show-errors": 0, "--recursive": 0, "--exclude": 1, "--include": 1}}
given, filters, places = set(), [], []
while words:
    word = words.pop(0)
    if word in options:
        given.add(word)
        value = words.pop(0) if options[word] else ""
        if value:
            filters.append((word == "--include", value))
    else:
        places.append(pathlib.Path(word.replace("s3://", "{folder}/s3/")))
source, target = places
if "--recursive" not in given and not source.exists():
    sys.exit(f"fatal error: An error occurred (404) when calling the HeadObject operation: Key {{source}} does not exist")
if (answer := pathlib.Path("{folder}/answer")).exists():
    print(answer.read_text(), file=sys.stderr)
    sys.exit(1)
for file in sorted(source.rglob("*")) if "--recursive" in given else [source]:
    chosen = [True] + [included for included, pattern in filters if fnmatch.fnmatch(file.name, pattern)]  # the last one counts
    if file.is_dir() or not chosen[-1]:
        continue
    to = target / file.relative_to(source) if "--recursive" in given else target
    to.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, to)
""")
(folder / "aws").chmod(0o755)


def run(*words, expect=0, cwd=folder, **variables):
    done = subprocess.run([str(word) for word in words], cwd=cwd, text=True, env={**os.environ, "PATH": path, **variables},
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    assert done.returncode == expect, f"{words}: {done.returncode}\n{done.stdout}"
    return done.stdout


def outputs(place):
    return {file.name: file.read_bytes() for file in sorted(place.glob("*.glb"))}


def test_kubernetes():
    text = (contrib / "kubernetes/job.yaml").read_text()
    arguments = re.findall(r"^            - (\S+)$", text, re.M)
    count = int(re.search(r"completions: (\d+)", text)[1])
    assert f"--shard=auto/{count}" in arguments, arguments
    run(program, "batch", "plan", "in/*.glb", "--out-dir", "out", "-o", "plan.jsonl", "-q")
    for index in range(count):
        run(program, *arguments, JOB_COMPLETION_INDEX=str(index))
    run(program, "batch", "merge", "out", "--report", "report.json", "-q")
    report = json.loads((folder / "report.json").read_text())
    assert report["encoded"] == 6 and report["shards"] == {"count": count, "unfinished": [], "running": [], "failed": []}, report
    assert outputs(folder / "out") == outputs(folder / "one")


# What containers run is an ordinary user's, in the image and in the pods.
def test_users():
    final = (contrib / "Dockerfile").read_text().split("\nFROM ")[-1]
    user = re.search(r"^USER (\d+):(\d+)$", final, re.M)
    assert user and int(user[1]) > 0, final
    for name in ("job.yaml", "pod.yaml"):
        assert f"runAsNonRoot: true, runAsUser: {user[1]}" in (contrib / "kubernetes" / name).read_text(), name


def test_aws_batch():
    definition = json.loads((contrib / "aws-batch/job-definition.json").read_text())
    words = [word.replace("Ref::plan", "s3://bucket/plan.jsonl").replace("Ref::out", "s3://bucket/out")
             for word in definition["containerProperties"]["command"]]
    bucket = folder / "s3/bucket"
    shutil.copytree(folder / "in", bucket / "assets")
    (bucket / "out/.gltf-psplit-batch").mkdir(parents=True)
    items = [{"input": f"s3://bucket/assets/{file.name}", "name": file.name, "bytes": file.stat().st_size, "version": "1"}
             for file in sorted((bucket / "assets").iterdir())]
    (bucket / "plan.jsonl").write_text("".join(json.dumps(item) + "\n" for item in items))

    def array(size, attempt):
        for index in range(size):
            run(contrib / "aws-batch/run-shard", *words, AWS_BATCH_JOB_ARRAY_INDEX=str(index), AWS_BATCH_JOB_ARRAY_SIZE=str(size))
        assert outputs(bucket / "out") == outputs(folder / "one")
        merged = folder / f"merged{attempt}"
        shutil.copytree(bucket / "out/.gltf-psplit-batch", merged / ".gltf-psplit-batch")
        run(program, "batch", "merge", merged, "--report", "report.json", "-q")
        report = json.loads((folder / "report.json").read_text())
        assert not report["shards"]["unfinished"], report
        return report["encoded"], report["up_to_date"]

    assert array(3, 1) == (6, 0)
    assert array(3, 2) == (0, 6)
    assert array(2, 3) == (0, 6)
    items[0]["version"] = "2"
    (bucket / "plan.jsonl").write_text("".join(json.dumps(item) + "\n" for item in items))
    assert array(3, 4) == (1, 5)

    # An OBJ comes with its material and texture, and both decide whether it is up to date.
    places = [("obj/cube.obj", b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"),
              ("obj/m.mtl", b"newmtl m\nmap_Kd tex/t.png\n"), ("obj/tex/t.png", b"\x89PNG\r\n\x1a\n first")]
    for name, content in places:
        (bucket / name).parent.mkdir(parents=True, exist_ok=True)
        (bucket / name).write_bytes(content)
    line = {"input": "s3://bucket/obj/cube.obj", "name": "obj/cube.glb", "version": "1"}
    (bucket / "objects.jsonl").write_text(json.dumps(line) + "\n")
    for texture, counts in {"first": "1 encoded, 0 up to date", "second": "1 encoded, 0 up to date",
                            "again": "0 encoded, 1 up to date"}.items():
        if texture == "second":
            (bucket / "obj/tex/t.png").write_bytes(b"\x89PNG\r\n\x1a\n second")
        printed = run(contrib / "aws-batch/run-shard", "s3://bucket/objects.jsonl", "s3://bucket/out-obj", *words[2:],
                      AWS_BATCH_JOB_ARRAY_INDEX="0", AWS_BATCH_JOB_ARRAY_SIZE="1")
        assert "shard 0/1 of " in printed and counts in printed and printed.count("\n") == 1, printed
    assert b"second" in (bucket / "out-obj/obj/cube.glb").read_bytes()
    assert definition["timeout"]["attemptDurationSeconds"] >= 600, definition

    # What S3 refuses is permanent; what it may answer later is not.
    for answer, code in {"fatal error: An error occurred (404) when calling the HeadObject operation: Key is missing": 2,
                         "upload failed: An error occurred (AccessDenied) when calling the PutObject operation": 2,
                         "fatal error: An error occurred (SlowDown) when calling the PutObject operation": 75,
                         "a(404).glb: Could not connect to the endpoint URL": 75}.items():
        (folder / "answer").write_text(answer)
        printed = run(contrib / "aws-batch/run-shard", *words, expect=code, AWS_BATCH_JOB_ARRAY_INDEX="0",
                      AWS_BATCH_JOB_ARRAY_SIZE="1")
        assert answer in printed, printed
    (folder / "answer").unlink()
    # An input is gone: that is permanent, and the other assets are done.
    (bucket / "assets/0.glb").unlink()
    shutil.rmtree(bucket / "out")
    (bucket / "out/.gltf-psplit-batch").mkdir(parents=True)
    printed = run(contrib / "aws-batch/run-shard", *words, expect=2, AWS_BATCH_JOB_ARRAY_INDEX="0", AWS_BATCH_JOB_ARRAY_SIZE="1")
    assert "--fetch failed: exit code 66" in printed and len(outputs(bucket / "out")) == 5, printed


try:
    (folder / "in").mkdir()
    for i in range(6):
        run(program, "generate", f"in/{i}.glb", "--faces", 500, "--seed", i, "-q")
    run(program, "batch", "in/*.glb", "-o", "one", "-q", "--report", "one.json")
    test_users()
    test_kubernetes()
    test_aws_batch()
    print("contrib: all is well")
finally:
    shutil.rmtree(folder, ignore_errors=True)
