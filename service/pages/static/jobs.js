// Gallery and list of jobs: live states, selection, and the form that queues scans.
import { followJobs } from './live.js';
import { startSelection } from './selection.js';
import { startForm } from './submit.js';

startForm();
startSelection();
followJobs();
