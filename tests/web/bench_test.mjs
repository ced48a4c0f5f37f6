// The decoders that scripts/web-bench measures decode. It measures nothing here.
import assert from 'node:assert/strict';
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import test from 'node:test';
import { calling_thread, code_of_pages, in_workers } from '../../bench/web/decoders.mjs';
import { compressed_primitives, root } from './load.mjs';
import { streams } from './stock_draco.mjs';

const [container] = compressed_primitives(path.join(root, 'gltf_ext/PSPLIT_mesh_draco_patches/samples/patches.glb'), 'PSPLIT_mesh_draco_patches');
const [[, bytes]] = streams();
const meshes = { stock: { bytes, attributes: [{ name: 'POSITION', uniqueId: 0, type: 'float32', componentCount: 3 }] },
  patches: container, condensed: container };

for (const decoder of [...await calling_thread([]), ...in_workers()].filter(({ stored }) => stored in meshes))
  test(decoder.name, async () => {
    const { run, end } = await decoder.create();
    try {
      await run(meshes[decoder.stored]);
    } finally {
      end?.();
    }
  });

test('the code that a page loads', async () => {
  for (const [name, parts] of await code_of_pages([])) for (const part of parts) assert.ok(part.length > 1000, name);
});

test('what its modules import is there', async () => {
  const folder = path.join(root, 'bench/web');
  for (const file of readdirSync(folder))
    for (const [, names, module] of readFileSync(path.join(folder, file), 'utf8').matchAll(/^import \{([^}]*)\} from '(\.[^']*)';/gm)) {
      const exported = await import(path.join(folder, module));
      for (const name of names.split(',')) assert.ok(name.trim().split(' ')[0] in exported, `${file}: ${name} of ${module}`);
    }
});
