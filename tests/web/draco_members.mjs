// Tests that a list of bindings/web/js/draco has every member of draco3d's module, and says of each what ours does.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { root } from './load.mjs';

// What emscripten's glue has for itself.
const kOfGlue = /^_|^(asm|calledRun|ready|inspect|onModuleParsed|onRuntimeInitialized|then)$/;
const members = (draco) => Object.keys(draco).flatMap((name) => {
  if (kOfGlue.test(name) || typeof draco[name] === 'number') return [];
  const of_class = Object.getOwnPropertyNames(draco[name]?.prototype ?? {}).filter((member) => !/^(constructor|__)/.test(member));
  return /^[A-Z]/.test(name) && of_class.length > 0 ? of_class.map((member) => `${name}.${member}`) : [name];
});

/** `theirs`: modules of draco3d by version, which have at least `least` members. */
export function test_list(list, ours, theirs, least) {
  // The state of each member in the list.
  const states = new Map([...readFileSync(path.join(root, 'bindings/web/js/draco', list), 'utf8').matchAll(/^\| (`.*`) \| (.*) \|$/gm)]
    .flatMap(([, names, state]) => names.split(', ').map((name) => [name.replaceAll('`', ''), state])));
  // An inherited member is there, too. A class without members of its own is not in the list.
  const is_there = (name) => name.split('.').reduce((at, part) => (at === undefined ? at : at.prototype?.[part] ?? at[part]), ours) !== undefined;

  for (const [version, draco] of Object.entries(theirs))
    test(`${list} has every member of draco3d ${version}`, () => {
      const wanted = members(draco).filter((name) => !/^(GeometryAttribute|Metadata)$/.test(name));
      assert.ok(wanted.length >= least, `${wanted.length} members`);
      assert.deepEqual(wanted.filter((name) => !states.has(name)), []);
      for (const [name, value] of Object.entries(draco)) if (typeof value === 'number' && !name.startsWith('_')) assert.equal(ours[name], value, name);
      const unknown = [...states.keys()].filter((name) => !wanted.includes(name) && !/^(_malloc|_free)$/.test(name));
      assert.deepEqual(unknown, []);
    });

  test(`members of ${list} are there, or it says why they are absent`, () => {
    for (const [name, state] of states) {
      assert.match(state, /^(as draco3d|absent: .|\w)/);
      assert.equal(is_there(name), !state.startsWith('absent: '), name);
    }
  });
}
