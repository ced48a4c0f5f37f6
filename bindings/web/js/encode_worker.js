// The worker of an encoder.
import { make_runner } from './encode_runner.js';
import { serve } from './worker_port.js';

serve(make_runner);
