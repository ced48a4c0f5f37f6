#!/usr/bin/env python3
"""Tests scripts/bench on invented measurements. Nothing is timed here."""
import json, os, pathlib, shutil, subprocess, sys, tempfile, unittest

root = pathlib.Path(__file__).resolve().parent.parent.parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(root / "scripts"))
from benchmarks.ratios import allowance, compare, rival_of, samples_of, spread_of, summarize

kOurs, kRival = "positions/4800/speed5/cpu/threads:1", "positions/4800/speed5/draco/threads:1"


def report(times, unit="ms"):
    """Google Benchmark's JSON for these repetitions, with aggregates as in its own."""
    benchmarks = []
    for name, samples in times.items():
        for i, sample in enumerate(samples):
            benchmarks.append({"name": f"{name}/real_time", "run_name": f"{name}/real_time", "run_type": "iteration",
                               "repetitions": len(samples), "repetition_index": i, "real_time": sample, "time_unit": unit})
        benchmarks.append({"name": f"{name}/real_time_mean", "run_name": f"{name}/real_time", "run_type": "aggregate",
                           "aggregate_name": "mean", "real_time": 1e9, "time_unit": unit})
    return {"context": {}, "benchmarks": benchmarks}


def rows_of(ours, rival):
    return summarize(samples_of(report({kOurs: ours, kRival: rival})))


def verdicts(now, before, **more):
    return [verdict for *_, verdict in compare(now, before, **more)[0]]


class Ratios(unittest.TestCase):
    def test_every_benchmark_of_ours_has_its_rival(self):
        self.assertEqual(rival_of(kOurs), kRival)
        self.assertEqual(rival_of("positions/whole/speed0/core"), "positions/whole/speed0/draco")
        self.assertEqual(rival_of("positions/1200/speed0/core_in_step"), "positions/1200/speed0/draco")
        self.assertEqual(rival_of("partition/440/psplit/threads:2"), "partition/440/metis")
        for ours in ("stream", "patches/threads:2"):
            self.assertEqual(rival_of(f"encode/positions/speed5/{ours}"), "encode/positions/speed5/draco")
        for name in (kRival, "partition/440/metis", "positions/whole/speed0/draco"):
            self.assertIsNone(rival_of(name))

    def test_medians_are_of_repetitions_in_any_unit_without_aggregates(self):
        row, = rows_of([20, 22, 21], [80, 84, 400])
        self.assertEqual((row["name"], row["rival"]), (kOurs, kRival))
        self.assertEqual((row["median_ms"], row["rival_median_ms"], row["ratio"]), (21, 84, 0.25))
        self.assertEqual(samples_of(report({"a": [3e6]}, "ns"), report({"a": [4.0]}, "ms")), {"a": [3.0, 4.0]})

    def test_a_benchmark_without_its_rival_has_no_row(self):
        self.assertEqual(summarize(samples_of(report({kOurs: [1]}))), [])

    def test_a_benchmark_that_failed_is_an_error(self):
        broken = report({kOurs: [1]})
        broken["benchmarks"][0] |= {"error_occurred": True, "error_message": "it broke"}
        with self.assertRaisesRegex(ValueError, "it broke"):
            samples_of(broken)

    def test_spread_is_the_interquartile_range_divided_by_the_median(self):
        self.assertEqual(spread_of([100] * 8 + [900]), 0)
        self.assertAlmostEqual(spread_of([90, 95, 100, 105, 110]), 0.1)
        self.assertEqual(spread_of([7]), 0)


