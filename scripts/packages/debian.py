"""Debian's packages without installing them, by apt with state of its own: sources, and packages of another architecture."""
import os, pathlib, re, shutil, subprocess


class NotFound(Exception):
    pass


def run_apt(folder, options, *command, cwd=None):
    done = subprocess.run(["apt-get", "-qq", *[word for option in options for word in ("-o", option)], *command], cwd=cwd,
                          capture_output=True, text=True)
    if done.returncode != 0:
        raise NotFound(f"apt-get {command[0]}: " + " ".join(done.stderr.split())[:300])


def installed_version(package):
    done = subprocess.run(["dpkg-query", "-W", "-f=${Version}", package], capture_output=True, text=True)
    if done.returncode != 0 or not done.stdout:
        raise NotFound(f"{package} is not a package of this system")
    return done.stdout


def packages_to_cross_build(project):
    """What third_party/packages.txt names for the command and the libraries, without tools, and what tests need."""
    listed = (project / "third_party/packages.txt").read_text().split("# tests\n")[0].splitlines()
    tools = ("build-essential", "cmake", "ninja-build")
    return ["libc6-dev", "libstdc++-12-dev", "libgtest-dev", *(line for line in listed if line and line[0] != "#" and line not in tools)]


def source(package, version, folder):
    """The folder of a source package, which is unpacked in `folder`."""
    unpacked = re.compile(re.escape(package) + r"-[^/]*")
    found = [path for path in folder.glob(f"{package}-*") if path.is_dir() and unpacked.fullmatch(path.name)]
    if found:
        return found[0]
    sources = folder / "sources"
    for part in (sources, folder / "lists/partial", folder / "cache"):
        part.mkdir(parents=True, exist_ok=True)
    system = pathlib.Path("/etc/apt")
    for entry in [*(system / "sources.list.d").glob("*.sources"), *(system / "sources.list.d").glob("*.list"), system / "sources.list"]:
        if entry.exists():
            text = re.sub(r"^(Types: *)deb *$", r"\1deb-src", entry.read_text(), flags=re.M)
            (sources / entry.name).write_text(re.sub(r"^deb ", "deb-src ", text, flags=re.M))
    options = [f"Dir::Etc::SourceParts={sources}", "Dir::Etc::SourceList=/dev/null", f"Dir::State::Lists={folder / 'lists'}",
               f"Dir::Cache={folder / 'cache'}"]
    run_apt(folder, options, "update", cwd=folder)
    run_apt(folder, options, "source", f"{package}={version}", cwd=folder)
    return next(path for path in folder.glob(f"{package}-*") if path.is_dir())


def unpack(architecture, packages, folder):
    """Unpacks packages of an architecture and all that they depend on in `folder`/root, and returns a list of what is there:
    (package, version)."""
    root, listed, done = folder / "root", folder / "packages.txt", folder / "asked.txt"
    asked = " ".join(sorted(packages))
    if not done.exists() or done.read_text() != asked:
        shutil.rmtree(root, ignore_errors=True)
        for part in (root, folder / "state/lists/partial", folder / "cache/archives/partial"):
            part.mkdir(parents=True, exist_ok=True)
        (folder / "status").write_text("")  # nothing is installed
        options = [f"Dir::State={folder / 'state'}", f"Dir::State::status={folder / 'status'}", f"Dir::Cache={folder / 'cache'}",
                   f"APT::Architecture={architecture}", f"APT::Architectures={architecture}", "Debug::NoLocking=1"]
        run_apt(folder, options, "update")
        run_apt(folder, options, "install", "-y", "--no-install-recommends", "--download-only", *packages)
        lines = []
        for archive in sorted((folder / "cache/archives").glob("*.deb")):
            subprocess.run(["dpkg", "-x", archive, root], check=True)
            lines.append(subprocess.run(["dpkg-deb", "-W", "--showformat=${Package}\t${Version}\n", archive], check=True,
                                        capture_output=True, text=True).stdout)
        # Links to absolute places stay in the folder.
        for link in root.rglob("*"):
            if link.is_symlink() and (target := os.readlink(link)).startswith("/"):
                link.unlink()
                link.symlink_to(os.path.relpath(root / target.lstrip("/"), link.parent))
        listed.write_text("".join(lines))
        done.write_text(asked)
    return [tuple(line.split("\t")) for line in listed.read_text().splitlines()]
