// Shortens the shaders of psplit/webgpu in a package, because bundlers keep strings as they are. A program:
//
//   node bindings/web/shaders/shorten.mjs FOLDER_OF_PACKAGE
//
// Comments and spaces go, and names become short, the same name everywhere. JavaScript makes a part of the shaders, and names stages and
// constants: names that occur in JavaScript stay as they are.
import { readdirSync, readFileSync, writeFileSync } from 'node:fs';
import path from 'node:path';

const folder = path.join(process.argv[2], 'webgpu');
const files = [`${folder}.js`, ...readdirSync(folder).filter((name) => name.endsWith('.js')).map((name) => path.join(folder, name))];
const kCode = /(\/\* wgsl \*\/ `\n)([^`]*)`/g, kWord = /\b[A-Za-z_]\w*/g;
const words_of = (text) => text.match(kWord) ?? [];

const without_comments = (code) => code.replace(/ *\/\/.*$/gm, '').replace(/^ +/gm, '').replace(/\n+/g, '\n');
const texts = new Map(files.map((file) => [file, readFileSync(file, 'utf8').replace(kCode, (_, begin, code) => `${begin}${without_comments(code)}\``)]));
const code = [...texts.values()].flatMap((text) => [...text.matchAll(kCode)].map(([, , one]) => one)).join('');
const of_javascript = new Set([...texts.values()].flatMap((text) => words_of(text.replace(kCode, '').replace(/^ *\/\/.*$|^ *\/?\*.*$/gm, ''))));

// Names of functions and words that WGSL has, if they are declared as well; components of vectors.
const kOfWgsl = /^(abs|align|all|any|array|binding|builtin|group|clamp|cross|distance|dot|floor|fract|length|max|min|mix|normalize|pow|round|select|sign|sqrt|step|trunc|[xyzw]{1,4}|[rgba]{1,4})$/;
const kShortWords = new Set(['as', 'do', 'fn', 'if', 'in', 'is', 'of', 'or']);
const declared = new Set([...code.matchAll(/\b(?:fn|struct|alias|const|let|var(?:<[^>]*>)?) +(\w+)|\b(\w+): /g)].map(([, a, b]) => a ?? b));
const counts = new Map();
for (const word of words_of(code)) counts.set(word, (counts.get(word) ?? 0) + 1);
const renamed = [...counts].filter(([word]) => declared.has(word) && !of_javascript.has(word) && !kOfWgsl.test(word)).sort(([, a], [, b]) => b - a).map(([word]) => word);

const taken = new Set([...counts.keys()].filter((word) => !renamed.includes(word)));
function* short_names() {
  const letters = [...'abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ'];
  for (const prefix of ['', ...letters])
    for (const letter of letters) if (!taken.has(prefix + letter) && !kOfWgsl.test(prefix + letter) && !kShortWords.has(prefix + letter) && !of_javascript.has(prefix + letter)) yield prefix + letter;
}
const names = short_names(), short = new Map(renamed.map((word) => [word, names.next().value]));

// Two operators stay two.
const without_spaces = (text) => text.replace(/\n/g, ' ').replace(/(?<=[^\w]) (?=[\w(@])|(?<=[\w)\]]) (?=[^\w@])|(?<=[{};,(]) (?=.)/g, '').trim();
for (const [file, text] of texts) {
  const shorter = text.replace(kCode, (_, begin, one) => `${begin}${without_spaces(one.replace(kWord, (word) => short.get(word) ?? word))}\n\``);
  if (shorter !== text) writeFileSync(file, shorter);
}
