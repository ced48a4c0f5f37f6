"""The version, which CMakeLists.txt says, and every other file that has to repeat it."""
import datetime, email.utils, os, pathlib, re

from packages import home

root = pathlib.Path(__file__).resolve().parent.parent.parent
kChangelog = "contrib/debian/changelog"
# Each pattern's group is the version, or its first two numbers where a file asks for these; or its groups are the numbers. What
# stands after a # tells several places of a file apart.
kPlaces = {
    "CMakeLists.txt": r"^project\(psplit VERSION (\S+)",
    "include/psplit/version.h": r"_MAJOR (\d+)\n#define PSPLIT_VERSION_MINOR (\d+)\n#define PSPLIT_VERSION_PATCH (\d+)",
    "vcpkg.json": r'^  "version": "([^"]+)"',
    "bindings/web/package.json": r'^  "version": "([^"]+)"',
    "bindings/web/examples/bundlers/package.json": r'"psplit": "([^"]+)"',
    kChangelog: r"\Apsplit \(([^)-]+)-\d+\)",
    "contrib/vcpkg/psplit/vcpkg.json": r'^  "version": "([^"]+)"',
    "contrib/conan/conanfile.py": r'^    version = "([^"]+)"',
    "contrib/homebrew/psplit.rb": r'^  version "([^"]+)"',
    ".github/actions/psplit-encode/action.yml": r"^    default: v(\S+)",
    "bindings/c/examples/CMakeLists.txt": r"^ *find_package\(psplit (\S+)",
    "gltf_ext/examples/CMakeLists.txt": r"^ *find_package\(psplit (\S+)",
    "bindings/rust/gltf-psplit-sys/Cargo.toml": r'^version = "([^"]+)"',
    "bindings/rust/gltf-psplit/Cargo.toml": r'^version = "([^"]+)"',
    "bindings/rust/gltf-psplit/Cargo.toml#its-dependency": r'^gltf-psplit-sys = \{ version = "=([^"]+)"',
    "bindings/csharp/GltfPsplit.nuspec": r"<version>([^<]+)<",
}


def file_of(place):
    return root / place.partition("#")[0]


def said(match):
    return ".".join(match.groups())


def versions():
    """{place: (version, where it stands)} as the files have it."""
    found = {}
    for place, pattern in kPlaces.items():
        match = re.search(pattern, file_of(place).read_text(), re.M)
        if not match:
            raise ValueError(f"{place} has no version where it should have one")
        found[place] = match
    return found


def version():
    return versions()["CMakeLists.txt"].group(1)


def disagreements():
    """The files that say another version than CMakeLists.txt."""
    right = version()
    return [f"{place} says {said(match)}, CMakeLists.txt {right}" for place, match in versions().items()
            if said(match) not in (right, right.rpartition(".")[0])]


def changelog_entry(new):
    """The changelog entry of the first revision of Debian's package. Its date is $SOURCE_DATE_EPOCH or now."""
    seconds = int(os.environ.get("SOURCE_DATE_EPOCH") or datetime.datetime.now().timestamp())
    date = email.utils.format_datetime(datetime.datetime.fromtimestamp(seconds, datetime.timezone.utc))
    return f"psplit ({new}-1) unstable; urgency=medium\n\n  * Version {new}; CHANGELOG.md says what changed.\n\n" \
           f" -- {home.maintainer()}  {date}\n\n"


def set_version(new):
    if not re.fullmatch(r"\d+\.\d+\.\d+", new):
        raise ValueError(f"{new} is no version such as 1.2.3")
    for place, pattern in kPlaces.items():
        text = file_of(place).read_text()
        match = re.search(pattern, text, re.M)  # again, because an earlier place may be of the same file
        if place == kChangelog and match.group(1) != new:
            # What it says of older versions stays.
            file_of(place).write_text(changelog_entry(new) + text)
            continue
        numbers = new.split(".")[:said(match).count(".") + 1]
        words = [".".join(numbers)] if len(match.groups()) == 1 else numbers
        for i, word in reversed(list(enumerate(words, 1))):  # from the end, so that places before it stay
            text = text[:match.start(i)] + word + text[match.end(i):]
        file_of(place).write_text(text)
