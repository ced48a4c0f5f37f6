#!/usr/bin/env python3
"""Tests the sentences with which measured pages begin, and pages with a section for each processor, on invented figures. Nothing is
timed here."""
import datetime, pathlib, sys, tempfile, unittest

root = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(root / "scripts"))
from benchmarks import rivals
from benchmarks.encode_rows import encode_findings, kHead, kRival, kStreams, stream_rows
from benchmarks.findings import batch_findings, kTypicalHead, libdraco_findings, out_of_core_findings, python_findings, typical_findings
from benchmarks.pages import cells_of, page_by_processor, script_name, sections_of, span, table, text_before, value_of


def written(processor, ms, before):
    """A page that says which milliseconds all its sections have."""
    return page_by_processor("Title", lambda tables: [f"{len(tables)} processors, {[each['psplit']['ms'] for each in tables]}."], ["More."],
                             ["A sentence.", "", *table(["codec", "ms"], [["psplit", ms]])], before, [0.1], [str(root / "scripts/rivals"), "--dragon"],
                             datetime.date(2026, 11, 5), processor)


class Processors(unittest.TestCase):
    def test_a_run_replaces_its_own_section_and_keeps_the_others(self):
        first = written("A (R) CPU", "5.0", "")
        self.assertEqual(first.split("\n")[:7], ["# Title", "", "1 processors, ['5.0'].", "", "More.", "", "## A (R) CPU"])
        both = written("B", "7.0", first)
        self.assertIn("2 processors, ['7.0', '5.0'].", both)
        self.assertEqual(list(sections_of(both)), ["B", "A (R) CPU"])
        self.assertEqual(sections_of(both)["A (R) CPU"], sections_of(first)["A (R) CPU"])
        again = written("A (R) CPU", "4.0", both)
        self.assertEqual(list(sections_of(again)), ["A (R) CPU", "B"])
        self.assertIn("2 processors, ['4.0', '7.0'].", again)
        self.assertEqual(written("A (R) CPU", "4.0", again), again)

    def test_a_section_says_how_it_was_made(self):
        self.assertIn("`scripts/rivals --dragon` wrote this section on 5 November 2026, measured on \"B\" with", written("B", "7.0", ""))

    def test_the_first_table_of_a_section_is_read(self):
        text = "Words.\n\n" + "\n".join(table(["codec", "bytes", "ms"], [["a, b", "1,000", ""], ["c", "+1.4 %", "2.5"]])) + "\n\n| d |\n|---|\n| e |"
        self.assertEqual(cells_of(text), {"a, b": {"codec": "a, b", "bytes": "1,000", "ms": ""}, "c": {"codec": "c", "bytes": "+1.4 %", "ms": "2.5"}})

    def test_numbers_and_names(self):
        self.assertEqual([value_of(cell) for cell in ("1,170,090", "+1.4 %", "-7.2 %", "2.5")], [1170090, 1.4, -7.2, 2.5])
        self.assertEqual([span([3.614, 2.55]), span([2]), span([2.55, 3.61], 1)], ["2.55 to 3.61", "2.00", "2.5 to 3.6"])
        self.assertEqual([script_name(root / "bindings/python/benchmark.py"), script_name("/x/scripts/typical")],
                         ["bindings/python/benchmark.py", "scripts/typical"])
        with tempfile.TemporaryDirectory() as folder:
            page, other = pathlib.Path(folder, "page.md"), pathlib.Path(folder, "other.md")
            self.assertEqual(text_before(page, page), "")
            page.write_text("old")
            self.assertEqual([text_before(page, output) for output in (page, "-", other)], ["old", "old", ""])


def split(patches, condensed, size, one, two):
    return {"patches": patches, "condensed": condensed, "bytes": size, "directory_bytes": 0 if patches == 1 and not condensed else 64,
            "decode": [{"backend": "cpu", "threads": 1, "median_ms": one}, {"backend": "cpu", "threads": 2, "median_ms": two}]}


def report_of(version, k, codec=1):
    """What `compare --condense --format json` says, k times as slow."""
    row = lambda size, ms: {"version": version, "codec_version": codec, "bytes": size, "decode_ms": ms * k}
    splits = [(1, False, 1000, 40, 40), (1, True, 930, 50, 50), (8, False, 1020, 40, 20), (8, True, 950, 50, 25), (20, False, 1060, 32, 18),
              (20, True, 940, 50, 25), (90, False, 1300, 50, 25)]
    return {"stock": {"speed": 5, "bytes": 1000, "decode_ms": 100 * k},
            "splits": [split(patches, condensed, size, one * k, two * k) for patches, condensed, size, one, two in splits],
            "meshopt_plain": row(3000, 5), "meshopt": row(1500, 10), "meshopt_brotli": row(1400, 50)}


