// How much of a frame's time the page of romano web needs: `PAGE_TEST_MODULES=... node frames.mjs URL SECONDS`. A frame's work is
// from its beginning until everything that it called is done; the renderer's processor time is the kernel's count.

import {createRequire} from 'node:module';
import {readdirSync, readFileSync} from 'node:fs';

const {chromium} = createRequire(process.env.PAGE_TEST_MODULES + '/')('playwright-core');
const [url, seconds] = [process.argv[2], Number(process.argv[3] ?? 10)];

/** Ticks of 10 ms that the renderers of this browser have had. */
function rendererTicks() {
    let ticks = 0;
    for (const entry of readdirSync('/proc').filter((name) => /^\d+$/.test(name))) {
        try {
            if (!readFileSync(`/proc/${entry}/cmdline`, 'utf8').includes('--type=renderer')) continue;
            const fields = readFileSync(`/proc/${entry}/stat`, 'utf8').split(') ')[1].split(' ');
            ticks += Number(fields[11]) + Number(fields[12]);
        } catch {
            // It has ended meanwhile.
        }
    }
    return ticks;
}

const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: process.getuid() === 0 ? ['--no-sandbox'] : [],
});
const page = await browser.newPage({viewport: {width: 1280, height: 900}});
await page.goto(url);
await page.waitForTimeout(3000);
const before = rendererTicks();
const {gaps, work} = await page.evaluate((time) => new Promise((done) => {
    const [gaps, work] = [[], []];
    const end = performance.now() + time * 1000;
    let last;
    const frame = (began) => {
        if (last !== undefined) gaps.push(began - last);
        last = began;
        const channel = new MessageChannel();
        channel.port1.onmessage = () => work.push(performance.now() - began);
        channel.port2.postMessage(0);
        if (performance.now() < end) requestAnimationFrame(frame);
        else done({gaps, work});
    };
    requestAnimationFrame(frame);
}), seconds);
const ticks = rendererTicks() - before;
const share = (values, part) => values.sort((a, b) => a - b)[Math.min(values.length - 1, Math.floor(values.length * part))].toFixed(1);
const robots = await page.locator('#robot-count').innerText();
console.log(`${robots} robots, ${gaps.length} frames in ${seconds} s`);
console.log(`work of a frame: half within ${share(work, 0.5)} ms, 95 % within ${share(work, 0.95)} ms, 99 % within ${share(work, 0.99)} ms`);
console.log(`between frames: half ${share(gaps, 0.5)} ms, 99 % within ${share(gaps, 0.99)} ms, at most ${share(gaps, 1)} ms`);
console.log(`the renderer's processor time: ${(ticks * 10 / seconds).toFixed(0)} ms a second`);
await browser.close();
