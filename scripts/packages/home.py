"""The address of the project, which CMakeLists.txt says, and every manifest that repeats it; and the address for mail. Both are of
example.org until the project has a public home: scripts/release --home sets them."""
import pathlib, re

root = pathlib.Path(__file__).resolve().parent.parent.parent
kFirst = ("CMakeLists.txt", r'HOMEPAGE_URL "([^"]+)"')
kManifests = ("CMakeLists.txt", "vcpkg.json", "contrib/vcpkg/psplit/vcpkg.json", "contrib/conan/conanfile.py", "contrib/homebrew/psplit.rb",
              "contrib/debian/control", "contrib/debian/copyright", "bindings/web/package.json", "bindings/python/pyproject.toml",
              "bindings/rust/gltf-psplit-sys/Cargo.toml", "bindings/rust/gltf-psplit/Cargo.toml", "bindings/csharp/GltfPsplit.nuspec")
# Debian's changelog keeps the address that an entry was written with.
kMail = ("contrib/debian/control", r"^Maintainer: (.+ <[^>]+>)$")


def said(place):
    return re.search(place[1], (root / place[0]).read_text(), re.M).group(1)


def home():
    return said(kFirst)


def maintainer():
    """As Debian has it: a name, and an address in angle brackets."""
    return said(kMail)


def disagreements():
    return [f"{file} does not name {home()}" for file in kManifests if home() not in (root / file).read_text()]


def set_home(new):
    if not re.fullmatch(r"https://[^/\s\"<>]+(/[^/\s\"<>]+)*", new):
        raise ValueError(f"{new} is no address such as https://example.org/psplit, without a slash at its end")
    old = home()
    for file in kManifests:
        (root / file).write_text((root / file).read_text().replace(old, new))


def set_maintainer(new):
    if not re.fullmatch(r"[^<>]+ <[^<>@\s]+@[^<>@\s]+>", new):
        raise ValueError(f'{new} is not of the form "Name <name@example.org>"')
    file = root / kMail[0]
    file.write_text(file.read_text().replace(maintainer(), new))
