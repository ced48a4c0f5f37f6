#!/usr/bin/env python3
"""The commands of the pages work:  commands_test.py PSPLIT

Blocks of `sh` in README.md and docs/*.md run line by line, each page in a folder of its own with meshes under the names that the
commands read. Only gltf-psplit runs, and programs that make its inputs (kRun). A block of `text` after one of `sh` has lines of its
output. Of all other programs, of the other pages, and of `code` in sentences the files and the options are looked up: of gltf-psplit
in its help, of scripts in their source, of CMake in CMakeLists.txt.
"""
import os, pathlib, re, shlex, shutil, struct, subprocess, sys, tempfile

from pages import blocks, inline_code, pages, root

psplit = pathlib.Path(sys.argv[1]).resolve()
# Programs that are not ours, whose options nobody looks up here.
kOthers = {"awk", "aws", "blender", "cp", "docker", "draco_decoder", "draco_encoder", "esbuild", "export", "git", "jq", "kubectl", "printf", "python3", "sbatch",
           "sed", "squeue", "zcat"}
# Programs that run.
kRun = {"awk", "gltf-psplit", "printf", "zcat"}
# Blocks that do not run: {page: reason}. Their options are looked up.
kLookedUp = {"docs/benchmarks.md": "benchmarks of many minutes, of meshes that are not here", "docs/web.md": "benchmarks of a browser"}
# Options of inline code that belong to programs not ours: {option: program}.
kForeign = {"--as-needed": "linkers", "--build": "cmake", "--install": "cmake", "--cflags": "pkg-config", "--libs": "pkg-config", "--param": "GCC",
            "--gtest_filter": "GoogleTest", "--system-site-packages": "venv", "--config": "gltf-transform", "--enable-unsafe-webgpu": "Chromium",
            "--use-webgpu-adapter": "Chromium", "--enable-features": "Chromium", "--use-vulkan": "Chromium"}

helps = {}


def help_of(verb):
    if verb not in helps:
        done = subprocess.run([psplit, *filter(None, [verb]), "--help"], capture_output=True, text=True)
        helps[verb] = done.stdout if done.returncode == 0 else None
    return helps[verb]


def options_in(text):
    """The options that a text names, as --option and -o."""
    return set(re.findall(r"(?<![\w-])--?[A-Za-z][\w-]*", text))


def source_of(program):
    """The text of a script, with the modules that it may use."""
    file = root / program
    beside = [*(root / "scripts").glob("*/*.py"), *file.parent.glob("*.mjs"), *(root / "bench/web").glob("*.mjs"), *(root / "tests").glob("*/*.mjs")]
    return "\n".join(path.read_text(encoding="utf-8", errors="replace") for path in [file, *beside])


cmake_text = "\n".join(path.read_text() for path in [root / "CMakeLists.txt", *root.glob("*/CMakeLists.txt"), *root.glob("*/*/CMakeLists.txt"),
                                                     *root.glob("*/*.cmake")])


def simple_commands(line):
    """The programs with their arguments of a line of the shell, without assignments and redirections."""
    lexer = shlex.shlex(line, posix=True, punctuation_chars="();<>|&")
    lexer.whitespace_split, lexer.commenters = True, "#"
    commands, command = [], []
    for word in [*lexer, ";"]:
        if re.fullmatch(r"[();|&]+", word):
            commands.append(command)
            command = []
        elif command or not re.match(r"\w+=", word):
            command.append(word)
    return [command for command in commands if command and command[0]]


def faults_of(words, page):
    """The faults of a command on a page, whose files and options are looked up."""
    while words and (words[0] in ("time", "command", "do") or words[0].startswith("-") or "%" in words[0]):
        words = words[1:]
    if not words or words[0] in ("for", "done"):
        return
    program, rest = words[0], words[1:]
    name = program.rpartition("/")[2]
    options = {re.sub(r"=.*", "", word) for word in rest if re.match(r"--?[A-Za-z]", word)}
    if name == "gltf-psplit":
        plain = [word for word in rest if not word.startswith("-")]
        verb = plain[0] if plain else None
        if verb and re.fullmatch(r"[A-Z]+", verb):
            return
        nested = rest[1] if verb == "batch" and len(rest) > 1 and rest[1] in ("plan", "merge") else None
        text = help_of(verb)
        if text is None:
            yield f"gltf-psplit has no verb {verb}"
            return
        known = options_in(text)
        if nested:
            known |= options_in(subprocess.run([psplit, verb, nested, "--help"], capture_output=True, text=True, check=True).stdout)
        for option in sorted(options - known):
            yield f"gltf-psplit {verb or ''} has no option {option}"
    elif program == "cmake":
        for word in rest:
            if (match := re.match(r"-D(PSPLIT_\w+)", word)) and not re.search(rf"\b{match[1]}\b", cmake_text):
                yield f"CMake has no option {match[1]}"
        for before, word in zip(rest, rest[1:]):
            if before == "--target" and word != "install" and not re.search(rf"\b{word}\b", cmake_text):
                yield f"CMake has no target {word}"
            if before == "-S" and (root / word).parent.exists() and word.count("/") and not (root / word / "CMakeLists.txt").exists():
                yield f"{word} is no project"
    elif re.match(r"(scripts|bench|bindings|tests|contrib)/", program):
        if not (root / program).is_file():
            yield f"there is no {program}"
            return
        source = source_of(program)
        for option in sorted(options):
            if option.startswith("--") and option not in source and not re.search(rf"['\"]{option[2:]}['\"]", source):
                yield f"{program} has no option {option}"
    elif not program.startswith(("build/", "~/", "environment/")) and name not in kOthers and not (root / page).with_name(program).is_file():
        yield f"{program} is not known: is it spelled right? then name it in kOthers"


