#!/usr/bin/env python3
"""Tests what scripts/typical, scripts/rivals and scripts/first-decode compute, on invented measurements. Nothing is timed here."""
import datetime, pathlib, sys, unittest

root = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(root / "scripts"))
from benchmarks import rivals
from benchmarks.pages import extremes, join, noise, page, rows_by_subject, table


def run_of(version, codec, psplit_ms, size, faces=20000, **forms):
    """A line of typical_benchmark."""
    return {"faces": faces, "psplit_ms": psplit_ms, "libdraco_ms": 3 * psplit_ms, "bytes": size,
            "meshoptimizer": {"version": version, "codec": codec, **{form: {"bytes": b, "ms": ms} for form, (b, ms) in forms.items()}}}


def asset_of(new_bytes, faces=20000):
    return rivals.merge([run_of("0.18", 0, 2, 1000, faces, plain=(3000, 0.5), zstd=(2000, 1)),
                         run_of("1.2", 1, 4, 1000, faces, plain=(2500, 0.5), zstd=(1600, 1), brotli=(new_bytes, 2))])


def report_of(version, codec, ours_ms, stock_ms, rival_ms, patches=(1, 8)):
    """What `compare --format json` says."""
    row = lambda size, ms: {"version": version, "codec_version": codec, "bytes": size, "decode_ms": ms}
    split = lambda count: {"patches": count, "bytes": 1000 + count, "directory_bytes": 0 if count == 1 else 64, "decode": [
        {"backend": "draco", "threads": 1, "median_ms": 99, "lower_quartile_ms": 0, "upper_quartile_ms": 99},
        *({"backend": "cpu", "threads": threads, "median_ms": ours_ms / threads, "lower_quartile_ms": 0.9 * ours_ms / threads,
           "upper_quartile_ms": 1.2 * ours_ms / threads} for threads in (1, 2))]}
    return {"faces": 5000, "stock": {"speed": 5, "bytes": 1000, "decode_ms": stock_ms}, "splits": [split(count) for count in patches],
            "meshopt_plain": row(3000, rival_ms / 2), "meshopt": row(1300, rival_ms), "meshopt_brotli": row(1200, 3 * rival_ms) if codec else None}


class Typical(unittest.TestCase):
    def test_each_meshoptimizer_is_compared_with_psplit_of_its_own_run(self):
        asset = asset_of(1250)
        self.assertEqual(asset["psplit_ms"], 2)
        self.assertNotIn("meshoptimizer", asset)
        self.assertEqual(asset["rivals"]["0.18, codec 0"]["zstd"], {"time": 2, "bytes": 0.5})
        self.assertEqual(asset["rivals"]["1.2, codec 1"]["brotli"], {"time": 2, "bytes": 0.8})
        self.assertEqual(rivals.rivals_of([asset]), ["0.18, codec 0", "1.2, codec 1"])
        self.assertEqual(rivals.forms_of([asset], "0.18, codec 0"), ["plain", "zstd"])

    def test_rows_have_means_and_say_how_often_the_rival_is_smaller(self):
        rows = rivals.rival_rows([asset_of(500), asset_of(2000, faces=2000)])
        self.assertEqual([row[:2] for row in rows], [["0.18, codec 0", "alone"], ["0.18, codec 0", "zstd"], ["1.2, codec 1", "alone"],
                                                     ["1.2, codec 1", "zstd"], ["1.2, codec 1", "brotli"]])
        # Of bytes 1000 / 500 and 1000 / 2000: the geometric mean is 1; small assets have 0.5.
        self.assertEqual(rows[-1][2:], ["2.00", "2.00", "1.00", "0.50", "1 of 2"])

    def test_the_first_sentence_is_about_the_newest_rival_with_its_fewest_bytes(self):
        text = rivals.where_the_rival_wins([asset_of(500), asset_of(2000)])
        self.assertTrue(text.startswith("meshoptimizer 1.2 with brotli decodes faster than psplit on one thread in 2 of 2 assets (of all, at 2.0 to 2.0 times"))
        self.assertIn("makes 1 of them smaller; psplit's streams take 1.00 times its bytes.", text)
        self.assertNotIn("fewer than", text)
        self.assertIn("and 0.50 times where an asset has fewer than 10,000", rivals.where_the_rival_wins([asset_of(500), asset_of(2000, 9999)]))


