// How soon three draws a character that arrives slowly: from the begin of the load until the pixels of the first frame are there.
//
//   node first_frame.mjs FOLDER ROUNDS MBITS...   FOLDER has assets as NAME.WAY.glb, of the ways below
//
// Each load is in a page of its own. The code of the page and of the decoders is there before the load begins, and the page has drawn
// the original, NAME.original.glb, and gltfpack's file, so that the shaders of both are compiled. Files are sent as they are. The processor computes WebGL.
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { close_browser, open_page } from '../../tests/web/browser.mjs';
import { serve } from './slow_line.mjs';

// The name of a file, what made it, and whether psplit's loadStreaming loads it.
const kWays = [['gltfpack', 'gltfpack -cz', false], ['default', 'encode', false], ['meshopt', 'encode --meshopt', false],
  ['condensed', 'encode --condense --meshopt', false], ['condensed', 'encode --condense --meshopt, loadStreaming', true],
  ['smallest', 'encode --profile size --condense --meshopt', false]];

// In the page: milliseconds until the asset is loaded, and until it is drawn; and how many pixels it has.
async function draw(url, is_streaming) {
  const { AmbientLight, Box3, PerspectiveCamera, Scene, Vector3, WebGLRenderer } = await import('three');
  const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js'), loader = new GLTFLoader();
  const { createPool } = await import('/psplit/index.js'), { loadStreaming, PsplitDracoLoader, PsplitPlugin } = await import('/psplit/three.js');
  const { MeshoptDecoder } = await import('three/addons/libs/meshopt_decoder.module.js');
  const pool = createPool(), renderer = new WebGLRenderer();
  loader.setDRACOLoader(new PsplitDracoLoader({ pool })).setMeshoptDecoder(MeshoptDecoder);
  renderer.setSize(512, 512);
  // Workers are up, and have their modules; so has the renderer.
  const none = new Uint8Array(12), scene = new Scene().add(new AmbientLight('#fff', 3)), camera = new PerspectiveCamera(40, 1, 0.01, 1000);
  await Promise.allSettled([MeshoptDecoder.ready, ...Array.from({ length: 4 }, () => pool.decodeDraco(none))]);
  const draw_model = (model) => {
    scene.add(model);
    const box = new Box3().setFromObject(model), size = box.getSize(new Vector3()).length();
    camera.position.copy(box.getCenter(new Vector3())).add(new Vector3(0, 0, 1.3 * size));
    [camera.near, camera.far] = [size / 100, 10 * size];
    camera.updateProjectionMatrix();
    renderer.render(scene, camera);
    const pixels = new Uint8Array(4 * 512 * 512), gl = renderer.getContext();
    gl.readPixels(0, 0, 512, 512, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    return pixels;
  };
  for (const before of ['/original.glb', '/gltfpack.glb']) {
    const { scene: model } = await loader.loadAsync(before);
    draw_model(model);
    scene.remove(model);
  }
  await new Promise((resolve) => setTimeout(resolve, 200));

  const begin = performance.now();
  if (!is_streaming) loader.register((parser) => new PsplitPlugin(parser, { pool }));
  const gltf = await (is_streaming ? loadStreaming(loader, url, { pool }) : loader.loadAsync(url));
  await gltf.psplit?.whole;
  const loaded = performance.now() - begin;
  const pixels = draw_model(gltf.scene);
  return { loaded, drawn: performance.now() - begin, pixels: pixels.reduce((count, value, i) => count + (i % 4 === 0 && value > 0 ? 1 : 0), 0) };
}

const [folder, round_count, ...speeds] = process.argv.slice(2);
for (const name of readdirSync(folder).filter((file) => file.endsWith('.gltfpack.glb')).map((file) => file.slice(0, -'.gltfpack.glb'.length)))
  for (const mbits of speeds.map(Number)) {
    const files = Object.fromEntries(kWays.map(([way]) => [`/${way}.glb`, readFileSync(path.join(folder, `${name}.${way}.glb`))]));
    files['/original.glb'] = readFileSync(path.join(folder, `${name}.original.glb`));
    const { origin, close } = await serve(files, mbits), results = kWays.map(() => []);
    for (let round = 0; round < Number(round_count); ++round)
      for (const [i, [way, , is_streaming]] of kWays.entries()) {
        const { page, errors, close: close_page } = await open_page(origin);
        results[i].push(await page.evaluate(`(${draw})('/${way}.glb', ${is_streaming})`));
        // loadStreaming ends the download when it has all that it needs.
        const faults = errors.filter((error) => !is_streaming || !error.endsWith('ERR_ABORTED'));
        if (faults.length > 0) throw new Error(faults.join('\n'));
        await close_page();
      }
    close();
    console.log(`### ${name}, at ${mbits} Mbit/s\n\n| made by | bytes | loaded, ms | drawn, ms | loaded, of gltfpack's | drawn, of gltfpack's | pixels |\n|---|---:|---:|---:|---:|---:|---:|`);
    // The least of all rounds: what else runs on the machine only adds to it.
    const least = (i, key) => Math.min(...results[i].map((result) => result[key]));
    for (const [i, [way, made_by]] of kWays.entries()) {
      const ratio = (key) => (least(i, key) / least(0, key)).toFixed(2);
      const cells = [least(i, 'loaded').toFixed(0), least(i, 'drawn').toFixed(0), ratio('loaded'), ratio('drawn'), least(i, 'pixels')];
      console.log(`| ${[made_by, files[`/${way}.glb`].length.toLocaleString('en-US'), ...cells].join(' | ')} |`);
    }
    console.log();
  }
await close_browser();
