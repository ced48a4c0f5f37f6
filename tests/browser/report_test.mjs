// Tests the page of `gltf-psplit compare --format html` in a browser without a network, in light and in dark mode:
//
//   node report_test.mjs WRITE_REPORTS MODULES OUT [SEED]
//
// WRITE_REPORTS (write_reports.cpp) writes pages with random times. SEED chooses other times.
//
// The page prints nothing on the console, requests only itself, and has a mark for every number of its tables. Nothing is
// clipped, overlaps or is hard to read: in wide windows, on phones (where charts are drawn for narrow windows, and tables scroll in
// boxes of their own and say so), and on paper (where results come first and words last, no page is half empty, every cell of every
// table is on a page, and every heading is on the page of its text). Screenshots and PDFs stay in OUT. MODULES is the folder where npm installed tests/validator. Without Chromium, pdftotext or MODULES the test says so and
// exits with 77.
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { check, check_equal, finish } from '../support/checks.mjs';

const [write_reports, modules, out, seed = '1'] = process.argv.slice(2);
function skip(why) {
  console.log(`skipped: ${why}`);
  process.exit(77);
}
if (!modules || !existsSync(path.join(modules, 'node_modules/puppeteer-core')))
  skip('npm has not installed tests/validator: -DPSPLIT_VALIDATOR names its folder');
const chromium = ['chromium', 'chromium-browser', 'google-chrome']
  .map((name) => spawnSync('sh', ['-c', `command -v ${name}`], { encoding: 'utf8' }).stdout.trim())
  .find((found) => found);
if (!chromium) skip('no Chromium (Debian: chromium)');
if (spawnSync('pdftotext', ['-v']).error) skip('no pdftotext (Debian: poppler-utils)');
const puppeteer = createRequire(path.resolve(modules, 'package.json'))('puppeteer-core');

mkdirSync(out, { recursive: true });

// Makes the page of a mesh; also returns the number of its splits. A file name may contain characters that mean something to
// HTML.
function make_report(input, counts, threads) {
  execFileSync(write_reports, [out, seed, input, String(threads), ...counts.map(String)]);
  return { page: path.join(out, `${seed}.html`), input, splits: counts.length };
}

