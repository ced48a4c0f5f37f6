#!/usr/bin/env python3
"""Tests the pages that scripts/web-bench writes, on invented measurements. Nothing is timed here."""
import datetime, pathlib, sys, unittest

root = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(root / "scripts"))
from benchmarks import web

kHow = {"words": [str(root / "scripts/web-bench"), "a.glb"], "today": datetime.date(2026, 11, 5), "processor": "Some CPU"}


def rows(lines):
    return {row.split(" | ")[0].lstrip("| "): row.strip("| ").split(" | ") for row in lines}


def decoder(ms, size=100, heap=None, busiest=0):
    # The machine is three times as slow in the second round.
    return {"main": [ms, 3 * ms, ms], "busiest": [busiest, 3 * busiest, busiest], "bytes": size, **({} if heap is None else {"heap": heap << 20})}


def thread_line(what, name, scale):
    """psplit/draco is twice as fast as draco3d, times the scale."""
    decoders = {"draco3d 1.5.7": decoder(8), "three's draco_decoder": decoder(10), "psplit/draco": decoder(4 / scale), "psplit, one stream": decoder(2 / scale)}
    if what == "thread":
        decoders |= {"psplit, patches": decoder(2 / scale, 110, 5), "meshopt_decoder 9.9": decoder(0.5, 220)}
    return {"what": what, "name": name, "decoders": decoders}


def web_lines():
    encoders = lambda speed, containers: {"draco3d": {"ms": [10, 30, 10], "bytes": 100, "heap": 40}, "psplit/draco": {"ms": [5, 15, 5], "bytes": 100, "heap": 60}, **containers}
    containers = {"patches": {"ms": [40, 120, 40], "bytes": 102}, "condensed": {"ms": [90, 270, 90], "bytes": 80}}
    loaders = {"three's DRACOLoader, 1 worker": decoder(1, busiest=9), "psplit, patches, 2 workers": decoder(2, busiest=2)}
    return [thread_line("asset", "duck", 1), thread_line("asset", "fish", 4), thread_line("thread", "small", 5), thread_line("thread", "terrain", 1),
            {"what": "workers", "name": "terrain", "decoders": loaders},
            {"what": "page", "name": "terrain", "ms": {"three's draco_decoder": [300, 310, 900], "psplit, patches, 2 workers": [99, 100, 102]}},
            {"what": "encoders", "name": "terrain", "faces": 2000, "attributes": ["POSITION", "NORMAL"], "speed": 0, "encoders": encoders(0, {})},
            {"what": "encoders", "name": "terrain", "faces": 2000, "attributes": ["POSITION", "NORMAL"], "speed": 5, "encoders": encoders(5, containers)}]


def streaming_line(name, mbits, streaming, meshoptimizer):
    of = lambda first, end: {"bytes": 1000, "first": [first] * 3, "all": [end] * 3}
    return {"what": "streaming", "name": name, "mbits": mbits, "faces": 5000, "loaders": {"three's DRACOLoader": of(1000, 1000),
            "meshoptimizer 9.9, codec 0, brotli": of(meshoptimizer, meshoptimizer), "loadStreaming": of(streaming, 2 * streaming)}}


def character_line():
    of = lambda drawn: {"bytes": 77, "first_loaded": [9 * drawn, 8 * drawn], "first_drawn": [10 * drawn, 9 * drawn], "second_loaded": [drawn, drawn + 5], "second_drawn": [drawn + 10, drawn]}
    return {"what": "character", "name": "anna", "mbits": 10, "ways": {"gltfpack -cz": of(100), "encode --condense --meshopt": of(80),
            "encode --condense --meshopt, loadStreaming": of(50)}}


