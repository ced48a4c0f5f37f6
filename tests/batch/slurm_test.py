#!/usr/bin/env python3
"""Runs contrib/slurm on Slurm itself:  slurm_test.py GLTF_PSPLIT

Starts slurmctld and slurmd on this machine for the time of the test, without munge, systemd and cgroups. An array of 8 tasks
encodes small assets. At first one task is killed, one asset hangs and one runs out of memory; their tasks are queued again by
their exit codes. The output must be byte for byte that of a single run, and further arrays, also with another number of tasks,
must find everything done. At last a task is cancelled. Needs root and Debian's slurm-wlm."""
import json, os, pathlib, random, re, shutil, signal, socket, subprocess, sys, tempfile, time

program = pathlib.Path(sys.argv[1]).resolve()
root = pathlib.Path(__file__).resolve().parents[2]
missing = [tool for tool in ("slurmctld", "slurmd", "sbatch", "squeue", "scontrol") if shutil.which(tool) is None]
if missing or os.geteuid() != 0:
    print("skipped:", f"Slurm is not installed ({', '.join(missing)} missing)" if missing else "slurmd needs root")
    sys.exit(0)

folder = pathlib.Path(tempfile.mkdtemp(prefix="psplit-slurm-"))
os.chmod(folder, 0o755)
host = socket.gethostname().split(".")[0]
port = random.randrange(20000, 30000, 2)
(folder / "slurm.conf").write_text(f"""
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
SlurmctldPort={port}
SlurmdPort={port + 1}
AuthType=auth/none
CredType=cred/none
AuthInfo=cred_expire=5
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
SchedulerParameters=sched_interval=1,sched_min_interval=0
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
ReturnToService=2
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
NodeName={host} NodeAddr=127.0.0.1 CPUs=8 RealMemory=1000 State=UNKNOWN
PartitionName=test Nodes={host} Default=YES MaxTime=10 State=UP
""")
for name in ("state", "spool", "bin", "in", "log"):
    (folder / name).mkdir()
# At its first start, a task is on a node with little memory.
(folder / "bin/gltf-psplit").write_text(f"""#!/bin/sh
[ -n "$SLURM_RESTART_COUNT" ] || [ "$UNLIMITED" = 1 ] || ulimit -v 70000
exec {program} "$@"
""")
(folder / "bin/gltf-psplit").chmod(0o755)
environment = {**os.environ, "SLURM_CONF": str(folder / "slurm.conf"), "PATH": f"{folder}/bin:{os.environ['PATH']}"}
daemons = []


def run(*words, **options):
    done = subprocess.run([str(word) for word in words], cwd=folder, env={**environment, **options}, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, words))} exits with {done.returncode}:\n{done.stdout}")
    return done.stdout


def wait_until(what, holds, seconds=80):
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            raise SystemExit(f"{what}: not within {seconds} s\n{run('squeue', '-r')}\n" + logs())
        time.sleep(0.1)


def logs():
    return "\n".join(f"{file.name}:\n{file.read_text()[-2000:]}" for file in [folder / "slurmctld.log", folder / "slurmd.log",
                                                                             *sorted((folder / "log").iterdir())])


def submit(tasks, **options):
    """The number of the job."""
    return run("sbatch", "--parsable", f"--array=0-{tasks - 1}", "--output=log/%A_%a", root / "contrib/slurm/batch.sbatch",
               PLAN="plan.jsonl", OUT="out", PSPLIT_OPTIONS="--timeout 15", **options).strip()


def states(job):
    """The state and the restarts of each task of an array."""
    found = {}
    for line in run("scontrol", "--oneliner", "show", "job", job).splitlines():
        fields = dict(word.split("=", 1) for word in line.split() if "=" in word)
        found[fields["ArrayTaskId"]] = (fields["JobState"], int(fields["Restarts"]))
    return found


def finish(job):
    wait_until(f"array {job} ends", lambda: not run("squeue", "-h", "-r", "-j", job).strip())
    ended = states(job)
    wrong = {task: state for task, state in ended.items() if state[0] != "COMPLETED"}
    if wrong:
        raise SystemExit(f"array {job}: {wrong}\n" + logs())
    return ended


def files():
    found = sorted(file for file in (folder / "out").rglob("*") if file.is_file() and ".gltf-psplit-batch" not in file.parts)
    return {str(file.relative_to(folder / "out")): (file.read_bytes(), file.stat().st_mtime_ns) for file in found}


def shards_of(name):
    """The output is in this shard, found by a dry run."""
    for shard in range(8):
        rows = run(program, "batch", "--manifest", "plan.jsonl", "--out-dir", "nowhere", "--dry-run", "--progress", "json",
                   "--quiet", "--shard", f"{shard}/8", "--memory", "100GB")
        if any(json.loads(row)["input"] == f"in/{name}" for row in rows.splitlines()):
            return str(shard)


