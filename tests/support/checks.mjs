// Counts what a test checks. It goes on after a check that fails.
let checks = 0, failures = 0;

export function check(holds, what) {
  checks += 1;
  if (holds) return;
  failures += 1;
  console.log(`FAILED  ${what}`);
}

export function check_equal(value, expected, what) {
  check(value === expected, `${what}: ${JSON.stringify(value)} instead of ${JSON.stringify(expected)}`);
}

// Says how many checks hold, and ends the process: with 1 if one failed, or if there was none.
export function finish(name) {
  console.log(`${name}: ${checks - failures} of ${checks} checks hold`);
  process.exit(failures > 0 || checks === 0 ? 1 : 0);
}
