#!/usr/bin/env python3
"""Runs batch and contrib/aws-batch against an S3 server, and checks contrib/kubernetes/job.yaml:  s3_test.py GLTF_PSPLIT

The server and the schema of Kubernetes are npm packages (package.json), which are installed into build/batch. --fetch and --store
are curl, which signs requests; run-shard runs with the AWS command line itself, if it is installed."""
import json, os, pathlib, re, shlex, shutil, subprocess, sys, tempfile, time

program = pathlib.Path(sys.argv[1]).resolve()
here = pathlib.Path(__file__).resolve().parent
root = here.parents[1]
packages = root / "build/batch"
folder = pathlib.Path(tempfile.mkdtemp(prefix="psplit-s3-"))
environment = {**os.environ, "AWS_ACCESS_KEY_ID": "S3RVER", "AWS_SECRET_ACCESS_KEY": "S3RVER", "AWS_DEFAULT_REGION": "us-east-1",
               "PATH": f"{folder}/bin:{os.environ['PATH']}"}


def skip(why):
    print("skipped:", why)
    sys.exit(0)


def install():
    packages.mkdir(parents=True, exist_ok=True)
    wanted = (here / "package.json").read_text()
    for file in ("s3_server.mjs", "check_job.mjs"):
        shutil.copy(here / file, packages)
    mark = packages / "installed.json"
    if mark.exists() and mark.read_text() == wanted:
        return
    (packages / "package.json").write_text(wanted)
    try:
        done = subprocess.run(["npm", "install", "--no-package-lock", "--no-audit", "--no-fund", "--loglevel=error"], cwd=packages,
                              timeout=120, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    except (FileNotFoundError, subprocess.TimeoutExpired) as error:
        skip(f"npm install: {error}")
    if done.returncode != 0:
        skip(f"npm cannot install the packages of tests/batch: {done.stdout.strip()[-300:]}")
    mark.write_text(wanted)


def run(*words, expect=0, **variables):
    """What the command prints to stdout. Messages of the commands that it starts would cut its lines there."""
    done = subprocess.run([str(word) for word in words], cwd=folder, text=True, env={**environment, **variables},
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert done.returncode == expect, f"{words}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def outputs(place):
    return {file.name: file.read_bytes() for file in sorted(place.glob("*.glb"))}


def batch(*words, expect=0):
    """The status of each asset, by input."""
    rows = run(program, "batch", "--manifest", "plan.jsonl", "--out-dir", "records", "--quiet", "--progress", "json", "-j", 4, *words,
               expect=expect).splitlines()
    return {row["input"]: row["status"] for row in map(json.loads, filter(lambda line: line.startswith("{"), rows))}


def counts(statuses):
    return {status: list(statuses.values()).count(status) for status in set(statuses.values())}


def test_commands(port):
    """curl in place of the client of a storage."""
    url = f"http://127.0.0.1:{port}/bucket"
    curl = ("curl -sS --fail --aws-sigv4 aws:amz:us-east-1:s3 --user S3RVER:S3RVER -H x-amz-content-sha256:UNSIGNED-PAYLOAD")
    for file in sorted((folder / "in").iterdir()):
        run(*shlex.split(curl), "-T", file, f"{url}/in/{file.name}")
    lines = [{"input": f"in/{file.name}", "name": f"x/{file.name}", "bytes": file.stat().st_size, "version": "1"}
             for file in sorted((folder / "in").iterdir())]
    (folder / "plan.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    fetch = ["--fetch", f'{curl} -o "$2" {url}/"$1"']
    store = ["--store", f'{curl} -T "$1" {url}/out/"$2"']
    back = ["--fetch-output", f'{curl} -o "$2" {url}/out/"$1"']
    assert counts(batch(*fetch, *store)) == {"encoded": len(lines)}
    assert counts(batch(*fetch, *store)) == {"up to date": len(lines)}
    (folder / "back").mkdir()
    for line in lines:
        run(*shlex.split(curl), "-o", f"back/{pathlib.Path(line['name']).name}", f"{url}/out/{line['name']}")
    assert outputs(folder / "back") == outputs(folder / "one"), "other bytes than those of local files"

    # An object that changed, one that was removed, and an input that is gone.
    (folder / "damaged").write_text("damaged")
    run(*shlex.split(curl), "-T", "damaged", f"{url}/out/x/0.glb")
    run(*shlex.split(curl), "-X", "DELETE", f"{url}/out/x/1.glb")
    assert counts(batch(*fetch, *store)) == {"up to date": len(lines)}, "without --fetch-output the storage is not read"
    found = batch(*fetch, *store, *back)
    assert {name for name, status in found.items() if status == "encoded"} == {"in/0.glb", "in/1.glb"}, found
    assert counts(batch(*fetch, *store, *back)) == {"up to date": len(lines)}
    run(*shlex.split(curl), "-X", "DELETE", f"{url}/in/0.glb")
    found = batch(*fetch, *store, "--force", expect=75)
    assert [name for name, status in found.items() if status == "failed"] == ["in/0.glb"], found
    run(*shlex.split(curl), "-T", "in/0.glb", f"{url}/in/0.glb")
    # A server that is away.
    found = batch(*(word.replace(str(port), "9") for word in fetch), *store, "--force", expect=75)
    assert counts(found) == {"failed": len(lines)}, found


def test_aws_batch(port):
    """The commands of contrib/aws-batch/README.md and run-shard, with the AWS command line."""
    aws = shutil.which("aws", path=os.environ["PATH"])
    if aws is None or shutil.which("jq") is None:
        print("skipped: run-shard on the S3 server needs the commands aws and jq")
        return
    (folder / "bin/aws").write_text(f'#!/bin/sh\nexec {aws} --endpoint-url http://127.0.0.1:{port} "$@"\n')
    (folder / "bin/aws").chmod(0o755)
    os.symlink(program, folder / "bin/gltf-psplit")
    for file in sorted((folder / "in").iterdir()):
        run("aws", "s3", "cp", "--only-show-errors", file, f"s3://bucket/assets/{file.name}")
    page = (root / "contrib/aws-batch/README.md").read_text()
    plan = re.search(r"^aws s3api .*?[^|]\n(?=\n)", page, re.M | re.S)[0]
    merge = re.search(r"^aws s3 cp --recursive .*?^gltf-psplit batch merge [^\n]*\n", page, re.M | re.S)[0]
    definition = json.loads((root / "contrib/aws-batch/job-definition.json").read_text())["containerProperties"]["command"]
    words = [word.replace("Ref::plan", "s3://bucket/plan.jsonl").replace("Ref::out", "s3://bucket/out") for word in definition]

    def array(size):
        run("sh", "-ec", plan.replace("BUCKET", "bucket"))
        for index in range(size):
            run(root / "contrib/aws-batch/run-shard", *words, AWS_BATCH_JOB_ARRAY_INDEX=str(index), AWS_BATCH_JOB_ARRAY_SIZE=str(size))
        shutil.rmtree(folder / "out", ignore_errors=True)
        run("sh", "-ec", merge.replace("BUCKET", "bucket"))
        report = json.loads((folder / "report.json").read_text())
        assert not report["shards"]["unfinished"] and report["failed"] == 0, report
        return report["encoded"], report["up_to_date"]

    assets = len(list((folder / "in").iterdir()))
    assert array(2) == (assets, 0)
    run("aws", "s3", "cp", "--only-show-errors", "--recursive", "s3://bucket/out/", "aws-out")
    assert outputs(folder / "aws-out") == outputs(folder / "one")
    # Another object with another ETag, and another count of shards.
    run(program, "generate", "other.glb", "--faces", 500, "--seed", 99, "-q")
    run("aws", "s3", "cp", "--only-show-errors", "other.glb", "s3://bucket/assets/0.glb")
    assert array(3) == (1, assets - 1)

    # The words of the AWS command line for a missing object, and for a server that is away.
    shard = {"AWS_BATCH_JOB_ARRAY_INDEX": "0", "AWS_BATCH_JOB_ARRAY_SIZE": "3", "AWS_MAX_ATTEMPTS": "1"}
    run_shard = root / "contrib/aws-batch/run-shard"
    run(run_shard, "s3://bucket/no-plan.jsonl", "s3://bucket/out", expect=2, **shard)
    run(run_shard, "s3://bucket/plan.jsonl", "s3://no-bucket/out", expect=2, **shard)
    (folder / "bin/aws").write_text(f'#!/bin/sh\nexec {aws} --endpoint-url http://127.0.0.1:9 "$@"\n')
    run(run_shard, *words, expect=75, **shard)


server = None
begin = time.monotonic()
try:
    install()
    run("node", packages / "check_job.mjs", root / "contrib/kubernetes/job.yaml", root / "contrib/kubernetes/pod.yaml")
    for name in ("bin", "in", "data"):
        (folder / name).mkdir()
    for i in range(4):
        run(program, "generate", f"in/{i}.glb", "--faces", 500, "--seed", i, "-q")
    run(program, "batch", "in/*.glb", "-o", "one", "-q", "--report", "one.json")
    server = subprocess.Popen(["node", packages / "s3_server.mjs", folder / "data"], stdout=subprocess.PIPE, text=True)
    port = int(server.stdout.readline())
    test_commands(port)
    test_aws_batch(port)
    print(f"S3: all is well, in {time.monotonic() - begin:.0f} s")
finally:
    if server is not None:
        server.terminate()
        server.wait()
    shutil.rmtree(folder, ignore_errors=True)
