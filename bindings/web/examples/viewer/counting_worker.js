// The package's worker, which also says how much memory of WebAssembly it has.
import './psplit/worker.js';
import { answer_in_worker } from './costs.js';

answer_in_worker();