def goes_on(line):
    """Whether a command goes on in the next line: after a backslash, or in a quotation."""
    if line.endswith("\\"):
        return True
    try:
        shlex.split(line, comments=True)
    except ValueError:
        return True
    return False


def lines_of(block):
    """(number, command) of each command, with its lines joined."""
    number, command = block.line, ""
    for i, line in enumerate(block.code.split("\n"), block.line):
        number = number if command else i
        command += line
        if goes_on(command):
            command = command.removesuffix("\\") + " "
            continue
        if command.strip() and not command.lstrip().startswith("#"):
            yield number, command
        command = ""


def make_inputs(folder):
    """Meshes under the names that commands of the pages read."""
    def run(*words):
        subprocess.run([psplit, *map(str, words)], cwd=folder, check=True, capture_output=True, text=True)

    samples = root / "gltf_ext/PSPLIT_mesh_draco_patches/samples"
    run("generate", "mesh.ply", "--shape", "blob", "--faces", 21000)
    run("generate", "in.gltf", "--shape", "scene", "--faces", 30000, "--normals", "--texcoords")
    run("decode", samples / "targets.glb", "character.glb")
    for name in ("dragon.ply", "scan.ply"):
        shutil.copy(folder / "mesh.ply", folder / name)
    subprocess.run(["gzip", "--keep", folder / "dragon.ply"], check=True)
    for name in ("assets/a.glb", "assets/b/c.glb"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        run("encode", "in.gltf", name)
    run("decode", "assets/a.glb", "in.glb")
    run("encode", "mesh.ply", "huge.glb")
    run("decode", "mesh.ply", "mesh.drc")
    for name in ("dragon.drc", "bunny.drc"):
        shutil.copy(folder / "mesh.drc", folder / name)
    points = b"".join(struct.pack("<3f", i % 10, i // 10 % 10, i // 100) for i in range(1000))
    (folder / "points.ply").write_bytes(b"ply\nformat binary_little_endian 1.0\nelement vertex 1000\nproperty float x\nproperty float y\n"
                                        b"property float z\nend_header\n" + points)
    run("encode", "points.ply", "points.drc")


def run_line(line, folder, said):
    """The fault of a line that runs, or None. Appends its output to `said`."""
    environment = os.environ | {"PATH": f"{psplit.parent}:{os.environ['PATH']}"}
    done = subprocess.run(["bash", "-o", "pipefail", "-c", line], cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
    said.append(done.stdout + done.stderr)
    return None if done.returncode == 0 else f"exits with {done.returncode}: {line.strip()}\n{(done.stdout + done.stderr)[-600:]}"


def main():
    bad, run_count, looked_up = [], 0, 0
    with tempfile.TemporaryDirectory() as name:
        inputs = pathlib.Path(name, "inputs")
        inputs.mkdir()
        make_inputs(inputs)
        for page in pages():
            runs = page.count("/") == page.startswith("docs/") and page not in kLookedUp
            folder = pathlib.Path(name, page.replace("/", "_"))
            said = []
            for block in blocks(page):
                if block.language == "text":
                    bad += [f"{block}: the commands do not print {line!r}, but {said}" for line in block.code.splitlines() if line not in "".join(said)]
                if block.language != "sh":
                    continue
                said = []
                for number, line in lines_of(block):
                    commands = simple_commands(line)
                    found = [fault for words in commands for fault in faults_of(words, page)]
                    looked_up += len(commands)
                    if runs and not found and all(words[0] in kRun for words in commands):
                        if not folder.exists():
                            shutil.copytree(inputs, folder)
                        run_count += 1
                        found = list(filter(None, [run_line(line, folder, said)]))
                    bad += [f"{page}:{number}: {fault}" for fault in found]
        # Sentences have whole commands, and options of any program.
        known = set().union(*(options_in(help_of(verb)) for verb in [None, *re.findall(r"^  ([a-z]+)\s", help_of(None).split("Subcommands:")[1], re.M)]))
        known |= options_in(subprocess.run([psplit, "batch", "plan", "--help"], capture_output=True, text=True).stdout)
        known |= set(kForeign) | options_in("\n".join(file.read_text(errors="replace") for pattern in ("scripts/*", "bench/*", "bindings/*/*.py", "tests/*/*.py")
                                                              for file in root.glob(pattern) if file.is_file()))
        for page in pages():
            if page == "CHANGELOG.md":
                continue  # has options that are gone
            for line, code in inline_code(page):
                if code.startswith("gltf-psplit ") and "..." not in code:
                    found = [fault for words in simple_commands(code) for fault in faults_of(words, page)]
                    looked_up += 1
                elif "/" in page and not page.startswith("docs/") or "-cz" in code:
                    continue  # options of other programs: of contrib, of npm's
                else:
                    found = [f"no program has the option {option}" for option in sorted(options_in(code)) if option.startswith("--") and option not in known]
                    looked_up += len(options_in(code))
                bad += [f"{page}:{line}: {fault}" for fault in found]
    if bad:
        sys.exit("\n".join(bad))
    if run_count < 25 or looked_up < 300:
        sys.exit(f"only {run_count} commands ran, and {looked_up} were looked up")
    print(f"{run_count} lines ran, {looked_up} commands and options were looked up")


main()