class SpeedUps(unittest.TestCase):
    reports = [report_of("0.18", 1, codec=0), report_of("1.2", 2), report_of("0.18", 1, codec=0), report_of("1.2", 2)]

    def test_rows_are_those_that_users_choose_and_ratios_are_of_one_report(self):
        rows = rivals.speed_up_rows(self.reports)
        self.assertEqual(rows[0], ["libdraco, one stream a primitive, speed 5", "1,000", "+0.0 %", "150.0", "1.00", "", ""])
        self.assertEqual(rows[1][1:], ["1,000", "+0.0 %", "60.0", "2.50", "60.0", "2.50"])
        self.assertEqual([row[0] for row in rows[2:]], ["psplit, 8 patches", "psplit, 8 patches, condensed", "psplit, 20 patches",
                                                        "meshoptimizer 0.18, codec 0, zstd", "meshoptimizer 1.2, codec 1, zstd",
                                                        "meshoptimizer 1.2, codec 1, brotli"])
        self.assertEqual(rows[3][1:], ["950", "-5.0 %", "75.0", "2.00", "37.5", "4.00"])
        self.assertEqual(len(rows[0]), len(rivals.kSpeedUpHead))

    def test_findings_have_the_ranges_of_all_processors_and_the_bytes_of_the_first(self):
        here = cells_of("\n".join(table(rivals.kSpeedUpHead, rivals.speed_up_rows(self.reports))))
        old = {"psplit, 8 patches": dict.fromkeys(rivals.kSpeedUpHead, "3.00") | {"bytes": ""}}
        text = rivals.speed_up_findings([here, old])
        self.assertEqual(text[0], "meshoptimizer 0.18, codec 0, zstd, decodes 4.0 times as fast as psplit's 8 patches on one thread, and takes 1.47 "
                         "times the bytes; meshoptimizer 1.2, codec 1, brotli, takes 1.37 times.")
        self.assertEqual(text[1], "psplit's 8 patches decode 2.50 to 3.00 times as fast as stock Draco on one thread, and 3.00 to 5.00 times on two, "
                         "for 2.0 % more bytes.")
        self.assertEqual(text[2], "Condensed, they take 5.0 % fewer bytes than stock Draco, and decode 2.00 times as fast as it on one thread.")


class Typical(unittest.TestCase):
    def test_findings_have_the_ranges_of_all_processors_at_the_speeds_of_the_first(self):
        here, there = (cells_of("\n".join(table(kTypicalHead, rows))) for rows in (
            [["5", "40", "3.10", "2.05", "1.85 (12)"]], [["5", "40", "3.43", "2.24", "1.73 (12)"], ["0", "40", "3.33", "1.90", ""]]))
        self.assertEqual(typical_findings([here, there]), "At speed 5, psplit decodes 3.10 to 3.43 times as fast as libdraco, on the processors below, "
                         "and no asset less than 2.05 times.")
        self.assertEqual(typical_findings([there, here]), "At speeds 5 and 0, psplit decodes 3.10 to 3.43 and 3.33 times as fast as libdraco, in this "
                         "order, on the processors below, and no asset less than 1.90 times.")


