"""The bill of materials of a static command, in SPDX 2.3, and the licences of the libraries in it."""
import datetime, hashlib, json, urllib.parse

kHeaders = {
    "libcli11-dev": "BSD-3-Clause",
    "libxxhash-dev": "BSD-2-Clause",
    "nlohmann-json3-dev": "MIT",
}
# The Debian packages whose code is in the command, with their licences in SPDX's names.
kLinked = {
    "libc6-dev": "LGPL-2.1-or-later",
    "libgcc-12-dev": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "libstdc++-12-dev": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "libpng-dev": "libpng-2.0",
    "libzstd-dev": "BSD-3-Clause OR GPL-2.0-only",
    "zlib1g-dev": "Zlib",
} | kHeaders
# Linked in the command for Windows.
kLinkedOnWindows = {
    "mingw-w64-x86-64-dev": "ZPL-2.1",
    "gcc-mingw-w64-x86-64-posix-runtime": "GPL-3.0-or-later WITH GCC-exception-3.1",
    "libz-mingw-w64-dev": "Zlib",
} | kHeaders
kLinkedInWheel = {
    "libxxhash-dev": "BSD-2-Clause",
    "nlohmann-json3-dev": "MIT",
    "pybind11-dev": "BSD-3-Clause",
}
# Linked in the WebAssembly modules of the npm package.
kLinkedInModules = {
    "libc++-dev-wasm32": "Apache-2.0 WITH LLVM-exception",
}
kMeshoptimizer = "MIT"


def licences(root, linked, meshoptimizer, what="The command"):
    """The text that a package passes on. `root` is where the packages are installed or unpacked; `meshoptimizer` is its source,
    or None."""
    parts = [f"{what} in this package is linked with these libraries, whose licences follow.\n"]
    texts = {package: root / "usr/share/doc" / package / "copyright" for package in linked}
    if meshoptimizer:
        texts["meshoptimizer"] = meshoptimizer / "LICENSE.md"
    for name, file in texts.items():
        parts.append(f"{'=' * 100}\n{name}\n{'=' * 100}\n\n{file.read_text()}")
    return "\n".join(parts)


def address(package, version, architecture):
    """A package URL."""
    return f"pkg:deb/debian/{urllib.parse.quote(package)}@{urllib.parse.quote(version)}?arch={architecture}"


def document(archive, version, architecture, licence_of, packages, meshoptimizer_version, epoch, home, name="gltf-psplit"):
    """SPDX's JSON for a package. `licence_of`: one of the tables above. `packages`: {Debian package: version}. `home`: the project's
    address, beside which `home`.git is the repository."""
    digest = hashlib.sha256(archive.read_bytes()).hexdigest()
    created = datetime.datetime.fromtimestamp(epoch, datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    command = {"SPDXID": f"SPDXRef-{name}", "name": name, "homepage": home, "versionInfo": version, "packageFileName": archive.name,
               "downloadLocation": f"git+{home}.git@v{version}", "filesAnalyzed": False, "licenseConcluded": "Apache-2.0",
               "licenseDeclared": "Apache-2.0", "copyrightText": "NOASSERTION", "primaryPackagePurpose": "APPLICATION",
               "checksums": [{"algorithm": "SHA256", "checksumValue": digest}]}
    linked = [(name, packages[name], licence, address(name, packages[name], architecture)) for name, licence in licence_of.items()]
    if meshoptimizer_version:
        linked.append(("meshoptimizer", meshoptimizer_version, kMeshoptimizer, address("meshoptimizer", meshoptimizer_version, "source")))
    parts = [{"SPDXID": "SPDXRef-" + name.replace("+", "p").replace(".", "-"), "name": name, "versionInfo": its_version,
              "downloadLocation": "NOASSERTION", "filesAnalyzed": False, "licenseConcluded": "NOASSERTION", "licenseDeclared": licence,
              "copyrightText": "NOASSERTION", "primaryPackagePurpose": "LIBRARY",
              "externalRefs": [{"referenceCategory": "PACKAGE-MANAGER", "referenceType": "purl", "referenceLocator": purl}]}
             for name, its_version, licence, purl in linked]
    relations = [{"spdxElementId": "SPDXRef-DOCUMENT", "relationshipType": "DESCRIBES", "relatedSpdxElement": command["SPDXID"]}]
    relations += [{"spdxElementId": command["SPDXID"], "relationshipType": "STATIC_LINK", "relatedSpdxElement": part["SPDXID"]}
                  for part in parts]
    return json.dumps({"spdxVersion": "SPDX-2.3", "dataLicense": "CC0-1.0", "SPDXID": "SPDXRef-DOCUMENT", "name": archive.name,
                       "documentNamespace": f"urn:psplit:sbom:{archive.name}:{digest}",
                       "creationInfo": {"created": created, "creators": ["Tool: psplit-scripts-release"]},
                       "packages": [command, *parts], "relationships": relations}, indent=1) + "\n"