class Web(unittest.TestCase):
    def test_ratios_are_of_one_round_and_means_of_assets(self):
        found = rows(web.thread_table(web_lines()))
        self.assertEqual(found["decoder"][:5], ["decoder", "assets, mean", "least", "small", "terrain"])
        # Of assets 2 and 8.
        self.assertEqual(found["psplit/draco"], ["psplit/draco", "4.00", "2.00", "10.00", "2.00", "100"])
        self.assertEqual(found["three's draco_decoder"][1:5], ["0.80", "0.80", "0.80", "0.80"])
        self.assertEqual(found["three's draco_decoder"][-1], "310")
        self.assertEqual(found["psplit, patches"], ["psplit, patches", "", "", "20.00", "4.00", "110", "5.0"])

    def test_workers_count_both_threads(self):
        found = rows(web.workers_table(web_lines()))
        self.assertEqual(found["psplit, patches, 2 workers"][1:], ["2.0 + 2.0 (2.50)", "100"])

    def test_encoders_are_over_draco3d(self):
        table = web.encoders_table(web_lines())
        self.assertEqual(table[2], "| terrain: 2,000, P N | 0 | 10 | 2.00 | 1.50 |  |  |  |  |")
        self.assertEqual(table[3], "| terrain: 2,000, P N | 5 | 10 | 2.00 | 1.50 | 4.0 | 1.02 | 9.0 | 0.80 |")

    def test_the_page_says_first_where_the_rival_wins(self):
        text = web.web_page(web_lines(), 3, "Node.js 1.", **kHow)
        first = text.split("\n")[2]
        self.assertTrue(first.startswith("On one thread meshopt_decoder 9.9 decodes large meshes 16.00 times as fast as draco3d 1.5.7, and psplit's patches 4.00 times; "
                                         "its bytes in brotli are 2.00 times those of patches. Stock streams of 2 assets decode 4.00 times"), first)
        self.assertIn("by psplit/draco, and 8.00 times by `decodeDraco`, at least 2.00 times.", first)
        self.assertIn("in 1.50 of its heap; `encodeMesh` takes 4.0 times as long as draco3d for one stream, and 9.0 times for condensed patches.", first)
        self.assertIn("`scripts/web-bench a.glb` wrote this page on 5 November 2026", text)
        # Quartiles of 1, 1 and 3 are 1 and 2: every time is noisy.
        self.assertIn("**Other programs used the machine:**", text)
        self.assertLessEqual(len(text.split("\n")), 45)


class Streaming(unittest.TestCase):
    def test_cells_are_milliseconds_and_the_share_of_all_triangles_of_dracoloader(self):
        lines = [streaming_line("Dragon", 10, 100, 900), streaming_line("Dragon", 50, 300, 200), streaming_line("Duck", 10, 1, 1)]
        found = web.streaming_rows(lines)
        self.assertEqual(list(found), ["Dragon, 5,000 faces", "Duck, 5,000 faces"])
        self.assertEqual(found["Dragon, 5,000 faces"][2], ["loadStreaming", "1,000", "100 (0.10)", "200 (0.20)", "300 (0.30)", "600 (0.60)"])

    def test_losses_come_first(self):
        lines = [streaming_line("Dragon", 10, 100, 900), streaming_line("Dragon", 50, 300, 200), character_line()]
        text = web.streaming_findings(lines)
        self.assertEqual(text[0], "meshoptimizer's file of Dragon is shown sooner than the first triangles by `loadStreaming`: in 0.67 (at 50 Mbit/s) of their time.")
        self.assertEqual(text[1], "`loadStreaming` shows the first triangles of Dragon, and all, in this share of the time of three's DRACOLoader: "
                         "0.10 and 0.20 at 10 Mbit/s and 0.30 and 0.60 at 50 Mbit/s.")
        self.assertEqual(text[2], "anna, by `encode --condense --meshopt`, is drawn in 0.80 of the time of gltfpack -cz's file, and with `loadStreaming` in 0.50.")

    def test_a_character_that_gltfpack_draws_sooner_is_a_loss(self):
        line = character_line()
        line["ways"]["gltfpack -cz"]["second_drawn"] = [60, 70]
        self.assertTrue(web.streaming_findings([streaming_line("Dragon", 10, 100, 900), line])[0].startswith("anna, by `encode --condense --meshopt`, is drawn in 1.33"))

    def test_the_least_times_of_a_character_count(self):
        self.assertEqual(web.character_rows(character_line())[1], ["encode --condense --meshopt", "77", "80", "80 (0.80)", "640", "720 (0.80)"])

    def test_the_page(self):
        text = web.streaming_page([streaming_line("Dragon", 10, 100, 900), character_line()], 3, "three 1.", **kHow)
        self.assertIn("| asset | loader | bytes | first triangles at 10 Mbit/s, ms | all at 10 Mbit/s, ms |", text)
        self.assertIn("## A character on a page", text)
        self.assertNotIn("Other programs", text)


class Sizes(unittest.TestCase):
    def test_tables(self):
        self.assertEqual(web.size_tables({"decoders": [["a", 1234, 567]], "encoders": [["b", 1, 2]]})[2], "| a | 1,234 | 567 |")


if __name__ == "__main__":
    unittest.main()
