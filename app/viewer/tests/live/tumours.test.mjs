// As load_case.test.mjs, on a liver whose finite elements, which `livermark run` solves as well, take minutes.
import { after, before, test } from 'node:test';
import { startTouch } from './touch_of_run.mjs';

let touch;
before(async () => (touch = await startTouch('liver_tumours')));
after(() => touch?.stop());

test('liver_tumours at rest under a finger has the force of livermark run', (t) => touch.agreesWithRun(t));
