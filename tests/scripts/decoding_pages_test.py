#!/usr/bin/env python3
"""Tests what the pages about decoding, the partition, condensed patches and `--profile size` say, on invented measurements. Nothing is
timed here."""
import datetime, pathlib, sys, unittest

root = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(root / "scripts"))
from benchmarks import condensed, decoding, partition, profile
from benchmarks.pages import span
from benchmarks.ratios import samples_of

kHow = {"words": ["scripts/some"], "today": datetime.date(2026, 11, 30), "processor": "Some CPU"}


def rows_with(text, *cells):
    """The rows of the page's tables that begin with these cells, without these."""
    begin = "| " + " | ".join(cells) + " |"
    return [[cell.strip() for cell in line[len(begin):].strip("|").split("|")] for line in text.split("\n") if line.startswith(begin)]


def iterations(times, more=None):
    """Google Benchmark's JSON of {benchmark: milliseconds of each repetition}, with aggregates as in its own."""
    entry = lambda name, kind, ms: {"name": name, "run_name": f"{name}/real_time", "run_type": kind, "real_time": ms, "time_unit": "ms"}
    repetitions = [{**entry(name, "iteration", ms), **(more or {}).get(name, {})} for name, samples in times.items() for ms in samples]
    return {"benchmarks": repetitions + [{**entry(name, "aggregate", 0), "bytes": 0} for name in times]}


class Decoding(unittest.TestCase):
    def results(self, connectivity_ms=5):
        samples = {}
        for kind in decoding.kinds():
            whole = "/whole/" in kind
            samples[f"{kind}/cpu/threads:1"] = [20, 20, 90]
            samples[f"{kind}/draco/threads:1"] = [40 if whole else 60] * 3
            if not whole:
                samples[f"{kind}/cpu/threads:2"], samples[f"{kind}/draco/threads:2"] = [13, 12.5, 90], [30] * 3
        stages, stage_samples = {}, {}
        for name in decoding.kStaged:
            stages[f"{name}/core_in_step"] = dict(zip(decoding.kStages, [connectivity_ms, 0, 2, 3, 4, 0]))
            stages[f"{name}/draco"] = dict(zip(decoding.kStages, [10, 0, 0, 0, 0, 30]))
            stage_samples |= {f"{name}/core_in_step": [15, 16, 99], f"{name}/draco": [41]}
        peaks = {(kind, decoder): 100 if decoder == "draco" else 125 if "/whole/" in kind else 50 for kind in decoding.kinds() for decoder in ("cpu", "draco")}
        return {"mesh": "Dragon", "rounds": 3, "samples": samples, "stages": stages, "stage_samples": stage_samples, "peaks": peaks}

    def test_findings_begin_with_memory(self):
        found = decoding.findings(self.results())
        self.assertEqual(found[0], "psplit takes 1.25 times libdraco's memory for whole streams, and 0.50 times for patches.")
        self.assertEqual(found[1], "On one thread it decodes patches of 4,800 and 1,200 faces 3.00 times as fast as libdraco, and whole streams 2.00 times.")
        self.assertEqual(found[2], "Patches decode 1.60 times as fast on 2 threads as on one.")

    def test_a_slower_stage_is_named(self):
        self.assertIn("takes longer than libdraco's in some cases: 1.50 times for `positions/4800/speed0`", decoding.findings(self.results(15))[1])

    def test_rows(self):
        text = decoding.text_of(self.results(), **kHow)
        self.assertEqual(rows_with(text, "positions", "4,800", "5"), [["20.0", "60.0", "3.00", "12.5", "30.0", "1.60", "50.0", "100.0"]])
        self.assertEqual(rows_with(text, "positions", "whole", "0"), [["20.0", "40.0", "2.00", "", "", "", "125.0", "100.0"]])
        # A stage that a decoder does not have, or does not time, is empty.
        self.assertEqual(rows_with(text, "`positions/4800/speed5`"), [["psplit", "5.0", "", "2.0", "3.0", "4.0", "", "15.0"]])
        self.assertEqual(rows_with(text, "", "libdraco")[0], ["10.0", "", "", "", "", "30.0", "41.0"])

    def test_stages_are_those_of_the_fastest_repetition(self):
        report = iterations({"a/core": [20, 10, 30]})
        for entry, ms in zip(report["benchmarks"], (3, 4, 9, 0)):
            entry |= dict.fromkeys(decoding.kStages, ms)
        self.assertEqual(decoding.stages_of(report), {"a/core": dict.fromkeys(decoding.kStages, 4)})