class Verdicts(unittest.TestCase):
    before = rows_of([20.0] * 9, [80.0] * 9)

    def test_a_slower_machine_does_not_change_the_ratio(self):
        self.assertEqual(verdicts(rows_of([60.0] * 9, [240.0] * 9), self.before), ["same"])

    def test_slower_and_faster_beyond_the_threshold_only(self):
        self.assertEqual(verdicts(rows_of([20.9] * 9, [80.0] * 9), self.before), ["same"])
        self.assertEqual(verdicts(rows_of([21.1] * 9, [80.0] * 9), self.before), ["slower"])
        self.assertEqual(verdicts(rows_of([18.0] * 9, [80.0] * 9), self.before), ["faster"])
        self.assertEqual(verdicts(rows_of([20.5] * 9, [80.0] * 9), self.before, threshold=0.02), ["slower"])

    def test_the_spread_of_either_run_allows_for_more(self):
        noisy = [18.0, 20.0, 20.5, 22.0, 22.5, 23.0, 24.0, 25.0, 26.0]
        now = rows_of(noisy, [80.0] * 9)
        self.assertEqual(verdicts(now, self.before), ["same"])
        self.assertAlmostEqual(allowance(now[0], self.before[0]), spread_of(noisy))
        self.assertEqual(verdicts(rows_of([22.5] * 9, [80.0] * 9), rows_of([20.0] * 9, [74.0, 80.0, 86.0] * 3)), ["same"])
        # A change by more than all spreads together is slower nevertheless.
        self.assertEqual(verdicts(rows_of([2 * ms for ms in noisy], [80.0] * 9), self.before), ["slower"])

    def test_noisy_if_the_spreads_are_too_wide(self):
        self.assertEqual(verdicts(rows_of([10.0, 20.0, 30.0] * 3, [80.0] * 9), self.before), ["noisy"])

    def test_new_and_missing_are_named(self):
        compared, missing = compare(self.before, [])
        self.assertEqual([verdict for *_, verdict in compared], ["new"])
        compared, missing = compare([], self.before)
        self.assertEqual((compared, missing), ([], [kOurs]))


class Script(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        # A copy of the scripts in a tree without a baseline.
        shutil.copytree(root / "scripts", self.folder / "scripts")
        (self.folder / "bench").mkdir()

    def bench(self, *arguments, mesh=None):
        environment = {name: value for name, value in os.environ.items() if name != "PSPLIT_BENCH_MESH"}
        if mesh:
            environment["PSPLIT_BENCH_MESH"] = mesh
        return subprocess.run([sys.executable, self.folder / "scripts/bench", *map(str, arguments)], text=True,
                              capture_output=True, env=environment)

    def write(self, name, ours, rival):
        path = self.folder / name
        path.write_text(json.dumps(report({kOurs: ours, kRival: rival})))
        return path

    def test_saves_a_baseline_and_compares_with_it(self):
        baseline = self.folder / "bench/baseline.json"
        first = self.bench("--reports", self.write("first.json", [20, 20.2, 19.9], [80, 80, 81]), "--save", baseline)
        self.assertEqual(first.returncode, 0, first.stderr)
        self.assertIn("no baseline", first.stderr)
        self.assertIn(kOurs, first.stdout)
        saved = json.loads(baseline.read_text())
        self.assertEqual(saved["benchmarks"][0]["ratio"], 0.25)
        for key in ("date", "command", "cpu", "threads", "mesh"):
            self.assertIn(key, saved)

        same = self.bench("--reports", self.write("same.json", [40, 40.2, 39.9], [160, 160, 161]))
        self.assertEqual(same.returncode, 0, same.stdout + same.stderr)
        self.assertNotIn("SLOWER", same.stdout)
        slower = self.bench("--reports", self.write("slower.json", [26, 26.2, 25.9], [80, 80, 81]))
        self.assertEqual(slower.returncode, 1, slower.stdout + slower.stderr)
        self.assertIn(f"SLOWER  {kOurs}", slower.stdout)
        lax = self.bench("--reports", self.folder / "slower.json", "--threshold", 40)
        self.assertEqual(lax.returncode, 0, lax.stdout + lax.stderr)

    def test_refuses_what_cannot_be_compared(self):
        reports = self.write("first.json", [20], [80])
        self.assertNotEqual(self.bench("--reports", reports, "--baseline", self.folder / "none.json").returncode, 0)
        self.bench("--reports", reports, "--save", self.folder / "bench/baseline.json")
        other = self.bench("--reports", reports, mesh="dragon.ply")
        self.assertNotEqual(other.returncode, 0)
        self.assertIn("dragon.ply", other.stderr)
        empty = self.folder / "empty.json"
        empty.write_text(json.dumps(report({kRival: [80]})))
        self.assertNotEqual(self.bench("--reports", empty).returncode, 0)


if __name__ == "__main__":
    unittest.main()
