// What compilers say of the shaders of psplit/webgpu: Dawn's (Tint) and wgpu's (naga) of WGSL, SPIRV-Tools of the SPIR-V that Dawn makes, and
// Mesa's compiler for AMD's GPUs of the registers that it takes; that GPU need not be there. A program:
//
//   node tests/web/webgpu_compilers.mjs    prints a table of the stages, and fails if a compiler finds a fault
import { execFileSync, spawnSync } from 'node:child_process';
import { existsSync, mkdirSync, rmSync, writeFileSync } from 'node:fs';
import path from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';
import { modules_folder, package_folder, root } from './load.mjs';

const deno = path.join(modules_folder, 'node_modules/.bin/deno'), here = (name) => fileURLToPath(new URL(name, import.meta.url));
const has = (command) => spawnSync('sh', ['-c', `command -v ${command}`]).status === 0;
export const no_deno = spawnSync(deno, ['--version']).status !== 0 && 'Deno does not run: it is an optional package of the tests';
export const no_spirv_tools = !has('spirv-as') && 'there are no SPIRV-Tools (Debian: spirv-tools)';

// wgpu reads the older name of the variable, too.
const with_driver = (file) => ({ ...process.env, VK_DRIVER_FILES: file, VK_ICD_FILENAMES: file, XDG_RUNTIME_DIR: process.env.XDG_RUNTIME_DIR ?? '/tmp' });

/** What webgpu_deno.mjs prints: { adapter, messages }, and of a folder of containers their sum. */
export function run_in_deno(...folder) {
  const text = execFileSync(deno, ['run', '-A', here('webgpu_deno.mjs'), package_folder, ...folder],
    { encoding: 'utf8', env: with_driver(process.env.VK_DRIVER_FILES), stdio: ['ignore', 'pipe', 'ignore'], maxBuffer: 1 << 28 });
  return text.trim().split('\n').map((line) => JSON.parse(line));
}

/**
 * The shaders in SPIR-V, as Dawn makes it, written to a folder: [entry point, file] each, of Draco's streams and then of condensed ones. Throws if SPIRV-Tools find them invalid. Takes as long
 * as compiling all pipelines.
 */
export function valid_spirv(folder) {
  // Dawn prints to the process' own output.
  const text = execFileSync(process.execPath, [here('webgpu_dump.mjs')],
    { encoding: 'utf8', env: { ...process.env, PSPLIT_DAWN: 'enable-dawn-features=dump_shaders,disable_symbol_renaming' }, maxBuffer: 1 << 28 });
  rmSync(folder, { recursive: true, force: true });
  mkdirSync(folder, { recursive: true });
  return text.split('/* Dumped SPIRV disassembly */').slice(1).map((part, n) => {
    const code = part.split('\n').filter((line) => /^\s*(;|Op|%\S+ = Op)/.test(line)).join('\n');
    const [, entry] = /OpEntryPoint GLCompute %([a-z_]+?)(?:_\d+)? /.exec(code), file = path.join(folder, `${n}_${entry}`);
    writeFileSync(`${file}.spvasm`, `${code}\n`);
    execFileSync('spirv-as', ['--target-env', 'vulkan1.3', `${file}.spvasm`, '-o', `${file}.spv`]);
    execFileSync('spirv-val', ['--target-env', 'vulkan1.3', `${file}.spv`]);
    return [entry, `${file}.spv`];
  });
}

const kRadv = `/usr/share/vulkan/icd.d/radeon_icd.${process.arch === 'arm64' ? 'aarch64' : 'x86_64'}.json`, kVulkanHeader = '/usr/include/vulkan/vulkan.h';
export const no_radv = !(existsSync(kRadv) && existsSync(kVulkanHeader)) && "there are no compiler for AMD's GPUs and headers of Vulkan (Debian: mesa-vulkan-drivers, libvulkan-dev)";
/**
 * What Mesa's compiler says of SPIR-V, for a GPU of a family such as navi21: { device, stages }, where a stage has `VGPRs`, `Scratch size` and so on,
 * in the order of the modules.
 */
export function compile_for_radv(modules, family, folder) {
  const program = path.join(folder, 'spirv_statistics');
  execFileSync('cc', ['-O1', '-Wall', '-Wextra', '-Werror', here('spirv_statistics.c'), '-o', program, '-lvulkan']);
  const text = execFileSync(program, modules.map(([, file]) => file), { encoding: 'utf8', env: { ...with_driver(kRadv), RADV_FORCE_FAMILY: family }, stdio: ['ignore', 'pipe', 'ignore'] });
  const [device, ...lines] = text.trim().split('\n');
  return { device, stages: lines.map((line) => Object.fromEntries(line.split('; ').map((pair) => pair.split('=')))) };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const why = no_spirv_tools || no_radv, folder = path.join(root, 'build/web/gpu/spirv');
  if (why) {
    console.error(`web-gpu: ${why}`);
    process.exit(1);
  }
  const of_package = async (name) => import(pathToFileURL(path.join(package_folder, 'webgpu', name)));
  const { stages: draco } = await of_package('shaders.js'), { condensed } = await of_package('condensed.js'), stages = [...draco, ...condensed.stages];
  const modules = valid_spirv(folder), { device, stages: found } = compile_for_radv(modules, 'navi21', folder);
  if (modules.length !== stages.length) throw new Error(`${modules.length} modules of ${stages.length} stages`);
  console.log(`${modules.length} modules of SPIR-V are valid. ${device}:\n`);
  console.log('| stage | vector registers | subgroups in flight on a SIMD | private memory, bytes | instructions |\n|---|--:|--:|--:|--:|');
  // Stages of both kinds stand once.
  for (const { entry } of new Map(stages.map((stage) => [stage.entry, stage])).values()) {
    const i = modules.findIndex(([of_module]) => of_module === entry);
    const { VGPRs: registers, 'Subgroups per SIMD': subgroups, 'Scratch size': scratch, Instructions: instructions } = found[i];
    console.log(`| \`${entry}\` | ${registers} | ${subgroups} | ${scratch} | ${Number(instructions).toLocaleString('en-US')} |`);
  }
}
