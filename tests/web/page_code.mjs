// The package's code as pages have it when a bundler made it.
import { createRequire } from 'node:module';
import path from 'node:path';
import { modules_folder, package_folder } from './load.mjs';

const { build } = createRequire(path.join(modules_folder, 'package.json'))('esbuild');

/**
 * A file of the package with its imports, minified, and without the loader's own code. Later, dynamic imports are left out.
 * @param {string} name
 * @param {string} [later] a file that is imported dynamically: then what it adds to that
 * @returns {Promise<Buffer>}
 */
export async function code_of_page(name, later) {
  const entry = path.join(package_folder, name);
  const { outputFiles, metafile } = await build({ entryPoints: [entry], bundle: true, minify: true, format: 'esm', splitting: true,
    outdir: package_folder, write: false, metafile: true, external: ['three', 'three/*', '@gltf-transform/core'], logLevel: 'error' });
  const outputs = new Map(Object.entries(metafile.outputs).map(([file, output]) => [path.resolve(file), output])), needed = new Set();
  const need = (file) => {
    needed.add(file);
    for (const { path: imported, kind, external } of outputs.get(file).imports)
      if (kind === 'import-statement' && !external && !needed.has(path.resolve(imported))) need(path.resolve(imported));
  };
  need(entry);
  const of_page = new Set(later === undefined ? [] : needed);
  if (later !== undefined) need([...outputs].find(([, { entryPoint }]) => entryPoint !== undefined && path.resolve(entryPoint) === path.join(package_folder, later))[0]);
  return Buffer.concat(outputFiles.filter((file) => needed.has(file.path) && !of_page.has(file.path)).map(({ contents }) => contents));
}