class Encoding(unittest.TestCase):
    @staticmethod
    def table_of(*ratios, memory=90):
        names = [kRival, *(f"gltf-psplit encode{more} -j {threads}" for more in ("", " --condense") for threads in (1, 2))]
        rows = [[f"`{name}`", "1.00", ratio, "1.00", "1.00", size] for name, ratio, size in zip(names, ("1.00", *ratios), [100] + [memory] * 4)]
        return cells_of("\n".join(table(["mesh", *kHead], rows)))

    def test_findings_have_the_ranges_of_all_processors(self):
        text = encode_findings([self.table_of("0.64", "0.47", "0.98", "0.60"), self.table_of("0.57", "0.50", "0.76", "0.60")])
        self.assertEqual(text, ["`encode`, which verifies what it writes, takes 0.57 to 0.64 of the time of `draco_encoder` on one thread, and 0.47 to "
                                "0.50 on two; with `--condense` 0.76 to 0.98 and 0.60."])

    def test_what_takes_more_than_the_rivals_comes_first(self):
        text = encode_findings([self.table_of("0.64", "0.47", "1.20", "0.60", memory=104)])
        self.assertTrue(text[0].startswith("`gltf-psplit encode --condense -j 1` takes up to 1.20 times the time of `draco_encoder`, "
                                           "`gltf-psplit encode -j 1` takes up to 1.04 times the memory of `draco_encoder`, "), text[0])
        self.assertEqual(len(text), 2)

    def test_rows_of_streams_have_a_ratio_for_each_speed(self):
        rows = stream_rows([{"name": f"{name}/speed{speed}/stream", "ratio": speed / 10} for name in kStreams for speed in (0, 5, 10)])
        self.assertEqual(rows[0], ["positions", "0.00", "0.50", "1.00"])
        self.assertEqual(len(rows), len(kStreams))


class OneProgram(unittest.TestCase):
    def test_libdracos_place(self):
        streams = [["a", "9", "3", "3.00", "", "2.90"], ["b", "9", "3", "2.87", "", "1.81"]]
        text = libdraco_findings(streams, [["draco_decoder, a", "1", "1", "2.15"], ["draco_decoder, b", "1", "1", "0.80"], ["c", "1", "1", "1.00"]])
        self.assertEqual(text, ["In libdraco's place, draco_decoder, b takes 1.25 times the time.", "psplit fills libdraco's classes 2.87 to 3.00 times as "
                                "fast as libdraco on one thread, and 1.81 to 2.90 times in the first decode of a process.",
                                "Other whole programs are 1.00 to 2.15 times as fast."])
        self.assertTrue(libdraco_findings(streams, [["a", "1", "1", "2.00"]])[-1].startswith("Whole programs are 2.00 times"))

    def test_python(self):
        decoding = [["ours", "", "1.00", "", "1.00"], ["C++", "", "0.98", "", "1.01"], ["DracoPy", "", "9.50", "", "6.40"],
                    ["libdraco", "", "2.60", "", "2.60"]]
        text = python_findings("dragon", decoding, [["encode", "", "1.00", "", "1.00"], ["theirs", "", "1.49", "", "1.43"]], {"encode": 1000, "theirs": 980})
        self.assertEqual(text, ["theirs makes 2.0 % fewer bytes of dragon than encode.", "C++ takes 0.98 to 1.01 times the time of ours.",
                                "DracoPy takes 6.40 to 9.50 times and libdraco takes 2.60 times the time of ours.",
                                "theirs takes 1.43 to 1.49 times the time of encode."])

    def test_batches(self):
        speeds = [["10,000", "one shard, 2 threads: encoded", "5.3", "1,896", "900"], ["10,000", "one shard, 2 threads: up to date", "1.2", "8,383", "200"]]
        memory = [["1,000,000", "`batch plan`", "415.6", "", "5.0"], ["1,000", "manifest, all", "8.0", "11.6", "1.0"],
                  ["1,000,000", "manifest, shard", "8.5", "11.8", "1.0"], ["1,000,000", "record", "8.3", "81.8", "1.0"]]
        self.assertEqual(batch_findings(speeds, memory), [
            "`batch plan` of 1,000,000 lines takes 415.6 MB, the most of all steps.",
            "A batch takes 8.0 MB for a manifest of 1,000 lines and 8.5 MB for a manifest of 1,000,000 lines.",
            "One shard on two threads encodes 1,896 assets a second, at 900 microseconds of CPU each; if all are up to date, it checks 8,383 a second."])
        self.assertEqual(len(batch_findings(speeds, [])), 1)

    def test_larger_than_memory(self):
        rows = [["3,000,000", "encode in memory", "4.5", "6.0", "1,500", "600", "1", "0"], ["30,000,000", "generate", "9.0", "9.0", "300", "20", "1", "0"],
                ["30,000,000", "encode", "60.0", "90.0", "2,000", "800", "1", "0"]]
        self.assertEqual(out_of_core_findings(rows, "1GB"), ["Encoding 30,000,000 triangles with `--memory 1GB` takes 60.0 seconds and 800 MB: "
                                                             "1.33 times as long for each triangle as 3,000,000 triangles in memory, which take 600 MB."])


if __name__ == "__main__":
    unittest.main()