class Patches(unittest.TestCase):
    def test_ratios_are_of_one_report_and_rows_of_all(self):
        # The second machine state is twice as slow.
        reports = [report_of("0.18", 0, 10, 30, 2), report_of("1.2", 1, 20, 60, 2)]
        rows = {row[0]: row[1:] for row in rivals.summarize(reports)}
        self.assertEqual(rows["libdraco, one stream a primitive, speed 5"], ["1,000", "+0.0 %", "45.00", "1.00", ""])
        self.assertEqual(rows["psplit, 8 patches"], ["1,008", "+0.8 %", "15.00", "0.33", "7.50"])
        self.assertEqual(rows["meshoptimizer 1.2, codec 1, zstd"], ["1,300", "+30.0 %", "2.00", "0.03", ""])
        self.assertEqual(rows["meshoptimizer 1.2, codec 1, brotli"], ["1,200", "+20.0 %", "6.00", "0.10", ""])
        self.assertNotIn("meshoptimizer 0.18, codec 0, zstd", rows)
        self.assertNotIn("meshoptimizer 1.2, codec 1", rows)

    def test_the_sentence_takes_the_smallest_form_of_the_last_build(self):
        reports = [report_of("0.18", 0, 10, 30, 2), report_of("1.2", 1, 12, 60, 2)]
        self.assertEqual(rivals.newest_rival(reports), "meshoptimizer 1.2, codec 1, brotli decodes 2.0 times as fast as psplit's 8 patches "
                         "on one thread, and takes 1.19 times the bytes.")
        self.assertIn("as fast as psplit's one stream a primitive", rivals.newest_rival([report_of("1.2", 1, 12, 60, 2, patches=(1,))]))
        self.assertIn("takes 2.0 times as long to decode as psplit's", rivals.newest_rival([report_of("1.2", 1, 12, 60, 8)]))

    def test_spreads_are_psplits(self):
        for spread in rivals.spreads_of(report_of("1.2", 1, 10, 30, 2)):
            self.assertAlmostEqual(spread, 0.3)


class FirstDecodes(unittest.TestCase):
    @staticmethod
    def line(first, warm, faults):
        return {"first_ms": first, "warm_ms": warm, "woken_ms": 3 * warm, "faults": faults}

    def rounds(self):
        # The machine is three times as slow in the second round.
        return [{"libdraco": self.line(20 * k, 12 * k, 100), "psplit, 1 thread": self.line(10 * k, 4 * k, 80 + k),
                 "psplit, 2 threads": self.line(8 * k, 2 * k, 90), "meshoptimizer 1.2, codec 1, zstd": self.line(2 * k, 1 * k, 9)}
                for k in (1, 3, 1)]

    def test_ratios_are_of_one_round(self):
        rounds = [{"libdraco": of.pop("libdraco"), "meshoptimizer 0.18, codec 0, zstd": self.line(3, 2, 9), **of} for of in self.rounds()]
        rows = {row[0]: row[1:] for row in rivals.first_decode_rows(rounds)}
        self.assertEqual(list(rows), ["libdraco", "psplit, 1 thread", "psplit, 2 threads", "meshoptimizer 1.2, codec 1, zstd"])
        self.assertEqual(rows["psplit, 1 thread"], ["10.00", "4.00", "12.00", "0.50", "0.33", "0.33", "81"])
        self.assertEqual(rows["libdraco"][3:6], ["1.00", "1.00", "1.00"])

    def test_findings_begin_with_the_rival(self):
        slower = [{**of, "meshoptimizer 1.2, codec 1, zstd": self.line(5 * of["libdraco"]["first_ms"] / 20, 1, 9)} for of in self.rounds()]
        text = rivals.first_decode_findings({"a": self.rounds(), "b": slower})
        self.assertEqual(text[0], "The first decode by meshoptimizer 1.2, codec 1, zstd, is 2.0 to 5.0 times as fast as psplit's on one thread.")
        self.assertIn("psplit on one thread is, over libdraco, 2.0 to 2.0 times as fast in the first decode of a process, 3.0 to 3.0", text[1])
        self.assertIn("0.80 to 0.80 times the time of one", text[2])

    def test_spreads_are_those_of_psplit(self):
        spreads = rivals.first_decode_spreads({"a": self.rounds()})
        self.assertEqual(len(spreads), 4)
        self.assertEqual(spreads[0], 1.0)  # 10, 10 and 30: the quartiles are 10 and 20


class Pages(unittest.TestCase):
    def test_a_page_begins_with_findings_and_says_how_it_was_made(self):
        text = page("Title", ["A rival wins.", "More."], ["| a |"], [0.1] * 20, ["/x/scripts/typical", "--meshoptimizer", "/home/me/current"],
                    datetime.date(2026, 11, 5), "Some CPU")
        self.assertEqual(text.split("\n")[:3], ["# Title", "", "A rival wins. More."])
        self.assertIn("`scripts/typical --meshoptimizer current` wrote this page on 5 November 2026, measured on \"Some CPU\"", text)
        self.assertTrue(text.endswith("\n| a |\n"))
        self.assertNotIn("Other programs", text)

    def test_noise_is_said(self):
        self.assertEqual(noise([0.3] + [0.1] * 9), "")
        self.assertIn("2 of 10 times vary by more than 20 %", noise([0.3] * 2 + [0.1] * 8))

    def test_extremes_are_the_first_and_the_last_of_the_order(self):
        self.assertEqual(extremes([3, 1, 5, 2, 4], lambda row: row, 2), [1, 2, 4, 5])
        self.assertEqual(extremes([3, 1, 2], lambda row: row, 2), [1, 2, 3])

    def test_tables_and_lists(self):
        self.assertEqual(table(["a", "b", "c"], [[1, 2, 3]], 2), ["| a | b | c |", "|---|---|--:|", "| 1 | 2 | 3 |"])
        self.assertEqual(rows_by_subject({"a": [[1], [2]], "b": [[3]]}), [["a", 1], ["", 2], ["b", 3]])
        self.assertEqual([join(list("a")), join(list("ab")), join(list("abc"))], ["a", "a and b", "a, b and c"])


if __name__ == "__main__":
    unittest.main()
