// GLTFLoader reads a file when it is whole. Here its plugin reads the file as it arrives.
import { LoaderUtils } from 'three';
import { ArrivingAsset } from '../arriving_asset.js';
import { PsplitError } from '../error.js';
import { signal_of } from '../job.js';
import { PsplitPlugin } from './psplit_plugin.js';

/**
 * Loads a GLB or glTF file while its bytes arrive: see three.d.ts.
 * @param {GLTFLoader} loader
 * @param {string} url
 * @param {PsplitPluginOptions} [options]
 */
export async function loadStreaming(loader, url, options) {
  const { manager, requestHeader, withCredentials } = loader;
  const { signal, end } = signal_of(options?.signal, manager.abortController?.signal);
  const request_of = (address) => new Request(manager.resolveURL(address),
    { headers: requestHeader, credentials: withCredentials ? 'include' : 'same-origin' });
  const path = loader.resourcePath || LoaderUtils.resolveURL(LoaderUtils.extractUrlBase(url), loader.path);
  manager.itemStart(url);
  try {
    const asset = await ArrivingAsset.open(request_of(LoaderUtils.resolveURL(url, loader.path)), signal,
      (uri) => request_of(LoaderUtils.resolveURL(uri, path)), options?.choose);
    if (asset.json === null) throw new PsplitError(`${url}: the file is a container without a glTF asset`, 'invalid-input');
    const make_plugin = (parser) => new PsplitPlugin(parser,
      { file: url, patchByPatch: true, dracoLoader: loader.dracoLoader ?? undefined, ...options, signal, asset });
    const gltf = await new Promise((resolve, reject) => {
      loader.register(make_plugin);
      try {
        loader.parse(asset.json, path, resolve, reject);
      } finally {
        loader.unregister(make_plugin);
      }
    });
    // GLTFLoader goes on without textures that it cannot load.
    if (signal.aborted) throw new PsplitError('aborted', 'aborted');
    gltf.psplit.whole.then(end, end);
    return gltf;
  } catch (error) {
    end();
    manager.itemError(url);
    throw error;
  } finally {
    manager.itemEnd(url);
  }
}
