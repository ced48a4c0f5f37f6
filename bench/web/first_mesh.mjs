// Measures the time of a page's first mesh in Chromium, from the page's begin until the decoded arrays are there. Each
// measurement has a page of its own in a fresh profile, without a cache. The server is on the same machine, and sends files as
// they are. The package is bundled, as pages have it.
import { copyFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { open_page, start_site } from '../../tests/web/browser.mjs';
import { modules_folder, package_folder, root } from '../../tests/web/load.mjs';

// Both run in the page. They return the number of faces.
async function by_package({ pool, attributes }) {
  const data = fetch('/mesh.bin').then((response) => response.arrayBuffer());
  const psplit = await import('/bundled/index.js'), decoder = pool > 0 ? psplit.createPool({ workers: pool }) : psplit;
  const { faceCount } = await (attributes === undefined ? decoder.decodeDraco(await data)
    : decoder.decodeContainer(await data, { attributes }));
  return { faces: faceCount, ms: performance.now() };
}
// Calls draco3d as loaders do.
async function by_draco3d({ folder }) {
  const data = fetch('/mesh.bin').then((response) => response.arrayBuffer());
  const wasm = fetch(`${folder}draco_decoder.wasm`).then((response) => response.arrayBuffer());
  const script = document.createElement('script');
  script.src = `${folder}draco_wasm_wrapper.js`;
  await new Promise((resolve, reject) => { document.head.append(Object.assign(script, { onload: resolve, onerror: reject })); });
  const wasmBinary = await wasm;
  // The module has a `then`, so it is wrapped.
  const { draco } = await new Promise((resolve) => {
    DracoDecoderModule({ wasmBinary, onModuleLoaded: (draco) => resolve({ draco }) });
  });
  const bytes = new Int8Array(await data), decoder = new draco.Decoder(), mesh = new draco.Mesh();
  if (!decoder.DecodeArrayToMesh(bytes, bytes.byteLength, mesh).ok()) throw new Error('not decoded');
  const copied = (Type, length, write) => {
    const size = length * Type.BYTES_PER_ELEMENT, at = draco._malloc(size);
    write(size, at);
    const array = new Type(draco.HEAPU8.buffer, at, length).slice();
    draco._free(at);
    return array;
  };
  const indices = copied(Uint32Array, 3 * mesh.num_faces(), (size, at) => decoder.GetTrianglesUInt32Array(mesh, size, at));
  for (let i = 0; i < mesh.num_attributes(); ++i) {
    const attribute = decoder.GetAttribute(mesh, i);
    copied(Float32Array, mesh.num_points() * attribute.num_components(), (size, at) =>
      decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, draco.DT_FLOAT32, size, at));
  }
  return { faces: indices.length / 3, ms: performance.now() };
}

// Bundles the package, and returns the folder.
function bundle() {
  const { buildSync } = createRequire(path.join(modules_folder, 'package.json'))('esbuild');
  const outdir = path.join(root, 'build/web/bundled');
  const entryPoints = ['index.js', 'worker.js'].map((name) => path.join(package_folder, name));
  buildSync({ entryPoints, outdir, bundle: true, minify: true, format: 'esm' });
  copyFileSync(path.join(package_folder, 'psplit.wasm'), path.join(outdir, 'psplit.wasm'));
  return outdir;
}

/**
 * Measures in turn, `rounds` times.
 * @param {{ stream: Uint8Array, container: Uint8Array, attributes: object[] }} mesh a Draco stream of floats, and the
 *   container of the same mesh with the attributes to ask for
 * @returns {Promise<Object<string, number[]>>} the milliseconds of each round, by decoder
 */
export async function first_mesh({ stream, container, attributes }, rounds) {
  const draco = '/modules/three/examples/jsm/libs/draco/gltf/', bundled = { folder: bundle() };
  const ways = [
    { name: "three's draco_decoder", bytes: stream, script: by_draco3d, argument: { folder: draco } },
    { name: 'psplit/draco', bytes: stream, script: by_draco3d, argument: { folder: '/psplit/draco/' } },
    { name: 'psplit, one stream', bytes: stream, script: by_package, argument: { pool: 0 } },
    ...[0, 1, 2].map((pool) => ({ name: `psplit, patches${['', ', 1 worker', ', 2 workers'][pool]}`,
      bytes: container, script: by_package, argument: { pool, attributes } })),
  ].map((way) => ({ ...way, times: [] }));
  for (let round = 0; round < rounds; ++round)
    for (const { bytes, script, argument, times } of ways) {
      const site = await start_site({ files: { '/mesh.bin': bytes, '/bundled/': bundled }, script, argument });
      const { page, close } = await open_page(site.origin);
      times.push((await page.evaluate(() => globalThis.result)).ms);
      await close();
      site.close();
    }
  return Object.fromEntries(ways.map(({ name, times }) => [name, times]));
}