// Collects the facts about the page; runs in the browser.
function look() {
  const all = (selector, within = document) => [...within.querySelectorAll(selector)];
  const luminance = (color) => {
    const [r, g, b] = color.match(/[\d.]+/g).slice(0, 3).map((part) => {
      const value = part / 255;
      return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
    });
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const page_color = getComputedStyle(document.body).backgroundColor;
  const contrast = (color) => {
    const [low, high] = [luminance(page_color), luminance(color)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  const box_of = (element) => element.getBoundingClientRect();
  const outside = (inner, outer) => inner.left < outer.left - 1 || inner.right > outer.right + 1 ||
    inner.top < outer.top - 1 || inner.bottom > outer.bottom + 1;
  const touch = (a, b) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 3 && b.top < a.bottom - 3;

  const problems = [];
  // Each chart has a drawing for wide windows and one for narrow windows, and shows one of them.
  const shown = (chart) => all('.plot svg', chart).filter((svg) => box_of(svg).width > 0);
  for (const svg of all('figure.chart').flatMap(shown)) {
    const frame = box_of(svg), texts = all('text', svg), name = svg.closest('figure').id;
    if (shown(svg.closest('figure')).length !== 1) problems.push(`${name} is drawn twice`);
    if (frame.left < -1 || frame.right > innerWidth + 1) problems.push(`${name} is wider than the window`);
    if (innerWidth < 600 && frame.width < 0.8 * innerWidth) problems.push(`${name} does not fill the window`);
    const scale = frame.width / svg.viewBox.baseVal.width;
    if (scale < 0.75 || scale > 1.7) problems.push(`the letters of ${name} are scaled by ${scale}`);
    const [next] = all('text.tick', svg);
    if (box_of(next).height < 10) problems.push(`${name}: letters of ${box_of(next).height} pixels`);
    if (!svg.getAttribute('aria-label')) problems.push(`${name} has no name`);
    for (const element of [...texts, ...all('.mark, .line, .spread', svg)])
      if (outside(box_of(element), frame)) problems.push(`${name}: ${element.outerHTML} is clipped`);
    texts.forEach((a, i) => texts.slice(i + 1).forEach((b) => {
      if (touch(box_of(a), box_of(b))) problems.push(`${name}: "${a.textContent}" and "${b.textContent}" overlap`);
    }));
    for (const mark of all('.mark', svg)) {
      if (!mark.querySelector('title')?.textContent) problems.push(`${name}: a mark without title`);
      const style = getComputedStyle(mark);
      if (contrast(mark.matches('.hollow') ? style.stroke : style.fill) < 3) problems.push(`${name}: a mark is hard to see`);
    }
    for (const text of texts)
      if (contrast(getComputedStyle(text).fill) < 4.5) problems.push(`${name}: "${text.textContent}" is hard to read`);
  }
  for (const element of all('h1, h2, p, dt, dd, li, figcaption, th, td, caption'))
    if (contrast(getComputedStyle(element).color) < 4.5) problems.push(`"${element.textContent}" is hard to read`);
  // A region that is wider than its box scrolls and says so; other content is not cut off.
  let scrolling = 0;
  for (const region of all('.scroll')) {
    const is_cut = region.scrollWidth > region.clientWidth + 1;
    const hint = region.previousElementSibling;
    scrolling += is_cut;
    if (is_cut && !/auto|scroll/.test(getComputedStyle(region).overflowX)) problems.push(`${region.ariaLabel} is cut off`);
    if (is_cut && (!hint.matches('.hint') || box_of(hint).height === 0)) problems.push(`${region.ariaLabel} scrolls and does not say so`);
    if (!is_cut && innerWidth >= 600 && box_of(hint).height > 0 && region.querySelector('#asset'))
      problems.push(`${region.ariaLabel} says that it scrolls`);
    if (is_cut && region.tabIndex !== 0) problems.push(`${region.ariaLabel} scrolls, but not by keys`);
  }
  for (const element of all('h1, h2, p, dt, dd, li, figcaption, img')) {
    const box = box_of(element);
    if (box.width > 0 && (box.left < -1 || box.right > innerWidth + 1)) problems.push(`"${element.textContent}" leaves the window`);
  }
  // Terms are explained at the end, and a link above the results leads there.
  const terms = all('dfn').map((term) => term.textContent);
  for (const term of ['patch', 'point', 'stock Draco', 'speed', 'speed-up', 'overhead', 'replication', 'stitch map',
    'directory', 'balance', 'decoder'])
    if (!terms.includes(term)) problems.push(`nothing explains "${term}"`);
  const order = all('header, section').map((element) => element.id || element.tagName);
  if (order[1] !== 'result' || order.at(-1) !== 'words') problems.push(`the sections are ${order}`);
  if (!document.querySelector('header a[href="#words"]')) problems.push('no link leads to the words');
  const picture = document.querySelector('.picture img');
  return {
    scrolling,
    problems: [...new Set(problems)],
    marks: Object.fromEntries(all('figure.chart').map((chart) => [chart.id, all('.mark', shown(chart)[0]).length])),
    rows: Object.fromEntries(all('table').map((table) => [table.id, all('tbody tr', table).length])),
    split_rows: all('#codecs tbody th').filter((cell) => cell.textContent.startsWith('psplit')).length,
    draco_rows: all('#codecs tbody tr').filter((row) => row.children[1].textContent === 'draco').length,
    cells: all('td, th').filter((cell) => /nan|inf/i.test(cell.textContent)).length,
    heading: document.querySelector('h1').textContent,
    heading_children: document.querySelector('h1').children.length,
    picture: picture && picture.complete && picture.naturalWidth,
    is_dark: luminance(page_color) < 0.2,
    is_too_wide: document.documentElement.scrollWidth > innerWidth,
  };
}

async function inspect(browser, report, scheme, width, screenshot) {
  const what = `${screenshot}: `;
  const page = await browser.newPage();
  const url = pathToFileURL(report.page).href;
  page.on('console', (message) => check(false, `${what}console: ${message.text()}`));
  page.on('pageerror', (error) => check(false, `${what}${error}`));
  page.on('requestfailed', (request) => check(false, `${what}failed request of ${request.url().slice(0, 80)}`));
  page.on('request', (request) =>
    check(request.url() === url || request.url().startsWith('data:'), `${what}asks for ${request.url()}`));
  await page.setOfflineMode(true);
  await page.setViewport({ width, height: 900 });
  await page.emulateMediaFeatures([{ name: 'prefers-color-scheme', value: scheme }]);
  await page.goto(url, { waitUntil: 'load' });
  const seen = await page.evaluate(look);
  await page.screenshot({ path: path.join(out, `${screenshot}.png`), fullPage: true });
  await page.close();

  for (const problem of seen.problems) check(false, what + problem);
  check_equal(seen.is_dark, scheme === 'dark', `${what}dark`);
  check(!seen.is_too_wide, `${what}the page is wider than the window`);
  check_equal(seen.heading, `${report.input}: size and decoding speed`, `${what}heading`);
  check_equal(seen.heading_children, 0, `${what}elements in the heading`);
  check_equal(seen.picture, 1200, `${what}width of the picture`);
  check_equal(seen.cells, 0, `${what}cells that are no numbers`);
  const { splits } = report;
  // Three speeds of stock Draco, three forms of meshoptimizer, and at least the decoders cpu and draco.
  check(seen.split_rows >= 2 * splits && seen.split_rows % splits === 0, `${what}${seen.split_rows} rows of splits`);
  check_equal(seen.rows.codecs, 3 + 3 + seen.split_rows, `${what}rows of codecs`);
  check_equal(seen.rows.sizes, 3 + splits, `${what}rows of sizes`);
  check_equal(seen.rows['stage-times'], splits, `${what}rows of stages`);
  const expected = {
    // libdraco on patches and brotli are not in the chart of size against speed.
    'size-speed': seen.rows.codecs - seen.draco_rows - 1, 'speed-up': seen.split_rows, 'patch-size': splits + 4, size: 1 + 3 * splits, stages: 5 * splits,
    replication: splits, balance: splits,
  };
  check_equal(JSON.stringify(seen.marks), JSON.stringify(expected), `${what}marks`);
  // Tables are wider than a phone, so they must scroll.
  if (width < 480) check(seen.scrolling >= 3, `${what}only ${seen.scrolling} regions scroll`);
}

// Words of a PDF, page by page, each with its box.
function words_of(pdf) {
  const xml = execFileSync('pdftotext', ['-bbox', pdf, '-'], { encoding: 'utf8', maxBuffer: 1 << 26 });
  return xml.split('<page ').slice(1).map((page) => {
    const [, width, height] = page.match(/^width="([\d.]+)" height="([\d.]+)"/).map(Number);
    const words = [...page.matchAll(/<word xMin="(.*?)" yMin="(.*?)" xMax="(.*?)" yMax="(.*?)">(.*?)<\/word>/g)]
      .map(([, left, top, right, bottom, text]) => ({
        left: +left, top: +top, right: +right, bottom: +bottom,
        text: text.replace(/&lt;/g, '<').replace(/&gt;/g, '>').replace(/&quot;/g, '"').replace(/&apos;|&#39;/g, "'")
          .replace(/&amp;/g, '&'),
      }));
    return { width, height, words };
  });
}

// Reads the text that the PDF must contain; runs in the browser.
function read_page() {
  const texts = (selector) => [...document.querySelectorAll(selector)].map((element) => element.textContent.trim());
  return {
    cells: texts('th, td'),
    headings: texts('h2'),
    headline: texts('.headline').join(''),
    last_word: texts('.words dd').at(-1),
    charts: [...document.querySelectorAll('figure.chart')].map((chart) => ({
      title: chart.querySelector('figcaption').firstChild.textContent,
      last: [...chart.querySelectorAll('text.title')].map((text) => text.textContent),
    })),
    first_caption: document.querySelector('#numbers .caption').textContent,
    captions: [...document.querySelectorAll('.caption')].map((caption) => ({
      caption: caption.textContent, header: caption.parentElement.querySelector('thead').textContent,
      first: caption.parentElement.querySelector('tbody th').textContent,
    })),
  };
}

const squeeze = (text) => text.replace(/\s+/g, '');

async function print(browser, report, format) {
  const pdf = path.join(out, `report-${format}.pdf`), what = `${format}: `;
  const page = await browser.newPage();
  await page.goto(pathToFileURL(report.page).href, { waitUntil: 'load' });
  const said = await page.evaluate(read_page);
  await page.pdf({ path: pdf, format });
  await page.close();
  const pages = words_of(pdf);
  check(pages.length > 1 && pages.length < 12, `${what}${pages.length} pages`);
  const counts = new Map();
  for (const { width, height, words } of pages)
    for (const word of words) {
      const inside = word.left >= 0 && word.right <= width && word.top >= 0 && word.bottom <= height;
      check(inside, `${what}"${word.text}" is not on its page`);
      if (inside) counts.set(word.text, (counts.get(word.text) ?? 0) + 1);
    }
  // Each word of a cell occurs in the PDF as often as in the tables. Words with a hyphen ("speed-up") may be broken there.
  const expected = new Map();
  for (const word of said.cells.flatMap((cell) => cell.split(/\s+/)).filter((word) => /^[^-]+$|^[-+]/.test(word)))
    expected.set(word, (expected.get(word) ?? 0) + 1);
  check(expected.size > 50, `${what}only ${expected.size} different words in tables`);
  for (const [word, count] of expected)
    check((counts.get(word) ?? 0) >= count, `${what}"${word}" is there ${counts.get(word) ?? 0} times, not ${count}`);

  // The lowest word of a page tells how full it is. Only the last page may end early.
  pages.slice(0, -1).forEach(({ height, words }, i) => {
    const lowest = Math.max(...words.map(({ bottom }) => bottom));
    check(lowest > 0.6 * height, `${what}page ${i + 1} ends at ${Math.round((100 * lowest) / height)} %`);
  });

  // A title is on the same page as its chart, table or section.
  const texts = pages.map(({ words }) => squeeze(words.map((word) => word.text).join('')));
  const together = (parts, of) => check(texts.some((text) => parts.every((part) => text.includes(squeeze(part)))),
    `${what}"${parts[0]}" is not on the page of ${of}`);
  for (const part of [said.headline, said.charts[0].title])
    check(texts[0].includes(squeeze(part)), `${what}"${part}" is not on the first page`);
  check(texts.at(-1).endsWith(squeeze(said.last_word)), `${what}the words are not the last`);
  for (const { title, last } of said.charts) together([title, ...last], 'its chart');
  // pdftotext orders words by columns where it sees some. Tables are read line by line here, and a cell may have several lines: its
  // words may be apart.
  const lines = pages.map(({ words }) => squeeze([...words].sort((a, b) => a.bottom - b.bottom || a.left - b.left).map((word) => word.text).join('')));
  for (const { caption, header, first } of said.captions)
    check(lines.some((text) => {
      let at = text.indexOf(squeeze(caption));
      return at >= 0 && [header.slice(0, 5), ...first.split(/\s+/)].every((word) => (at = text.indexOf(squeeze(word), at + 1)) >= 0);
    }), `${what}"${caption}" is not on the page of its table`);
  for (const heading of ['Charts', 'Numbers'])
    together([heading + (heading === 'Charts' ? said.charts[1].title : said.first_caption)], 'what follows it');
  for (const heading of said.headings)
    check(!texts.some((text) => text.endsWith(squeeze(heading))), `${what}"${heading}" is the last of its page`);
}

// Chromium's sandbox does not work for root.
const args = process.getuid?.() === 0 ? ['--no-sandbox'] : [];
const browser = await puppeteer.launch({
  executablePath: chromium, args: [...args, '--disable-dev-shm-usage', '--disable-gpu'],
});
try {
  const scene = make_report(`<b>a & "b" it's.glb`, [1, 4, 16], 2);
  await inspect(browser, scene, 'light', 1440, 'report-light');
  await inspect(browser, scene, 'dark', 1440, 'report-dark');
  await inspect(browser, scene, 'light', 360, 'report-phone');
  await inspect(browser, scene, 'dark', 768, 'report-tablet');
  for (const format of ['A4', 'Letter']) await print(browser, scene, format);
  const counts = Array.from({ length: 20 }, (_, i) => i + 1);
  const tiny = make_report('tiny.glb', counts, 3);
  await inspect(browser, tiny, 'light', 1440, 'report-tiny');
  const one = make_report('one.glb', [1], 1);
  await inspect(browser, one, 'dark', 1440, 'report-one');
} finally {
  await browser.close();
}
console.log(`screenshots are in ${out}`);
finish('report');
