// Some containers of the corpus on a GPU: scripts/web-gpu takes all.
import assert from 'node:assert/strict';
import test from 'node:test';
import { skip as no_browser, need_browser } from './browser.mjs';
import { no_deno } from './webgpu_compilers.mjs';
import { compare_in_chromium, compare_in_dawn, compare_in_deno, make_batches, skip as no_corpus, summary } from './webgpu_corpus.mjs';
import { skip as no_gpu } from './webgpu_device.mjs';

const batches = no_corpus ? [] : make_batches(true);
need_browser();
for (const [name, run, why] of [['in Dawn', compare_in_dawn, no_gpu], ['in Chromium', compare_in_chromium, no_browser],
  ['in Deno, whose WebGPU is not Dawn', compare_in_deno, no_gpu || no_deno]])
  test(`containers of the corpus ${name}`, { skip: no_corpus || why }, async (t) => {
    const sum = await run(batches);
    t.diagnostic(summary(sum));
    assert.deepEqual(sum.differences, []);
    assert.ok(sum.equal > 20, summary(sum));
  });
