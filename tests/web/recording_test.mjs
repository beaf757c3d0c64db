// The page of a recording in a real Chromium: `node recording_test.mjs URL ROBOT HEIR`. The robot is at r2 in the beginning;
// r2 is killed in the middle, and HEIR serves it from then on. What is not so ends it with exit code 1 and a sentence.

import {createRequire} from 'node:module';
import assert from 'node:assert/strict';

const {chromium} = createRequire(process.env.PAGE_TEST_MODULES + '/')('playwright-core');
const [url, robot, heir] = process.argv.slice(2);
const say = (line) => process.stdout.write(line + '\n');

const browser = await chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: process.getuid() === 0 ? ['--no-sandbox'] : [],
});
const page = await browser.newPage({viewport: {width: 390, height: 844}});
page.setDefaultTimeout(20000);
const complaints = [];
page.on('console', (message) => message.type() === 'error' && complaints.push(message.text()));
page.on('pageerror', (error) => complaints.push(error.message));

const place = page.locator('#place');
const play = page.locator('#play');
const homeIs = (home) => page.waitForFunction(([id, wanted]) => {
    const row = [...document.querySelectorAll('#robots tr')].find((tr) => tr.textContent.includes(id));
    return row?.querySelector('[data-column=Home]').textContent === wanted;
}, [robot, home]);

async function itIsARecording() {
    await page.goto(url);
    await page.locator('#recording-file', {hasText: 'test.mcap'}).waitFor();
    assert.ok(await page.locator('#stop-all').isHidden(), 'nobody can be steered');
    const wide = await page.evaluate(() => document.documentElement.scrollWidth);
    assert.ok(wide <= 390, `${wide} px are too wide for a phone`);
    if (process.env.PAGE_TEST_SHOTS) await page.screenshot({path: `${process.env.PAGE_TEST_SHOTS}/recording.png`, fullPage: true});
}

/** The keyboard is enough: Home and End are a range's own keys. */
async function aKeyGoesToAPlace() {
    await place.focus();
    await page.keyboard.press('End');
    await homeIs(heir);
    await page.locator('#time-line li[data-kind=broker-died]', {hasText: 'r2'}).waitFor();
    await page.locator('#brokers li.dead', {hasText: 'r2'}).waitFor();
    say('the end shows what happened');
    await page.keyboard.press('Home');
    await page.waitForFunction(() => document.querySelectorAll('#brokers li.dead').length === 0);
    await page.waitForFunction(() => document.querySelectorAll('#time-line li[data-kind=broker-died]').length === 0);
    say('the beginning knows nothing of it');
    await page.locator('#speed').selectOption('1');
    if (await play.textContent() === 'Play') await play.click();
    const talks = page.locator('#talks tr', {hasText: /^r2/});
    await talks.locator('[data-column=Hears]', {hasText: 'all 2 others'}).waitFor();
    await page.waitForFunction(() => [...document.querySelectorAll('#talks tr')].some((tr) =>
        tr.textContent.startsWith('r2') && parseFloat(tr.querySelector('[data-column="Its robots say"]').textContent) > 0));
    await page.locator('#brokers li', {hasText: /Longest turn\s*[\d.]+ ms/}).first().waitFor();
    say('it says who talks to whom');
}

async function itPlaysFastAndIsPaused() {
    await page.locator('#speed').selectOption('100');
    if (await play.textContent() === 'Play') await play.click();
    await homeIs(heir);
    await page.locator('#play', {hasText: 'Play'}).waitFor();  // it has come to its end
    assert.match(await place.getAttribute('aria-valuetext') ?? await place.evaluate((node) => node.ariaValueText), /of/);
    await page.locator('#speed').selectOption('0.1');
    await play.click();
    await page.locator('#play', {hasText: 'Pause'}).waitFor();
    await play.click();
    await page.locator('#play', {hasText: 'Play'}).waitFor();
    const at = await place.inputValue();
    await page.waitForTimeout(500);
    assert.equal(await place.inputValue(), at, 'it stands still');
    say('it plays and is paused');
}

try {
    await itIsARecording();
    await aKeyGoesToAPlace();
    await itPlaysFastAndIsPaused();
    assert.deepEqual(complaints, []);
} catch (error) {
    process.stderr.write(`${error.message}\n${complaints.join('\n')}\n`);
    process.exitCode = 1;
}
await browser.close();
process.exit();
