// Checks a Job, and a Pod on its volume, against the OpenAPI schema of Kubernetes:  check_job.mjs job.yaml pod.yaml
import { readFileSync } from 'node:fs';
import assert from 'node:assert';
import { Job } from 'kubernetes-models/batch/v1';
import { Pod } from 'kubernetes-models/v1';
import { parse } from 'yaml';

const [job, pod] = process.argv.slice(2).map((path) => parse(readFileSync(path, 'utf8')));
new Job(job).validate();
new Pod(pod).validate();
assert.deepEqual(pod.spec.volumes, job.spec.template.spec.volumes);

// The schema notices mistakes.
const mistakes = [
  (spec) => { spec.podFailurePolicy.rules[1].action = 'Retry'; },
  (spec) => { spec.podFailurePolicy.rules[1].onExitCodes.values = '75'; },
  (spec) => { spec.completions = '128'; },
  (spec) => { delete spec.template.spec.containers[0].name; },
];
for (const make_mistake of mistakes) {
  const wrong = structuredClone(job);
  make_mistake(wrong.spec);
  assert.throws(() => new Job(wrong).validate(), undefined, make_mistake.toString());
}

// What the schema does not say: https://kubernetes.io/docs/concepts/workloads/controllers/job/
const { spec } = job;
assert.equal(spec.template.spec.restartPolicy, 'Never', 'podFailurePolicy needs it');
assert.equal(spec.completionMode, 'Indexed', 'backoffLimitPerIndex needs it');
assert.ok(spec.maxFailedIndexes <= spec.completions);
const containers = spec.template.spec.containers.map((container) => container.name);
for (const { onExitCodes } of spec.podFailurePolicy.rules) {
  if (!onExitCodes) continue;
  assert.ok(containers.includes(onExitCodes.containerName));
  assert.deepEqual(onExitCodes.values, [...onExitCodes.values].sort((a, b) => a - b), 'the API server wants them in order');
  assert.ok(onExitCodes.operator === 'NotIn' || !onExitCodes.values.includes(0));
}