class Partition(unittest.TestCase):
    def line(self, patch_faces, ours, metis, paper):
        contender = lambda share, one, two, apart=0: {"patches": 10, "replication": share, "balance": 1.05, "apart": apart, "one_thread_ms": one,
                                                      "two_threads_ms": two}
        return {"faces": 48000, "patch_faces": patch_faces, "psplit": contender(ours, [30, 20, 25], [10, 10, 16]), "METIS": contender(metis, [40] * 3, [], 2),
                "paper": contender(paper, [], [50]), "meshlets": contender(0.2, [1], [], 3)}

    def test_findings_begin_with_what_replicates_fewer_points(self):
        found = partition.findings({"skull": [self.line(4800, 0.03, 0.031, 0.028), self.line(440, 0.12, 0.11, 0.13)]})
        self.assertEqual(found[0], "The paper's method replicates fewer points than psplit in 1 of 2 cases, by 0.20 % of a mesh's points, in 5.0 times the time.")
        self.assertEqual(found[1], "METIS replicates fewer in 1 of 2 (skull, 440 faces); on one thread psplit takes 0.50 of its time.")
        self.assertEqual(found[2], "None of psplit's patches has several components.")
        self.assertIn("in none of 1 cases, in 5.0 times", partition.findings({"skull": [self.line(440, 0.1, 0.2, 0.2)]})[0])

    def test_rows(self):
        text = partition.text_of({"skull": [self.line(4800, 0.03, 0.031, 0.028), self.line(440, 0.12, 0.11, 0.13)]}, 3, **kHow)
        self.assertEqual(rows_with(text, "skull, 48,000 faces", "4,800"), [["3.00 %", "3.10 %", "2.80 %", "20", "40", "10", "50", "1.050", "2"]])
        self.assertIn("meshlets of at most 440 faces replicate 20.0 %, 6 of 20 in several components.", text)


class Condensed(unittest.TestCase):
    def cases(self):
        times, bytes_of = {}, {}
        for size, plain, packed in (("whole", 1000, 950), ("440", 1400, 1020), ("4800", 1050, 900), ("1200", 1100, 1100)):
            for more, count, ms in (("", plain, 20), ("/condensed", packed, 25 if size == "whole" else 16)):
                name = f"positions/{size}/speed5{more}/cpu/threads:1"
                times[name], bytes_of[name] = [ms, ms, 3 * ms], {"bytes": count}
        report = iterations(times, bytes_of)
        lossless = {"mesh": "skull, lossless", "speed": 5, "size": 440, "stock": 5000, "ms": [], "patches": 5500, "condensed": 3000}
        return [*condensed.cases_of(report, "skull", samples_of(report)), lossless]

    def test_findings_begin_with_times(self):
        self.assertEqual(condensed.findings(self.cases()), [
            "On one thread condensed patches of 440 and 4,800 faces decode at 1.25 times the speed of ordinary patches, and one condensed patch alone at 0.80 times.",
            "At speed 5 condensed patches of 4,800 faces take 10.0 % fewer bytes than one stock stream, ordinary ones 5.0 % more.",
            "At speed 5 condensed patches of 440 faces take 2.0 % more bytes than one stock stream, ordinary ones 40.0 % more.",
            "Lossless ones take 40.0 % fewer than one lossless stream."])

    def test_changes_of_both_signs(self):
        self.assertEqual(condensed.change([-4.7, -12.72]), "4.7 to 12.7 % fewer")
        self.assertEqual(condensed.change([-2.2, 3]), "2.2 % fewer to 3.0 % more")
        self.assertEqual(condensed.change([0, 3]), "0.0 to 3.0 % more")

    def test_rows(self):
        text = condensed.text_of(self.cases(), [{"directory": 10, "fields": 15, "symbols": 25, "values": 50}], 3, **kHow)
        self.assertEqual(rows_with(text, "skull"), [["5", "whole", "1,000", "950 (-5.0 %)", "20.0", "25.0", "0.80"]])
        self.assertEqual(rows_with(text, "", "5", "440"), [["1,400 (+40.0 %)", "1,020 (+2.0 %)", "20.0", "16.0", "1.25"]])
        self.assertEqual(rows_with(text, "skull, lossless"), [["5", "440", "5,500 (+10.0 %)", "3,000 (-40.0 %)", "", "", ""]])
        self.assertIn("25 % of the saving of positions come from the directory and from fields that each Draco stream repeats, 25 % from the symbols", text)


class Profile(unittest.TestCase):
    kBytes = dict(zip(profile.kWays, (1000, 900, 800, 720)))

    def rounds(self):
        # The machine is three times as slow in the second round.
        seconds = {"default": 2, "`--profile size`": 5, "`--condense`": 3}
        return [{(command, way): k * seconds.get(way, 1) * (2 if command == "encode" else 1) for way in profile.kTimed for command in ("encode", "decode")}
                for k in (1, 3, 1)]

    def test_findings_begin_with_what_it_takes(self):
        found = profile.findings({"a": self.kBytes, "b": {**self.kBytes, "`--profile size`": 950}}, self.rounds(), "Dragon")
        self.assertEqual(found[0], "For the Dragon, `--profile size` takes 2.50 times the processor time of the default's `encode`, and 2.50 times that of its "
                         "`decode`; `--condense` takes 1.50 and 1.50 times.")
        self.assertEqual(found[1], "`--profile size` saves 5.0 to 20.0 % of the bytes of the default, and with `--condense` 28.0 %, which is 20.0 % of those "
                         "with `--condense` alone.")

    def test_rows(self):
        text = profile.text_of({"a": self.kBytes}, self.kBytes, self.rounds(), "Dragon", **kHow)
        self.assertEqual(rows_with(text, "a"), [["1,000", "900 (-10.0 %)", "800 (-20.0 %)", "720 (-28.0 %)"]])
        self.assertEqual(rows_with(text, "`--encode-speed 0`"), [["0.50", "0.50"]])
        self.assertEqual(rows_with(text, "default"), [])


class Spans(unittest.TestCase):
    def test_equal_ends_are_one_number(self):
        self.assertEqual(span([0.523, 0.98]), "0.52 to 0.98")
        self.assertEqual(span([0.521, 0.522]), "0.52")


if __name__ == "__main__":
    unittest.main()
