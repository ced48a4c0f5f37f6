"""The rules of NuGet for a .nuspec: https://learn.microsoft.com/nuget/reference/nuspec, and what nuget.org asks beside them."""
import re
from xml.etree import ElementTree

kNamespace = "{http://schemas.microsoft.com/packaging/2013/05/nuspec.xsd}"
kNeeded = ("id", "version", "description", "authors")
kMetadata = (*kNeeded, "title", "owners", "projectUrl", "licenseUrl", "license", "iconUrl", "icon", "readme", "requireLicenseAcceptance",
             "developmentDependency", "summary", "releaseNotes", "copyright", "language", "tags", "repository", "dependencies",
             "frameworkAssemblies", "references", "contentFiles", "packageTypes", "serviceable", "frameworkReferences")


def faults(path):
    """What of the rules a .nuspec breaks."""
    found = []
    package = ElementTree.parse(path).getroot()
    if package.tag != kNamespace + "package":
        return [f"{path.name}: {package.tag} is not NuGet's element `package`"]
    metadata = package.find(kNamespace + "metadata")
    names = [element.tag.removeprefix(kNamespace) for element in metadata]
    text = {name: (metadata.findtext(kNamespace + name) or "").strip() for name in names}
    found += [f"no {name}" for name in kNeeded if not text.get(name)]
    found += [f"NuGet has no element {name}" for name in names if name not in kMetadata]
    found += [f"{name} is there twice" for name in set(names) if names.count(name) > 1]
    if not re.fullmatch(r"\w+([.-]\w+)*", text.get("id", "")) or len(text.get("id", "")) > 100:
        found.append(f"the id {text.get('id')!r} is not words with . or - between them")
    if not re.fullmatch(r"\d+\.\d+\.\d+(-[0-9A-Za-z.-]+)?", text.get("version", "")):
        found.append(f"the version {text.get('version')!r} is not that of a release")
    if len(text.get("description", "")) > 4000:
        found.append("the description is longer than 4000 characters")
    if "license" in text and metadata.find(kNamespace + "license").get("type") not in ("expression", "file"):
        found.append("the license is neither an expression of SPDX nor a file")
    if "license" in text and "licenseUrl" in text:
        found.append("there is a license, and a licenseUrl beside it")
    repository = metadata.find(kNamespace + "repository")
    for name, address in (("projectUrl", text.get("projectUrl")), ("repository", repository is not None and repository.get("url"))):
        if address is not None and address is not False and not re.match(r"https://[^/\s]+/", address or ""):
            found.append(f"the {name} {address!r} is no address of https")
    files = {(file.get("target") or "").strip("/") + "/" + file.get("src").rpartition("/")[2] for file in package.iter(kNamespace + "file")}
    for name in ("readme", "icon"):
        if text.get(name) and "/" + text[name] not in files and text[name] not in files:
            found.append(f"the {name} {text[name]} is not among the files")
    return [f"{path.name}: {fault}" for fault in found]
