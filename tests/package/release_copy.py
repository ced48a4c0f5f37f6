"""A copy of scripts/release and of the files that it changes, for tests that let it change them."""
import pathlib, shutil


def copy_for_release(source, folder, files):
    """Copies `files`, named relative to `source`, and what scripts/release needs to run."""
    for file in [*files, "scripts/release", *(path.relative_to(source) for path in source.glob("scripts/packages/*.py"))]:
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(source / file, folder / file)
    return folder / "scripts/release"
