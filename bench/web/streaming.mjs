// How soon a page shows an asset that arrives slowly: from the begin of the load until the first triangles are in three's scene,
// and until all of them are:
//
//   node streaming.mjs FOLDER ROUNDS MBITS...   FOLDER has assets as NAME.plain.glb, .stock.glb, .patches.glb, .condensed.glb
//
// Prints a line of JSON for each asset and speed, which scripts/web-bench makes a table of.
//
// A server of this process sends everything that a page asks for, at MBITS Mbit/s in total. The loaders are three's GLTFLoader with
// DRACOLoader, with meshopt_decoder, with PsplitPlugin, and psplit's loadStreaming. Each load is in a page of its own. The code
// of the page and of the decoders is there before the load begins; drawing is not measured, which is the same for all. Files are
// sent as they are, except meshoptimizer's, which glTF-Transform makes on grids of the same bits: that coding is made for
// compression on the way, so its files are sent in brotli.
import { existsSync, readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { pathToFileURL } from 'node:url';
import { brotliCompressSync } from 'node:zlib';
import { close_browser, open_page } from '../../tests/web/browser.mjs';
import { modules_folder } from '../../tests/web/load.mjs';
import { serve } from './slow_line.mjs';

const in_modules = (name) => import(pathToFileURL(path.join(modules_folder, 'node_modules', name)));
async function make_meshopt(plain, out) {
  const [{ Logger, NodeIO }, { ALL_EXTENSIONS }, { meshopt }, { MeshoptEncoder }] = await Promise.all(['@gltf-transform/core/dist/index.js',
    '@gltf-transform/extensions/dist/index.js', '@gltf-transform/functions/dist/index.js', 'meshoptimizer/meshopt_encoder.js'].map(in_modules));
  const io = new NodeIO().registerExtensions(ALL_EXTENSIONS).registerDependencies({ 'meshopt.encoder': MeshoptEncoder });
  const document = (await io.read(plain)).setLogger(new Logger(Logger.Verbosity.SILENT));
  await document.transform(meshopt({ encoder: MeshoptEncoder, level: 'high' }));
  await io.write(out, document);
}

// Runs in the page, and returns the times in milliseconds and the number of triangles. A triangle is shown when it is in an index of the scene
// and is not degenerate.
async function load(kind, url) {
  const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js'), loader = new GLTFLoader();
  const { createPool } = await import('/psplit/index.js'), { loadStreaming, PsplitPlugin } = await import('/psplit/three.js');
  const { DRACOLoader } = await import('three/addons/loaders/DRACOLoader.js');
  const { MeshoptDecoder } = await import('three/addons/libs/meshopt_decoder.module.js');
  const pool = createPool(), draco = new DRACOLoader().setDecoderPath('/modules/three/examples/jsm/libs/draco/gltf/');
  loader.setDRACOLoader(draco).setMeshoptDecoder(MeshoptDecoder);
  // Workers are up, and have their modules.
  const none = new Uint8Array(12);
  draco.preload();
  await Promise.allSettled([MeshoptDecoder.ready, ...Array.from({ length: 4 }, () => pool.decodeDraco(none)),
    draco._getWorker(0, 0).catch(() => {})]);
  await new Promise((resolve) => setTimeout(resolve, 200));

  const begin = performance.now(), at = {}, parts = [];
  let scene = null, total = 0;
  const see = (count, time = performance.now() - begin) => {
    if (count > 0) at.first ??= time;
    if (count >= total) at.all ??= time;
  };
  const triangles = (object) => {
    let sum = 0;
    object.traverse(({ isMesh, geometry }) => { sum += isMesh ? geometry.index.count / 3 : 0; });
    return sum;
  };
  if (kind !== 'streaming') {
    if (kind === 'patches') loader.register((parser) => new PsplitPlugin(parser, { pool }));
    ({ scene } = await loader.loadAsync(url));
    total = triangles(scene);
    see(total);
  } else {
    // Parts that come before the scene is there are shown with it.
    const options = { pool, onPart: ({ indices, isFinal }) => {
      if (isFinal) parts.push({ count: indices.length / 3, time: performance.now() - begin });
    } };
    const gltf = await loadStreaming(loader, url, options), shown = performance.now() - begin;
    await gltf.psplit.whole;
    const end = performance.now() - begin;
    total = triangles(gltf.scene);
    const arriving = () => parts.reduce((sum, { count }) => sum + count, 0);
    let count = total - arriving();   // of other primitives, which are whole with the scene
    see(count, shown);
    for (const part of parts) see((count += part.count), Math.max(shown, part.time));
    at.all = Math.max(at.all, end);
  }
  return { ...at, total };
}

// glTF-Transform writes EXT_meshopt_compression, whose codec is version 0.
const { version: meshopt_version } = JSON.parse(readFileSync(path.join(modules_folder, 'node_modules/meshoptimizer/package.json'), 'utf8'));
const [folder, round_count, ...speeds] = process.argv.slice(2), rounds = Number(round_count);
const kWays = [["three's DRACOLoader", 'stock', 'whole'], [`meshoptimizer ${meshopt_version}, codec 0, brotli`, 'meshopt', 'whole'],
  ['PsplitPlugin', 'patches', 'patches'], ['loadStreaming', 'patches', 'streaming'], ['loadStreaming, condensed', 'condensed', 'streaming']];
const names = readdirSync(folder).filter((file) => file.endsWith('.stock.glb')).map((file) => file.slice(0, -'.stock.glb'.length));

for (const name of names) {
  const of_coding = (coding) => path.join(folder, `${name}.${coding}.glb`), files = {};
  if (!existsSync(of_coding('meshopt'))) await make_meshopt(of_coding('plain'), of_coding('meshopt'));
  for (const coding of new Set(kWays.map(([, coding]) => coding))) {
    const bytes = readFileSync(of_coding(coding));
    files[`/${coding}.glb`] = coding === 'meshopt' ? brotliCompressSync(bytes) : bytes;
  }
  for (const mbits of speeds.map(Number)) {
    const { origin, close } = await serve(files, mbits, ['/meshopt.glb']), results = kWays.map(() => []);
    for (let round = 0; round < rounds; ++round)
      for (const [i, [, coding, kind]] of kWays.entries()) {
        const { page, errors, close: close_page } = await open_page(origin);
        results[i].push(await page.evaluate(`(${load})(${JSON.stringify(kind)}, '/${coding}.glb')`));
        if (errors.length > 0) throw new Error(errors.join('\n'));
        await close_page();
      }
    close();
    const of_loader = (coding, times) => ({ bytes: files[`/${coding}.glb`].length, first: times.map(({ first }) => first), all: times.map(({ all }) => all) });
    const loaders = Object.fromEntries(kWays.map(([way, coding], i) => [way, of_loader(coding, results[i])]));
    console.log(JSON.stringify({ what: 'streaming', name, mbits, faces: results[0][0].total, loaders }));
  }
}
await close_browser();