def test():
    for i in range(40):
        run(program, "generate", f"in/{i}.glb", "--faces", 500, "--seed", i, "-q")
    run(program, "generate", "in/large.glb", "--faces", "800k", "-q")
    run(program, "generate", "hang.glb", "--faces", 500, "--seed", 99, "-q")
    shutil.copy(folder / "hang.glb", folder / "in/hang.glb")
    run(program, "batch", "in/*.glb", "--out-dir", "one", "-q", "--report", "one.json")
    run(program, "batch", "plan", "in/*.glb", "--out-dir", "out", "-o", "plan.jsonl", "-q")
    hanging, large = shards_of("hang.glb"), shards_of("large.glb")
    # The command of a third task is killed. It waits for one of its inputs until then, or it might end too early.
    held, killed = next((name, shard) for name, shard in ((f"{i}.glb", shards_of(f"{i}.glb")) for i in range(40))
                        if shard not in (hanging, large))

    for command in (["slurmctld", "-D", "-i"], ["slurmd", "-D", "-d", shutil.which("slurmstepd") or "/usr/sbin/slurmstepd"]):
        daemons.append(subprocess.Popen(command, cwd=folder, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
    wait_until("the node is idle", lambda: "idle" in subprocess.run(["sinfo", "-h", "-o", "%T"], env=environment, text=True,
                                                                   stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout)
    # A pipe that nobody writes to.
    (folder / "in/hang.glb").unlink()
    os.mkfifo(folder / "in/hang.glb")
    (folder / "in" / held).rename(folder / "held.glb")
    os.mkfifo(folder / "in" / held)
    job = submit(8)
    pid = kill_command_of(killed)
    (folder / "held.glb").replace(folder / "in" / held)
    wait_until("the hanging asset's task is queued again", lambda: states(job).get(hanging, ("", 0))[1] > 0)
    (folder / "in/hang.glb").unlink()
    shutil.copy(folder / "hang.glb", folder / "in/hang.glb")
    ended = finish(job)
    for task in {hanging, large, killed}:
        assert ended[task][1] > 0, f"task {task} was not queued again: {ended}"
    # The place in the file is named where one is at work when the memory ends.
    for task, cause in ((hanging, "hang.glb: took longer"), (large, "large.glb: (mesh 0.*: )?out of memory"), (killed, "exit code 137")):
        assert re.search(cause, (folder / f"log/{job}_{task}").read_text()), logs()
    print(f"tasks queued again: {hanging} (an asset hung), {large} (out of memory), {killed} (process {pid} killed)")

    first = files()
    single = {name: (folder / "one" / name).read_bytes() for name in first}
    assert len(first) == 42 and {name: data for name, (data, _) in first.items()} == single, "other bytes than a single run's"
    left = [file for file in (folder / "out").rglob("*") if file.name.endswith(".part") or "-staged-" in file.name]
    assert not left, f"left behind: {left}"
    print("42 outputs are byte for byte those of a single run")
    for tasks in (8, 5):
        finish(submit(tasks, UNLIMITED="1"))
        assert files() == first, f"an array of {tasks} tasks wrote again"
        run(program, "batch", "merge", "out", "--report", "merged.json", "-q")
        report = json.loads((folder / "merged.json").read_text())
        assert (report["up_to_date"], report["encoded"], report["failed"]) == (42, 0, 0), report
        print(f"a further array of {tasks} tasks does nothing")

    # scancel sends SIGTERM, and SIGKILL after 30 seconds.
    (folder / "in/hang.glb").unlink()
    os.mkfifo(folder / "in/hang.glb")
    job = submit(1, UNLIMITED="1")
    wait_until("the task is at work", lambda: (folder / "out/.gltf-psplit-batch/0-of-1.report.jsonl").exists())
    begin = time.monotonic()
    run("scancel", job)
    wait_until("the task is cancelled", lambda: not run("squeue", "-h", "-r", "-j", job).strip(), 25)
    assert states(job) == {"0": ("CANCELLED", 0)}, states(job)
    assert "stopped by a signal" in (folder / f"log/{job}_0").read_text(), logs()
    assert {name: data for name, (data, _) in files().items()} == single
    print(f"a cancelled task has ended after {time.monotonic() - begin:.0f} s")


def kill_command_of(shard):
    """Kills the gltf-psplit of a task, as an operator or the system might."""
    end = time.monotonic() + 30
    while time.monotonic() < end:
        for entry in pathlib.Path("/proc").iterdir():
            try:
                if not entry.name.isdigit() or os.readlink(entry / "exe") != str(program):
                    continue
                parent = (entry / "stat").read_text().rsplit(")", 1)[1].split()[1]
                if os.readlink(f"/proc/{parent}/exe") == str(program):
                    continue  # the worker, which would be replaced
                settings = (entry / "environ").read_bytes().split(b"\0")
                if f"SLURM_ARRAY_TASK_ID={shard}".encode() in settings and f"SLURM_CONF={folder}/slurm.conf".encode() in settings:
                    os.kill(int(entry.name), signal.SIGKILL)
                    return entry.name
            except (FileNotFoundError, ProcessLookupError, PermissionError):
                continue
    raise SystemExit("no task to kill\n" + logs())


def end_late(*_):
    raise SystemExit(f"Slurm: not done within {kLimit} s\n" + logs())


kLimit = 300
begin = time.monotonic()
signal.signal(signal.SIGALRM, end_late)
signal.alarm(kLimit)
try:
    test()
    print(f"Slurm: all is well, in {time.monotonic() - begin:.0f} s")
finally:
    for daemon in reversed(daemons):
        daemon.terminate()
    for daemon in daemons:
        try:
            daemon.wait(10)
        except subprocess.TimeoutExpired:
            daemon.kill()
            daemon.wait()
    shutil.rmtree(folder, ignore_errors=True)
