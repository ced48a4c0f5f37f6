// How soon three draws a character that arrives slowly: from the begin of the load until the pixels of the first frame are there.
//
//   node first_frame.mjs FOLDER ROUNDS MBITS...   FOLDER has assets as NAME.WAY.glb, of the ways below
//
// Each page loads and draws the same file twice. At the first time, the page has its scripts, but decoders, workers and shaders are loaded,
// started and compiled as the loader asks for them; decoders come at full speed. At the second time all that is there. Files are sent as
// they are. The processor computes WebGL. Prints a line of JSON for each asset and speed, which scripts/web-bench makes a table of.
import { readdirSync, readFileSync } from 'node:fs';
import path from 'node:path';
import { close_browser, open_page } from '../../tests/web/browser.mjs';
import { serve } from './slow_line.mjs';

// The name of a file, what made it, and whether psplit's loadStreaming loads it.
const kWays = [['gltfpack', 'gltfpack -cz', false], ['default', 'encode', false], ['meshopt', 'encode --meshopt', false],
  ['condensed', 'encode --condense --meshopt', false], ['condensed', 'encode --condense --meshopt, loadStreaming', true]];

// In the page: for both times milliseconds until the asset is loaded, and until it is drawn.
async function draw(url, is_streaming) {
  const { AmbientLight, Box3, PerspectiveCamera, Scene, Vector3, WebGLRenderer } = await import('three');
  const { GLTFLoader } = await import('three/addons/loaders/GLTFLoader.js'), loader = new GLTFLoader();
  const { createPool } = await import('/psplit/index.js'), { loadStreaming, PsplitDracoLoader, PsplitPlugin } = await import('/psplit/three.js');
  const { MeshoptDecoder } = await import('three/addons/libs/meshopt_decoder.module.js');
  const pool = createPool(), renderer = new WebGLRenderer();
  loader.setDRACOLoader(new PsplitDracoLoader({ pool })).setMeshoptDecoder(MeshoptDecoder);
  renderer.setSize(512, 512);
  const scene = new Scene().add(new AmbientLight('#fff', 3)), camera = new PerspectiveCamera(40, 1, 0.01, 1000), times = {};
  await MeshoptDecoder.ready;  // it is part of its script
  if (!is_streaming) loader.register((parser) => new PsplitPlugin(parser, { pool }));
  const load_model = async () => {
    const gltf = await (is_streaming ? loadStreaming(loader, url, { pool }) : loader.loadAsync(url));
    await gltf.psplit?.whole;
    return gltf.scene;
  };
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
  for (const time of ['first', 'second']) {
    await new Promise((resolve) => setTimeout(resolve, 300));
    const begin = performance.now(), model = await load_model();
    times[`${time}_loaded`] = performance.now() - begin;
    const pixels = draw_model(model);
    times[`${time}_drawn`] = performance.now() - begin;
    if (!pixels.some((value, i) => i % 4 === 0 && value > 0)) throw new Error(`${url}: nothing is drawn`);
    scene.remove(model);
  }
  return times;
}

const [folder, round_count, ...speeds] = process.argv.slice(2);
for (const name of readdirSync(folder).filter((file) => file.endsWith('.gltfpack.glb')).map((file) => file.slice(0, -'.gltfpack.glb'.length)))
  for (const mbits of speeds.map(Number)) {
    const files = Object.fromEntries(kWays.map(([way]) => [`/${way}.glb`, readFileSync(path.join(folder, `${name}.${way}.glb`))]));
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
    console.log(JSON.stringify({ what: 'character', name, mbits, ways: Object.fromEntries(kWays.map(([way, made_by], i) => [made_by,
      { bytes: files[`/${way}.glb`].length, ...Object.fromEntries(Object.keys(results[i][0]).map((key) => [key, results[i].map((result) => result[key])])) }])) }));
  }
await close_browser();
