"""The paper's models and figures, and where our models come from: files of a folder, or generated stand-ins."""
import dataclasses, gzip, pathlib, shutil

from paper.ply import to_little_endian

kPatches = (512, 2048, 8192)


@dataclasses.dataclass(frozen=True)
class Model:
    name: str
    title: str
    faces: float         # the paper's, in millions
    sequential: float    # MB of the paper's table 1
    parallel: tuple      # MB at kPatches; None where the table has no figure
    shape: str           # of the stand-in, and its seed
    seed: int
    files: tuple         # names of the real model's file, the Stanford repository's first
    unprocessed: tuple = ()  # MB at kPatches of the paper's row without refinement, if it has one


# Zhao, Tang, Tong 2012, table 1. For Happy Buddha it has two figures a row, at 512 and at 2,048 patches.
kModels = (
    Model("happy", "Happy Buddha", 1.1, 6.8, (7.0, 7.2, None), "blob", 1, ("happy_vrip.ply", "happy.ply"),
          unprocessed=(7.6, 8.5, None)),
    Model("dragon", "Dragon", 3.6, 20.5, (21.6, 22.9, 25.4), "gyroid", 2, ("xyzrgb_dragon.ply", "dragon.ply")),
    Model("statue", "Statue", 10.0, 44.9, (47.1, 49.2, 52.7), "blob", 3, ("xyzrgb_statuette.ply", "statue.ply")),
    Model("scene", "Scene of six models", 8.4, 37.8, (40.1, 42.9, 46.1), "scene", 4,
          ("scene.glb", "scene.gltf", "scene.ply")),
)
# The speed-ups that the text states; figure 12 is a picture.
kPaperSpeedups = {("dragon", 8192): 48.5}


def find_file(folder, model):
    """The real model's file in the folder or below it, or None. The name may end in `.gz` as well."""
    for name in model.files:
        for candidate in (name, name + ".gz"):
            found = sorted(folder.rglob(candidate))
            if found:
                return found[0]
    return None


def ready_file(path, work):
    """A file that the command can read: unpacked and little-endian. If `path` is not, that file is made in `work`."""
    name = path.name.removesuffix(".gz")
    ready = work / name
    if path.suffix == ".gz":
        if not is_fresh(ready, path):
            with gzip.open(path) as packed, open(ready, "wb") as plain:
                shutil.copyfileobj(packed, plain, 1 << 20)
        path = ready
    if not name.endswith(".ply"):
        return path
    with open(path, "rb") as file:
        if b"binary_big_endian" not in file.read(200):
            return path
    swapped = work / f"little-endian-{name}"
    if not is_fresh(swapped, path):
        swapped.write_bytes(to_little_endian(pathlib.Path(path).read_bytes()))
    return swapped


def is_fresh(made, source):
    return made.exists() and made.stat().st_mtime >= source.stat().st_mtime
