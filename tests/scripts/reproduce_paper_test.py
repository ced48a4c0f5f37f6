#!/usr/bin/env python3
"""Tests scripts/reproduce-paper on small stand-ins and files:  reproduce_paper_test.py GLTF_PSPLIT

The page has every row of the paper with ours beside it, and every figure of ours is what `compare` measured. No time is
judged.
"""
import gzip, json, pathlib, re, struct, subprocess, sys, tempfile, unittest
import xml.etree.ElementTree

root = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(root / "scripts"))
from paper.models import find_file, kModels, kPatches, ready_file
from paper.page import kCodings, percent, run_name, size_rows, speed_rows, table, timing
from paper.ply import PlyError, to_little_endian

psplit = pathlib.Path(sys.argv.pop(1)).resolve()
kScale = 0.002


def grid_ply(order, form, columns=12):
    """A wavy sheet as PLY with an extra property: binary in either byte order (">" or "<"), or text ("")."""
    points = [(x, y, 0.1 * ((x * y) % 3), 0.5) for y in range(columns + 1) for x in range(columns + 1)]
    faces = []
    for y in range(columns):
        for x in range(columns):
            a = x + y * (columns + 1)
            faces += [(a, a + 1, a + columns + 1), (a + 1, a + columns + 2, a + columns + 1)]
    header = f"ply\nformat {form} 1.0\ncomment a sheet\nelement vertex {len(points)}\n" + "".join(
        f"property float {name}\n" for name in ("x", "y", "z", "confidence")) + (
        f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n")
    if not order:
        return (header + "".join(" ".join(map(str, point)) + "\n" for point in points)
                + "".join("3 " + " ".join(map(str, face)) + "\n" for face in faces)).encode()
    return header.encode() + b"".join(struct.pack(f"{order}4f", *point) for point in points) + b"".join(
        struct.pack(f"{order}B3i", 3, *face) for face in faces)


def reproduce(folder, *arguments):
    return subprocess.run([sys.executable, root / "scripts/reproduce-paper", "--psplit", psplit, "--work", folder / "work",
                           "--output", folder / "paper.md", "--repeat", "1", *map(str, arguments)],
                          capture_output=True, text=True)


class Ply(unittest.TestCase):
    def test_big_endian_becomes_little_endian(self):
        big, little = grid_ply(">", "binary_big_endian"), grid_ply("<", "binary_little_endian")
        self.assertEqual(to_little_endian(big), little)

    def test_refuses_what_it_cannot_swap(self):
        big = grid_ply(">", "binary_big_endian")
        for broken in (b"plyglot", big[:-1], big.replace(b"property float x", b"property decimal x"),
                       big.replace(b"element vertex 169", b"element vertex 999999"),
                       big.replace(b"property list uchar int", b"property int a\nproperty list uchar int"),
                       big[:-13] + b"\4" + big[-12:]):
            with self.assertRaises(PlyError):
                to_little_endian(broken)

    def test_finds_files_below_a_folder_and_unpacks_them(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "happy_recon").mkdir()
            (folder / "happy_recon/happy_vrip.ply").write_bytes(grid_ply("", "ascii"))
            with gzip.open(folder / "xyzrgb_dragon.ply.gz", "wb") as packed:
                packed.write(grid_ply(">", "binary_big_endian"))
            happy, dragon, statue, _ = (find_file(folder, model) for model in kModels)
            self.assertEqual(happy.name, "happy_vrip.ply")
            self.assertIsNone(statue)
            self.assertEqual(ready_file(happy, folder), happy)
            self.assertEqual(ready_file(dragon, folder).read_bytes(), grid_ply("<", "binary_little_endian"))


class Page(unittest.TestCase):
    def test_percent_and_table(self):
        self.assertEqual([percent(1.239), percent(1), percent(0.95)], ["+23.9 %", "+0.0 %", "-5.0 %"])
        self.assertEqual(table(["a", "b"], [["cc", "1"]]), "| a  | b |\n|----|--:|\n| cc | 1 |")

    def test_the_papers_own_figures(self):
        self.assertEqual([model.faces for model in kModels], [1.1, 3.6, 10.0, 8.4])
        # The paper's summary: about 20 % more with 8,192 patches.
        for model in kModels:
            if model.parallel[2]:
                self.assertTrue(1.15 < model.parallel[2] / model.sequential < 1.25, model)


class Script(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.done = reproduce(cls.folder, "--faces-scale", kScale)
        if cls.done.returncode != 0:
            raise AssertionError(cls.done.stderr + cls.done.stdout)
        cls.results = json.loads((cls.folder / "work/results.json").read_text())
        cls.page = (cls.folder / "paper.md").read_text()

    def test_every_run_is_there(self):
        patches = [max(1, round(count * kScale)) for count in kPatches]
        for model in kModels:
            entry = self.results["models"][model.name]
            self.assertLess(abs(entry["faces"] / (model.faces * 1e6 * kScale) - 1), 0.1, model)
            wanted = [run_name(coding, refined) for refined in ((True, False) if model.unprocessed else (True,))
                      for coding in kCodings]
            self.assertEqual(list(entry["runs"]), wanted)
            for run in entry["runs"].values():
                self.assertEqual(len(run["splits"]), len(kPatches))
                # The scene has at least one patch for each of its meshes.
                if model.name != "scene":
                    self.assertEqual([split["patches"] for split in run["splits"]], patches)
            self.assertGreater(entry["runs"]["lossless"]["stock"]["bytes"], 12 * entry["points"])
            self.assertLess(entry["runs"]["quantized"]["stock"]["bytes"], entry["runs"]["lossless"]["stock"]["bytes"])

    def test_every_row_is_on_the_page_and_printed(self):
        for rows in (size_rows(self.results), speed_rows(self.results)):
            for row in rows:
                found = [text for text in (self.page, self.done.stdout)
                         if any([cell.strip() for cell in line.strip("|").split("|")] == row for line in text.splitlines())]
                self.assertEqual(len(found), 2, row)
        sizes = list(size_rows(self.results))
        self.assertEqual(len(sizes), 3 * 5)
        self.assertIn(["Dragon", "paper", "3.6", "20.5", "21.6 (+5.4 %)", "22.9 (+11.7 %)", "25.4 (+23.9 %)"], sizes)
        self.assertIn(["Happy Buddha, unprocessed", "paper", "1.1", "6.8", "7.6 (+11.8 %)", "8.5 (+25.0 %)", "–"], sizes)
        speeds = list(speed_rows(self.results))
        self.assertIn(["Dragon", "paper, GeForce GTX 580", "", "not in the text", "not in the text", "48.5x"], speeds)
        # The text has no other figure, and the page invents none.
        self.assertEqual(sum(cell.endswith("x") for row in speeds if row[1].startswith("paper") for cell in row), 1)

    def test_ours_are_what_compare_measured(self):
        split = self.results["models"]["dragon"]["runs"]["lossless"]["splits"][2]
        stock = self.results["models"]["dragon"]["runs"]["lossless"]["stock"]
        self.assertIn(f"({percent(split['bytes'] / stock['bytes'])})", self.page)
        on_all_threads = max((row for row in split["decode"] if row["backend"] == "cpu"), key=lambda row: row["threads"])
        self.assertIn(f"{on_all_threads['speedup']:.2f}x ({timing(on_all_threads['median_ms'])})", self.page)

    def test_the_page_says_how(self):
        for words in ("stand-in", "--shape gyroid", "stock Draco", "interleaved", "median", "Not the paper's sizes",
                      f"scripts/reproduce-paper --repeat 1 --faces-scale {kScale}", "libdraco"):
            self.assertIn(words, self.page)
        self.assertNotIn(str(self.folder), self.page)
        self.assertNotIn(str(root), self.page)

    def test_with_a_gpu_speed_ups_are_those_of_the_gpu(self):
        results = json.loads(json.dumps(self.results))
        results["machine"]["gpu"] = "A GPU"
        for entry in results["models"].values():
            for run in entry["runs"].values():
                for i, split in enumerate(run["splits"]):
                    split["decode"] = [{"backend": backend, "threads": threads, "median_ms": 3, "min_ms": 2, "max_ms": 4,
                                        "speedup": speedup} for backend, threads, speedup in
                                       [("cuda", 1, 7), ("cuda", 2, 100 + i), ("cpu", 1, 2), ("cpu", 2, 3), ("draco", 1, 1),
                                        ("draco", 2, 1)]]
        measured = self.folder / "gpu.json"
        measured.write_text(json.dumps(results))
        self.addCleanup((self.folder / "paper.md").write_text, self.page)
        self.assertEqual(reproduce(self.folder, "--results", measured).returncode, 0)
        page = (self.folder / "paper.md").read_text()
        self.assertIn("those of the GPU, A GPU", page)
        self.assertEqual([row[3] for row in speed_rows(results) if row[1] == "psplit, lossless, GPU"],
                         ["100.00x (3.00 ms)"] * 5)
        self.assertEqual(len([row for row in speed_rows(results) if "CPU, 2 threads" in row[1]]), 2 * 5)
        self.assertIn("lossless for 4 of 4 models", page.replace("\n ", ""))

    def test_the_figure_has_a_line_for_every_model_and_coding(self):
        svg = xml.etree.ElementTree.parse(self.folder / "paper.svg").getroot()
        lines = svg.findall("{http://www.w3.org/2000/svg}polyline")
        self.assertEqual(len(lines), 2 * 5)
        for line in lines:
            self.assertEqual(len(line.get("points").split()), len(kPatches))
        self.assertIn("](paper.svg)", self.page)

    def test_the_page_is_made_again_without_measuring(self):
        measured = self.folder / "measured.json"
        measured.write_text(json.dumps(self.results))
        again = reproduce(self.folder, "--results", measured)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual((self.folder / "paper.md").read_text(), self.page)

    def test_uses_real_models_if_there_are_some(self):
        models = self.folder / "models"
        models.mkdir()
        (models / "happy_vrip.ply").write_bytes(grid_ply("", "ascii"))
        (models / "xyzrgb_dragon.ply").write_bytes(grid_ply(">", "binary_big_endian"))
        made = {path: path.stat().st_mtime_ns for path in (self.folder / "work").glob("s*.glb")}
        self.assertEqual(len(made), 2)
        done = reproduce(self.folder, "--faces-scale", kScale, "--models", models)
        self.assertEqual(done.returncode, 0, done.stderr)
        # The stand-ins of the other two are not generated again.
        self.assertEqual(made, {path: path.stat().st_mtime_ns for path in (self.folder / "work").glob("s*.glb")})
        page = (self.folder / "paper.md").read_text()
        (self.folder / "paper.md").write_text(self.page)
        for name in ("happy_vrip.ply", "xyzrgb_dragon.ply"):
            self.assertRegex(page, re.escape(f"`{name}`, 288 faces, 169 points; the paper has"))
        self.assertRegex(page, r"\*\*Statue\*\*: a stand-in")
        self.assertIn("--models DIR", page)
        self.assertNotEqual(reproduce(self.folder, "--models", self.folder / "none").returncode, 0)


if __name__ == "__main__":
    unittest.main()
