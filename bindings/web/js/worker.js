// The worker of a pool.
import { make_runner } from './job_runner.js';
import { serve } from './worker_port.js';

serve(make_runner);
