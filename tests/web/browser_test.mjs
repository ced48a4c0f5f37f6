// Tests of browser.mjs itself: a test sees everything that its page reports.
import assert from 'node:assert/strict';
import { page_test } from './browser.mjs';

page_test('errors of a page, its workers and its policy are seen', {
  headers: { 'Content-Security-Policy': "script-src 'self'" },
  files: { '/worker.js': "console.error('from a worker'); throw new Error('thrown in a worker');" },
  script: async () => {
    setTimeout(() => { throw new Error('thrown in the page'); });
    await fetch('/nowhere').catch(() => {});
    console.error('from the page');  // puppeteer may lose what a page says while it is opened
    const inline = document.createElement('script');
    inline.textContent = '1';
    document.body.append(inline);
    await new Promise((resolve) => { new Worker('/worker.js').onerror = resolve; });
    await new Promise((resolve) => setTimeout(resolve, 200));
  },
  errors: [/^from the page$/, /thrown in the page/, /404|\/nowhere/, /inline script violates/, /from a worker/,
    /thrown in a worker/],
}, ({ result }) => result);

page_test('a script that rejects', { script: async () => { throw new RangeError('as it should'); } },
  ({ result }) => assert.rejects(result, /as it should/));
