// What a frame of the page costs while robots tell where they are: `node frames_test.mjs URL ROBOTS`. The work of a frame is the
// processor time of the page's thread from the frame before until it is drawn: news are read, the page is changed, laid out and
// painted. Time in which the thread waited for a processor is not in it, so that a busy machine does not count. What is not so ends
// it with exit code 1 and a sentence.

import {createRequire} from 'node:module';
import assert from 'node:assert/strict';

const {chromium} = createRequire(process.env.PAGE_TEST_MODULES + '/')('playwright-core');
const [url, robots] = [process.argv[2], Number(process.argv[3])];
const frameMs = 16;
const framesWanted = 80;  // of ten a second: some with the tables, which are laid out each second

/** Thread, task after task: the processor time of each frame in ms, by Chromium's trace. */
function workOfFrames(events) {
    const isFrame = (event) => event.name === 'FireAnimationFrame';
    const threadOf = (event) => `${event.pid}/${event.tid}`;
    const thread = threadOf(events.find(isFrame));
    const own = events.filter((event) => threadOf(event) === thread).sort((a, b) => a.ts - b.ts);
    const drawnAt = own.filter(isFrame).map((event) => event.ts);
    const tasks = own.filter((event) => event.name === 'RunTask' && event.ph === 'X');
    assert.ok(tasks.some((task) => task.tdur > 0), 'the trace tells processor time');
    const frames = [];
    let work = 0;
    for (const task of tasks) {
        work += (task.tdur ?? 0) / 1000;
        if (!drawnAt.some((at) => at >= task.ts && at <= task.ts + task.dur)) continue;
        frames.push(work);
        work = 0;
    }
    return frames.slice(1);  // the first began before the trace
}

const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: process.getuid() === 0 ? ['--no-sandbox'] : [],
});
try {
    const page = await browser.newPage({viewport: {width: 1280, height: 900}});
    page.setDefaultTimeout(60000);
    await page.addInitScript(() => {
        window.framesDrawn = 0;
        const request = window.requestAnimationFrame.bind(window);
        window.requestAnimationFrame = (draw) => request((time) => {
            ++window.framesDrawn;
            draw(time);
        });
    });
    await page.goto(url);
    await page.waitForFunction((all) => document.querySelectorAll('#robots tr').length === all, robots);
    await page.locator('#map-hint:empty').waitFor({state: 'attached'});  // they are on the map
    await page.waitForTimeout(2000);  // paths grow, and what is compiled once is compiled
    await browser.startTracing(page, {categories: ['devtools.timeline', 'disabled-by-default-devtools.timeline']});
    const before = await page.evaluate(() => window.framesDrawn);
    await page.waitForFunction((enough) => window.framesDrawn >= enough, before + framesWanted, {polling: 500});
    const trace = JSON.parse((await browser.stopTracing()).toString());
    const work = workOfFrames(trace.traceEvents).sort((a, b) => a - b);
    const share = (part) => work[Math.floor(work.length * part)];
    process.stdout.write(`${work.length} frames of ${await page.locator('#summary').innerText()}: half need ` +
        `${share(0.5).toFixed(1)} ms, 90 % ${share(0.9).toFixed(1)} ms, the longest ${work.at(-1).toFixed(1)} ms\n`);
    assert.ok(work.length >= framesWanted / 2, `only ${work.length} frames were drawn`);
    assert.ok(share(0.9) < frameMs, `90 % of the frames need up to ${share(0.9).toFixed(1)} ms of ${frameMs}`);
} catch (error) {
    process.stderr.write(`${error.message}\n`);
    process.exitCode = 1;
}
await browser.close();
process.exit();
